// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstdint>
#include <optional>

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

/// Where light from a point of the scene meets the film.
template <std::floating_point S>
struct LensSample {
  Vec2<S> film;      ///< pixels; may lie outside of the image
  Vec3<S> position;  ///< on the lens, world, m
  S film_density;    ///< `film_density` of the ray from there through the point, pixels^2 sr^-1
};

/// A camera whose importance is known, so that light paths can be connected with its lens. Contract, besides Camera's:
///  - `film_density(direction)`: area of film, in pixels^2, per solid angle of the rays that `ray` makes from one point of
///    the lens, sr^-1, at the unit direction of such a ray. It is the density of eye walks' first direction per unit area
///    of film, and as all rays count the same also the importance: W_e |cos| / (density of the lens point);
///  - `project(point, lens_u)`: the lens point that `ray` draws from `lens_u` and the place on the film of the ray from
///    there through `point`, also where that lies outside of the image; none if no film point has such a ray.
template <class C>
concept LensCamera = Camera<C> && requires(const C& camera, const Vec3<typename C::Scalar>& v,
                                           const Vec2<typename C::Scalar>& lens_u) {
  { camera.film_density(v) } -> std::same_as<typename C::Scalar>;
  { camera.project(v, lens_u) } -> std::same_as<std::optional<LensSample<typename C::Scalar>>>;
};

}  // namespace manylight
