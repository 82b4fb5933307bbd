// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <numeric>
#include <vector>

#include <fmt/core.h>

#ifdef MANYLIGHT_HAS_TBB
#include "manylight/core/tbb_executor.hpp"
#endif
#include "manylight/core/sobol.hpp"
#include "manylight/integrator/bidirectional_lightcuts.hpp"
#include "manylight/integrator/instant_radiosity.hpp"
#include "manylight/integrator/path.hpp"
#include "manylight/scene/camera.hpp"
#include "manylight/scene/scene.hpp"
#include "render/job.hpp"
#include "render/progress.hpp"

namespace manylight::render {

#ifdef MANYLIGHT_HAS_TBB
using ProgramExecutor = TbbExecutor;
[[nodiscard]] inline ProgramExecutor make_executor(std::uint32_t threads) { return ProgramExecutor(threads); }
#else
using ProgramExecutor = SerialExecutor;
[[nodiscard]] inline ProgramExecutor make_executor(std::uint32_t) { return {}; }
#endif

[[nodiscard]] inline nlohmann::json to_json(const RayCounts& rays) {
  return {{"closest", rays.closest}, {"shadow", rays.shadow}};
}

/// Mean, median, 99th percentile and maximum.
[[nodiscard]] inline nlohmann::json distribution(std::vector<std::uint32_t> values) {
  if (values.empty()) return nullptr;
  std::sort(values.begin(), values.end());
  const double sum = std::accumulate(values.begin(), values.end(), 0.0);
  const auto at = [&](double p) {
    return values[static_cast<std::size_t>(p * static_cast<double>(values.size() - 1) + 0.5)];
  };
  return {{"mean", sum / static_cast<double>(values.size())},
          {"median", at(0.5)},
          {"percentile_99", at(0.99)},
          {"maximum", values.back()}};
}

/// A scene of one instantiation with its camera, and the methods on it.
template <class Geometry, class Shader>
class Job {
 public:
  using SceneType = Scene<Geometry, Shader>;

  Job(scene_file::SceneDescription& description, const Options& options)
      : options_(options),
        executor_(make_executor(options.threads)),
        scene_(make_scene(description)),
        camera_(make_camera(description)),
        filter_(description.filter) {
    const int depth = options.max_depth.value_or(description.max_depth);
    max_edges_ = depth < 0 ? k_unlimited_edges : std::min(static_cast<unsigned>(depth), k_unlimited_edges);
    result_.statistics["seconds"]["build"] = clock_.seconds();
    result_.statistics["rays"] = {{"closest", 0}, {"shadow", 0}};
  }

  template <class Random>
  [[nodiscard]] JobResult run(const Random& sampler) {
    render_aovs(sampler);
    switch (options_.method) {
      case Method::path: path(sampler); break;
      case Method::vpl:
      case Method::bdlc: many_light(sampler); break;
    }
    return std::move(result_);
  }

 private:
  [[nodiscard]] static SceneType make_scene(scene_file::SceneDescription& description) {
    std::vector<Shader> shaders;
    std::vector<std::uint32_t> shader_of_shape;
    std::map<std::pair<std::uint32_t, std::array<float, 3>>, std::uint32_t> known;
    for (const auto& info : description.shape_infos) {
      const Rgb<float>& a = info.interior_absorption;
      const auto [entry, is_new] = known.try_emplace({info.material, {a.x, a.y, a.z}},
                                                     static_cast<std::uint32_t>(shaders.size()));
      if (is_new) shaders.emplace_back(description.materials[info.material], a);
      shader_of_shape.push_back(entry->second);
    }
    return SceneType(Geometry(std::move(description.shapes)), std::move(shaders), std::move(shader_of_shape),
                     description.emitters);
  }
  [[nodiscard]] static PerspectiveCamera<float> make_camera(const scene_file::SceneDescription& description) {
    const scene_file::CameraDescription& c = description.camera;
    PerspectiveConfig<float> config;
    config.to_world = c.to_world;
    config.horizontal_fov = scene_file::horizontal_fov_degrees(c);
    config.width = c.width;
    config.height = c.height;
    config.aperture_radius = c.aperture_radius;
    config.focus_distance = c.focus_distance;
    return PerspectiveCamera<float>(config);
  }

