// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <numeric>
#include <string>

#include "manylight/integrator/bidirectional_lightcuts.hpp"
#include "manylight/integrator/instant_radiosity.hpp"
#include "manylight/integrator/ledger.hpp"
#include "manylight/path/kollig_keller.hpp"
#include "render/either_bounds.hpp"
#include "render/setup.hpp"

namespace manylight::render {

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

[[nodiscard]] inline ManyLightConfig many_light_config(const Options& options, unsigned max_edges,
                                                       const Window& window) {
  ManyLightConfig config;
  config.vpls = options.vpls;
  config.eye_paths = options.eye_paths;
  config.max_edges = max_edges;
  config.threshold = options.threshold;
  config.max_cut = options.max_cut;
  config.adaptation_luminance = options.adaptation_luminance;
  config.clamp_scale = options.clamp_scale > 0 ? options.clamp_scale : k_infinity<double>;
  config.emitter_hits = options.hits_after_dirac_only ? EmitterHits::after_dirac : EmitterHits::all;
  config.window = window;
  return config;
}

/// Methods `vpl`, `lightcuts` and `bdlc` on one scene.
template <class Geometry, class Shader, class Media>
class ManyLightJob {
 public:
  using SceneType = typename Setup<Geometry, Shader, Media>::SceneType;

  ManyLightJob(const Setup<Geometry, Shader, Media>& setup, JobResult& result)
      : setup_(setup), options_(setup.options), result_(result),
        config_(many_light_config(setup.options, setup.max_edges, setup.window)), bounds_{setup.options.bounds} {}

  void run() {
    const Stopwatch clock;
    lights_ = prepare_lights(setup_.scene, setup_.camera, setup_.filter, config_, setup_.sampler, setup_.executor);
    if (options_.method != Method::vpl) tree_.emplace(std::move(lights_.lights.vpls), setup_.executor, bounds_);
    result_.statistics["seconds"]["vpls"] = clock.seconds();
    add_rays(result_, lights_.rays);
    report_lights();
    // `full` and `residual` are limits of `standard` and `four`: three weightings are instantiated, not five.
    const WeightingConfig<float>& weights = lights_.weights;
    switch (options_.weights) {
      case Weights::standard: render_with(StandardWeighting<float>(weights)); break;
      case Weights::full: render_with<StandardWeighting<float>>(FullWeighting<float>()); break;
      case Weights::four: render_with(FourConstraints<float>(weights)); break;
      case Weights::residual: render_with<FourConstraints<float>>(ResidualWeighting<float>(weights)); break;
      case Weights::kollig_keller: render_with(KolligKeller<float>(weights)); break;
    }
  }

 private:
  template <Weighting W>
  void render_with(const W& weighting) {
    const Stopwatch clock;
    ProgressLine progress(method_name(options_.method), options_.quiet);
    ManyLightImage<float> rendered =
        tree_ ? render_by_cuts(setup_.scene, setup_.camera, setup_.filter, config_, weighting, lights_, *tree_,
                               setup_.sampler, setup_.executor, std::ref(progress), bounds_)
              : render_all_pairs(setup_.scene, setup_.camera, setup_.filter, config_, weighting, lights_, setup_.sampler,
                                 setup_.executor, std::ref(progress));
    result_.statistics["seconds"]["pixels"] = clock.seconds();
    result_.image = std::move(rendered.image);
    report_pixels(rendered.statistics);
    if (options_.aovs.contains("cut-size")) result_.aovs["cut-size"] = cut_size_image(rendered.statistics.cut_sizes);
    if (options_.ledger_spp) book_missing(weighting);
  }

