// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "manylight/core/box.hpp"
#include "manylight/core/vector.hpp"

namespace manylight {

/// A set of directions: all within the half-angle of the unit `axis`. The half-angle is kept by cosine and sine, as an
/// arc cosine near 1 loses half its digits. Default-constructed it is the whole sphere.
template <std::floating_point S>
struct DirectionCone {
  Vec3<S> axis{0, 0, 1};
  S cos_half = S(-1);
  S sin_half = S(0);

  [[nodiscard]] static DirectionCone of(const Vec3<S>& direction) noexcept { return {direction, S(1), S(0)}; }
  [[nodiscard]] DirectionCone operator-() const noexcept { return {-axis, cos_half, sin_half}; }
  [[nodiscard]] bool is_full() const noexcept { return cos_half <= S(-1); }
  [[nodiscard]] S half_angle() const noexcept { return std::atan2(sin_half, cos_half); }
};

/// min(1, half-angle) to within 16 %, without inverse functions: for choices, not for bounds.
template <std::floating_point S>
[[nodiscard]] inline S spread(const DirectionCone<S>& cone) noexcept {
  return cone.cos_half > S(0.54) ? cone.sin_half : S(1);
}

/// Smallest cone that holds both, up to rounding, which only widens it.
template <std::floating_point S>
[[nodiscard]] inline DirectionCone<S> unite(const DirectionCone<S>& a, const DirectionCone<S>& b) noexcept {
  if (a.is_full() || b.is_full()) return {};
  // By the angle: cosines of narrow cones all round to 1.
  const bool a_is_wide = a.half_angle() >= b.half_angle();
  const DirectionCone<S>& wide = a_is_wide ? a : b;
  const DirectionCone<S>& narrow = a_is_wide ? b : a;
  const Vec3<S> cross = glm::cross(wide.axis, narrow.axis);
  const S between = std::atan2(glm::length(cross), glm::dot(wide.axis, narrow.axis));
  const S wide_half = wide.half_angle();
  const S reach = between + narrow.half_angle();
  if (reach <= wide_half) return wide;
  const S slack = S(64) * std::numeric_limits<S>::epsilon();  // of atan2, the rotation and the cosines below
  const S half = (wide_half + reach) / 2 + slack;
  if (!(half < k_pi<S>)) return {};
  // Rotate the wide axis towards the narrow one. Next to equal or opposite axes the plane to rotate in is rounding
  // noise: equal ones lie within the slack, opposite ones have no small cone.
  if (!(glm::length(cross) > S(8) * std::numeric_limits<S>::epsilon())) {
    if (between > S(1)) return {};
    return {wide.axis, std::cos(reach + slack), std::sin(reach + slack)};
  }
  const S turn = half - wide_half;
  const Vec3<S> across = glm::normalize(glm::cross(cross, wide.axis));
  const Vec3<S> axis = glm::normalize(wide.axis * std::cos(turn) + across * std::sin(turn));
  return {axis, std::cos(half), std::sin(half)};
}

/// Upper bound of cos(angle(u, v)) for u in `a`, v in `b`.
template <std::floating_point S>
[[nodiscard]] inline S max_cosine(const DirectionCone<S>& a, const DirectionCone<S>& b) noexcept {
  if (a.is_full() || b.is_full()) return S(1);
  const S cos_sum = a.cos_half * b.cos_half - a.sin_half * b.sin_half;
  const S sin_sum = a.sin_half * b.cos_half + a.cos_half * b.sin_half;
  if (sin_sum <= S(0) && cos_sum < S(1)) return S(1);  // the half-angles add to pi or more
  const S cosine = std::clamp(glm::dot(a.axis, b.axis), S(-1), S(1));
  if (cosine >= cos_sum) return S(1);
  const S rounding = S(16) * std::numeric_limits<S>::epsilon();
  // The sine by the cross product: sqrt(1 - cosine^2) loses half its digits at nearly opposite axes.
  return std::min(S(1), cosine * cos_sum + glm::length(glm::cross(a.axis, b.axis)) * sin_sum + rounding);
}

/// Lower bound of the angle between u in `a` and v in `b`, rad.
template <std::floating_point S>
[[nodiscard]] inline S min_angle(const DirectionCone<S>& a, const DirectionCone<S>& b) noexcept {
  return std::acos(std::clamp(max_cosine(a, b), S(-1), S(1)));
}

}  // namespace manylight
