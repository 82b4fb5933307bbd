// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "manylight/core/rgb_interval.hpp"
#include "manylight/scattering/fresnel.hpp"
#include "manylight/scattering/microfacet.hpp"

namespace manylight {

/// Perfect mirror of constant reflectance on the side of the normal (delta).
template <std::floating_point S>
struct Mirror {
  using Scalar = S;
  static constexpr bool k_isotropic = true;  ///< vertices need no tangent
  Rgb<S> reflectance{S(1)};  ///< per channel, [0, 1]

  /// Throws ParameterError.
  void validate() const { check::reflectance("Mirror reflectance", reflectance); }

  template <LocalDirection<S> Wi = Vec3<S>, LocalDirection<S> Wo = Vec3<S>>
  [[nodiscard]] static constexpr auto eval(const Wi& /*wi*/, const Wo& /*wo*/) noexcept {
    return PatternColour<Wi, Wo, S>(S(0));
  }
  [[nodiscard]] std::optional<DirectionSample<S>> sample(const Vec3<S>& known, Walk, S /*u_lobe*/,
                                                         const Vec2<S>& /*u*/) const noexcept {
    if (known.z <= S(0)) return std::nullopt;
    return DirectionSample<S>{local::mirror(known), S(1), true, reflectance};
  }
  [[nodiscard]] static constexpr S pdf(const Vec3<S>& /*known*/, const Vec3<S>& /*sampled*/, Walk) noexcept {
    return S(0);
  }
  [[nodiscard]] static constexpr Rgb<S> albedo() noexcept { return Rgb<S>(0); }
  [[nodiscard]] static constexpr bool is_delta() noexcept { return true; }
  [[nodiscard]] S sampling_weight(const Vec3<S>& known) const noexcept {
    return known.z > S(0) ? max_channel(reflectance) : S(0);
  }
};

/// Smooth metal (delta): a mirror whose reflectance is Fresnel's for the complex index eta + i k.
template <std::floating_point S>
struct SmoothConductor {
  using Scalar = S;
  static constexpr bool k_isotropic = true;  ///< vertices need no tangent
  Rgb<S> eta{S(0)};       ///< real part of the index relative to the outside, per channel, >= 0
  Rgb<S> k{S(1)};         ///< imaginary part, >= 0; eta = 0 reflects everything
  Rgb<S> specular{S(1)};  ///< factor on the reflectance, [0, 1]

  /// Throws ParameterError.
  void validate() const {
    check::non_negative("SmoothConductor eta", eta);
    check::non_negative("SmoothConductor k", k);
    check::reflectance("SmoothConductor specular", specular);
  }

  template <LocalDirection<S> Wi = Vec3<S>, LocalDirection<S> Wo = Vec3<S>>
  [[nodiscard]] static constexpr auto eval(const Wi& /*wi*/, const Wo& /*wo*/) noexcept {
    return PatternColour<Wi, Wo, S>(S(0));
  }
  [[nodiscard]] std::optional<DirectionSample<S>> sample(const Vec3<S>& known, Walk, S /*u_lobe*/,
                                                         const Vec2<S>& /*u*/) const noexcept {
    if (known.z <= S(0)) return std::nullopt;
    return DirectionSample<S>{local::mirror(known), S(1), true, specular * fresnel_conductor(known.z, eta, k)};
  }
  [[nodiscard]] static constexpr S pdf(const Vec3<S>& /*known*/, const Vec3<S>& /*sampled*/, Walk) noexcept {
    return S(0);
  }
  [[nodiscard]] static constexpr Rgb<S> albedo() noexcept { return Rgb<S>(0); }
  [[nodiscard]] static constexpr bool is_delta() noexcept { return true; }
  [[nodiscard]] S sampling_weight(const Vec3<S>& known) const noexcept {
    return known.z > S(0) ? max_channel(specular * fresnel_conductor(known.z, eta, k)) : S(0);
  }
};

/// Rough metal, f = specular F(wo . h) D(h) G1(wi) G1(wo) / (4 wi.z wo.z). Reciprocal. [Walter 2007, Eq. 20]
template <std::floating_point S>
struct RoughConductor {
  using Scalar = S;
  MicrofacetType distribution = MicrofacetType::beckmann;
  S alpha_u = S(0.1);     ///< roughness along local x
  S alpha_v = S(0.1);     ///< roughness along local y
  Rgb<S> eta{S(0)};       ///< real part of the index relative to the outside, per channel, >= 0
  Rgb<S> k{S(1)};         ///< imaginary part, >= 0; eta = 0 reflects everything
  Rgb<S> specular{S(1)};  ///< factor on the reflectance, [0, 1]

