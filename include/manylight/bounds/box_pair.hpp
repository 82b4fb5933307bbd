// SPDX-License-Identifier: Apache-2.0
#pragma once

// Bounds of distance and direction between two boxes, [Walter 2005] and theory sheet, section 6.1. All vectors run from
// the sensor's box to the light's box.

#include <cmath>

#include "manylight/bounds/direction_cone.hpp"
#include "manylight/core/box.hpp"

namespace manylight {

/// All vectors from a point of `from` to a point of `to`.
template <std::floating_point S>
[[nodiscard]] inline Box<S> difference(const Box<S>& from, const Box<S>& to) noexcept {
  return {to.lo - from.hi, to.hi - from.lo};
}

/// Lower bound of the squared length of the vectors in `vectors`, m^2; 0 if it contains 0.
template <std::floating_point S>
[[nodiscard]] inline S min_squared_length(const Box<S>& vectors) noexcept {
  const Vec3<S> gap = glm::max(Vec3<S>(0), glm::max(vectors.lo, -vectors.hi));
  return glm::dot(gap, gap) * (S(1) - S(8) * std::numeric_limits<S>::epsilon());
}

/// Cone around all directions of the vectors in `vectors`, by the box's bounding sphere; full if that contains 0.
template <std::floating_point S>
[[nodiscard]] inline DirectionCone<S> directions(const Box<S>& vectors) noexcept {
  const Vec3<S> center = (vectors.lo + vectors.hi) * S(0.5);
  const Vec3<S> half = (vectors.hi - vectors.lo) * S(0.5);
  const S squared_distance = glm::dot(center, center);
  const S squared_radius = glm::dot(half, half) * (S(1) + S(16) * std::numeric_limits<S>::epsilon()) +
                           squared_distance * sqr(S(8) * std::numeric_limits<S>::epsilon());
  if (!(squared_radius < squared_distance)) return {};
  const S squared_sine = squared_radius / squared_distance;
  return {center / std::sqrt(squared_distance), std::sqrt(S(1) - squared_sine), std::sqrt(squared_sine)};
}

}  // namespace manylight
