// SPDX-License-Identifier: Apache-2.0
#pragma once

// Sets of directions for bounds: what a formula asks of a unit vector (components, dot product, half vector, mirror
// image), asked of all directions in a cone. Answers are exact up to rounding, which only widens them: intervals of the
// components would not do, as they forget that the vectors are unit.

#include <algorithm>
#include <cmath>
#include <concepts>
#include <limits>

#include "manylight/core/direction_cone.hpp"
#include "manylight/core/interval.hpp"

namespace manylight {

namespace detail {
/// Margin of cosines: rounding of axes, members (both unit to 2 epsilon) and a few operations.
template <std::floating_point S>
inline constexpr S k_cosine_margin = S(16) * std::numeric_limits<S>::epsilon();

/// Cosines of angle +- half, the angle given by cosine and sine: [cos(min(pi, angle + half)), cos(max(0, angle -
/// half))], without inverse functions. Unit vectors are so up to rounding, hence ends may pass 1 by the margin.
template <std::floating_point S>
[[nodiscard]] inline Interval<S> cosines_around(S cosine, S sine, S cos_half, S sin_half) noexcept {
  constexpr S k_one = S(1) + k_cosine_margin<S>;
  const S lo = cosine <= -cos_half ? -k_one : cosine * cos_half - sine * sin_half - k_cosine_margin<S>;
  const S hi = cosine >= cos_half ? k_one : cosine * cos_half + sine * sin_half + k_cosine_margin<S>;
  return {std::max(lo, -k_one), std::min(hi, k_one)};
}
}  // namespace detail

/// All unit vectors within `cone`, in the frame of its axis, with the ranges of their components. `x`, `y`, `z` read
/// like those of a vector.
template <std::floating_point S>
struct DirectionSet {
  using Scalar = S;
  DirectionCone<S> cone;  ///< whole sphere by default
  Interval<S> x{S(-1), S(1)};
  Interval<S> y{S(-1), S(1)};
  Interval<S> z{S(-1), S(1)};

  DirectionSet() = default;
  /// `c.axis` must be unit, `c.cos_half`^2 + `c.sin_half`^2 = 1, both up to rounding.
  explicit DirectionSet(const DirectionCone<S>& c) noexcept
      : cone(c), x(component(c, 0)), y(component(c, 1)), z(component(c, 2)) {}
  /// All within `half_angle` (rad) of the unit `axis`.
  DirectionSet(const Vec3<S>& axis, S half_angle) noexcept : DirectionSet(around(axis, half_angle)) {}

  [[nodiscard]] DirectionSet operator-() const noexcept { return DirectionSet(-cone); }

