// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "manylight/core/vector.hpp"

namespace manylight {

/// Radiometric value in linear sRGB primaries; its unit is that of the quantity it holds.
template <std::floating_point S>
using Rgb = Vec3<S>;

/// Rec. 709 luminance, in the unit of `c`.
template <std::floating_point S>
[[nodiscard]] constexpr S luminance(const Rgb<S>& c) noexcept {
  return S(0.212671) * c.x + S(0.715160) * c.y + S(0.072169) * c.z;
}

/// The scalarisation of weights and bounds: with it every inequality holds for each channel.
template <std::floating_point S>
[[nodiscard]] constexpr S max_channel(const Rgb<S>& c) noexcept {
  return std::max(c.x, std::max(c.y, c.z));
}

/// max_channel / luminance, in [1, 13.9]: how far the channels of a colour stand out; 1 for black.
template <std::floating_point S>
[[nodiscard]] constexpr S saturation(const Rgb<S>& c) noexcept {
  const S y = luminance(c);
  return y > S(0) ? max_channel(c) / y : S(1);
}

template <std::floating_point S>
[[nodiscard]] constexpr bool is_black(const Rgb<S>& c) noexcept {
  return c.x == S(0) && c.y == S(0) && c.z == S(0);
}

/// True when `c` may enter a film: finite and nowhere negative.
template <std::floating_point S>
[[nodiscard]] inline bool is_valid_radiance(const Rgb<S>& c) noexcept {
  return is_finite(c) && c.x >= S(0) && c.y >= S(0) && c.z >= S(0);
}

}  // namespace manylight
