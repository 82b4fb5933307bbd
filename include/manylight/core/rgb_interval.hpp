// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <type_traits>

#include "manylight/core/direction_set.hpp"
#include "manylight/core/interval.hpp"
#include "manylight/core/interval_math.hpp"
#include "manylight/core/spectrum.hpp"

namespace manylight {

/// Range of a colour, per channel.
template <std::floating_point S>
struct RgbInterval {
  Interval<S> x;
  Interval<S> y;
  Interval<S> z;

  constexpr RgbInterval(const Interval<S>& red, const Interval<S>& green, const Interval<S>& blue) noexcept
      : x(red), y(green), z(blue) {}
  explicit constexpr RgbInterval(S grey) noexcept : x(grey), y(grey), z(grey) {}
};

template <std::floating_point S>
[[nodiscard]] inline RgbInterval<S> operator*(const Rgb<S>& c, const Interval<S>& factor) noexcept {
  return {c.x * factor, c.y * factor, c.z * factor};
}
/// The ranges are of `a` and `b` apart: what they have in common is not seen.
template <std::floating_point S>
[[nodiscard]] inline RgbInterval<S> operator+(const RgbInterval<S>& a, const RgbInterval<S>& b) noexcept {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <std::floating_point S>
inline RgbInterval<S>& operator+=(RgbInterval<S>& a, const RgbInterval<S>& b) noexcept {
  return a = a + b;
}
template <std::floating_point S>
[[nodiscard]] inline RgbInterval<S> operator*(S factor, const RgbInterval<S>& c) noexcept {
  return {factor * c.x, factor * c.y, factor * c.z};
}
template <std::floating_point S>
[[nodiscard]] inline RgbInterval<S> operator*(const RgbInterval<S>& c, const Interval<S>& factor) noexcept {
  return {c.x * factor, c.y * factor, c.z * factor};
}
/// Channel by channel.
template <std::floating_point S>
[[nodiscard]] inline RgbInterval<S> operator*(const Rgb<S>& a, const RgbInterval<S>& b) noexcept {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}
template <std::floating_point S>
[[nodiscard]] inline RgbInterval<S> hull(const RgbInterval<S>& a, const RgbInterval<S>& b) noexcept {
  return {hull(a.x, b.x), hull(a.y, b.y), hull(a.z, b.z)};
}
/// Range of the largest channel.
template <std::floating_point S>
[[nodiscard]] inline Interval<S> max_channel(const RgbInterval<S>& c) noexcept {
  return max(c.x, max(c.y, c.z));
}

/// What a pattern's scalars are: S if both directions are vectors, else an interval.
template <class Wi, class Wo, std::floating_point S>
using PatternScalar = std::conditional_t<std::is_same_v<Wi, Vec3<S>> && std::is_same_v<Wo, Vec3<S>>, S, Interval<S>>;

/// And its colours.
template <class Wi, class Wo, std::floating_point S>
using PatternColour = std::conditional_t<std::is_same_v<PatternScalar<Wi, Wo, S>, S>, Rgb<S>, RgbInterval<S>>;

}  // namespace manylight
