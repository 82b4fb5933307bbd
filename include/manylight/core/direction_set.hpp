// SPDX-License-Identifier: Apache-2.0
#pragma once

// Sets of directions for bounds: what a formula asks of a unit vector (components, dot product, half vector, mirror
// image), asked of all directions in a cone or in a ring around its axis. Answers are exact up to rounding, which only
// widens them: intervals of the components would not do, as they forget that the vectors are unit.

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

/// Cosine and sine of an angle in [0, pi].
template <std::floating_point S>
struct Turn {
  S cosine;
  S sine;
};
/// cos(a + b) and cos(a - b).
template <std::floating_point S>
[[nodiscard]] constexpr S cos_sum(const Turn<S>& a, const Turn<S>& b) noexcept {
  return a.cosine * b.cosine - a.sine * b.sine;
}
template <std::floating_point S>
[[nodiscard]] constexpr S cos_difference(const Turn<S>& a, const Turn<S>& b) noexcept {
  return a.cosine * b.cosine + a.sine * b.sine;
}

/// Cosines of the angles between a vector at `angle` off an axis and all vectors between `inner` and `outer` off it:
/// angles from max(0, angle - outer, inner - angle) to min(pi, angle + outer, 2 pi - inner - angle), without inverse
/// functions. Unit vectors are so up to rounding, hence ends may pass 1 by the margin.
template <std::floating_point S>
[[nodiscard]] inline Interval<S> cosines_around(const Turn<S>& angle, const Turn<S>& inner,
                                                const Turn<S>& outer) noexcept {
  constexpr S k_margin = k_cosine_margin<S>;
  constexpr S k_one = S(1) + k_margin;
  S lo = -k_one;
  if (angle.cosine > -outer.cosine) {
    lo = cos_sum(angle, outer) - k_margin;
  } else if (angle.cosine < -inner.cosine) {
    lo = cos_sum(angle, inner) - k_margin;
  }
  S hi = k_one;
  if (angle.cosine < outer.cosine) {
    hi = cos_difference(angle, outer) + k_margin;
  } else if (angle.cosine > inner.cosine) {
    hi = cos_difference(angle, inner) + k_margin;
  }
  return {std::max(lo, -k_one), std::min(hi, k_one)};
}
}  // namespace detail

/// All unit vectors within `cone`, in the frame of its axis, but not nearer to its axis than the inner angle: a ring, or
/// without an inner angle the whole cone. `x`, `y`, `z`, ranges of the components, read like those of a vector.
template <std::floating_point S>
struct DirectionSet {
  using Scalar = S;
  DirectionCone<S> cone;  ///< whole sphere by default
  S cos_inner = S(1);     ///< of the inner angle
  S sin_inner = S(0);
  Interval<S> x{S(-1), S(1)};
  Interval<S> y{S(-1), S(1)};
  Interval<S> z{S(-1), S(1)};

  DirectionSet() = default;
  /// `c.axis` must be unit, `c.cos_half`^2 + `c.sin_half`^2 = 1, both up to rounding, as for the inner angle, which must
  /// not be larger.
  explicit DirectionSet(const DirectionCone<S>& c, S cosine_inner = S(1), S sine_inner = S(0)) noexcept
      : cone(c), cos_inner(cosine_inner), sin_inner(sine_inner), x(component(0)), y(component(1)), z(component(2)) {}
  /// All within `half_angle` (rad) of the unit `axis`.
  DirectionSet(const Vec3<S>& axis, S half_angle) noexcept : DirectionSet(around(axis, half_angle)) {}
  /// All between `inner` and `outer` (rad) off the unit `axis`.
  [[nodiscard]] static DirectionSet ring(const Vec3<S>& axis, S inner, S outer) noexcept {
    return DirectionSet(around(axis, outer), std::cos(inner), std::sin(inner));
  }
  /// All of the side z >= 0 or z <= 0, without those next to it that rounding adds to a cone.
  [[nodiscard]] static DirectionSet hemisphere(bool upper) noexcept {
    DirectionSet half({Vec3<S>(0, 0, upper ? S(1) : S(-1)), S(0), S(1)});
    half.z = upper ? Interval<S>(S(0), S(1)) : Interval<S>(S(-1), S(0));
    return half;
  }

  [[nodiscard]] DirectionSet operator-() const noexcept {
    DirectionSet opposite = *this;
    opposite.cone.axis = -cone.axis;
    opposite.x = -x;
    opposite.y = -y;
    opposite.z = -z;
    return opposite;
  }

  [[nodiscard]] detail::Turn<S> inner() const noexcept { return {cos_inner, sin_inner}; }
  [[nodiscard]] detail::Turn<S> outer() const noexcept { return {cone.cos_half, cone.sin_half}; }