  /// The ledger of missing energy: statistics, and an image where asked for.
  template <Weighting W>
  void book_missing(const W& weighting) {
    const Stopwatch clock;
    ProgressLine progress("ledger", options_.quiet);
    LedgerConfig config;
    config.max_edges = setup_.max_edges;
    const LedgerIntegrator<SceneType, W> integrator(setup_.scene, weighting, config);
    const Ledger ledger = estimate_ledger(integrator, setup_.camera, setup_.filter, setup_.window, setup_.sampler, 0,
                                          *options_.ledger_spp, setup_.executor, std::ref(progress));
    add_rays(result_, ledger.rays);
    report_ledger(ledger);
    result_.statistics["seconds"]["ledger"] = clock.seconds();
    if (!options_.aovs.contains("missing")) return;
    Image<float> image(setup_.window.width(), setup_.window.height());
    for (std::size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] = Rgb<float>(ledger.missing[i]);
    result_.aovs["missing"] = std::move(image);
  }

  void report_ledger(const Ledger& ledger) {
    const auto entry = [&](const LedgerMean& mean) {
      const double truth = ledger.truth.luminance > 0 ? ledger.truth.luminance : 1;
      return nlohmann::json{{"luminance", mean.luminance},
                            {"standard_error", mean.luminance_error},
                            {"share", mean.luminance / truth}};
    };
    nlohmann::json& json = result_.statistics["missing"];
    json = {{"samples_per_pixel", *options_.ledger_spp},
            {"invalid_samples", ledger.invalid},
            {"truth", entry(ledger.truth)},
            {"total", entry(ledger.total)}};
    for (std::size_t e = 0; e < k_ledger_entries; ++e) {
      std::string key(name(static_cast<LedgerEntry>(e)));
      std::replace(key.begin(), key.end(), ' ', '_');
      json["entries"][key] = entry(ledger.entries[e]);
    }
  }

  [[nodiscard]] Image<float> cut_size_image(const std::vector<std::uint32_t>& sizes) const {
    Image<float> image(setup_.window.width(), setup_.window.height());
    for (std::size_t i = 0; i < sizes.size(); ++i) image.pixels[i] = Rgb<float>(static_cast<float>(sizes[i]));
    return image;
  }

  void report_lights() {
    nlohmann::json& json = result_.statistics;
    const std::size_t count = tree_ ? tree_->vpls().size() : lights_.lights.vpls.size();
    const std::size_t bytes = tree_ ? tree_->bytes() : count * sizeof(VertexOf<SceneType>);
    json["vpls"] = {{"count", count},
                    {"light_paths", lights_.lights.path_count},
                    {"bytes_per_vpl", count > 0 ? static_cast<double>(bytes) / static_cast<double>(count) : 0.0},
                    {"mean_intensity_w", lights_.lights.mean_intensity}};
    json["adaptation_luminance"] = lights_.adaptation_luminance;
    json["adaptation_is_fallback"] = lights_.is_adaptation_fallback;
    const float clamp = lights_.weights.c_clamp;
    json["clamp"] = clamp < k_infinity<float> ? nlohmann::json(clamp) : nlohmann::json(nullptr);
  }

  void report_pixels(const ManyLightStatistics& statistics) {
    nlohmann::json& json = result_.statistics;
    add_rays(result_, statistics.eye_rays);
    add_rays(result_, statistics.pairs.rays);
    json["eye_paths_per_pixel"] = options_.eye_paths;
    json["sensors"] = statistics.sensors;
    json["pairs"] = statistics.pairs.pairs;
    json["cut"] = tree_ ? distribution(statistics.cut_sizes) : nlohmann::json(nullptr);
    json["capped_pixels"] = statistics.capped_pixels;
    json["bound_violations"] = statistics.pairs.bound_violations;
    json["invalid_samples"] = statistics.invalid_samples;
  }

  const Setup<Geometry, Shader, Media>& setup_;
  const Options& options_;
  JobResult& result_;
  ManyLightConfig config_;
  EitherBounds bounds_;
  LightSide<SceneType> lights_;
  std::optional<LightTree<SceneType>> tree_;
};

}  // namespace manylight::render
