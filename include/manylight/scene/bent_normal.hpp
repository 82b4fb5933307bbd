// SPDX-License-Identifier: Apache-2.0
#pragma once

// Shading normals that textures bend, for shaders that have a `shading_normal`. Both functions return a unit normal on
// the side of `ng`, and the surface's own shading normal where the texture asks for one beyond the horizon, or where
// the surface has no texture coordinates: such a place is shaded as if it were smooth, never black.

#include <cmath>

#include "manylight/core/frame.hpp"
#include "manylight/geometry/ray.hpp"

namespace manylight {

/// Of the surface displaced along its shading normal by a height h(u, v) with derivatives `gradient` = (dh/du, dh/dv),
/// m: perpendicular to dp/du + n dh/du and dp/dv + n dh/dv, of dp/du and dp/dv the parts across n. [Blinn 1978]
template <std::floating_point S>
[[nodiscard]] inline Vec3<S> bumped_normal(const SurfacePoint<S>& point, const Vec2<S>& gradient) noexcept {
  const Vec3<S>& n = point.ns;
  const Vec3<S> along_u = point.dpdu + n * (gradient.x - glm::dot(n, point.dpdu));
  const Vec3<S> along_v = point.dpdv + n * (gradient.y - glm::dot(n, point.dpdv));
  Vec3<S> bent = glm::cross(along_u, along_v);
  if (glm::dot(bent, n) < S(0)) bent = -bent;
  const S length = glm::length(bent);
  if (!(length > S(0) && std::isfinite(length)) || !(glm::dot(bent, point.ng) > S(0))) return n;
  return bent / length;
}

/// The normal that a map gives as `local` (any length) in the shading frame: x along dp/du, z the shading normal.
template <std::floating_point S>
[[nodiscard]] inline Vec3<S> mapped_normal(const SurfacePoint<S>& point, const Vec3<S>& local) noexcept {
  const S length = glm::length(local);
  if (!(glm::dot(point.dpdu, point.dpdu) > S(0)) || !(length > S(0) && std::isfinite(length)) || !(local.z > S(0))) {
    return point.ns;
  }
  const Vec3<S> bent = glm::normalize(Frame<S>(point.ns, point.dpdu).to_world(local / length));
  return glm::dot(bent, point.ng) > S(0) ? bent : point.ns;
}

}  // namespace manylight
