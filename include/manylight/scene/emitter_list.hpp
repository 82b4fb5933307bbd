// SPDX-License-Identifier: Apache-2.0
#pragma once

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

/// Isotropic point light.
template <std::floating_point S>
struct PointEmitter {
  Vec3<S> position{0};  ///< m, world
  Rgb<S> intensity{1};  ///< W sr^-1
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
