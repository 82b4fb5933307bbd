// SPDX-License-Identifier: Apache-2.0
#pragma once

// Bounds of distance and direction between two boxes, [Walter 2005] and theory sheet, section 6.1. All vectors run from
// the sensor's box to the light's box.

#include <algorithm>
#include <cmath>
#include <limits>

#include "manylight/core/box.hpp"
#include "manylight/core/direction_cone.hpp"
#include "manylight/core/frame.hpp"

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

/// The directions of all vectors in a box, for bounds of cosines with them.
template <std::floating_point S>
class BoxDirections {
 public:
  explicit BoxDirections(const Box<S>& vectors) noexcept
      : center_((vectors.lo + vectors.hi) * S(0.5)),
        half_((vectors.hi - vectors.lo) * S(0.5)),
        rounding_(S(16) * std::numeric_limits<S>::epsilon() *
                  (glm::dot(glm::abs(center_), Vec3<S>(1)) + glm::dot(half_, Vec3<S>(1)))) {}

  [[nodiscard]] BoxDirections operator-() const noexcept {
    BoxDirections opposite = *this;
    opposite.center_ = -center_;
    return opposite;
  }

  /// The vectors' box, a little wider.
  [[nodiscard]] Box<S> box() const noexcept { return {center_ - half_ - rounding_, center_ + half_ + rounding_}; }

  /// Upper bound of cos(angle(u, p)) for u in `axes`, p in the box. A cosine over the box [theory 6.1, Walter 2005], by
  /// intervals in a frame around the axis; then the turn by the axes' half-angle. Tight where a cone around the box is
  /// not: for flat boxes, such as those of two pieces of wall.
  friend S max_cosine(const DirectionCone<S>& axes, const BoxDirections& box) noexcept {
    if (axes.is_full()) return S(1);
    const S rounding = S(16) * std::numeric_limits<S>::epsilon();
    const S cosine = box.max_cosine_with(axes.axis) + rounding;  // before the sine, which is steep next to -1
    if (cosine >= axes.cos_half) return S(1);
    const S sine = std::sqrt(std::max(S(0), S(1) - sqr(cosine)));
    return std::min(S(1), cosine * axes.cos_half + sine * axes.sin_half + rounding);
  }

 private:
  [[nodiscard]] S max_cosine_with(const Vec3<S>& n) const noexcept {
    const S z = glm::dot(center_, n) + glm::dot(half_, glm::abs(n)) + rounding_;
    // z / |p| is largest at the shortest p if z > 0, at the longest if z < 0.
    if (z < S(0)) return z / glm::length(glm::abs(center_) + half_ + rounding_);
    const Frame<S> frame(n);
    const S across = sqr(min_distance(frame.s)) + sqr(min_distance(frame.t));
    return across > S(0) ? z / std::sqrt(across + z * z) : S(1);
  }
  /// Lower bound of |p . axis|, m.
  [[nodiscard]] S min_distance(const Vec3<S>& axis) const noexcept {
    return std::max(S(0), std::abs(glm::dot(center_, axis)) - glm::dot(half_, glm::abs(axis)) - rounding_);
  }

  Vec3<S> center_;  ///< of the box, m
  Vec3<S> half_;    ///< half its extent, m
  S rounding_;      ///< bound of the rounding of a component in any frame, m
};

}  // namespace manylight
