// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>

#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>

#include "manylight/core/vector.hpp"
#include "manylight/geometry/shapes.hpp"
#include "manylight/geometry/triangle.hpp"
#include "manylight/geometry/validate.hpp"

namespace manylight {

template <std::floating_point S>
using Mat4 = glm::mat<4, 4, S, glm::defaultp>;

namespace detail {

template <std::floating_point S>
[[nodiscard]] Vec3<S> transform_point(const Mat4<S>& m, const Vec3<S>& p) noexcept {
  return Vec3<S>(m * glm::vec<4, S, glm::defaultp>(p, S(1)));
}

/// Matrix that carries normals: inverse transpose of the linear part.
template <std::floating_point S>
[[nodiscard]] glm::mat<3, 3, S, glm::defaultp> normal_matrix(const Mat4<S>& m) {
  const glm::mat<3, 3, S, glm::defaultp> linear(m);
  const S determinant = glm::determinant(linear);
  if (determinant == S(0) || !std::isfinite(determinant)) {
    throw_geometry_error("transformation has determinant ", determinant, ", allowed: finite and not 0");
  }
  return glm::transpose(glm::inverse(linear));
}

}  // namespace detail

/// The mesh moved by the affine `m`. Normals follow the inverse transpose. The winding stays as it is, so a reflection
/// turns the normal of a mesh without vertex normals (as Mitsuba does).
template <std::floating_point S>
[[nodiscard]] TriangleMesh<S> transform(TriangleMesh<S> mesh, const Mat4<S>& m) {
  const auto normal_matrix = detail::normal_matrix(m);
  for (Vec3<S>& p : mesh.positions) p = detail::transform_point(m, p);
  for (Vec3<S>& n : mesh.normals) n = detail::normalize_or_zero<S>(normal_matrix * n);
  return mesh;
}

/// The sphere moved by `m`, which must scale all axes alike (GeometryError otherwise). Its uv poles stay on z.
template <std::floating_point S>
[[nodiscard]] Sphere<S> transform(Sphere<S> sphere, const Mat4<S>& m) {
  constexpr S k_tolerance = S(1e-3);  // relative; files hold rotations with few digits
  const glm::mat<3, 3, S, glm::defaultp> linear(m);
  const Vec3<S> scale{glm::length(linear[0]), glm::length(linear[1]), glm::length(linear[2])};
  const S skew = std::max({std::abs(glm::dot(linear[0], linear[1])), std::abs(glm::dot(linear[1], linear[2])),
                           std::abs(glm::dot(linear[2], linear[0]))});
  const bool alike = std::abs(scale.y - scale.x) <= k_tolerance * scale.x &&
                     std::abs(scale.z - scale.x) <= k_tolerance * scale.x && skew <= k_tolerance * sqr(scale.x);
  if (!alike || !(scale.x > S(0))) {
    detail::throw_geometry_error("sphere: scales along the axes are ", scale.x, ", ", scale.y, ", ", scale.z,
                                 ", allowed: equal, above 0 and without shear");
  }
  sphere.center = detail::transform_point(m, sphere.center);
  sphere.radius *= scale.x;
  return sphere;
}

/// The disk moved by `m`, which must map it to a disk (GeometryError otherwise).
template <std::floating_point S>
[[nodiscard]] Disk<S> transform(Disk<S> disk, const Mat4<S>& m) {
  constexpr S k_tolerance = S(1e-3);  // relative; files hold rotations with few digits
  const glm::mat<3, 3, S, glm::defaultp> linear(m);
  const Vec3<S> along = linear * disk.tangent;
  const Vec3<S> across = linear * glm::cross(disk.normal, disk.tangent);
  const S scale = glm::length(along);
  if (!(scale > S(0)) || std::abs(glm::length(across) - scale) > k_tolerance * scale ||
      std::abs(glm::dot(along, across)) > k_tolerance * sqr(scale)) {
    detail::throw_geometry_error("disk: scales in its plane are ", scale, " and ", glm::length(across),
                                 ", allowed: equal, above 0 and without shear");
  }
  disk.normal = glm::normalize(detail::normal_matrix(m) * disk.normal);
  disk.center = detail::transform_point(m, disk.center);
  disk.tangent = glm::normalize(along - disk.normal * glm::dot(along, disk.normal));
  disk.radius *= scale;
  return disk;
}

}  // namespace manylight
