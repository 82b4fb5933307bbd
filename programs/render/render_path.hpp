// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "manylight/integrator/path.hpp"
#include "render/setup.hpp"

namespace manylight::render {

/// Method `path`: passes over the window until the samples are taken or the time is up.
template <class Geometry, class Shader, class Media>
void render_path(const Setup<Geometry, Shader, Media>& setup, JobResult& result) {
  const Options& options = setup.options;
  const Stopwatch clock;
  const PathIntegrator<typename Setup<Geometry, Shader, Media>::SceneType> integrator(
      setup.scene, PathConfig{setup.max_edges, PathConfig{}.roulette_edges, options.straight_is_free});
  std::vector<Rgb<double>> sums(setup.window.pixel_count(), Rgb<double>(0));
  ProgressLine progress("path", options.quiet);
  PathStatistics statistics;
  std::uint32_t done = 0;
  while (done < options.spp) {
    const std::uint32_t pass = std::min(options.spp - done, std::clamp(done, 1U, 16U));
    const double elapsed = clock.seconds();
    const bool out_of_time = options.time_limit && done > 0 && elapsed + elapsed / done * pass > *options.time_limit;
    if (out_of_time) break;
    statistics += accumulate_path_samples(integrator, setup.camera, setup.filter, setup.window, setup.sampler, done, pass,
                                          sums, setup.executor);
    done += pass;
    const double by_count = static_cast<double>(done) / options.spp;
    progress.update(options.time_limit ? std::max(by_count, std::min(1.0, clock.seconds() / *options.time_limit))
                                       : by_count);
  }
  result.image = Image<float>(setup.window.width(), setup.window.height());
  for (std::size_t i = 0; i < sums.size(); ++i) {
    result.image.pixels[i] = Rgb<float>(sums[i] / static_cast<double>(done));
  }
  add_rays(result, statistics.rays);
  result.statistics["seconds"]["pixels"] = clock.seconds();
  result.statistics["samples_per_pixel"] = done;
  result.statistics["invalid_samples"] = statistics.invalid;
}

}  // namespace manylight::render
