// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <vector>

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

/// Edge of the square tiles that tasks work on, pixels.
inline constexpr std::uint32_t k_tile_size = 16;

/// Calls `tile(state, x, y)` for every pixel of a film, one task per tile with a state of its own from `make_state()`,
/// and returns the states in tile order, for ordered reductions.
template <Executor Exec, class MakeState, class Pixel, class Progress>
auto for_each_pixel(std::uint32_t width, std::uint32_t height, const Exec& executor, const MakeState& make_state,
                    const Pixel& pixel, const Progress& progress) {
  const std::uint32_t tiles_x = (width + k_tile_size - 1) / k_tile_size;
  const std::uint32_t tiles_y = (height + k_tile_size - 1) / k_tile_size;
  const std::size_t tile_count = std::size_t{tiles_x} * tiles_y;
  std::vector<decltype(make_state())> states;
  states.reserve(tile_count);
  for (std::size_t i = 0; i < tile_count; ++i) states.push_back(make_state());
  std::atomic<std::size_t> done{0};
  executor.for_each_index(tile_count, [&](std::size_t tile) {
    const auto x0 = static_cast<std::uint32_t>(tile % tiles_x) * k_tile_size;
    const auto y0 = static_cast<std::uint32_t>(tile / tiles_x) * k_tile_size;
    for (std::uint32_t y = y0; y < std::min(y0 + k_tile_size, height); ++y) {
      for (std::uint32_t x = x0; x < std::min(x0 + k_tile_size, width); ++x) pixel(states[tile], x, y);
    }
    progress(++done, tile_count);
  });
  return states;
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
