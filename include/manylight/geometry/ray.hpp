// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "manylight/core/vector.hpp"

namespace manylight {

/// Points `origin + t * direction`, t in [t_min, t_max]. The direction need not have unit length: a shadow ray between
/// two points has the whole segment as its direction and t_max just below 1. World frame, metres.
template <std::floating_point S>
struct Ray {
  Vec3<S> origin;
  Vec3<S> direction;
  S t_min = S(0);
  S t_max = k_infinity<S>;
};

/// Where a ray meets a shape: enough to rebuild the surface point, independent of the backend.
template <std::floating_point S>
struct Hit {
  S t;                      ///< ray parameter, in units of the ray's direction length
  std::uint32_t shape;      ///< id in `Shapes`
  std::uint32_t primitive;  ///< triangle index of a mesh, 0 otherwise
  S u;                      ///< barycentric weight of the triangle's second corner
  S v;                      ///< barycentric weight of the triangle's third corner
};

/// A point on a surface, world frame.
template <std::floating_point S>
struct SurfacePoint {
  Vec3<S> position;
  S error;                  ///< bound of the absolute error of each coordinate of `position`, m
  Vec3<S> ng;               ///< geometric unit normal, on the side that the shape declares as outside
  Vec3<S> ns;               ///< shading unit normal, same hemisphere as `ng`
  Vec3<S> dpdu;             ///< derivative of the position by u, m, (0,0,0) if unknown
  Vec3<S> dpdv;             ///< the same by v
  Vec2<S> uv;
  std::uint32_t shape;
  std::uint32_t primitive;
};

}  // namespace manylight
