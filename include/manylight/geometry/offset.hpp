// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <concepts>
#include <limits>

#include "manylight/core/vector.hpp"
#include "manylight/geometry/ray.hpp"

/// Leaving a surface without meeting it again, by bounds of the rounding error instead of a global epsilon:
/// a scene keeps its picture whether it is measured in millimetres or kilometres, or lies far from the origin.
/// [Pharr, Jakob and Humphreys 2016, section 3.9 "Managing Rounding Error"]
namespace manylight {

/// Bound of the relative error of n rounded operations in a row: gamma(n) = n u / (1 - n u), u half an ulp of 1.
/// [Higham 2002, section 3.1]
template <std::floating_point S>
[[nodiscard]] constexpr S rounding_gamma(int n) noexcept {
  const S nu = static_cast<S>(n) * std::numeric_limits<S>::epsilon() / S(2);
  return nu / (S(1) - nu);
}

/// Moves `position` (m), known to within `error` per coordinate, along the unit normal `ng` to the side on which
/// `direction` leaves, far enough that the true surface lies behind the result.
template <std::floating_point S>
[[nodiscard]] inline Vec3<S> offset_origin(const Vec3<S>& position, S error, const Vec3<S>& ng,
                                           const Vec3<S>& direction) noexcept {
  // Half the extent of the error box along ng: no point of the box lies further out.
  const S distance = error * (std::abs(ng.x) + std::abs(ng.y) + std::abs(ng.z));
  const Vec3<S> offset = ng * (glm::dot(direction, ng) < S(0) ? -distance : distance);
  Vec3<S> result = position + offset;
  for (int axis = 0; axis < 3; ++axis) {
    // The sum itself rounds, possibly back into the box: step one ulp further out.
    const S ulp = std::abs(result[axis]) * std::numeric_limits<S>::epsilon();
    if (offset[axis] > S(0)) result[axis] += ulp;
    if (offset[axis] < S(0)) result[axis] -= ulp;
  }
  return result;
}

/// The ray leaving a surface at `p` along `direction`, with no upper end.
template <std::floating_point S>
[[nodiscard]] inline Ray<S> leaving_ray(const SurfacePoint<S>& p, const Vec3<S>& direction) noexcept {
  return {offset_origin(p.position, p.error, p.ng, direction), direction};
}

/// Shadow ray between the surface points `p` and `q`, each with its error bound (m) and unit geometric normal. The
/// direction is the whole segment between the two offset points, t_max just below 1.
template <std::floating_point S>
[[nodiscard]] inline Ray<S> segment_ray(const Vec3<S>& p, S error_p, const Vec3<S>& ng_p, const Vec3<S>& q, S error_q,
                                        const Vec3<S>& ng_q) noexcept {
  const Vec3<S> from_p_to_q = q - p;
  // A backend translates the surface at q to the ray's origin: it sees that surface rounded relative to the distance.
  const S error_far = error_q + rounding_gamma<S>(8) * glm::length(from_p_to_q);
  const Vec3<S> origin = offset_origin(p, error_p, ng_p, from_p_to_q);
  const Vec3<S> end = offset_origin(q, error_far, ng_q, -from_p_to_q);
  return {origin, end - origin, S(0), S(1) - S(4) * std::numeric_limits<S>::epsilon()};
}

/// Shadow ray from the surface point `p` to the point `q` that lies on no surface (a point light, the eye).
template <std::floating_point S>
[[nodiscard]] inline Ray<S> segment_ray(const Vec3<S>& p, S error_p, const Vec3<S>& ng_p, const Vec3<S>& q) noexcept {
  const Vec3<S> origin = offset_origin(p, error_p, ng_p, q - p);
  return {origin, q - origin, S(0), S(1) - S(4) * std::numeric_limits<S>::epsilon()};
}

}  // namespace manylight
