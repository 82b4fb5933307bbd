// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "manylight/core/rgb_interval.hpp"
#include "manylight/core/warp.hpp"
#include "manylight/scattering/fresnel.hpp"
#include "manylight/scattering/local_geometry.hpp"
#include "manylight/scattering/validation.hpp"

namespace manylight {

/// Does the colour of a coated diffuse base shift by repeated reflection under the coat?
enum class CoatedBase : bool { linear, nonlinear };

/// Diffuse base of reflectance `diffuse` under a smooth dielectric coat. Delta part: the mirror image, times Fresnel.
/// The rest of the light enters, scatters at the base, is reflected back down by the coat with the hemispherical
/// reflectance F_in, and so on; the geometric series sums to
///     f = diffuse / (1 - diffuse F_in) (1 - F(wi)) (1 - F(wo)) / (pi eta^2)         (nonlinear)
/// while `linear` puts 1 - F_in below the line, which keeps the colour of `diffuse`. Reciprocal.
template <std::floating_point S>
struct Plastic {
  using Scalar = S;
  static constexpr bool k_isotropic = true;  ///< vertices need no tangent
  Rgb<S> diffuse{S(0.5)};  ///< reflectance of the base per channel, [0, 1]
  Rgb<S> specular{S(1)};   ///< factor on the mirror reflection, [0, 1]

  Plastic() : Plastic(Rgb<S>(S(0.5)), Rgb<S>(S(1)), S(1.49)) {}
  /// `eta` = index of the coat / index outside. Evaluates logarithms: for textures make one, then set `diffuse`.
  Plastic(const Rgb<S>& diffuse_reflectance, const Rgb<S>& specular_reflectance, S eta,
          CoatedBase base = CoatedBase::linear) noexcept
      : diffuse(diffuse_reflectance),
        specular(specular_reflectance),
        eta_(eta),
        reflectance_inside_(fresnel_diffuse_inside(eta)),
        base_(base) {}

  /// Throws ParameterError.
  void validate() const {
    check::relative_ior("Plastic eta", eta_);
    check::reflectance("Plastic diffuse", diffuse);
    check::reflectance("Plastic specular", specular);
  }

  /// Of vectors the BSDF; of direction sets the range of its values over them.
  template <LocalDirection<S> Wi = Vec3<S>, LocalDirection<S> Wo = Vec3<S>>
  [[nodiscard]] auto eval(const Wi& wi, const Wo& wo) const noexcept {
    if constexpr (std::is_same_v<PatternScalar<Wi, Wo, S>, S>) {
      if (!local::both_above(wi, wo)) return Rgb<S>(0);
      return base() * (transmittance(wi.z) * transmittance(wo.z) * k_inv_pi<S>);
    } else {
      return when(wi.z > S(0) && wo.z > S(0), [&] {
        return base() * (transmittance(Interval<S>(wi.z)) * transmittance(Interval<S>(wo.z)) * k_inv_pi<S>);
      });
    }
  }

  [[nodiscard]] std::optional<DirectionSample<S>> sample(const Vec3<S>& known, Walk walk, S u_lobe,
                                                         const Vec2<S>& u) const noexcept {
    if (known.z <= S(0)) return std::nullopt;
    const S probability = coat_probability(known);
    if (u_lobe < probability) {
      const S weight = (S(1) - transmittance(known.z)) / probability;
      return DirectionSample<S>{local::mirror(known), probability, true, specular * weight};
    }
    const Vec3<S> w = warp::square_to_cosine_hemisphere(u);
    const S density = pdf(known, w, walk);
    if (!(density > S(0))) return std::nullopt;
    return DirectionSample<S>{w, density, false, Rgb<S>(0)};
  }
  [[nodiscard]] S pdf(const Vec3<S>& known, const Vec3<S>& sampled, Walk) const noexcept {
    if (!local::both_above(known, sampled)) return S(0);
    return (S(1) - coat_probability(known)) * warp::cosine_hemisphere_pdf(sampled);
  }

  /// Of the diffuse part, exact at normal incidence: int (1 - F) dmu^2 = (1 - F_in) eta^2.
  [[nodiscard]] Rgb<S> albedo() const noexcept { return base_albedo(S(1)); }
  [[nodiscard]] static constexpr bool is_delta() noexcept { return false; }
  [[nodiscard]] S sampling_weight(const Vec3<S>& known) const noexcept {
    if (known.z <= S(0)) return S(0);
    return max_channel(specular) * (S(1) - transmittance(known.z)) + max_channel(base_albedo(known.z));
  }
  [[nodiscard]] S eta() const noexcept { return eta_; }

 private:
  [[nodiscard]] S transmittance(S cosine) const noexcept { return S(1) - fresnel_dielectric(cosine, eta_).reflectance; }
  [[nodiscard]] Interval<S> transmittance(const Interval<S>& cosine) const noexcept {
    return S(1) - reflectance_dielectric(cosine, eta_);
  }
  /// Total internal reflection aside, the transmittance falls monotonically with the angle.
  [[nodiscard]] S max_transmittance() const noexcept { return transmittance(S(1)); }
  /// diffuse / ((1 - ...) eta^2)
  [[nodiscard]] Rgb<S> base() const noexcept {
    const Rgb<S> trapped = base_ == CoatedBase::nonlinear ? diffuse * reflectance_inside_ : Rgb<S>(reflectance_inside_);
    return diffuse / ((Rgb<S>(1) - trapped) * (eta_ * eta_));
  }
  [[nodiscard]] Rgb<S> base_albedo(S cosine) const noexcept {
    return base() * (transmittance(cosine) * (S(1) - reflectance_inside_) * (eta_ * eta_));
  }
  [[nodiscard]] S coat_probability(const Vec3<S>& known) const noexcept {
    const S coat = max_channel(specular) * (S(1) - transmittance(known.z));
    const S below = max_channel(base_albedo(known.z));
    return coat + below > S(0) ? coat / (coat + below) : S(0);
  }

  S eta_;
  S reflectance_inside_;  ///< F_in
  CoatedBase base_;
};

static_assert(SetEvaluable<Plastic<float>> && SetEvaluable<Plastic<double>>);

}  // namespace manylight
