// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "manylight/integrator/bidirectional_lightcuts.hpp"
#include "manylight/integrator/instant_radiosity.hpp"
#include "manylight/integrator/ledger.hpp"
#include "manylight/path/kollig_keller.hpp"
#include "render/either_bounds.hpp"
#include "render/passes.hpp"
#include "render/setup.hpp"

namespace manylight::render {

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

/// Methods `vpl`, `ir`, `lightcuts` and `bdlc` on one scene: the mean of passes, whole images with lights and eye paths of
/// their own.
template <class Geometry, class Shader, class Media>
class ManyLightJob {
 public:
  using SceneType = typename Setup<Geometry, Shader, Media>::SceneType;

  ManyLightJob(const Setup<Geometry, Shader, Media>& setup, JobResult& result)
      : setup_(setup), options_(setup.options), result_(result),
        config_(many_light_config(setup.options, setup.max_edges, setup.window)), bounds_{setup.options.bounds},
        sums_(setup.window.pixel_count(), Rgb<double>(0)), cut_sizes_(setup.window.pixel_count(), 0) {}

  void run() {
    PassLoop loop(options_, options_.passes, SampleUnit::whole_image);
    const auto image = [&] { return mean_image(setup_.window, sums_, loop.done()); };
    try {
      while (loop.next() > 0) {
        prepare(loop.done());
        loop.tell(0);
        with_weighting([&](const auto& weighting) { render(weighting, loop); });
        loop.finish(1, image);
      }
    } catch (const PassAbandoned&) {
      // Nothing of that pass is in the sums.
    }
    result_.image = image();
    result_.statistics.set_interrupted(loop.is_interrupted());
    report_pixels(loop.done());
    if (options_.ledger_spp) with_weighting([&](const auto& weighting) { book_missing(weighting); });
  }

 private:
  /// The light side of a pass. L_a is that of the first one, so that all clamp alike.
  void prepare(std::uint32_t pass) {
    const Stopwatch clock;
    tree_.reset();
    sampler_ = setup_.sampler.pass(pass);
    lights_ = prepare_lights(setup_.scene, setup_.camera, setup_.filter, config_, sampler_, setup_.executor);
    if (has_cuts(options_.method)) tree_.emplace(std::move(lights_.lights.vpls), setup_.executor, bounds_);
    light_seconds_ += clock.seconds();
    result_.statistics.set_seconds("vpls", light_seconds_);
    result_.statistics.add_rays(lights_.rays);
    if (pass > 0) return;
    report_lights();
    config_.adaptation_luminance = lights_.adaptation_luminance;
  }

  template <class Use>
  void with_weighting(const Use& use) {
    // `full` and `residual` are limits of `standard` and `four`: three weightings are instantiated, not five.
    using Standard = StandardWeighting<float>;
    using Four = FourConstraints<float>;
    const WeightingConfig<float>& weights = lights_.weights;
    switch (options_.weights) {
      case Weights::standard: use(Standard(weights)); break;
      case Weights::full: use(static_cast<const Standard&>(FullWeighting<float>())); break;
      case Weights::four: use(Four(weights)); break;
      case Weights::residual: use(static_cast<const Four&>(ResidualWeighting<float>(weights))); break;
      case Weights::kollig_keller: use(KolligKeller<float>(weights)); break;
    }
  }

  template <Weighting W>
  void render(const W& weighting, PassLoop& loop) {
    const Stopwatch clock;
    const ManyLightImage<float> rendered =
        tree_ ? render_by_cuts(setup_.scene, setup_.camera, setup_.filter, config_, weighting, lights_, *tree_, sampler_,
                               setup_.executor, std::ref(loop), bounds_)
              : render_all_pairs(setup_.scene, setup_.camera, setup_.filter, config_, weighting, lights_, sampler_,
                                 setup_.executor, std::ref(loop));
    for (std::size_t i = 0; i < sums_.size(); ++i) sums_[i] += Rgb<double>(rendered.image.pixels[i]);
    for (std::size_t i = 0; i < sums_.size(); ++i) cut_sizes_[i] += rendered.statistics.cut_sizes[i];
    statistics_ += rendered.statistics;
    pixel_seconds_ += clock.seconds();
  }

  /// The ledger of missing energy: statistics, and an image where asked for; nothing after a stop signal.
  template <Weighting W>
  void book_missing(const W& weighting) {
    const Stopwatch clock;
    ProgressLine line("ledger", options_.quiet);
    const auto progress = [&](std::size_t done, std::size_t total) {
      if (stop_requested()) throw PassAbandoned{};
      line(done, total);
    };
    LedgerConfig config;
    config.max_edges = setup_.max_edges;
    const LedgerIntegrator<SceneType, W> integrator(setup_.scene, weighting, config);
    Ledger ledger;
    try {
      ledger = estimate_ledger(integrator, setup_.camera, setup_.filter, setup_.window, setup_.sampler, 0,
                               *options_.ledger_spp, setup_.executor, progress);
    } catch (const PassAbandoned&) {
      result_.statistics.set_interrupted(true);
      return;
    }
    result_.statistics.add_rays(ledger.rays);
    result_.statistics.set_ledger(ledger, *options_.ledger_spp);
    result_.statistics.set_seconds("ledger", clock.seconds());
    if (!options_.aovs.contains("missing")) return;
    Image<float> image(setup_.window.width(), setup_.window.height());
    for (std::size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] = Rgb<float>(ledger.missing[i]);
    result_.aovs["missing"] = std::move(image);
  }

  void report_lights() {
    const std::size_t count = tree_ ? tree_->vpls().size() : lights_.lights.vpls.size();
    result_.statistics.set_lights({count, tree_ ? tree_->bytes() : count * sizeof(VertexOf<SceneType>),
                                   lights_.lights.path_count, static_cast<double>(lights_.lights.mean_intensity),
                                   lights_.adaptation_luminance, lights_.is_adaptation_fallback,
                                   lights_.weights.c_clamp});
  }

  void report_pixels(std::uint32_t passes) {
    PixelReport report{passes, options_.eye_paths, pixel_seconds_, has_cuts(options_.method), {}};
    for (const std::uint64_t sum : cut_sizes_) report.cut_sizes.push_back(static_cast<std::uint32_t>(sum / passes));
    if (options_.aovs.contains("cut-size")) {
      Image<float>& image = result_.aovs["cut-size"] = Image<float>(setup_.window.width(), setup_.window.height());
      for (std::size_t i = 0; i < report.cut_sizes.size(); ++i) {
        image.pixels[i] = Rgb<float>(static_cast<float>(report.cut_sizes[i]));
      }
    }
    result_.statistics.set_pixels(report, statistics_);
  }

  const Setup<Geometry, Shader, Media>& setup_;
  const Options& options_;
  JobResult& result_;
  ManyLightConfig config_;
  EitherBounds bounds_;
  EitherSampler sampler_;  ///< of the running pass
  LightSide<SceneType> lights_;
  std::optional<LightTree<SceneType>> tree_;
  std::vector<Rgb<double>> sums_;          ///< over passes, W/m^2/sr
  std::vector<std::uint64_t> cut_sizes_;   ///< over passes
  ManyLightStatistics statistics_;
  double light_seconds_ = 0;
  double pixel_seconds_ = 0;
};

}  // namespace manylight::render
