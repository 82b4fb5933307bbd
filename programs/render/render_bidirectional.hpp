// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <functional>
#include <vector>

#include "manylight/integrator/bidirectional_image.hpp"
#include "render/passes.hpp"
#include "render/setup.hpp"

namespace manylight::render {

/// Longest paths that get images by strategy: 44 of them, and 2 kB per pixel while rendering.
inline constexpr unsigned k_max_strategy_edges = 8;

/// Weighted images of the strategies, and their means over the window.
void report_strategies(const StrategyImages& images, const Window& window, std::uint32_t samples, JobResult& result);

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
  result.statistics.add_rays(statistics.rays);
  result.statistics.set_seconds("pixels", clock.seconds());
  result.statistics.set_samples(loop.done(), statistics.invalid);
  result.statistics.set_interrupted(loop.is_interrupted());
}

}  // namespace manylight::render
