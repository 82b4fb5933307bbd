// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <concepts>

#include "manylight/core/vector.hpp"

namespace manylight {

/// cross(b - a, c - a) of a triangle, not normalised. In double also for float: the products are then exact, and the
/// normal of a sliver is not noise.
template <std::floating_point S>
[[nodiscard]] inline Vec3<double> triangle_cross(const Vec3<S>& a, const Vec3<S>& b, const Vec3<S>& c) noexcept {
  const Vec3<double> origin(a);
  return glm::cross(Vec3<double>(b) - origin, Vec3<double>(c) - origin);
}

/// Whether a triangle can be hit at all.
template <std::floating_point S>
[[nodiscard]] inline bool has_area(const Vec3<S>& a, const Vec3<S>& b, const Vec3<S>& c) noexcept {
  return triangle_cross(a, b, c) != Vec3<double>(0);
}

namespace detail {

/// `v` at length 1, or zero where it has no direction.
template <std::floating_point S>
[[nodiscard]] Vec3<S> normalize_or_zero(const Vec3<S>& v) noexcept {
  const S length = glm::length(v);
  return length > S(0) && std::isfinite(length) ? v / length : Vec3<S>(0);
}

}  // namespace detail

}  // namespace manylight
