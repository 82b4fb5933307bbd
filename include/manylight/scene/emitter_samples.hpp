// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "manylight/core/spectrum.hpp"

namespace manylight {

enum class EmitterKind : std::uint8_t { area, point, directional, environment };

/// True for light that comes from infinitely far away: no position, no 1/d^2.
[[nodiscard]] constexpr bool is_infinite(EmitterKind kind) noexcept {
  return kind == EmitterKind::directional || kind == EmitterKind::environment;
}
/// True where a surface or direction cannot be hit by chance: only next event estimation finds this light.
[[nodiscard]] constexpr bool is_delta(EmitterKind kind) noexcept {
  return kind == EmitterKind::point || kind == EmitterKind::directional;
}

/// Shape id of light that sits on no shape.
inline constexpr std::uint32_t k_no_shape = 0xFFFFFFFFu;

/// A light seen from a reference point. Its contribution to radiance there is
/// f(wi, wo) |wi . n| visibility radiance / pdf, for all kinds.
template <std::floating_point S>
struct DirectSample {
  Vec3<S> wi{0};                     ///< unit, from the reference towards the light, world
  S distance = S(0);                 ///< m; infinity for light at infinity
  Rgb<S> radiance{0};                ///< arriving along wi, W m^-2 sr^-1; of delta lights irradiance, W m^-2
  S pdf = S(0);                      ///< solid angle at the reference, sr^-1, times the selection probability;
                                     ///< of delta lights the selection probability alone
  EmitterKind kind{};                ///< what was selected
  bool is_delta = false;             ///< point and directional: MIS weight 1
  bool infinite = false;             ///< no position, error, ng; the shadow ray has no end
  Vec3<S> position{0};               ///< on the light, world, m
  S error = S(0);                    ///< bound of the absolute error of each coordinate of `position`, m
  Vec3<S> ng{0};                     ///< geometric unit normal there, outer side; (0,0,0) for point lights
  std::uint32_t shape = k_no_shape;  ///< of area lights
  std::uint32_t primitive = 0;       ///< triangle of an area light on a mesh
  std::uint32_t emitter = 0;         ///< emissive primitive, as Emitters::selection_probability counts them
};

/// The start of a light subpath. Throughputs and intensities are for ONE path: divide by the number of paths N.
/// In the notation of [Walter 2012]: I_l = intensity / N and N B_{l-1} c' = beta, c' the cosine where the ray arrives.
template <std::floating_point S>
struct EmissionSample {
  EmitterKind kind{};                ///< what was selected
  Vec3<S> position{0};               ///< area, point: on the light; infinite: start of the ray, outside the scene
  S error = S(0);                    ///< bound of the absolute error of each coordinate of `position`, m; area only
  Vec3<S> ng{0};                     ///< geometric unit normal of an area light, outer side; (0,0,0) for the others
  Vec3<S> wo{0};                     ///< unit direction in which the light leaves (travels), world
  Rgb<S> radiance{0};                ///< along wo: area, environment W m^-2 sr^-1; point W sr^-1; directional W m^-2
  Rgb<S> intensity{0};               ///< alpha_D / p(v_l), W: area pi L_e / p_A; point 4 pi I, of spots along the axis;
                                     ///< infinite pi R^2 L_e / p(wo); selection is part of every p
  Rgb<S> beta{0};                    ///< e_l / (p(v_l) p(wo)), W: what the ray carries; its mean is the total flux
  S pdf_position = S(0);             ///< area m^-2, point 1: of the position, selection included;
                                     ///< infinite m^-2: of the start on the disk, 1 / (pi R^2), without selection
  S pdf_direction = S(0);            ///< area, point sr^-1: of wo given the position; environment sr^-1: of wo,
                                     ///< selection included; directional: the selection probability
  Vec2<S> uv{0};                     ///< of area lights
  std::uint32_t shape = k_no_shape;  ///< of area lights
  std::uint32_t primitive = 0;       ///< triangle of an area light on a mesh
  bool two_sided = false;            ///< area lights: the pattern D is |wo . ng| / pi on both sides

  /// Density of the start, p(position) p(wo), over the cosine |wo . ng| of area lights: the same for all their wo.
  /// m^-2 sr^-1; of point lights sr^-1, of directional ones m^-2; selection included.
  [[nodiscard]] S projected_pdf() const noexcept {
    if (kind != EmitterKind::area) return pdf_position * pdf_direction;
    return pdf_position * k_inv_pi<S> / (two_sided ? S(2) : S(1));
  }
};

}  // namespace manylight
