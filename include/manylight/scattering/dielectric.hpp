// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "manylight/core/rgb_interval.hpp"
#include "manylight/scattering/fresnel.hpp"
#include "manylight/scattering/local_geometry.hpp"
#include "manylight/scattering/validation.hpp"

namespace manylight {

/// Smooth interface between two dielectrics (delta reflection and refraction). Local z > 0 is outside; both sides are
/// handled. Radiance that crosses it is scaled by the squared ratio of the indices (basic radiance L / eta^2 is what is
/// conserved); importance is not. [Veach 1997, section 5.2]
template <std::floating_point S>
struct Dielectric {
  using Scalar = S;
  static constexpr bool k_isotropic = true;  ///< vertices need no tangent
  S eta = S(1.5046);                    ///< index inside / index outside, > 0
  Rgb<S> specular_reflectance{S(1)};    ///< factor on reflected light, [0, 1]
  Rgb<S> specular_transmittance{S(1)};  ///< factor on refracted light, [0, 1]

  /// Throws ParameterError.
  void validate() const {
    check::relative_ior("Dielectric eta", eta);
    check::reflectance("Dielectric specular_reflectance", specular_reflectance);
    check::reflectance("Dielectric specular_transmittance", specular_transmittance);
  }

  template <LocalDirection<S> Wi = Vec3<S>, LocalDirection<S> Wo = Vec3<S>>
  [[nodiscard]] static constexpr auto eval(const Wi& /*wi*/, const Wo& /*wo*/) noexcept {
    return PatternColour<Wi, Wo, S>(S(0));
  }

  /// Chooses reflection with the probability of its share of the energy.
  [[nodiscard]] std::optional<DirectionSample<S>> sample(const Vec3<S>& known, Walk walk, S u_lobe,
                                                         const Vec2<S>& /*u*/) const noexcept {
    if (known.z == S(0)) return std::nullopt;
    const DielectricInterface<S> surface = fresnel_dielectric(known.z, eta);
    const S reflect = surface.reflectance * max_channel(specular_reflectance);
    const S refract = (S(1) - surface.reflectance) * max_channel(specular_transmittance);
    if (!(reflect + refract > S(0))) return std::nullopt;
    const S probability = reflect / (reflect + refract);
    if (u_lobe < probability) {
      return DirectionSample<S>{local::mirror(known), probability, true,
                                specular_reflectance * (surface.reflectance / probability)};
    }
    if (!(refract > S(0))) return std::nullopt;
    const Vec3<S> w =
        glm::normalize(Vec3<S>(-surface.eta_ratio * known.x, -surface.eta_ratio * known.y, surface.cos_t));
    // In an eye walk `known` is wo: (eta_wo / eta_wi)^2 is the squared ratio of the incident to the far side.
    const S radiance_factor = walk == Walk::eye ? sqr(surface.eta_ratio) : S(1);
    const S weight = (S(1) - surface.reflectance) * radiance_factor / (S(1) - probability);
    return DirectionSample<S>{w, S(1) - probability, true, specular_transmittance * weight};
  }
  [[nodiscard]] static constexpr S pdf(const Vec3<S>& /*known*/, const Vec3<S>& /*sampled*/, Walk) noexcept {
    return S(0);
  }
  [[nodiscard]] static constexpr Rgb<S> albedo() noexcept { return Rgb<S>(0); }
  [[nodiscard]] static constexpr bool is_delta() noexcept { return true; }
  [[nodiscard]] S sampling_weight(const Vec3<S>& /*known*/) const noexcept {
    return std::max(max_channel(specular_reflectance), max_channel(specular_transmittance));
  }
};

/// Sheet of glass so thin that refracted light leaves straight through (delta); all inner reflections are summed:
/// R' = R + (1-R)^2 R + (1-R)^2 R^3 + ... = 2 R / (1 + R). Both sides alike; no radiance factor, as light ends in the
/// medium it came from.
template <std::floating_point S>
struct ThinDielectric {
  using Scalar = S;
  static constexpr bool k_isotropic = true;  ///< vertices need no tangent
  S eta = S(1.5046);                    ///< index of the sheet / index around it, > 0
  Rgb<S> specular_reflectance{S(1)};    ///< factor on reflected light, [0, 1]
  Rgb<S> specular_transmittance{S(1)};  ///< factor on transmitted light, [0, 1]

  /// Throws ParameterError.
  void validate() const {
    check::relative_ior("ThinDielectric eta", eta);
    check::reflectance("ThinDielectric specular_reflectance", specular_reflectance);
    check::reflectance("ThinDielectric specular_transmittance", specular_transmittance);
  }

  /// R' of the sheet for a direction of either side.
  [[nodiscard]] S sheet_reflectance(const Vec3<S>& w) const noexcept {
    const S r = fresnel_dielectric(std::abs(w.z), eta).reflectance;
    return S(2) * r / (S(1) + r);
  }

  template <LocalDirection<S> Wi = Vec3<S>, LocalDirection<S> Wo = Vec3<S>>
  [[nodiscard]] static constexpr auto eval(const Wi& /*wi*/, const Wo& /*wo*/) noexcept {
    return PatternColour<Wi, Wo, S>(S(0));
  }
  [[nodiscard]] std::optional<DirectionSample<S>> sample(const Vec3<S>& known, Walk, S u_lobe,
                                                         const Vec2<S>& /*u*/) const noexcept {
    if (known.z == S(0)) return std::nullopt;
    const S r = sheet_reflectance(known);
    const S reflect = r * max_channel(specular_reflectance);
    const S pass = (S(1) - r) * max_channel(specular_transmittance);
    if (!(reflect + pass > S(0))) return std::nullopt;
    const S probability = reflect / (reflect + pass);
    if (u_lobe < probability) {
      return DirectionSample<S>{local::mirror(known), probability, true, specular_reflectance * (r / probability)};
    }
    if (!(pass > S(0))) return std::nullopt;
    return DirectionSample<S>{-known, S(1) - probability, true,
                              specular_transmittance * ((S(1) - r) / (S(1) - probability))};
  }
  [[nodiscard]] static constexpr S pdf(const Vec3<S>& /*known*/, const Vec3<S>& /*sampled*/, Walk) noexcept {
    return S(0);
  }
  [[nodiscard]] static constexpr Rgb<S> albedo() noexcept { return Rgb<S>(0); }
  [[nodiscard]] static constexpr bool is_delta() noexcept { return true; }
  [[nodiscard]] S sampling_weight(const Vec3<S>& /*known*/) const noexcept {
    return std::max(max_channel(specular_reflectance), max_channel(specular_transmittance));
  }
};

static_assert(SetEvaluable<Dielectric<float>> && SetEvaluable<Dielectric<double>>);
static_assert(SetEvaluable<ThinDielectric<float>> && SetEvaluable<ThinDielectric<double>>);

}  // namespace manylight
