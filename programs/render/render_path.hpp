// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "manylight/integrator/path.hpp"
#include "render/passes.hpp"
#include "render/setup.hpp"

namespace manylight::render {

/// Method `path`.
template <class Geometry, class Shader, class Media>
void render_path(const Setup<Geometry, Shader, Media>& setup, JobResult& result) {
  const Options& options = setup.options;
  const Stopwatch clock;
  const PathIntegrator<typename Setup<Geometry, Shader, Media>::SceneType> integrator(
      setup.scene, PathConfig{setup.max_edges, PathConfig{}.roulette_edges, options.straight_is_free});
  std::vector<Rgb<double>> sums(setup.window.pixel_count(), Rgb<double>(0));
  PathStatistics statistics;
  PassLoop loop(options, options.spp, SampleUnit::sample);
  const auto image = [&] { return mean_image(setup.window, sums, loop.done()); };
  while (const std::uint32_t count = loop.next()) {
    statistics += accumulate_path_samples(integrator, setup.camera, setup.filter, setup.window, setup.sampler,
                                          loop.done(), count, sums, setup.executor, std::ref(loop));
    loop.finish(count, image);
  }
  result.image = image();
  result.statistics.add_rays(statistics.rays);
  result.statistics.set_seconds("pixels", clock.seconds());
  result.statistics.set_samples(loop.done(), statistics.invalid);
  result.statistics.set_interrupted(loop.is_interrupted());
}

}  // namespace manylight::render
