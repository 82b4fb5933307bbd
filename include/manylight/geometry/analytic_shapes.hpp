// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <concepts>
#include <cstdint>
#include <utility>

#include "manylight/core/box.hpp"
#include "manylight/core/vector.hpp"
#include "manylight/geometry/ray.hpp"
#include "manylight/geometry/shapes.hpp"

/// Rays against spheres and disks: shared by all backends, so that they agree to the bit.
namespace manylight::detail {

/// The two parameters (ascending) at which a ray's line crosses a sphere; ordered false if it does not.
struct SphereCrossings {
  bool crosses = false;
  double near = 0;
  double far = 0;
};

/// Computed in double also for float, and with the discriminant from the perpendicular distance instead of b^2 - 4ac:
/// a small sphere far away keeps its digits. [Haines et al. 2019, "Precision Improvements for Ray/Sphere Intersection"]
template <std::floating_point S>
[[nodiscard]] inline SphereCrossings sphere_crossings(const Sphere<S>& sphere, const Ray<S>& ray) noexcept {
  const Vec3<double> d(ray.direction);
  const Vec3<double> f = Vec3<double>(ray.origin) - Vec3<double>(sphere.center);
  const double r = double(sphere.radius);
  const double a = glm::dot(d, d);
  const double b = -glm::dot(f, d);
  const Vec3<double> perpendicular = f + d * (b / a);
  const double discriminant = r * r - glm::dot(perpendicular, perpendicular);
  if (!(discriminant >= 0)) return {};
  const double c = (glm::length(f) - r) * (glm::length(f) + r);
  const double q = b + std::copysign(std::sqrt(a * discriminant), b);
  const double far_from_cancellation = q / a;
  const double other = q != 0 ? c / q : far_from_cancellation;
  if (far_from_cancellation < other) return {true, far_from_cancellation, other};
  return {true, other, far_from_cancellation};
}

/// Calls `visit(t)` for each crossing of the ray's segment, ascending.
template <std::floating_point S, class Visit>
inline void visit_crossings(const Sphere<S>& sphere, const Ray<S>& ray, const Visit& visit) noexcept {
  const SphereCrossings crossings = sphere_crossings(sphere, ray);
  if (!crossings.crosses) return;
  const S near = static_cast<S>(crossings.near);
  const S far = static_cast<S>(crossings.far);
  if (near >= ray.t_min && near <= ray.t_max) visit(near);
  if (far >= ray.t_min && far <= ray.t_max) visit(far);
}

/// Calls `visit(t)` if the ray's segment crosses the disk. A ray in the disk's plane does not.
template <std::floating_point S, class Visit>
inline void visit_crossings(const Disk<S>& disk, const Ray<S>& ray, const Visit& visit) noexcept {
  const Vec3<double> n(disk.normal);
  const Vec3<double> d(ray.direction);
  const double cosine = glm::dot(d, n);
  if (cosine == 0) return;
  const Vec3<double> to_center = Vec3<double>(disk.center) - Vec3<double>(ray.origin);
  const double t = glm::dot(to_center, n) / cosine;
  const Vec3<double> from_center = d * t - to_center;
  const S rounded = static_cast<S>(t);
  const bool inside = glm::dot(from_center, from_center) <= double(disk.radius) * double(disk.radius);
  if (inside && rounded >= ray.t_min && rounded <= ray.t_max) visit(rounded);
}

/// Calls `visit(t)` for each crossing of the sphere or disk with the id `shape`.
template <std::floating_point S, class Visit>
inline void visit_crossings(const Shapes<S>& shapes, std::uint32_t shape, const Ray<S>& ray,
                            const Visit& visit) noexcept {
  if (shapes.is_sphere(shape)) {
    visit_crossings(shapes.sphere(shape), ray, visit);
  } else {
    visit_crossings(shapes.disk(shape), ray, visit);
  }
}

template <std::floating_point S>
[[nodiscard]] inline Box<S> bounds_of(const Sphere<S>& sphere) noexcept {
  return {sphere.center - sphere.radius, sphere.center + sphere.radius};
}
template <std::floating_point S>
[[nodiscard]] inline Box<S> bounds_of(const Disk<S>& disk) noexcept {
  // Along an axis the disk reaches out by r sin(angle between the axis and the normal).
  const Vec3<S> sine{safe_sqrt(S(1) - sqr(disk.normal.x)), safe_sqrt(S(1) - sqr(disk.normal.y)),
                     safe_sqrt(S(1) - sqr(disk.normal.z))};
  // sin near 0 has lost half of its digits: a margin of 1e-3 r covers it, in float and double.
  const Vec3<S> reach = (sine + S(1e-3)) * disk.radius;
  return {disk.center - reach, disk.center + reach};
}
template <std::floating_point S>
[[nodiscard]] inline Box<S> analytic_bounds(const Shapes<S>& shapes, std::uint32_t shape) noexcept {
  return shapes.is_sphere(shape) ? bounds_of(shapes.sphere(shape)) : bounds_of(shapes.disk(shape));
}

}  // namespace manylight::detail
