// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the methods with photons share: sums over samples of pixels, and the test for glossy vertices.

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "manylight/integrator/film.hpp"
#include "manylight/integrator/path.hpp"

namespace manylight {
namespace detail {

/// Whether the density of directions at `hit` passes `limit` (sr^-1) in one of the directions where lobes peak:
/// mirrored, back and straight on. A function of the vertex alone, so that methods may treat glossy vertices in their
/// own way.
template <class Hit, std::floating_point S>
[[nodiscard]] bool is_glossy(const Hit& hit, const Vec3<S>& wo, S limit) noexcept {
  const Vec3<S> mirrored = hit.frame.n * (S(2) * glm::dot(wo, hit.frame.n)) - wo;
  return direction_pdf(hit, mirrored, wo) > limit || direction_pdf(hit, wo, wo) > limit ||
         direction_pdf(hit, -wo, wo) > limit;
}

/// Adds `radiance(ray, pixel, stream, rays)` of the samples [first, first + count) of every pixel of `window` to
/// `sums`, row by row. Throws ParameterError unless the window lies in the film and `sums` has a place for each of its
/// pixels.
template <class S, Camera C, Sampler Random, Executor Exec, class Radiance, class Progress>
PathStatistics accumulate_samples(const C& camera, const ReconstructionFilter<S>& filter, const Window& window,
                                  const Random& sampler, Stage stage, std::uint32_t first, std::uint32_t count,
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
          auto stream = sampler.stream(stage, film_index(camera, x, y), i);
          const Ray<S> ray = camera_ray(camera, filter, x, y, stream);
          const Rgb<S> sample = radiance(ray, pixel, stream, statistics.rays);
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