 private:
  [[nodiscard]] static DirectionCone<S> around(const Vec3<S>& axis, S half_angle) noexcept {
    if (!(half_angle < k_pi<S>)) return {axis, S(-1), S(0)};
    return {axis, std::cos(half_angle), std::sin(half_angle)};
  }
  [[nodiscard]] static Interval<S> component(const DirectionCone<S>& c, int i) noexcept {
    // The sine from the other components: sqrt(1 - cos^2) loses half its digits next to 1.
    const S p = c.axis[(i + 1) % 3];
    const S q = c.axis[(i + 2) % 3];
    return detail::cosines_around(c.axis[i], std::sqrt(p * p + q * q), c.cos_half, c.sin_half);
  }
};

/// What patterns take as directions: a unit vector, or a set of them.
template <class D, class S>
concept LocalDirection = std::same_as<D, Vec3<S>> || std::same_as<D, DirectionSet<S>>;

/// Cosines of the angles between members of both.
template <std::floating_point S>
[[nodiscard]] inline S dot(const Vec3<S>& a, const Vec3<S>& b) noexcept {
  return glm::dot(a, b);
}
template <std::floating_point S>
[[nodiscard]] inline Interval<S> dot(const DirectionSet<S>& a, const Vec3<S>& b) noexcept {
  const S sine = glm::length(glm::cross(a.cone.axis, b));
  return detail::cosines_around(glm::dot(a.cone.axis, b), sine, a.cone.cos_half, a.cone.sin_half);
}
template <std::floating_point S>
[[nodiscard]] inline Interval<S> dot(const Vec3<S>& a, const DirectionSet<S>& b) noexcept {
  return dot(b, a);
}
template <std::floating_point S>
[[nodiscard]] inline Interval<S> dot(const DirectionSet<S>& a, const DirectionSet<S>& b) noexcept {
  const DirectionCone<S>& p = a.cone;
  const DirectionCone<S>& q = b.cone;
  const S cos_sum = p.cos_half * q.cos_half - p.sin_half * q.sin_half;
  const S sin_sum = p.sin_half * q.cos_half + p.cos_half * q.sin_half;
  constexpr S k_one = S(1) + detail::k_cosine_margin<S>;
  const bool reaches_around = sin_sum <= S(0) && cos_sum < S(1);  // the half-angles add to pi or more
  if (p.is_full() || q.is_full() || reaches_around) return {-k_one, k_one};
  const S sine = glm::length(glm::cross(p.axis, q.axis));
  return detail::cosines_around(glm::dot(p.axis, q.axis), sine, cos_sum, sin_sum);
}

/// The mirror image about the normal, +z.
template <std::floating_point S>
[[nodiscard]] constexpr Vec3<S> mirror(const Vec3<S>& w) noexcept {
  return {-w.x, -w.y, w.z};
}
template <std::floating_point S>
[[nodiscard]] inline DirectionSet<S> mirror(const DirectionSet<S>& w) noexcept {
  return DirectionSet<S>({mirror(w.cone.axis), w.cone.cos_half, w.cone.sin_half});
}

/// The mirror image about the unit vector `m`. (glm::reflect has the opposite sign.)
template <std::floating_point S>
[[nodiscard]] inline Vec3<S> mirror(const Vec3<S>& w, const Vec3<S>& m) noexcept {
  return S(2) * glm::dot(w, m) * m - w;
}
template <std::floating_point S>
[[nodiscard]] inline DirectionSet<S> mirror(const DirectionSet<S>& w, const Vec3<S>& m) noexcept {
  return DirectionSet<S>({glm::normalize(mirror(w.cone.axis, m)), w.cone.cos_half, w.cone.sin_half});
}

namespace detail {
/// Half vectors of `wi` within `half_angle` of `axis`, and `wo`. Seen from wo, theta -> theta / 2 stretches by 1/2
/// along and by 1 / (2 cos(theta / 2)) across, so that all lie within half_angle / (2 cos(theta_max / 2)) of the axis'
/// own [theory 6.4]. With wo in a cone, too, both move by turns, and the half-angles add. Whole sphere if theta_max
/// comes next to pi, where the half vector may point anywhere across.
template <std::floating_point S>
[[nodiscard]] inline DirectionSet<S> half_vectors(const Vec3<S>& axis, const Vec3<S>& wo, S half_angle) noexcept {
  const Vec3<S> sum = axis + wo;
  const S theta = std::atan2(glm::length(glm::cross(axis, wo)), glm::dot(axis, wo));
  const S margin = k_cosine_margin<S>;
  const S theta_max = theta + half_angle + margin;
  if (!(theta_max < k_pi<S> - S(64) * margin)) return {};
  // The axis' own error is that of the two vectors, over the length of their sum: the same stretch.
  const S half = (half_angle + margin) / (S(2) * std::cos(theta_max / S(2))) * (S(1) + margin);
  return DirectionSet<S>(glm::normalize(sum), half);
}
}  // namespace detail

/// Unit half vector of two directions; the normal if they cancel to nothing.
template <std::floating_point S>
[[nodiscard]] inline Vec3<S> half_vector(const Vec3<S>& wi, const Vec3<S>& wo) noexcept {
  const Vec3<S> h = wi + wo;
  const S length2 = glm::dot(h, h);
  return length2 > std::numeric_limits<S>::min() ? h / std::sqrt(length2) : Vec3<S>(0, 0, 1);
}
template <std::floating_point S>
[[nodiscard]] inline DirectionSet<S> half_vector(const DirectionSet<S>& wi, const Vec3<S>& wo) noexcept {
  return wi.cone.is_full() ? DirectionSet<S>() : detail::half_vectors(wi.cone.axis, wo, wi.cone.half_angle());
}
template <std::floating_point S>
[[nodiscard]] inline DirectionSet<S> half_vector(const Vec3<S>& wi, const DirectionSet<S>& wo) noexcept {
  return half_vector(wo, wi);
}
template <std::floating_point S>
[[nodiscard]] inline DirectionSet<S> half_vector(const DirectionSet<S>& wi, const DirectionSet<S>& wo) noexcept {
  if (wi.cone.is_full() || wo.cone.is_full()) return {};
  return detail::half_vectors(wi.cone.axis, wo.cone.axis, wi.cone.half_angle() + wo.cone.half_angle());
}

/// Range of x / z and y / z over a set: of the slopes of the facets whose normals it holds.
template <std::floating_point S>
struct Slopes {
  Interval<S> x;
  Interval<S> y;
  Interval<S> tan2;  ///< x^2 + y^2
};
/// A plane through the y axis of slope s = x / z touches the cone where sin(half) = rho |sin(angle to its axis)|, rho
/// the length of the axis' shadow on the xz plane: tan(angle of the shadow +- delta), tan(delta) = sin(half) /
/// sqrt(rho^2 - sin^2(half)). Unbounded where the cone reaches the horizon.
template <std::floating_point S>
[[nodiscard]] inline Slopes<S> slopes(const DirectionSet<S>& set) noexcept {
  const Vec3<S>& a = set.cone.axis;
  if (!(set.z.lo > S(0)) || set.cone.cos_half <= S(0)) {
    return {Interval<S>::whole(), Interval<S>::whole(), {S(0), k_infinity<S>}};
  }
  const S sine = set.cone.sin_half + detail::k_cosine_margin<S>;
  const auto range = [&](S along) -> Interval<S> {
    const S left = along * along + a.z * a.z - sine * sine;
    if (!(left > S(0))) return Interval<S>::whole();
    const S delta = sine / std::sqrt(left);
    const S low = a.z + along * delta;   // cos(shadow - delta), up to a factor
    const S high = a.z - along * delta;  // cos(shadow + delta)
    if (!(low > S(0) && high > S(0))) return Interval<S>::whole();
    const S margin = S(8) * detail::k_cosine_margin<S>;
    const S from = (along - a.z * delta) / low;
    const S to = (along + a.z * delta) / high;
    return {from - margin * (std::abs(from) + delta), to + margin * (std::abs(to) + delta)};
  };
  // tan^2 of the polar angle, whose cosines are z: sin^2 = 1 - z^2 next to the pole would lose what sqrt(x^2 + y^2)
  // keeps.
  const S across = std::sqrt(a.x * a.x + a.y * a.y);
  const Interval<S> radial = range(across);
  return {range(a.x), range(a.y), {sqr(std::max(S(0), radial.lo)), radial.hi * radial.hi}};
}

}  // namespace manylight