 private:
  [[nodiscard]] static DirectionCone<S> around(const Vec3<S>& axis, S half_angle) noexcept {
    if (!(half_angle < k_pi<S>)) return {axis, S(-1), S(0)};
    return {axis, std::cos(half_angle), std::sin(half_angle)};
  }
  [[nodiscard]] Interval<S> component(int i) const noexcept {
    // The sine from the other components: sqrt(1 - cos^2) loses half its digits next to 1.
    const S p = cone.axis[(i + 1) % 3];
    const S q = cone.axis[(i + 2) % 3];
    return detail::cosines_around({cone.axis[i], std::sqrt(p * p + q * q)}, inner(), outer());
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
  return detail::cosines_around({glm::dot(a.cone.axis, b), sine}, a.inner(), a.outer());
}
template <std::floating_point S>
[[nodiscard]] inline Interval<S> dot(const Vec3<S>& a, const DirectionSet<S>& b) noexcept {
  return dot(b, a);
}
/// Of two sets, as if both had no inner angle.
template <std::floating_point S>
[[nodiscard]] inline Interval<S> dot(const DirectionSet<S>& a, const DirectionSet<S>& b) noexcept {
  const detail::Turn<S> p = a.outer();
  const detail::Turn<S> q = b.outer();
  const detail::Turn<S> sum{cos_sum(p, q), p.sine * q.cosine + p.cosine * q.sine};
  constexpr S k_one = S(1) + detail::k_cosine_margin<S>;
  const bool reaches_around = sum.sine <= S(0) && sum.cosine < S(1);  // the half-angles add to pi or more
  if (a.cone.is_full() || b.cone.is_full() || reaches_around) return {-k_one, k_one};
  const S sine = glm::length(glm::cross(a.cone.axis, b.cone.axis));
  return detail::cosines_around({glm::dot(a.cone.axis, b.cone.axis), sine}, {S(1), S(0)}, sum);
}

/// The mirror image about the normal, +z.
template <std::floating_point S>
[[nodiscard]] constexpr Vec3<S> mirror(const Vec3<S>& w) noexcept {
  return {-w.x, -w.y, w.z};
}
template <std::floating_point S>
[[nodiscard]] inline DirectionSet<S> mirror(const DirectionSet<S>& w) noexcept {
  DirectionSet<S> image = w;  // keeps what is known of z
  image.cone.axis = mirror(w.cone.axis);
  image.x = -w.x;
  image.y = -w.y;
  return image;
}

/// The mirror image about the unit vector `m`. (glm::reflect has the opposite sign.)
template <std::floating_point S>
[[nodiscard]] inline Vec3<S> mirror(const Vec3<S>& w, const Vec3<S>& m) noexcept {
  return S(2) * glm::dot(w, m) * m - w;
}
template <std::floating_point S>
[[nodiscard]] inline DirectionSet<S> mirror(const DirectionSet<S>& w, const Vec3<S>& m) noexcept {
  const Vec3<S> axis = glm::normalize(mirror(w.cone.axis, m));
  return DirectionSet<S>({axis, w.cone.cos_half, w.cone.sin_half}, w.cos_inner, w.sin_inner);
}

namespace detail {
/// Upper bound of an angle, rad; below 30 degrees by the series of the arc sine, the last term of which stands for all
/// that follow (their sum over x^7 rises, to 0.05401 at x = 1/2).
template <std::floating_point S>
[[nodiscard]] inline S angle_above(const Turn<S>& a) noexcept {
  if (!(a.cosine > S(0.87))) return std::atan2(a.sine, a.cosine);
  const S x2 = a.sine * a.sine;
  return a.sine * (S(1) + x2 * (S(1) / S(6) + x2 * (S(0.075) + x2 * S(0.05402)))) * (S(1) + k_cosine_margin<S>);
}
/// A turn by at least `angle` (rad, at least 0), itself at most pi.
template <std::floating_point S>
[[nodiscard]] inline Turn<S> turn_above(S angle) noexcept {
  if (!(angle < k_pi<S>)) return {S(-1), S(0)};
  if (!(angle < S(1))) return {std::cos(angle), std::sin(angle)};
  const S a2 = angle * angle;
  const S sine = angle * (S(1) - a2 * (S(1) / S(6) - a2 / S(120)));  // the series' next term is negative
  return {std::sqrt(S(1) - sine * sine), sine};
}
/// Half of an angle, less `margin` (rad, small); at least 0.
template <std::floating_point S>
[[nodiscard]] inline Turn<S> half_below(const Turn<S>& angle, S margin) noexcept {
  const S cosine = std::sqrt(std::max(S(0), (S(1) + angle.cosine) / S(2)));
  const S sine = angle.cosine > S(0) ? angle.sine / (S(2) * cosine) : std::sqrt((S(1) - angle.cosine) / S(2));
  if (sine < S(0.8)) {
    const S less = std::max(S(0), sine - margin);
    return {std::sqrt(S(1) - less * less), less};
  }
  const S more = std::min(S(1), cosine + S(2) * margin);
  return {more, std::sqrt(S(1) - more * more)};
}

/// Half vectors of `wo` and of `wi` between `inner` and `outer` off `axis`. Seen from wo, theta -> theta / 2 stretches by
/// 1/2 along and by 1 / (2 cos(theta / 2)) across, so that all lie within outer / (2 cos(theta_max / 2)) of the axis' own
/// [theory 6.4], and, as nothing shrinks by more than 1/2, not nearer than inner / 2. With wo in a cone, too, both move by
/// turns, and the half-angles add. The outer angle is pi if theta_max comes next to pi, where the half vector may point
/// anywhere across.
template <std::floating_point S>
[[nodiscard]] inline DirectionSet<S> half_vectors(const Vec3<S>& axis, const Vec3<S>& wo, const Turn<S>& inner,
                                                  const Turn<S>& outer, S outer_angle) noexcept {
  constexpr S k_margin = k_cosine_margin<S>;
  const Vec3<S> sum = axis + wo;
  const S length = glm::length(sum);
  if (!(length > S(64) * k_margin)) return {};
  // The axis' own error is that of the two vectors, over the length of their sum.
  const S axis_error = k_margin / length;
  const Turn<S> nearest = inner.sine > S(0) || inner.cosine < S(0) ? half_below(inner, axis_error) : Turn<S>{S(1), S(0)};
  const Turn<S> theta{glm::dot(axis, wo), glm::length(glm::cross(axis, wo))};
  const S cos_max = cos_sum(theta, outer) - k_margin;
  const S sin_max = theta.sine * outer.cosine + theta.cosine * outer.sine;
  Turn<S> farthest{S(-1), S(0)};
  const bool is_below_pi = sin_max > S(0) || (theta.cosine > S(0) && outer.cosine > S(0));
  if (is_below_pi && cos_max > S(64) * k_margin - S(1)) {
    const S stretch = S(1) / std::sqrt(S(2) * (S(1) + cos_max));
    farthest = turn_above((outer_angle + S(2) * k_margin) * stretch * (S(1) + k_margin));
  }
  return DirectionSet<S>({sum / length, farthest.cosine, farthest.sine}, nearest.cosine, nearest.sine);
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
  return detail::half_vectors(wi.cone.axis, wo, wi.inner(), wi.outer(), detail::angle_above(wi.outer()));
}
template <std::floating_point S>
[[nodiscard]] inline DirectionSet<S> half_vector(const Vec3<S>& wi, const DirectionSet<S>& wo) noexcept {
  return half_vector(wo, wi);
}
/// Of two sets, as if both had no inner angle.
template <std::floating_point S>
[[nodiscard]] inline DirectionSet<S> half_vector(const DirectionSet<S>& wi, const DirectionSet<S>& wo) noexcept {
  const S angle = detail::angle_above(wi.outer()) + detail::angle_above(wo.outer());
  if (!(angle < k_pi<S>)) return {};
  return detail::half_vectors(wi.cone.axis, wo.cone.axis, {S(1), S(0)}, {std::cos(angle), std::sin(angle)}, angle);
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
/// sqrt(rho^2 - sin^2(half)). Unbounded where the cone reaches the horizon. Only of members above it.
template <std::floating_point S>
[[nodiscard]] inline Slopes<S> slopes(const DirectionSet<S>& set) noexcept {
  constexpr S k_margin = detail::k_cosine_margin<S>;
  const Vec3<S>& a = set.cone.axis;
  const S across = std::sqrt(a.x * a.x + a.y * a.y);
  // A ring around an axis near the normal is far from the normal: by inner - (angle of the axis).
  const S sin_near = set.sin_inner * a.z - set.cos_inner * across - k_margin;
  const S cos_near = set.cos_inner * a.z + set.sin_inner * across + k_margin;
  const S tan_near = sin_near > S(0) && cos_near > S(0) ? sin_near / cos_near * (S(1) - k_margin) : S(0);
  const S tan2_near = tan_near * tan_near;
  if (!(set.z.lo > S(0)) || set.cone.cos_half <= S(0)) {
    return {Interval<S>::whole(), Interval<S>::whole(), {tan2_near, k_infinity<S>}};
  }
  const S sine = set.cone.sin_half + k_margin;
  const auto range = [&](S along) -> Interval<S> {
    const S left = along * along + a.z * a.z - sine * sine;
    if (!(left > S(0))) return Interval<S>::whole();
    const S delta = sine / std::sqrt(left);
    const S low = a.z + along * delta;   // cos(shadow - delta), up to a factor
    const S high = a.z - along * delta;  // cos(shadow + delta)
    if (!(low > S(0) && high > S(0))) return Interval<S>::whole();
    const S margin = S(8) * k_margin;
    const S from = (along - a.z * delta) / low;
    const S to = (along + a.z * delta) / high;
    return {from - margin * (std::abs(from) + delta), to + margin * (std::abs(to) + delta)};
  };
  // tan^2 of the polar angle, whose cosines are z: sin^2 = 1 - z^2 next to the pole would lose what sqrt(x^2 + y^2)
  // keeps.
  const Interval<S> radial = range(across);
  return {range(a.x), range(a.y), {std::max(sqr(std::max(S(0), radial.lo)), tan2_near), radial.hi * radial.hi}};
}

}  // namespace manylight
