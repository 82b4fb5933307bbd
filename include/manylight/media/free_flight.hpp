// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <concepts>

#include "manylight/core/vector.hpp"

namespace manylight {

/// Half the step between variates of the streams in core/sampler.hpp (24 bits in float, 32 in double).
template <std::floating_point S>
inline constexpr S k_half_variate_step = sizeof(S) <= 4 ? S(0x1p-25) : S(0x1p-33);

/// Optical thickness up to the next collision, density exp(-x), from `u` in [0, 1). Never 0, so that a collision never
/// lies on the point that it was looked for from; never infinite: float ends at 16.6, double at 22.2.
template <std::floating_point S>
[[nodiscard]] inline S optical_flight(S u) noexcept {
  return u > S(0) ? -std::log(S(1) - u) : k_half_variate_step<S>;
}

/// exp(-sigma t); a channel without extinction keeps all light over infinite distances, too.
template <std::floating_point S>
[[nodiscard]] inline S exponential_transmittance(S sigma, S t) noexcept {
  return sigma > S(0) ? std::exp(-sigma * t) : S(1);
}

}  // namespace manylight
