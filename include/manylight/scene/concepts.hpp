// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstdint>

#include "manylight/core/vector.hpp"
#include "manylight/geometry/ray.hpp"

namespace manylight {

/// What turns a point of the film into a ray. Contract:
///  - `ray(film, lens_u)`: the ray along which the radiance of `film` arrives, pointing into the scene; `film` in
///    pixels, (0, 0) is the top-left corner of the image and (width, height) the bottom-right one, points outside are
///    allowed (filters reach over the border); `lens_u` in [0,1)^2 chooses the point of the aperture. Unit direction,
///    origin on the lens, world frame, t in [0, infinity);
///  - the density of lens points is that of the camera model, so that a pixel is the plain mean of the radiances of its
///    rays (no further weight);
///  - `width()`, `height()`: size of the film, pixels.
/// Immutable, callable from several threads.
template <class C>
concept Camera = requires(const C& camera, const Vec2<typename C::Scalar>& film,
                          const Vec2<typename C::Scalar>& lens_u) {
  typename C::Scalar;
  { camera.ray(film, lens_u) } -> std::same_as<Ray<typename C::Scalar>>;
  { camera.width() } -> std::same_as<std::uint32_t>;
  { camera.height() } -> std::same_as<std::uint32_t>;
};

}  // namespace manylight
