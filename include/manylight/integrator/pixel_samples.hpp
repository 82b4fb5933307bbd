// SPDX-License-Identifier: Apache-2.0
#pragma once

// What methods that sample one pixel after the other share: the sums over samples, and what those cost.

#include <cstdint>
#include <string>
#include <vector>

#include "manylight/integrator/film.hpp"
#include "manylight/scene/instants.hpp"

namespace manylight {

/// What a set of samples cost.
struct PathStatistics {
  RayCounts rays;
  std::uint64_t samples = 0;
  std::uint64_t invalid = 0;  ///< samples that were not finite or negative: dropped and counted

  PathStatistics& operator+=(const PathStatistics& other) noexcept {
    rays += other.rays;
    samples += other.samples;
    invalid += other.invalid;
    return *this;
  }
};

namespace detail {

/// Adds `radiance(ray, pixel, instant, stream, rays)`, W/m^2/sr, of the samples [first, first + count) of every pixel of
/// `window` to `sums`, row by row. The samples of a pixel take the instants of a motion in turn, from one set of numbers: a
/// pixel has few per instant, so that a set for each (as light paths have) would be the noisier. Throws ParameterError
/// unless the window lies in the film and `sums` has a place for each of its pixels.
template <class S, Camera C, Sampler Random, Executor Exec, class Radiance, class Progress>
PathStatistics accumulate_samples(const C& camera, std::uint32_t instants, const ReconstructionFilter<S>& filter,
                                  const Window& window, const Random& sampler, std::uint32_t first, std::uint32_t count,
                                  std::vector<Rgb<double>>& sums, const Radiance& radiance, const Exec& executor,
                                  const Progress& progress) {
  window.validate(camera.width(), camera.height());
  require(sums.size() == window.pixel_count(), "number of sums", sums.size(),
          "one per pixel of the window: " + std::to_string(window.pixel_count()));
  const auto render_tile = [&](const Window& tile) {
    PathStatistics statistics;
    for (std::uint32_t y = tile.y0; y < tile.y1; ++y) {
      for (std::uint32_t x = tile.x0; x < tile.x1; ++x) {
        const std::size_t pixel = window.index(x, y);
        for (std::uint32_t i = first; i < first + count; ++i) {
          auto stream = sampler.stream(Stage::eye, film_index(camera, x, y), i);
          const std::uint32_t instant = sample_instant(instants, sampler, film_index(camera, x, y), i);
          const Ray<S> ray = camera_ray(at_instant(camera, instant), filter, x, y, stream);
          const Rgb<S> sample = radiance(ray, pixel, instant, stream, statistics.rays);
          ++statistics.samples;
          if (is_valid_radiance(sample)) {
            sums[pixel] += Rgb<double>(sample);
          } else {
            ++statistics.invalid;
          }
        }
      }
    }
    return statistics;
  };
  PathStatistics total;
  for (const PathStatistics& tile : for_each_tile(window, executor, render_tile, progress)) total += tile;
  return total;
}

}  // namespace detail
}  // namespace manylight