  /// Throws ParameterError.
  void validate() const {
    check::roughness("RoughConductor alpha_u", alpha_u);
    check::roughness("RoughConductor alpha_v", alpha_v);
    check::non_negative("RoughConductor eta", eta);
    check::non_negative("RoughConductor k", k);
    check::reflectance("RoughConductor specular", specular);
  }

  /// Of vectors the BSDF; of direction sets the range of its values over them.
  template <LocalDirection<S> Wi = Vec3<S>, LocalDirection<S> Wo = Vec3<S>>
  [[nodiscard]] auto eval(const Wi& wi, const Wo& wo) const noexcept {
    if constexpr (std::is_same_v<PatternScalar<Wi, Wo, S>, S>) {
      if (!local::both_above(wi, wo)) return Rgb<S>(0);
      const MicrofacetDistribution<S> facets = microfacets();
      const Vec3<S> h = local::half_vector(wi, wo);
      const S density = facets.density(h);
      if (!(density > S(0))) return Rgb<S>(0);
      const S value = S(0.25) * density * facets.masking_over_cos(wi) * facets.masking_over_cos(wo);
      return specular * fresnel_conductor(glm::dot(wo, h), eta, k) * value;
    } else {
      return range_with(wi, wo, [](const auto& facets, const Wi& w) { return facets.masking_over_cos(w); });
    }
  }
  /// The BSDF times |wi.z|: its range has G1(wi) <= 1 in place of G1(wi) / wi.z.
  template <LocalDirection<S> Wi = Vec3<S>, LocalDirection<S> Wo = Vec3<S>>
  [[nodiscard]] auto eval_cos(const Wi& wi, const Wo& wo) const noexcept {
    if constexpr (std::is_same_v<PatternScalar<Wi, Wo, S>, S>) {
      return eval(wi, wo) * std::abs(wi.z);
    } else {
      return range_with(wi, wo, [](const auto& facets, const Wi& w) { return facets.masking(w); });
    }
  }

  /// Reflects about a visible normal; what leaves below the surface is rejected.
  [[nodiscard]] std::optional<DirectionSample<S>> sample(const Vec3<S>& known, Walk walk, S /*u_lobe*/,
                                                         const Vec2<S>& u) const noexcept {
    if (known.z <= S(0)) return std::nullopt;
    const Vec3<S> h = microfacets().sample_visible(known, u);
    const Vec3<S> w = glm::normalize(local::mirror(known, h));
    const S density = pdf(known, w, walk);
    if (!(density > S(0))) return std::nullopt;
    return DirectionSample<S>{w, density, false, Rgb<S>(0)};
  }

  /// Density of the visible normal, D G1 (known . h) / known.z, over the Jacobian 4 (known . h).
  [[nodiscard]] S pdf(const Vec3<S>& known, const Vec3<S>& sampled, Walk) const noexcept {
    if (!local::both_above(known, sampled)) return S(0);
    const MicrofacetDistribution<S> facets = microfacets();
    return S(0.25) * facets.density(local::half_vector(known, sampled)) * facets.masking_over_cos(known);
  }

  [[nodiscard]] Rgb<S> albedo() const noexcept { return specular * fresnel_conductor(S(1), eta, k); }
  [[nodiscard]] static constexpr bool is_delta() noexcept { return false; }
  [[nodiscard]] MicrofacetDistribution<S> microfacets() const noexcept { return {distribution, alpha_u, alpha_v}; }

 private:
  template <class Wi, class Wo, class Masking>
  [[nodiscard]] RgbInterval<S> range_with(const Wi& wi, const Wo& wo, const Masking& masking) const noexcept {
    return when(wi.z > S(0) && wo.z > S(0), [&] {
      const MicrofacetDistribution<S> facets = microfacets();
      const Interval<S> value = facets.density_of_half(wi, wo) * (S(0.25) * Interval<S>(masking(facets, wi))) *
                                Interval<S>(facets.masking_over_cos(wo));
      return specular * fresnel_conductor(local::cos_to_half(wi, wo), eta, k) * widen(value, facets.k_rounding);
    });
  }
};

static_assert(SetEvaluable<Mirror<float>> && SetEvaluable<Mirror<double>>);
static_assert(SetEvaluable<SmoothConductor<float>> && SetEvaluable<SmoothConductor<double>>);
static_assert(SetEvaluable<RoughConductor<float>> && SetEvaluable<RoughConductor<double>>);

}  // namespace manylight
