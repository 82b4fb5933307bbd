// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>

#include "manylight/geometry/ray.hpp"
#include "manylight/scattering/concepts.hpp"

namespace manylight {

/// What the surface of a shape is made of: turns a surface point into the local `Material` there (looks textures up).
/// Contract, besides the members checked here:
///  - `material(point, outside)`: the material on the side given by `outside` (true: the side of `point.ng`). A two-sided
///    shader sees a frame that was turned to that side already; a one-sided one always sees the shape's own frame;
///  - `is_two_sided()`: the frame is turned to the side of the known direction before the material is used;
///  - `k_may_be_transparent` (static): false removes all opacity code; if true, `is_transparent()` tells whether this
///    surface has an opacity mask and `opacity(point)` in [0, 1] which part of light it stops, the rest goes straight on;
///  - `k_may_absorb` (static): false removes all absorption code; if true, `interior_absorption()` is the coefficient
///    sigma_a (m^-1) of what a dielectric shape holds;
///  - optional type `Subsurface` (subsurface.hpp) with `subsurface()`: a pointer to what scatters below the surface, or
///    null; it must live as long as the shader. Light enters and leaves on the side of `point.ng`;
///  - optional `shading_normal(point)`: the unit normal to shade with in place of `point.ns`, on the side of `point.ng`
///    (bent_normal.hpp).
template <class T>
concept SurfaceShader =
    Material<typename T::Material> &&
    requires(const T& shader, const SurfacePoint<typename T::Material::Scalar>& point, bool outside) {
      { shader.material(point, outside) } -> std::same_as<typename T::Material>;
      { shader.is_two_sided() } -> std::same_as<bool>;
      { T::k_may_be_transparent } -> std::convertible_to<bool>;
      { T::k_may_absorb } -> std::convertible_to<bool>;
    };

/// Of a scene without subsurface scattering.
struct NoSubsurface {};

namespace detail {
template <class Shader>
struct SubsurfaceOf {
  using Type = NoSubsurface;
};
template <class Shader>
  requires requires { typename Shader::Subsurface; }
struct SubsurfaceOf<Shader> {
  using Type = typename Shader::Subsurface;
};
}  // namespace detail

/// The same material everywhere on a shape.
template <Material M>
struct UniformShader {
  using Material = M;
  static constexpr bool k_may_be_transparent = false;
  static constexpr bool k_may_absorb = false;
  M surface;
  bool two_sided = true;

  [[nodiscard]] M material(const SurfacePoint<typename M::Scalar>&, bool) const noexcept { return surface; }
  [[nodiscard]] bool is_two_sided() const noexcept { return two_sided; }
};

}  // namespace manylight
