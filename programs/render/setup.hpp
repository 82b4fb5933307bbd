// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <utility>
#include <vector>

#ifdef MANYLIGHT_HAS_TBB
#include "manylight/core/tbb_executor.hpp"
#endif
#include "manylight/integrator/film.hpp"
#include "manylight/path/transfer.hpp"
#include "manylight/scene/camera.hpp"
#include "manylight/scene/scene.hpp"
#include "render/either_sampler.hpp"
#include "render/file_media.hpp"
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

/// A scene of one instantiation, its camera and film, and what the options say of both.
template <class Geometry, class Shader, class Media>
struct Setup {
  using SceneType = Scene<Geometry, Shader, Media>;

  /// Moves the shapes out of `description`. Throws what scene, camera and window throw for values out of range.
  Setup(scene_file::SceneDescription& description, const Options& chosen)
      : options(chosen),
        executor(make_executor(chosen.threads)),
        scene(make_scene(description)),
        camera(make_camera(description)),
        filter(description.filter),
        window(chosen.window.value_or(Window::of(camera))),
        sampler{chosen.sampler, chosen.seed} {
    const int depth = options.max_depth.value_or(description.max_depth);
    max_edges = depth < 0 ? k_unlimited_edges : std::min(static_cast<unsigned>(depth), k_unlimited_edges);
    window.validate(camera.width(), camera.height());
  }

  const Options& options;
  ProgramExecutor executor;
  SceneType scene;
  PerspectiveCamera<float> camera;
  ReconstructionFilter<float> filter;
  Window window;
  EitherSampler sampler;
  unsigned max_edges = k_unlimited_edges;

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
                     description.emitters, make_media(description));
  }

  [[nodiscard]] static Media make_media(scene_file::SceneDescription& description) {
    if constexpr (Media::k_exist) {
      return make_file_media(description);
    } else {
      static_cast<void>(description);
      return {};
    }
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
};


inline void add_rays(JobResult& result, const RayCounts& rays) {
  auto& json = result.statistics["rays"];
  json["closest"] = json["closest"].get<std::uint64_t>() + rays.closest;
  json["shadow"] = json["shadow"].get<std::uint64_t>() + rays.shadow;
}

}  // namespace manylight::render
