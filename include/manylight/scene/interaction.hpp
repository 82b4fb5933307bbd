// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstdint>

#include "manylight/core/frame.hpp"
#include "manylight/geometry/ray.hpp"
#include "manylight/scene/scene_media.hpp"

namespace manylight {

/// Rays traced, by kind; summed over tiles in a fixed order.
struct RayCounts {
  std::uint64_t closest = 0;
  std::uint64_t shadow = 0;

  RayCounts& operator+=(const RayCounts& other) noexcept {
    closest += other.closest;
    shadow += other.shadow;
    return *this;
  }
};

/// A surface point with its scattering, turned to the side of the known direction `w` where the shader is two-sided.
template <std::floating_point S, class M>
struct Interaction {
  SurfacePoint<S> point;
  Vec3<S> ng;  ///< geometric normal, oriented
  Frame<S> frame;  ///< shading frame, oriented
  M material;
  MediaSides media{};  ///< front on the side of `ng`
};

/// Whether a scene is one instant of a motion (instants.hpp).
struct Still {
  static constexpr bool k_moves = false;
};
struct Moving {
  static constexpr bool k_moves = true;
};

/// One end of a shadow ray: a point, the error bound of its coordinates (m), its geometric normal and what surrounds it.
template <std::floating_point S>
struct Anchor {
  Vec3<S> position;
  S error;
  Vec3<S> ng;
  MediaSides media{};  ///< of the end that the ray starts from
};

/// A shadow ray of a scene with media.
template <std::floating_point S>
struct MediumRay {
  Ray<S> ray;
  MediumId medium;     ///< that it starts in
  std::uint64_t seed;  ///< of its random transmittance: the same ray gets the same
};

}  // namespace manylight
