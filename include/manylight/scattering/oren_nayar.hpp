// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "manylight/core/warp.hpp"
#include "manylight/scattering/local_geometry.hpp"
#include "manylight/scattering/validation.hpp"

namespace manylight {

/// `full`: single scattering and interreflection of the grooves; `qualitative`: the paper's short form.
enum class OrenNayarModel { full, qualitative };

/// Rough diffuse surface of V-grooves. Reciprocal. Where the fitted polynomial of the full model dips below zero (both
/// directions grazing, opposite azimuths) it is cut to 0.
/// [Oren and Nayar 1994, "Generalization of Lambert's reflectance model", Eqs. 29 to 31]
template <std::floating_point S>
struct OrenNayar {
  using Scalar = S;
  static constexpr bool k_isotropic = true;  ///< vertices need no tangent
  Rgb<S> reflectance{S(0.5)};  ///< albedo of the facets per channel, [0, 1]
  /// Root mean square slope of the facets, the roughness of the Beckmann distribution; the paper's sigma (rad) is taken
  /// as alpha / sqrt(2), the conversion that the peers use.
  S alpha = S(0.2);
  OrenNayarModel model = OrenNayarModel::full;

  /// Throws ParameterError.
  void validate() const {
    check::reflectance("OrenNayar reflectance", reflectance);
    check::non_negative("OrenNayar alpha", alpha);
  }

  [[nodiscard]] Rgb<S> eval(const Vec3<S>& wi, const Vec3<S>& wo) const noexcept {
    if (!local::both_above(wi, wo)) return Rgb<S>(0);
    const bool wi_steeper = wi.z > wo.z;
    const Pair pair = pair_of(wi_steeper ? wo : wi, wi_steeper ? wi : wo);
    const S sigma2 = variance();
    if (model == OrenNayarModel::qualitative) {
      const S single = c1(sigma2) + c2(sigma2) * std::max(pair.cos_phi, S(0)) * pair.sin_a * pair.tan_b;
      return reflectance * (k_inv_pi<S> * single);
    }
    const S a = angle_fraction(wi_steeper ? wo : wi);
    const S b = angle_fraction(wi_steeper ? wi : wo);
    const S along = pair.cos_phi >= S(0) ? pair.sin_a : pair.sin_a - b * b * b;
    const S single = c1(sigma2) + pair.cos_phi * c2(sigma2) * along * pair.tan_b +
                     (S(1) - std::abs(pair.cos_phi)) * c3(sigma2) * sqr(a * b) * pair.tan_half_sum;
    const S twice = c4(sigma2) * (S(1) - pair.cos_phi * b * b);
    return reflectance * k_inv_pi<S> * (std::max(single, S(0)) + reflectance * twice);
  }

  [[nodiscard]] std::optional<DirectionSample<S>> sample(const Vec3<S>& known, Walk, S /*u_lobe*/,
                                                         const Vec2<S>& u) const noexcept {
    if (known.z <= S(0)) return std::nullopt;
    const Vec3<S> w = warp::square_to_cosine_hemisphere(u);
    return DirectionSample<S>{w, warp::cosine_hemisphere_pdf(w), false, Rgb<S>(0)};
  }
  [[nodiscard]] S pdf(const Vec3<S>& known, const Vec3<S>& sampled, Walk) const noexcept {
    return known.z > S(0) ? warp::cosine_hemisphere_pdf(sampled) : S(0);
  }

  /// Exact at normal incidence, where only C1 and the constant part of the interreflection remain.
  [[nodiscard]] Rgb<S> albedo() const noexcept {
    const S sigma2 = variance();
    const S twice = model == OrenNayarModel::full ? c4(sigma2) : S(0);
    return reflectance * (c1(sigma2) + reflectance * twice);
  }
  [[nodiscard]] static constexpr bool is_delta() noexcept { return false; }

  // ---- bounds (see BoundedMaterial) ----
  // tan(beta) c <= sin(beta) for either cosine c, as beta is the smaller angle; tan((a + b)/2) c <= 1 + sin(beta) <= 2.
  // So the terms in C2 and C3 are a constant over wi, the others a multiple of the cosine.
  [[nodiscard]] S sup_cos_eval(const Vec3<S>& wo) const noexcept {
    return wo.z > S(0) ? diffuse_albedo() * k_inv_pi<S> + sup_gloss_beyond(wo, S(0)) : S(0);
  }
  [[nodiscard]] S sup_eval_cos_wo(const Vec3<S>& wo) const noexcept {
    return wo.z > S(0) ? diffuse_albedo() * k_inv_pi<S> * wo.z + sup_gloss_beyond(wo, S(0)) : S(0);
  }
  [[nodiscard]] S diffuse_albedo() const noexcept {
    const S rho = max_channel(reflectance);
    const S sigma2 = variance();
    const S twice = model == OrenNayarModel::full ? S(2) * c4(sigma2) : S(0);
    return rho * (c1(sigma2) + rho * twice);
  }
  /// Independent of theta: the retro-reflecting part has no peak at the mirror direction.
  [[nodiscard]] S sup_gloss_beyond(const Vec3<S>& wo, S /*theta*/) const noexcept {
    if (wo.z <= S(0)) return S(0);
    const S sigma2 = variance();
    const S sine = safe_sqrt(local::sin2_theta(wo));
    const S grooves = model == OrenNayarModel::full ? S(2) * c3(sigma2) * sqr(angle_fraction(wo)) : S(0);
    return max_channel(reflectance) * k_inv_pi<S> * (c2(sigma2) * sine + grooves);
  }

 private:
  /// Two directions, a (the paper's alpha) farther from the normal than b (its beta).
  struct Pair {
    S sin_a;
    S tan_b;
    S tan_half_sum;  ///< tan((a + b) / 2)
    S cos_phi;       ///< cosine of the difference of the azimuths
  };
  [[nodiscard]] S variance() const noexcept { return S(0.5) * alpha * alpha; }
  [[nodiscard]] static S c1(S s2) noexcept { return S(1) - S(0.5) * s2 / (s2 + S(0.33)); }
  [[nodiscard]] static S c2(S s2) noexcept { return S(0.45) * s2 / (s2 + S(0.09)); }
  [[nodiscard]] static S c3(S s2) noexcept { return S(0.125) * s2 / (s2 + S(0.09)); }
  [[nodiscard]] static S c4(S s2) noexcept { return S(0.17) * s2 / (s2 + S(0.13)); }
  /// 2 theta / pi
  [[nodiscard]] static S angle_fraction(const Vec3<S>& w) noexcept {
    return S(2) * k_inv_pi<S> * std::atan2(safe_sqrt(local::sin2_theta(w)), w.z);
  }

  [[nodiscard]] static Pair pair_of(const Vec3<S>& far, const Vec3<S>& near) noexcept {
    const S sin_a = safe_sqrt(local::sin2_theta(far));
    const S sin_b = safe_sqrt(local::sin2_theta(near));
    const S product = sin_a * sin_b;
    const S cos_phi = product > S(1e-12) ? std::clamp((far.x * near.x + far.y * near.y) / product, S(-1), S(1)) : S(0);
    const S floor = S(1e-15);  // keeps the tangents finite in single precision
    return {sin_a, sin_b / std::max(near.z, floor), (sin_a + sin_b) / std::max(far.z + near.z, floor), cos_phi};
  }
};

static_assert(BoundedMaterial<OrenNayar<float>> && BoundedMaterial<OrenNayar<double>>);

}  // namespace manylight
