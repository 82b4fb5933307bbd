// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "manylight/core/config.hpp"
#include "manylight/core/rgb_interval.hpp"
#include "manylight/core/warp.hpp"
#include "manylight/scattering/plastic.hpp"
#include "manylight/scattering/rough_transmittance.hpp"

namespace manylight {

/// Diffuse base under a rough dielectric coat. A microfacet lobe of the coat,
///     specular F(wo . h) D(h) G1(wi) G1(wo) / (4 wi.z wo.z),
/// plus the base of `Plastic` with the tabulated rough transmittances in place of 1 - F. Reciprocal.
/// The table is not owned: whoever keeps the material's parameters keeps it alive.
template <std::floating_point S>
struct RoughPlastic {
  using Scalar = S;
  static constexpr bool k_isotropic = true;     ///< vertices need no tangent
  const RoughTransmittance<S>* coat = nullptr;  ///< roughness, index and transmittance; never null when used
  Rgb<S> diffuse{S(0.5)};                       ///< reflectance of the base per channel, [0, 1]
  Rgb<S> specular{S(1)};                        ///< factor on the coat's lobe, [0, 1]
  CoatedBase base = CoatedBase::linear;

  /// Throws ParameterError.
  void validate() const {
    require(coat != nullptr, "RoughPlastic coat", "null", "a table that outlives the material");
    check::reflectance("RoughPlastic diffuse", diffuse);
    check::reflectance("RoughPlastic specular", specular);
  }

  /// Of vectors the BSDF; of direction sets the range of its values over them.
  template <LocalDirection<S> Wi = Vec3<S>, LocalDirection<S> Wo = Vec3<S>>
  [[nodiscard]] auto eval(const Wi& wi, const Wo& wo) const noexcept {
    if constexpr (std::is_same_v<PatternScalar<Wi, Wo, S>, S>) {
      if (!local::both_above(wi, wo)) return Rgb<S>(0);
      const MicrofacetDistribution<S> facets = coat->facets();
      const Vec3<S> h = local::half_vector(wi, wo);
      const S lobe = S(0.25) * facets.density(h) * facets.masking_over_cos(wi) * facets.masking_over_cos(wo) *
                     fresnel_dielectric(glm::dot(wo, h), coat->eta()).reflectance;
      return specular * lobe + base_factor() * (coat->at(wi.z) * coat->at(wo.z) * k_inv_pi<S>);
    } else {
      return when(wi.z > S(0) && wo.z > S(0), [&] {
        const Interval<S> below = Interval<S>(coat->at(wi.z)) * Interval<S>(coat->at(wo.z)) * k_inv_pi<S>;
        return specular * lobe_range(wi, wo, coat->facets().masking_over_cos(wi)) + base_factor() * below;
      });
    }
  }
  /// The BSDF times |wi.z|: the range of its lobe has G1(wi) <= 1 in place of G1(wi) / wi.z.
  template <LocalDirection<S> Wi = Vec3<S>, LocalDirection<S> Wo = Vec3<S>>
  [[nodiscard]] auto eval_cos(const Wi& wi, const Wo& wo) const noexcept {
    if constexpr (std::is_same_v<PatternScalar<Wi, Wo, S>, S>) {
      return eval(wi, wo) * std::abs(wi.z);
    } else {
      return when(wi.z > S(0) && wo.z > S(0), [&] {
        const Interval<S> below = Interval<S>(coat->at(wi.z)) * Interval<S>(coat->at(wo.z)) * k_inv_pi<S>;
        return specular * lobe_range(wi, wo, coat->facets().masking(wi)) +
               base_factor() * (below * max0(Interval<S>(wi.z)));
      });
    }
  }

  [[nodiscard]] std::optional<DirectionSample<S>> sample(const Vec3<S>& known, Walk walk, S u_lobe,
                                                         const Vec2<S>& u) const noexcept {
    if (known.z <= S(0)) return std::nullopt;
    const bool reflect = u_lobe < coat_probability(known);
    const Vec3<S> w = reflect ? glm::normalize(local::mirror(known, coat->facets().sample_visible(known, u)))
                              : warp::square_to_cosine_hemisphere(u);
    const S density = pdf(known, w, walk);
    if (!(density > S(0))) return std::nullopt;
    return DirectionSample<S>{w, density, false, Rgb<S>(0)};
  }
  [[nodiscard]] S pdf(const Vec3<S>& known, const Vec3<S>& sampled, Walk) const noexcept {
    if (!local::both_above(known, sampled)) return S(0);
    const MicrofacetDistribution<S> facets = coat->facets();
    const S lobe = S(0.25) * facets.density(local::half_vector(known, sampled)) * facets.masking_over_cos(known);
    const S probability = coat_probability(known);
    return probability * lobe + (S(1) - probability) * warp::cosine_hemisphere_pdf(sampled);
  }

  /// At normal incidence; of the coat the reflectance of a flat one.
  [[nodiscard]] Rgb<S> albedo() const noexcept {
    return specular * fresnel_dielectric(S(1), coat->eta()).reflectance + base_albedo(S(1));
  }
  [[nodiscard]] static constexpr bool is_delta() noexcept { return false; }
  [[nodiscard]] S sampling_weight(const Vec3<S>& known) const noexcept {
    if (known.z <= S(0)) return S(0);
    return coat_weight(known) + max_channel(base_albedo(known.z));
  }

 private:
  /// Of the coat, `masking_i` that of `wi` or its quotient with the cosine.
  template <class Wi, class Wo>
  [[nodiscard]] Interval<S> lobe_range(const Wi& wi, const Wo& wo, const Interval<S>& masking_i) const noexcept {
    const MicrofacetDistribution<S> facets = coat->facets();
    const Interval<S> value = facets.density_of_half(wi, wo) * (S(0.25) * masking_i) *
                              Interval<S>(facets.masking_over_cos(wo)) *
                              reflectance_dielectric(Interval<S>(local::cos_to_half(wi, wo)), coat->eta());
    return widen(value, facets.k_rounding);
  }
  /// diffuse / ((1 - ...) eta^2)
  [[nodiscard]] Rgb<S> base_factor() const noexcept {
    const S inside = coat->reflectance_inside();
    const Rgb<S> trapped = base == CoatedBase::nonlinear ? diffuse * inside : Rgb<S>(inside);
    return diffuse / ((Rgb<S>(1) - trapped) * sqr(coat->eta()));
  }
  [[nodiscard]] Rgb<S> base_albedo(S cosine) const noexcept {
    return base_factor() * (coat->at(cosine) * coat->mean());
  }
  /// An estimate of what the coat reflects: all that it does not transmit.
  [[nodiscard]] S coat_weight(const Vec3<S>& known) const noexcept {
    return max_channel(specular) * (S(1) - coat->at(known.z));
  }
  [[nodiscard]] S coat_probability(const Vec3<S>& known) const noexcept {
    const S lobe = coat_weight(known);
    const S below = max_channel(base_albedo(known.z));
    return lobe + below > S(0) ? lobe / (lobe + below) : S(0);
  }
};

static_assert(SetEvaluable<RoughPlastic<float>> && SetEvaluable<RoughPlastic<double>>);

}  // namespace manylight
