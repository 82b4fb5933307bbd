// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "manylight/integrator/bidirectional_image.hpp"
#include "render/passes.hpp"
#include "render/setup.hpp"

namespace manylight::render {

/// Longest paths that get images by strategy: 44 of them, and 2 kB per pixel while rendering.
inline constexpr unsigned k_max_strategy_edges = 8;

/// Weighted images of the strategies, and their means over the window.
inline void report_strategies(const StrategyImages& images, const Window& window, std::uint32_t samples,
                              JobResult& result) {
  for (unsigned edges = 1; edges <= images.max_edges; ++edges) {
    for (unsigned s = 0; s <= edges; ++s) {
      const unsigned t = edges + 1 - s;
      const std::string name = "s" + std::to_string(s) + "_t" + std::to_string(t);
      const std::vector<Rgb<double>>& sums = images.at(s, t).weighted;
      double sum = 0;
      for (const Rgb<double>& pixel : sums) sum += luminance(pixel);
      result.statistics["strategies"][name] = sum / (static_cast<double>(sums.size()) * samples);
      result.strategies[name] = mean_image(window, sums, samples);
    }
  }
}

/// Method `bdpt`.
template <class Geometry, class Shader, class Media>
void render_bidirectional(const Setup<Geometry, Shader, Media>& setup, JobResult& result) {
  const Options& options = setup.options;
  const Stopwatch clock;
  const BidirectionalPathIntegrator<typename Setup<Geometry, Shader, Media>::SceneType> integrator(
      setup.scene, BidirectionalPathConfig{setup.max_edges});
  const unsigned strategy_edges =
      options.strategy_images.empty() ? 0 : std::min(setup.max_edges, k_max_strategy_edges);
  BidirectionalSums sums(setup.window.pixel_count(), strategy_edges);
  PathStatistics statistics;
  PassLoop loop(options, options.spp, SampleUnit::sample);
  const auto image = [&] {
    std::vector<Rgb<double>> all = sums.eye;
    for (std::size_t i = 0; i < all.size(); ++i) all[i] += sums.light[i];
    return mean_image(setup.window, all, loop.done());
  };
  while (const std::uint32_t count = loop.next()) {
    statistics += accumulate_bidirectional_samples(integrator, setup.camera, setup.filter, setup.window, setup.sampler,
                                                   loop.done(), count, sums, setup.executor, std::ref(loop));
    loop.finish(count, image);
  }
  result.image = image();
  report_strategies(sums.strategies, setup.window, loop.done(), result);
  add_rays(result, statistics.rays);
  result.statistics["seconds"]["pixels"] = clock.seconds();
  result.statistics["samples_per_pixel"] = loop.done();
  result.statistics["invalid_samples"] = statistics.invalid;
  result.statistics["interrupted"] = loop.is_interrupted();
}

}  // namespace manylight::render
