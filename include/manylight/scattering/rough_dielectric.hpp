// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <type_traits>

#include "manylight/scattering/fresnel.hpp"
#include "manylight/scattering/microfacet.hpp"

namespace manylight {

/// Rough interface between two dielectrics; local z > 0 is outside, both sides are handled. With h the normal of the
/// facet that takes wi to wo, of the upper side, and eta_i, eta_o the indices on their sides:
///     reflection  F D G1(wi) G1(wo) / (4 |wi.z wo.z|)
///     refraction  (1 - F) D G1(wi) G1(wo) |wi.h wo.h| / |wi.z wo.z|  eta_o^2 / |eta_i wi + eta_o wo|^2
/// Refraction scales radiance by (eta_o / eta_i)^2, as that of `Dielectric` does: not f but f / eta_o^2 is symmetric.
/// [Walter 2007, Eq. 20, 21]
template <std::floating_point S>
struct RoughDielectric {
  using Scalar = S;
  S eta = S(1.5046);  ///< index inside / index outside, > 0 and not 1
  MicrofacetType distribution = MicrofacetType::beckmann;
  S alpha_u = S(0.1);                   ///< roughness along local x
  S alpha_v = S(0.1);                   ///< roughness along local y
  Rgb<S> specular_reflectance{S(1)};    ///< factor on reflected light, [0, 1]
  Rgb<S> specular_transmittance{S(1)};  ///< factor on refracted light, [0, 1]

  /// Throws ParameterError.
  void validate() const {
    check::relative_ior("RoughDielectric eta", eta);
    require(std::abs(eta - S(1)) >= S(1e-3), "RoughDielectric eta", eta, "at least 0.001 away from 1");
    check::roughness("RoughDielectric alpha_u", alpha_u);
    check::roughness("RoughDielectric alpha_v", alpha_v);
    check::reflectance("RoughDielectric specular_reflectance", specular_reflectance);
    check::reflectance("RoughDielectric specular_transmittance", specular_transmittance);
  }

  template <LocalDirection<S> Wi, LocalDirection<S> Wo>
  [[nodiscard]] auto eval(const Wi& wi, const Wo& wo) const noexcept {
    if constexpr (std::is_same_v<PatternScalar<Wi, Wo, S>, S>) {
      return value_of(wi, wo);
    } else {
      const Interval<S> zi(wi.z);
      const Interval<S> zo(wo.z);
      const auto above = when(zi > S(0) && zo > S(0), [&] { return reflected_range(wi, wo, eta); });
      const auto below = when(zi < S(0) && zo < S(0), [&] { return reflected_range(-wi, -wo, S(1) / eta); });
      const auto down = when(zi < S(0) && zo > S(0), [&] { return refracted_range(-wi, wo, S(1)); });
      const auto up = when(zi > S(0) && zo < S(0), [&] { return refracted_range(wi, -wo, eta); });
      return hull(hull(above, below), hull(down, up));
    }
  }

  /// Draws a visible normal, then reflection with the probability of its share of the energy; what leaves on the wrong
  /// side is rejected.
  [[nodiscard]] std::optional<DirectionSample<S>> sample(const Vec3<S>& known, Walk walk, S u_lobe,
                                                         const Vec2<S>& u) const noexcept {
    if (known.z == S(0)) return std::nullopt;
    const Vec3<S> h = microfacets().sample_visible(known.z > S(0) ? known : -known, u);
    const S cosine = glm::dot(known, h);
    const DielectricInterface<S> facet = fresnel_dielectric(cosine, eta);
    const bool reflect = u_lobe < reflection_probability(facet.reflectance);
    const Vec3<S> w = reflect ? local::mirror(known, h) : (h * cosine - known) * facet.eta_ratio + h * facet.cos_t;
    if (reflect != (w.z * known.z > S(0))) return std::nullopt;
    const Vec3<S> unit = glm::normalize(w);
    const S density = pdf(known, unit, walk);
    if (!(density > S(0))) return std::nullopt;
    return DirectionSample<S>{unit, density, false, Rgb<S>(0)};
  }

  /// Density of the visible normal, D G1 |known . h| / |known.z|, over the Jacobian of reflection or refraction.
  /// [Walter 2007, Eq. 14, 17]
  [[nodiscard]] S pdf(const Vec3<S>& known, const Vec3<S>& sampled, Walk) const noexcept {
    const Facet facet = facet_between(known, sampled);
    if (!(facet.density > S(0))) return S(0);
    const S reflect = reflection_probability(fresnel_dielectric(glm::dot(known, facet.h), eta).reflectance);
    const S lobe = sqr(index_at(sampled)) * facet.density * microfacets().masking_over_cos(known);
    return lobe * (facet.is_reflection ? reflect : S(1) - reflect);
  }

