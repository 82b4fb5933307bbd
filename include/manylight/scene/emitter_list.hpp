// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include <glm/mat3x3.hpp>

#include "manylight/core/spectrum.hpp"
#include "manylight/scattering/texture.hpp"
#include "manylight/scene/image.hpp"

namespace manylight {

/// A shape that emits like a Lambertian source: the same radiance in all directions of its outer side.
template <std::floating_point S>
struct AreaEmitter {
  std::uint32_t shape = 0;  ///< id in `Shapes`; at most one emitter per shape
  Texture<S> radiance{};    ///< W m^-2 sr^-1, looked up by the surface's uv
  bool two_sided = false;   ///< emits the same radiance on its inner side, too
};

/// Part of a spot light's intensity that leaves in the unit direction `w`: 1 up to `beam_width` off the unit `axis`,
/// then linear in the angle down to 0 at `cutoff`; both in rad, 0 <= beam_width <= cutoff <= pi.
template <std::floating_point S>
[[nodiscard]] inline S spot_falloff(const Vec3<S>& w, const Vec3<S>& axis, S beam_width, S cutoff) noexcept {
  const S angle = std::atan2(glm::length(glm::cross(w, axis)), glm::dot(w, axis));  // exact for narrow cones, too
  if (angle >= cutoff) return S(0);
  return angle <= beam_width ? S(1) : (cutoff - angle) / (cutoff - beam_width);
}

/// Point light, isotropic or, with a cutoff below pi, a spot light.
template <std::floating_point S>
struct PointEmitter {
  Vec3<S> position{0};     ///< m, world
  Rgb<S> intensity{1};     ///< W sr^-1; of a spot light along its axis
  Vec3<S> axis{0, 0, 1};   ///< of a spot light, world, any length
  S cutoff = k_pi<S>;      ///< half-angle of the cone that is lit, rad, [1e-4, pi]
  S beam_width = k_pi<S>;  ///< half-angle of the cone of full intensity, rad, [0, cutoff]; see `spot_falloff`

  [[nodiscard]] bool is_spot() const noexcept { return beam_width < k_pi<S>; }
  /// Intensity in the unit direction `w`, W sr^-1. The axis must be unit.
  [[nodiscard]] Rgb<S> intensity_towards(const Vec3<S>& w) const noexcept {
    return is_spot() ? intensity * spot_falloff(w, axis, beam_width, cutoff) : intensity;
  }
  /// Density of the directions of light subpaths, uniform in what is lit, sr^-1.
  [[nodiscard]] S pdf_direction() const noexcept {
    // 1 - cos(cutoff) = 2 sin^2(cutoff / 2): narrow cones keep their width.
    return is_spot() ? S(0.25) * k_inv_pi<S> / sqr(std::sin(cutoff / S(2))) : S(0.25) * k_inv_pi<S>;
  }
  /// Solid angle that full intensity would fill with the same flux, sr: 2 pi int falloff sin, from
  /// int_b^c (c - t) sin t dt = (c - b) cos b - sin c + sin b.
  [[nodiscard]] S effective_solid_angle() const noexcept {
    if (!is_spot()) return S(4) * k_pi<S>;
    const S width = cutoff - beam_width;
    // The mean of the cosine over [beam width, cutoff], by its middle and sin(x) / x, which keeps its digits.
    const S half = width / S(2);
    const S middle = (cutoff + beam_width) / S(2);
    const S sink = half > S(0.1) ? S(1) - std::sin(half) / half : half * half / S(6) * (S(1) - half * half / S(20));
    const S haversine = std::sin(middle / S(2));
    return S(2) * k_pi<S> * (S(2) * haversine * haversine * (S(1) - sink) + sink);  // 1 - cos(middle) sin(half) / half
  }
};

/// Parallel light from infinitely far away, as of a sun without a disk.
template <std::floating_point S>
struct DirectionalEmitter {
  Vec3<S> direction{0, 0, -1};  ///< in which the light travels, world, any length
  Rgb<S> irradiance{1};         ///< W m^-2 on a surface perpendicular to it
};

/// Light from all directions at infinity: constant, or an image of the sphere times `radiance`.
/// Image (u to the right, v downwards): u = atan2(x, -z) / (2 pi) mod 1 and v = acos(y) / pi of the direction to the
/// light in the emitter's frame, so the top row looks along +y, u = 0 along -z and u = 1/4 along +x. Texel columns
/// have their centres at u = (column + 1/2) / width, rows at v = row / (height - 1); bilinear between (Mitsuba 3's
/// convention: the first and last row lie on the poles).
template <std::floating_point S>
struct EnvironmentEmitter {
  Rgb<S> radiance{1};                               ///< W m^-2 sr^-1; factor on the image, if there is one
  std::shared_ptr<const Image<S>> image{};          ///< at least 2 rows; none: constant
  glm::mat<3, 3, S, glm::defaultp> to_world{S(1)};  ///< emitter to world: rotation, mirroring; scale ignored
};

/// All light sources of a scene, as loaded. Environments add up.
template <std::floating_point S>
struct EmitterList {
  std::vector<AreaEmitter<S>> areas;
  std::vector<PointEmitter<S>> points;
  std::vector<DirectionalEmitter<S>> directionals;
  std::vector<EnvironmentEmitter<S>> environments;

  [[nodiscard]] std::size_t size() const noexcept {
    return areas.size() + points.size() + directionals.size() + environments.size();
  }
};

}  // namespace manylight
