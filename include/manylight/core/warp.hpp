// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "manylight/core/vector.hpp"

/// Maps of the unit square [0,1)^2 with their densities. Spherical maps are about local +z, densities per
/// solid angle (sr^-1); planar ones per area.
namespace manylight::warp {

/// Concentric map to the unit disk; density 1/pi. [Shirley and Chiu 1997]
template <std::floating_point S>
[[nodiscard]] inline Vec2<S> square_to_disk(const Vec2<S>& u) noexcept {
  const S x = S(2) * u.x - S(1);
  const S y = S(2) * u.y - S(1);
  if (x == S(0) && y == S(0)) return Vec2<S>(0);
  const bool x_larger = std::abs(x) > std::abs(y);
  const S r = x_larger ? x : y;
  const S phi = x_larger ? k_pi<S> / 4 * (y / x) : k_pi<S> / 2 - k_pi<S> / 4 * (x / y);
  return {r * std::cos(phi), r * std::sin(phi)};
}

/// Uniform on the sphere; density 1/(4 pi).
template <std::floating_point S>
[[nodiscard]] inline Vec3<S> square_to_sphere(const Vec2<S>& u) noexcept {
  const S z = S(1) - S(2) * u.x;
  const S r = safe_sqrt(S(1) - z * z);
  const S phi = S(2) * k_pi<S> * u.y;
  return {r * std::cos(phi), r * std::sin(phi), z};
}

/// Cosine-weighted on the upper hemisphere; density z/pi.
template <std::floating_point S>
[[nodiscard]] inline Vec3<S> square_to_cosine_hemisphere(const Vec2<S>& u) noexcept {
  const Vec2<S> d = square_to_disk(u);
  // The floor keeps z > 0, so that a density is never zero at a point that was drawn.
  return {d.x, d.y, std::max(safe_sqrt(S(1) - d.x * d.x - d.y * d.y), S(1e-7))};
}
template <std::floating_point S>
[[nodiscard]] inline S cosine_hemisphere_pdf(const Vec3<S>& w) noexcept {
  return w.z > S(0) ? w.z * k_inv_pi<S> : S(0);
}

/// Uniform in the cone around +z with cosine of the half-angle `cos_max`; density 1/(2 pi (1 - cos_max)).
template <std::floating_point S>
[[nodiscard]] inline Vec3<S> square_to_cone(const Vec2<S>& u, S cos_max) noexcept {
  const S z = S(1) - u.x * (S(1) - cos_max);
  const S r = safe_sqrt(S(1) - z * z);
  const S phi = S(2) * k_pi<S> * u.y;
  return {r * std::cos(phi), r * std::sin(phi), z};
}
template <std::floating_point S>
[[nodiscard]] inline S cone_pdf(S cos_max) noexcept {
  return S(1) / (S(2) * k_pi<S> * (S(1) - cos_max));
}

/// Uniform barycentric weights (of the second and third corner); density 1/area on the triangle.
template <std::floating_point S>
[[nodiscard]] inline Vec2<S> square_to_triangle(const Vec2<S>& u) noexcept {
  const S root = std::sqrt(S(1) - u.x);
  return {S(1) - root, root * u.y};
}

/// Tent (linear hat) on (-1, 1) from one variate; density 1 - |x|.
template <std::floating_point S>
[[nodiscard]] inline S interval_to_tent(S u) noexcept {
  return u < S(0.5) ? std::sqrt(S(2) * u) - S(1) : S(1) - std::sqrt(S(2) - S(2) * u);
}

}  // namespace manylight::warp