  void add_rays(const RayCounts& rays) {
    auto& json = result_.statistics["rays"];
    json["closest"] = json["closest"].get<std::uint64_t>() + rays.closest;
    json["shadow"] = json["shadow"].get<std::uint64_t>() + rays.shadow;
  }

  template <class Random>
  void path(const Random& sampler) {
    const Stopwatch clock;
    const PathIntegrator<SceneType> integrator(scene_, PathConfig{max_edges_});
    std::vector<Rgb<double>> sums(std::size_t{camera_.width()} * camera_.height(), Rgb<double>(0));
    ProgressLine progress("path", options_.quiet);
    PathStatistics statistics;
    std::uint32_t done = 0;
    while (done < options_.spp) {
      const std::uint32_t pass = std::min(options_.spp - done, std::clamp(done, 1U, 16U));
      const double elapsed = clock.seconds();
      const bool out_of_time = options_.time_limit && done > 0 && elapsed + elapsed / done * pass > *options_.time_limit;
      if (out_of_time) break;
      statistics += accumulate_path_samples(integrator, camera_, filter_, Window::of(camera_), sampler, done, pass, sums, executor_);
      done += pass;
      const double by_count = static_cast<double>(done) / options_.spp;
      progress.update(options_.time_limit ? std::max(by_count, std::min(1.0, clock.seconds() / *options_.time_limit))
                                          : by_count);
    }
    result_.image = Image<float>(camera_.width(), camera_.height());
    for (std::size_t i = 0; i < sums.size(); ++i) result_.image.pixels[i] = Rgb<float>(sums[i] / static_cast<double>(done));
    add_rays(statistics.rays);
    result_.statistics["seconds"]["pixels"] = clock.seconds();
    result_.statistics["samples_per_pixel"] = done;
    result_.statistics["invalid_samples"] = statistics.invalid;
  }

  template <class Random>
  void many_light(const Random& sampler) {
    ManyLightConfig config;
    config.vpls = options_.vpls;
    config.eye_paths = options_.eye_paths;
    config.max_edges = max_edges_;
    config.threshold = options_.threshold;
    config.max_cut = options_.max_cut;
    config.adaptation_luminance = options_.adaptation_luminance;
    config.clamp_scale = options_.clamp_scale > 0 ? options_.clamp_scale : k_infinity<double>;
    config.emitter_hits = options_.hits_after_dirac_only ? EmitterHits::after_dirac : EmitterHits::all;
    const Stopwatch light_clock;
    const LightSide<SceneType> lights = prepare_lights(scene_, camera_, filter_, config, sampler, executor_);
    add_rays(lights.rays);
    nlohmann::json& json = result_.statistics;
    std::size_t bytes = lights.lights.vpls.size() * sizeof(VertexOf<SceneType>);
    ManyLightImage<float> rendered;
    if (options_.method == Method::vpl) {
      json["seconds"]["vpls"] = light_clock.seconds();
      const Stopwatch clock;
      ProgressLine progress("vpl", options_.quiet);
      rendered = render_instant_radiosity(scene_, camera_, filter_, config, lights, sampler, executor_, std::ref(progress));
      json["seconds"]["pixels"] = clock.seconds();
    } else {
      const LightTree<SceneType> tree(lights.lights.vpls, executor_);
      bytes = tree.bytes();
      json["seconds"]["vpls"] = light_clock.seconds();
      const Stopwatch clock;
      ProgressLine progress("bdlc", options_.quiet);
      rendered = render_bidirectional_lightcuts(scene_, camera_, filter_, config, lights, tree, sampler, executor_,
                                                std::ref(progress));
      json["seconds"]["pixels"] = clock.seconds();
    }
    result_.image = std::move(rendered.image);
    report(lights, rendered.statistics, bytes);
  }

