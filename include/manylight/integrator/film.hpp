// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "manylight/core/error.hpp"
#include "manylight/core/executor.hpp"
#include "manylight/core/sampler.hpp"
#include "manylight/core/spectrum.hpp"
#include "manylight/scene/concepts.hpp"
#include "manylight/scene/filter.hpp"
#include "manylight/scene/image.hpp"

namespace manylight {

/// Progress callback that does nothing. A callback is called as `progress(done, total)` after every tile, from any thread
/// and possibly from several at once.
struct NoProgress {
  void operator()(std::size_t /*done*/, std::size_t /*total*/) const noexcept {}
};

/// A rectangle of pixels of a film, [x0, x1) x [y0, y1). Every pixel's random numbers are keyed by its place in the whole
/// film, so that a window has the same bits as the same pixels of the full image.
struct Window {
  std::uint32_t x0 = 0;
  std::uint32_t y0 = 0;
  std::uint32_t x1 = 0;
  std::uint32_t y1 = 0;

  /// The whole film of `camera`.
  template <Camera C>
  [[nodiscard]] static Window of(const C& camera) {
    return {0, 0, camera.width(), camera.height()};
  }
  [[nodiscard]] std::uint32_t width() const noexcept { return x1 - x0; }
  [[nodiscard]] std::uint32_t height() const noexcept { return y1 - y0; }
  [[nodiscard]] std::size_t pixel_count() const noexcept { return std::size_t{width()} * height(); }
  /// Place of pixel (x, y) of the film in an image of the window, row by row.
  [[nodiscard]] std::size_t index(std::uint32_t x, std::uint32_t y) const noexcept {
    return std::size_t{y - y0} * width() + (x - x0);
  }
  /// Throws ParameterError unless it is a part of a film of this size, at least one pixel.
  void validate(std::uint32_t film_width, std::uint32_t film_height) const {
    const auto text = std::to_string(x0) + "," + std::to_string(y0) + "," + std::to_string(x1) + "," + std::to_string(y1);
    require(x0 < x1 && y0 < y1 && x1 <= film_width && y1 <= film_height, "window", text,
            "x0,y0,x1,y1 with x0 < x1 <= " + std::to_string(film_width) + " and y0 < y1 <= " + std::to_string(film_height));
  }
};

/// Edge of the square tiles that tasks work on, pixels.
inline constexpr std::uint32_t k_tile_size = 16;

/// Calls `render_tile(tile)`, a Window, for every tile of `window`, one task each, and returns what the calls return in
/// tile order, for ordered reductions. Scratch memory belongs inside the call, so that it lives as long as its tile.
template <Executor Exec, class RenderTile, class Progress>
[[nodiscard]] auto for_each_tile(const Window& window, const Exec& executor, const RenderTile& render_tile,
                                 const Progress& progress) {
  const std::uint32_t tiles_x = (window.width() + k_tile_size - 1) / k_tile_size;
  const std::uint32_t tiles_y = (window.height() + k_tile_size - 1) / k_tile_size;
  const std::size_t tile_count = std::size_t{tiles_x} * tiles_y;
  std::vector<decltype(render_tile(window))> results(tile_count);
  std::atomic<std::size_t> done{0};
  executor.for_each_index(tile_count, [&](std::size_t i) {
    const auto x = window.x0 + static_cast<std::uint32_t>(i % tiles_x) * k_tile_size;
    const auto y = window.y0 + static_cast<std::uint32_t>(i / tiles_x) * k_tile_size;
    results[i] = render_tile(Window{x, y, std::min(x + k_tile_size, window.x1), std::min(y + k_tile_size, window.y1)});
    progress(++done, tile_count);
  });
  return results;
}

/// Key of pixel (x, y) in the whole film: what its random numbers are a function of.
template <Camera C>
[[nodiscard]] std::uint64_t film_index(const C& camera, std::uint32_t x, std::uint32_t y) noexcept {
  return std::uint64_t{y} * camera.width() + x;
}

/// The camera ray of one sample of a pixel: its point is drawn from the filter, its lens point from the aperture.
template <Camera C, SampleStream Stream>
[[nodiscard]] Ray<typename C::Scalar> camera_ray(const C& camera,
                                                 const ReconstructionFilter<typename C::Scalar>& filter,
                                                 std::uint32_t x, std::uint32_t y, Stream& stream) {
  using S = typename C::Scalar;
  const Vec2<S> center(static_cast<S>(x) + S(0.5), static_cast<S>(y) + S(0.5));
  const Vec2<S> film = center + filter.sample(stream.next_2d());
  return camera.ray(film, stream.next_2d());
}

}  // namespace manylight
