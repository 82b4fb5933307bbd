// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "manylight/core/vector.hpp"

namespace manylight {

/// Right-handed orthonormal frame; local z is the normal `n`.
template <std::floating_point S>
struct Frame {
  Vec3<S> s{1, 0, 0};
  Vec3<S> t{0, 1, 0};
  Vec3<S> n{0, 0, 1};

  Frame() = default;
  /// Any frame around the unit vector `normal`, without a branch on its direction
  /// [Duff 2017, "Building an Orthonormal Basis, Revisited"].
  explicit Frame(const Vec3<S>& normal) noexcept : n(normal) {
    const S sign = std::copysign(S(1), n.z);
    const S a = S(-1) / (sign + n.z);
    const S b = n.x * n.y * a;
    s = {S(1) + sign * n.x * n.x * a, sign * b, -sign * n.x};
    t = {b, sign + n.y * n.y * a, -n.y};
  }
  /// Frame around the unit vector `normal` whose s lies in the plane of `normal` and `tangent`
  /// (any length); falls back to any frame when the two are parallel or `tangent` is zero.
  Frame(const Vec3<S>& normal, const Vec3<S>& tangent) noexcept : Frame(normal) {
    const Vec3<S> in_plane = tangent - normal * glm::dot(normal, tangent);
    const S length = glm::length(in_plane);
    if (length > S(1e-6) * glm::length(tangent) && std::isfinite(length)) {
      s = in_plane / length;
      t = glm::cross(n, s);
    }
  }

  [[nodiscard]] Vec3<S> to_local(const Vec3<S>& w) const noexcept {
    return {glm::dot(w, s), glm::dot(w, t), glm::dot(w, n)};
  }
  [[nodiscard]] Vec3<S> to_world(const Vec3<S>& w) const noexcept { return s * w.x + t * w.y + n * w.z; }
};

}  // namespace manylight