  void report(const LightSide<SceneType>& lights, const ManyLightStatistics& statistics, std::size_t bytes) {
    nlohmann::json& json = result_.statistics;
    add_rays(statistics.eye_rays);
    add_rays(statistics.pairs.rays);
    const std::size_t count = lights.lights.vpls.size();
    json["vpls"] = {{"count", count},
                    {"light_paths", lights.lights.path_count},
                    {"bytes_per_vpl", count > 0 ? static_cast<double>(bytes) / static_cast<double>(count) : 0.0},
                    {"mean_intensity_w", lights.lights.mean_intensity}};
    json["adaptation_luminance"] = lights.adaptation_luminance;
    json["adaptation_is_fallback"] = lights.is_adaptation_fallback;
    const auto clamp = lights.weights.c_clamp;
    json["clamp"] = clamp < k_infinity<float> ? nlohmann::json(clamp) : nlohmann::json(nullptr);
    json["eye_paths_per_pixel"] = options_.eye_paths;
    json["sensors"] = statistics.sensors;
    json["pairs"] = statistics.pairs.pairs;
    json["cut"] = options_.method == Method::bdlc ? distribution(statistics.cut_sizes) : nlohmann::json(nullptr);
    json["capped_pixels"] = statistics.capped_pixels;
    json["bound_violations"] = statistics.pairs.bound_violations;
    json["invalid_samples"] = statistics.invalid_samples;
  }

  /// First hits, 16 samples per pixel.
  template <class Random>
  void render_aovs(const Random& sampler) {
    if (options_.aovs.empty()) return;
    constexpr std::uint32_t k_samples = 16;
    Image<float> normal(camera_.width(), camera_.height());
    Image<float> albedo = normal;
    Image<float> depth = normal;
    const auto render_tile = [&](const Window& tile) {
      RayCounts rays;
      for (std::uint32_t y = tile.y0; y < tile.y1; ++y) {
        for (std::uint32_t x = tile.x0; x < tile.x1; ++x) {
          for (std::uint32_t i = 0; i < k_samples; ++i) {
            auto stream = sampler.stream(Stage::eye, film_index(camera_, x, y), i);
            const Ray<float> ray = camera_ray(camera_, filter_, x, y, stream);
            const auto point = scene_.intersect(ray, stream, rays);
            if (!point) continue;
            const auto hit = scene_.interaction(*point, -ray.direction);
            normal.at(x, y) += hit.frame.n / float{k_samples};
            albedo.at(x, y) += hit.material.albedo() / float{k_samples};
            depth.at(x, y) += Rgb<float>(glm::length(point->position - ray.origin) / float{k_samples});
          }
        }
      }
      return rays;
    };
    for (const RayCounts& rays : for_each_tile(Window::of(camera_), executor_, render_tile, NoProgress{})) add_rays(rays);
    for (const auto& [name, file] : options_.aovs) {
      result_.aovs[name] = name == "normal" ? normal : name == "albedo" ? albedo : depth;
    }
  }

  Stopwatch clock_;
  const Options& options_;
  ProgramExecutor executor_;
  SceneType scene_;
  PerspectiveCamera<float> camera_;
  ReconstructionFilter<float> filter_;
  unsigned max_edges_ = k_unlimited_edges;
  JobResult result_;
};

template <class Geometry, class Shader>
JobResult run_job(scene_file::SceneDescription& description, const Options& options) {
  Job<Geometry, Shader> job(description, options);
  if (options.sampler == SamplerKind::sobol) return job.run(SobolSampler<float>{options.seed});
  return job.run(IndependentSampler<float>{options.seed});
}

}  // namespace manylight::render
