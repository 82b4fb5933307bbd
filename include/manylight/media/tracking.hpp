// SPDX-License-Identifier: Apache-2.0
#pragma once

// Free flights and transmittance through a grid by candidate collisions of a majorant that is constant per block.
// Loops end: the optical thickness of majorants along any ray is limited at set-up (check_tracking_cost), candidates
// are counted off in optical thickness, which single precision resolves up to that limit, and each is at least half a
// variate's step further. Nothing is cut off, so nothing is biased.

#include <algorithm>
#include <concepts>
#include <optional>
#include <string_view>

#include "manylight/core/error.hpp"
#include "manylight/core/sampler.hpp"
#include "manylight/media/block_majorants.hpp"
#include "manylight/media/free_flight.hpp"

namespace manylight {

/// A real collision: where, and the extinction there.
template <std::floating_point S>
struct Collision {
  S t;        ///< m along the ray
  S sigma_t;  ///< m^-1, above 0
};

/// Largest optical thickness of a majorant over a grid's diagonal, and so about the largest mean number of steps.
inline constexpr double k_max_tracking_thickness = 1e6;

/// Throws ParameterError unless rays through a grid with majorants up to `majorant` (m^-1) take that few steps.
template <std::floating_point S>
inline void check_tracking_cost(std::string_view element, S majorant, const GridLattice<S>& lattice) {
  const double thickness = static_cast<double>(majorant) * static_cast<double>(lattice.world_diagonal());
  require(thickness <= k_max_tracking_thickness, element, thickness, "at most 1e6 over the diagonal of its box");
}

/// Delta tracking [Woodcock 1965]: of the candidates of the majorant, a share sigma_t / majorant are real. The first
/// real one has the density sigma_t times transmittance. `sigma_t(g)`, m^-1, of lattice coordinates must not exceed
/// `scale` times the block's majorant. None: got through.
template <std::floating_point S, class SigmaT, SampleStream Stream>
[[nodiscard]] inline std::optional<Collision<S>> track_collision(const BlockMajorants<S>& blocks,
                                                                 const GridSegment<S>& segment, S scale,
                                                                 const SigmaT& sigma_t, Stream& stream) noexcept {
  std::optional<Collision<S>> found;
  S ahead = optical_flight(stream.next());  // thickness from the block's entry to the next candidate
  blocks.walk(segment, [&](const BlockStretch<S>& block) {
    const S majorant = scale * block.majorant;
    const S thickness = majorant * (block.s1 - block.s0);
    while (ahead < thickness) {
      const S s = std::min(block.s0 + ahead / majorant, block.s1);
      const S sigma = sigma_t(block.at(segment, s));
      // The middle of a variate's step: a collision at sigma near 0 would have a weight of any size.
      if ((stream.next() + k_half_variate_step<S>)*majorant < sigma) {
        found = Collision<S>{segment.t_entry + s, sigma};
        return false;
      }
      ahead += optical_flight(stream.next());
    }
    ahead -= thickness;  // an exponential has no memory
    return true;
  });
  return found;
}

/// Ratio tracking [Novak 2014, Sec. 4]: product of 1 - sigma_t / majorant over the candidates, in [0, 1], its mean the
/// transmittance. Below 0.1 a product T survives with probability T / 0.1, and is 0.1 then: unbiased as ever, and with
/// values in [0, 1] the variance stays at most that of delta tracking, T (1 - T).
template <std::floating_point S, class SigmaT, SampleStream Stream>
[[nodiscard]] inline S track_transmittance(const BlockMajorants<S>& blocks, const GridSegment<S>& segment, S scale,
                                           const SigmaT& sigma_t, Stream& stream) noexcept {
  constexpr S k_roulette = S(0.1);
  S product = S(1);
  S ahead = optical_flight(stream.next());
  blocks.walk(segment, [&](const BlockStretch<S>& block) {
    const S majorant = scale * block.majorant;
    const S thickness = majorant * (block.s1 - block.s0);
    while (ahead < thickness) {
      const S s = std::min(block.s0 + ahead / majorant, block.s1);
      product *= std::max(S(1) - sigma_t(block.at(segment, s)) / majorant, S(0));
      if (product < k_roulette) {
        if (stream.next() * k_roulette >= product) {
          product = S(0);
          return false;
        }
        product = k_roulette;
      }
      ahead += optical_flight(stream.next());
    }
    ahead -= thickness;
    return true;
  });
  return product;
}

}  // namespace manylight
