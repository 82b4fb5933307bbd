// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <limits>

#include "manylight/core/vector.hpp"
#include "manylight/geometry/offset.hpp"
#include "manylight/geometry/ray.hpp"
#include "manylight/geometry/shapes.hpp"
#include "manylight/geometry/triangle.hpp"

namespace manylight {

namespace detail {

/// Largest absolute coordinate.
template <std::floating_point S>
[[nodiscard]] inline S max_abs(const Vec3<S>& v) noexcept {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

/// A backend's own arithmetic sees a shape of this extent (m) displaced by as much, when the ray starts on the shape.
/// The factor holds for translation, shear and three products of the triangle tests, with a margin of two.
template <std::floating_point S>
[[nodiscard]] inline S backend_error(S extent) noexcept {
  return rounding_gamma<S>(16) * extent;
}

/// Derivatives of the position by u and v: solves [dp1 dp2] = [dpdu dpdv] [duv1 duv2]; zero if the uv triangle is
/// degenerate.
template <std::floating_point S>
[[nodiscard]] inline std::array<Vec3<S>, 2> tangents_from_uv(const std::array<Vec3<S>, 3>& p,
                                                             const std::array<Vec2<S>, 3>& uv) noexcept {
  const Vec2<S> duv1 = uv[1] - uv[0];
  const Vec2<S> duv2 = uv[2] - uv[0];
  const S determinant = duv1.x * duv2.y - duv1.y * duv2.x;
  if (determinant == S(0)) return {Vec3<S>(0), Vec3<S>(0)};
  const Vec3<S> dpdu = ((p[1] - p[0]) * duv2.y - (p[2] - p[0]) * duv1.y) / determinant;
  const Vec3<S> dpdv = ((p[2] - p[0]) * duv1.x - (p[1] - p[0]) * duv2.x) / determinant;
  if (!is_finite(dpdu) || !is_finite(dpdv)) return {Vec3<S>(0), Vec3<S>(0)};
  return {dpdu, dpdv};
}

template <std::floating_point S>
[[nodiscard]] inline SurfacePoint<S> mesh_point(const TriangleMesh<S>& mesh, const Hit<S>& hit) noexcept {
  const std::array<std::uint32_t, 3>& corner = mesh.triangles[hit.primitive];
  const std::array<Vec3<S>, 3> p{mesh.positions[corner[0]], mesh.positions[corner[1]], mesh.positions[corner[2]]};
  const Vec3<S> b{S(1) - hit.u - hit.v, hit.u, hit.v};
  SurfacePoint<S> point{};
  point.shape = hit.shape;
  point.primitive = hit.primitive;
  point.position = p[0] * b[0] + p[1] * b[1] + p[2] * b[2];
  const Vec3<S> sum = glm::abs(p[0] * b[0]) + glm::abs(p[1] * b[1]) + glm::abs(p[2] * b[2]);
  point.error = rounding_gamma<S>(7) * max_abs(sum) + backend_error(max_abs(p[1] - p[0]) + max_abs(p[2] - p[0]));
  point.ng = Vec3<S>(glm::normalize(triangle_cross(p[0], p[1], p[2])));
  point.ns = point.ng;
  if (!mesh.normals.empty()) {
    const Vec3<S> ns = mesh.normals[corner[0]] * b[0] + mesh.normals[corner[1]] * b[1] + mesh.normals[corner[2]] * b[2];
    const S length = glm::length(ns);
    if (length > S(0) && std::isfinite(length)) {
      point.ns = ns / length;
      if (glm::dot(point.ns, point.ng) < S(0)) point.ng = -point.ng;
    }
  }
  if (mesh.flip_normals) {
    point.ng = -point.ng;
    point.ns = -point.ns;
  }
  point.uv = {hit.u, hit.v};
  if (!mesh.uvs.empty()) {
    const std::array<Vec2<S>, 3> uv{mesh.uvs[corner[0]], mesh.uvs[corner[1]], mesh.uvs[corner[2]]};
    point.uv = uv[0] * b[0] + uv[1] * b[1] + uv[2] * b[2];
    const std::array<Vec3<S>, 2> tangents = tangents_from_uv(p, uv);
    point.dpdu = tangents[0];
    point.dpdv = tangents[1];
  }
  return point;
}

/// Azimuth about +z in [0, 1), 0 at +x.
template <std::floating_point S>
[[nodiscard]] inline S azimuth_fraction(S y, S x) noexcept {
  const S fraction = std::atan2(y, x) / (S(2) * k_pi<S>);
  return fraction < S(0) ? std::min(fraction + S(1), S(1) - std::numeric_limits<S>::epsilon()) : fraction;
}

template <std::floating_point S>
[[nodiscard]] inline SurfacePoint<S> sphere_point(const Sphere<S>& sphere, const Ray<S>& ray,
                                                  const Hit<S>& hit) noexcept {
  // The ray's end drifts off by the error of t times the distance; putting it back on the sphere removes all of that.
  const Vec3<double> center(sphere.center);
  const Vec3<double> end = Vec3<double>(ray.origin) + Vec3<double>(ray.direction) * double(hit.t);
  const Vec3<double> outward = glm::normalize(end - center);
  SurfacePoint<S> point{};
  point.shape = hit.shape;
  point.position = Vec3<S>(center + outward * double(sphere.radius));
  point.error = rounding_gamma<S>(2) * max_abs(point.position) + backend_error(sphere.radius);
  const Vec3<S> normal(outward);
  point.ng = sphere.flip_normals ? -normal : normal;
  point.ns = point.ng;
  point.uv = {azimuth_fraction(normal.y, normal.x), std::acos(std::clamp(normal.z, S(-1), S(1))) * k_inv_pi<S>};
  point.dpdu = Vec3<S>(-normal.y, normal.x, S(0)) * (S(2) * k_pi<S> * sphere.radius);
  const S sine = std::sqrt(normal.x * normal.x + normal.y * normal.y);
  const Vec2<S> outwards = sine > S(0) ? Vec2<S>(normal) / sine : Vec2<S>(S(1), S(0));
  point.dpdv = Vec3<S>(outwards * normal.z, -sine) * (k_pi<S> * sphere.radius);
  return point;
}

template <std::floating_point S>
[[nodiscard]] inline SurfacePoint<S> disk_point(const Disk<S>& disk, const Ray<S>& ray, const Hit<S>& hit) noexcept {
  const Vec3<double> normal(disk.normal);
  const Vec3<double> end = Vec3<double>(ray.origin) + Vec3<double>(ray.direction) * double(hit.t);
  Vec3<double> from_center = end - Vec3<double>(disk.center);
  from_center -= normal * (glm::dot(from_center, normal) / glm::dot(normal, normal));
  SurfacePoint<S> point{};
  point.shape = hit.shape;
  point.position = Vec3<S>(Vec3<double>(disk.center) + from_center);
  // `normal` is rounded too: across the disk its plane is off by an ulp of the radius.
  point.error = rounding_gamma<S>(2) * max_abs(point.position) + backend_error(disk.radius);
  point.ng = disk.normal;
  point.ns = disk.normal;
  const Vec3<S> radial(from_center);
  const S distance = glm::length(radial);
  point.uv = {
      std::min(distance / disk.radius, S(1)),
      azimuth_fraction(glm::dot(radial, glm::cross(disk.normal, disk.tangent)), glm::dot(radial, disk.tangent))};
  point.dpdu = distance > S(0) ? radial * (disk.radius / distance) : disk.tangent * disk.radius;
  point.dpdv = glm::cross(disk.normal, radial) * (S(2) * k_pi<S>);
  return point;
}

}  // namespace detail

/// The point where `ray` met a shape, with a bound of its error.
///  - Triangles: position by barycentric interpolation, which forgets the error of t. ng follows the winding, but
///    where the mesh has vertex normals it turns to their side; ns is the interpolated normal, so that always
///    dot(ng, ns) >= 0 (Mitsuba's convention). A zero vertex normal falls back to ng. `flip_normals` turns both.
///  - Spheres, disks: the end of the ray is projected back onto the surface.
/// A mesh without uv gets the barycentric weights (u, v) as uv and no tangents.
template <std::floating_point S>
[[nodiscard]] inline SurfacePoint<S> surface_point(const Shapes<S>& shapes, const Ray<S>& ray,
                                                   const Hit<S>& hit) noexcept {
  if (shapes.is_mesh(hit.shape)) return detail::mesh_point(shapes.meshes[hit.shape], hit);
  if (shapes.is_sphere(hit.shape)) return detail::sphere_point(shapes.sphere(hit.shape), ray, hit);
  return detail::disk_point(shapes.disk(hit.shape), ray, hit);
}

}  // namespace manylight
