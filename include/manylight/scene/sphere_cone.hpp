// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "manylight/core/frame.hpp"
#include "manylight/core/vector.hpp"

namespace manylight {

/// The cone of directions in which a sphere is seen from a point outside it. Written with 1 - cos and d - r, so that
/// float keeps its digits for spheres that are tiny, far away or touched by the point.
template <std::floating_point S>
struct SphereCone {
  Vec3<S> axis;         ///< unit, from the point to the centre
  S sin2_max;           ///< squared sine of the half-angle, (0, 1]
  S one_minus_cos_max;  ///< 1 - cosine of the half-angle
  S distance;           ///< to the centre, m

  /// None for a point inside or on the sphere.
  [[nodiscard]] static std::optional<SphereCone> seen_from(const Vec3<S>& point, const Vec3<S>& center,
                                                           S radius) noexcept {
    const Vec3<S> to_center = center - point;
    const S d = glm::length(to_center);
    if (!(d > radius)) return std::nullopt;
    const S sin_max = radius / d;
    const S cos_max = safe_sqrt((d - radius) * (d + radius)) / d;
    return SphereCone{to_center / d, sin_max * sin_max, sin_max * sin_max / (S(1) + cos_max), d};
  }

  /// Density of directions drawn uniformly from the cone, sr^-1.
  [[nodiscard]] S pdf() const noexcept { return S(1) / (S(2) * k_pi<S> * one_minus_cos_max); }

  /// A direction drawn uniformly from the cone and the unit outward normal where it enters the sphere.
  struct Direction {
    Vec3<S> wi, normal;
  };
  [[nodiscard]] Direction sample(const Vec2<S>& u) const noexcept {
    const S one_minus_cos = u.x * one_minus_cos_max;
    const S cos_theta = S(1) - one_minus_cos;
    const S sin2_theta = one_minus_cos * (S(2) - one_minus_cos);
    const S sin_theta = safe_sqrt(sin2_theta);
    const S phi = S(2) * k_pi<S> * u.y;
    // Angle alpha at the sphere's centre between the axis back to the point and the entry point, from the sine law:
    // sin(alpha + theta) = sin(theta) / sin_max.
    const S sin_max = std::sqrt(sin2_max);
    const S ratio = std::min(sin_theta / sin_max, S(1));
    const S cos_sum = safe_sqrt((S(1) - ratio) * (S(1) + ratio));
    const S cos_alpha = ratio * sin_theta + cos_sum * cos_theta;
    const S sin_alpha = std::max(ratio * cos_theta - cos_sum * sin_theta, S(0));
    const Frame<S> frame(axis);
    const Vec3<S> side = frame.s * std::cos(phi) + frame.t * std::sin(phi);
    return {glm::normalize(side * sin_theta + axis * cos_theta), glm::normalize(side * sin_alpha - axis * cos_alpha)};
  }
};

}  // namespace manylight