  [[nodiscard]] Rgb<S> albedo() const noexcept {
    const S r = fresnel_dielectric(S(1), eta).reflectance;
    return specular_reflectance * r + specular_transmittance * (S(1) - r);
  }
  [[nodiscard]] static constexpr bool is_delta() noexcept { return false; }
  [[nodiscard]] S sampling_weight(const Vec3<S>& /*known*/) const noexcept {
    return std::max(max_channel(specular_reflectance), max_channel(specular_transmittance));
  }
  [[nodiscard]] MicrofacetDistribution<S> microfacets() const noexcept { return {distribution, alpha_u, alpha_v}; }

 private:
  /// The facet that takes one direction to the other.
  struct Facet {
    Vec3<S> h{0, 0, 1};  ///< its normal, of the upper side
    S density = S(0);    ///< D |a . h| |b . h| / |eta_a a + eta_b b|^2; 0 if there is none
    bool is_reflection = true;
  };

  [[nodiscard]] S index_at(const Vec3<S>& w) const noexcept { return w.z > S(0) ? S(1) : eta; }

  [[nodiscard]] Facet facet_between(const Vec3<S>& a, const Vec3<S>& b) const noexcept {
    Facet facet;
    facet.is_reflection = (a.z > S(0)) == (b.z > S(0));
    if (a.z == S(0) || b.z == S(0)) return facet;
    if (facet.is_reflection) {
      facet.h = local::half_vector(a, b);
      if (a.z < S(0)) facet.h = -facet.h;
      facet.density = S(0.25) * microfacets().density(facet.h) / sqr(index_at(a));
      return facet;
    }
    const Vec3<S> sum = a * index_at(a) + b * index_at(b);
    const S squared = glm::dot(sum, sum);
    facet.h = sum * (std::copysign(S(1), sum.z) / std::sqrt(squared));
    const S cos_a = glm::dot(a, facet.h);
    const S cos_b = glm::dot(b, facet.h);
    // Each direction must see the facet from its own side.
    if (cos_a * a.z > S(0) && cos_b * b.z > S(0)) {
      facet.density = microfacets().density(facet.h) * std::abs(cos_a * cos_b) / squared;
    }
    return facet;
  }

  [[nodiscard]] Rgb<S> value_of(const Vec3<S>& wi, const Vec3<S>& wo) const noexcept {
    const Facet facet = facet_between(wi, wo);
    if (!(facet.density > S(0))) return Rgb<S>(0);
    const MicrofacetDistribution<S> facets = microfacets();
    const S r = fresnel_dielectric(glm::dot(wo, facet.h), eta).reflectance;
    const S value = sqr(index_at(wo)) * facet.density * facets.masking_over_cos(wi) * facets.masking_over_cos(wo);
    return facet.is_reflection ? specular_reflectance * (r * value) : specular_transmittance * ((S(1) - r) * value);
  }
  /// Both directions on the upper side, `ratio` the index below over that above.
  template <class Wi, class Wo>
  [[nodiscard]] RgbInterval<S> reflected_range(const Wi& wi, const Wo& wo, S ratio) const noexcept {
    const MicrofacetDistribution<S> facets = microfacets();
    const Interval<S> value = facets.density_of_half(wi, wo) * (S(0.25) * Interval<S>(facets.masking_over_cos(wi))) *
                              Interval<S>(facets.masking_over_cos(wo)) *
                              reflectance_dielectric(Interval<S>(local::cos_to_half(wi, wo)), ratio);
    return specular_reflectance * widen(value, facets.k_rounding);
  }
  /// `wi` and `wo` turned to the upper side, `index_o` the index on the side of wo. The facet is left open: 1 - F, |wi.h|
  /// and |wo.h| <= 1, |eta_i wi + eta_o wo| >= |eta - 1|.
  template <class Wi, class Wo>
  [[nodiscard]] RgbInterval<S> refracted_range(const Wi& wi, const Wo& wo, S index_o) const noexcept {
    const MicrofacetDistribution<S> facets = microfacets();
    const Interval<S> most = Interval<S>(facets.max_density() * sqr(index_o / (eta - S(1)))) *
                             Interval<S>(facets.masking_over_cos(wi)) * Interval<S>(facets.masking_over_cos(wo));
    return specular_transmittance * widen(Interval<S>(S(0), most.hi), facets.k_rounding);
  }

  [[nodiscard]] S reflection_probability(S r) const noexcept {
    const S reflect = r * max_channel(specular_reflectance);
    const S refract = (S(1) - r) * max_channel(specular_transmittance);
    return reflect + refract > S(0) ? reflect / (reflect + refract) : S(1);
  }
};

static_assert(SetEvaluable<RoughDielectric<float>> && SetEvaluable<RoughDielectric<double>>);

}  // namespace manylight
