// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "manylight/core/interval_math.hpp"
#include "manylight/core/rgb_interval.hpp"
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

  /// Of vectors the BSDF; of direction sets the range of its values over them.
  template <LocalDirection<S> Wi = Vec3<S>, LocalDirection<S> Wo = Vec3<S>>
  [[nodiscard]] auto eval(const Wi& wi, const Wo& wo) const noexcept {
    if constexpr (std::is_same_v<PatternScalar<Wi, Wo, S>, S>) {
      return local::both_above(wi, wo) ? value(wi, wo) : Rgb<S>(0);
    } else {
      return when(wi.z > S(0) && wo.z > S(0), [&] { return range(wi, wo); });
    }
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

 private:
  /// Two directions, a (the paper's alpha) farther from the normal than b (its beta).
  struct Pair {
    S sin_a;
    S tan_b;
    S tan_half_sum;  ///< tan((a + b) / 2)
    S cos_phi;       ///< cosine of the difference of the azimuths
  };
  [[nodiscard]] Rgb<S> value(const Vec3<S>& wi, const Vec3<S>& wo) const noexcept {
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

  /// The terms in turn; each is monotone in the two polar angles and in what the difference of azimuths allows.
  template <class Wi, class Wo>
  [[nodiscard]] RgbInterval<S> range(const Wi& wi, const Wo& wo) const noexcept {
    using I = Interval<S>;
    const S sigma2 = variance();
    const Cosines c(wi, wo);
    const Azimuths azimuths = azimuths_of(wi, wo, c);
    const I ratio = azimuths.product / c.near;  // cos_phi sin_a tan_b
    if (model == OrenNayarModel::qualitative) {
      const I single = c1(sigma2) + c2(sigma2) * max0(ratio);
      return reflectance * widen(k_inv_pi<S> * single, k_rounding);
    }
    const I b = angle_fraction(c.near);
    // sin_b >= b >= b^3 (Jordan), so that 1 - b^3 / sin_a is in [0, 1]: opposite azimuths make this term negative.
    const I shrunk = clamp(S(1) - sqr(b) * (b / c.sin_far), S(0), S(1));
    const I along = max0(ratio) - max0(-ratio) * shrunk;
    // The product of squared angles and the tangent grows with either angle: its ends are at those of both cosines.
    const I grooves(grooves_at(c.far.hi, c.near.hi), grooves_at(c.far.lo, c.near.lo));
    const I single = c1(sigma2) + c2(sigma2) * along + c3(sigma2) * ((S(1) - abs(azimuths.cos_phi)) * grooves);
    const I twice = c4(sigma2) * (S(1) - azimuths.cos_phi * sqr(b));
    const I first = max0(widen(single, k_rounding) + I(-k_rounding, k_rounding));
    const I second = widen(max0(twice), k_rounding);
    const auto channel = [&](S rho) { return k_inv_pi<S> * rho * (first + rho * second); };
    return {channel(reflectance.x), channel(reflectance.y), channel(reflectance.z)};
  }
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

  // ---- ranges over sets ----
  static constexpr S k_rounding = S(32) * std::numeric_limits<S>::epsilon();

  /// Of the upper parts of both sets. The larger and the smaller of two cosines are monotone in both.
  struct Cosines {
    Interval<S> i;
    Interval<S> o;
    Interval<S> near;
    Interval<S> far;
    Interval<S> sin_far;
    template <class Wi, class Wo>
    Cosines(const Wi& wi, const Wo& wo) noexcept
        : i(clamp(Interval<S>(wi.z), S(0), S(1))),
          o(clamp(Interval<S>(wo.z), S(0), S(1))),
          near(max(i, o)),
          far(min(i, o)),
          sin_far(sine(far)) {}
  };
  struct Azimuths {
    Interval<S> product;  ///< x_i x_o + y_i y_o = cos_phi sin_a sin_b
    Interval<S> cos_phi;
  };
  [[nodiscard]] static Interval<S> sine(const Interval<S>& cosine) noexcept {
    return sqrt((S(1) - cosine) * (S(1) + cosine));
  }
  [[nodiscard]] static Interval<S> angle_fraction(const Interval<S>& cosine) noexcept {
    const auto at = [](S c) { return S(2) * k_inv_pi<S> * std::acos(c); };
    return {std::max(S(0), at(cosine.hi) - k_rounding), at(cosine.lo) + k_rounding};
  }
  /// (4 a b / pi^2)^2 tan((a + b) / 2), a and b given by their cosines.
  [[nodiscard]] static S grooves_at(S cos_a, S cos_b) noexcept {
    const auto fraction = [](S c) { return S(2) * k_inv_pi<S> * std::acos(c); };
    const auto sine_of = [](S c) { return safe_sqrt((S(1) - c) * (S(1) + c)); };
    const S sum = cos_a + cos_b;
    const S tangent = sum > S(0) ? (sine_of(cos_a) + sine_of(cos_b)) / sum : k_infinity<S>;
    return sqr(fraction(cos_a) * fraction(cos_b)) * tangent;
  }

  /// Of a set and a vector: with u the unit vector along the vector's azimuth and v across, cos_phi = p / sqrt(p^2 +
  /// q^2), p = w . u, q = w . v, grows with p and with |q| moves towards 0.
  [[nodiscard]] static Azimuths azimuths_of(const DirectionSet<S>& w, const Vec3<S>& known, const Cosines&) noexcept {
    const S sin2 = local::sin2_theta(known);
    const S sine = std::sqrt(sin2);
    if (!(sine > S(1e-5))) return {Interval<S>(-sine, sine) * S(1.01), Interval<S>(S(-1), S(1))};
    const Vec3<S> u(known.x / sine, known.y / sine, S(0));
    const Interval<S> p = dot(w, u);
    const Interval<S> q = abs(dot(w, Vec3<S>(-u.y, u.x, S(0))));
    const auto cosine = [](S along, S across) {
      const S length = std::sqrt(along * along + across * across);
      return length > S(0) ? along / length : S(0);
    };
    const S lo = cosine(p.lo, p.lo > S(0) ? q.hi : q.lo);
    const S hi = cosine(p.hi, p.hi > S(0) ? q.lo : q.hi);
    Interval<S> cos_phi(std::max(S(-1), lo - k_rounding), std::min(S(1), hi + k_rounding));
    Interval<S> product = widen(p * sine, k_rounding);
    if (w.z.hi > S(0.9999)) {  // `pair_of` has no azimuth next to the normal
      cos_phi = hull(cos_phi, Interval<S>(S(0)));
      product = hull(product, Interval<S>(S(0)));
    }
    return {product, cos_phi};
  }
  [[nodiscard]] static Azimuths azimuths_of(const Vec3<S>& known, const DirectionSet<S>& w, const Cosines& c) noexcept {
    return azimuths_of(w, known, c);
  }
  /// Of two sets, by the cosine rule, within sin_a sin_b.
  [[nodiscard]] static Azimuths azimuths_of(const DirectionSet<S>& wi, const DirectionSet<S>& wo,
                                            const Cosines& c) noexcept {
    const Interval<S> sines = sine(c.i) * sine(c.o);
    const Interval<S> product = refine(Interval<S>(dot(wi, wo)) - c.i * c.o,
                                       [&] { return Interval<S>(-sines.hi - k_rounding, sines.hi + k_rounding); });
    if (!(sines.lo > S(1e-5))) return {hull(product, Interval<S>(S(0))), Interval<S>(S(-1), S(1))};
    return {product, clamp(product / sines, S(-1), S(1))};
  }
};

static_assert(SetEvaluable<OrenNayar<float>> && SetEvaluable<OrenNayar<double>>);

}  // namespace manylight
