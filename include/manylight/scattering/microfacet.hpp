// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "manylight/core/warp.hpp"
#include "manylight/scattering/inverse_erf.hpp"
#include "manylight/scattering/local_geometry.hpp"
#include "manylight/scattering/slope_range.hpp"
#include "manylight/scattering/validation.hpp"

namespace manylight {

enum class MicrofacetType : std::uint8_t { beckmann, ggx };

/// Distribution of the normals of a rough surface, anisotropic along local x and y, with Smith's separable masking.
/// D integrates to 1 over the projected hemisphere: int D(h) h_z dh = 1.
/// [Walter 2007, "Microfacet models for refraction through rough surfaces"; Heitz 2014, "Understanding the
/// masking-shadowing function in microfacet-based BRDFs"]
template <std::floating_point S>
struct MicrofacetDistribution {
  /// Relative error of formulas against bounds by other operations, unit vectors that are so by 2 epsilon included.
  static constexpr S k_rounding = S(24) * std::numeric_limits<S>::epsilon();
  MicrofacetType type = MicrofacetType::beckmann;
  S alpha_u = S(0.1);  ///< roughness along local x; of Beckmann the root mean square slope
  S alpha_v = S(0.1);  ///< along local y

  /// D(h), sr^-1, for a unit `h` of the upper side.
  [[nodiscard]] S density(const Vec3<S>& h) const noexcept {
    if (h.z <= S(0)) return S(0);
    const S scaled = sqr(h.x / alpha_u) + sqr(h.y / alpha_v);
    const S z2 = h.z * h.z;
    const S area = k_pi<S> * alpha_u * alpha_v;
    if (type == MicrofacetType::ggx) return S(1) / (area * sqr(scaled + z2));
    const S gauss = std::exp(-scaled / z2);
    return gauss > S(0) ? gauss / (area * z2 * z2) : S(0);
  }

  /// Range of D over the half vectors of two directions or sets, on the upper side. With t = tan^2 and e = t q the
  /// scaled one, GGX ((1 + t) / (1 + e))^2 / area, Beckmann ((1 + t) exp(-e / 2))^2 / area.
  template <class Wi, class Wo>
  [[nodiscard]] Interval<S> density_of_half(const Wi& wi, const Wo& wo) const noexcept {
    const SlopeRange<S> slope(wi, wo, alpha_u, alpha_v);
    const Interval<S> root = type == MicrofacetType::ggx ? slope.slope_ratio() : slope.gauss_slope(S(0.5));
    return widen(sqr(root) / Interval<S>(k_pi<S> * alpha_u * alpha_v), k_rounding);
  }
  [[nodiscard]] S density_of_half(const Vec3<S>& wi, const Vec3<S>& wo) const noexcept {
    return density(local::half_vector(wi, wo));
  }

  /// Masking G1(w) / |w.z|: the quotient stays finite where both vanish. Of the directions of one side.
  /// GGX: 2 / (c + sqrt(c^2 + s^2)) with s^2 = (alpha_u x)^2 + (alpha_v y)^2. Beckmann: with a = c / s, the Smith
  /// integral c (1 + Lambda) = (c (1 + erf a) + s exp(-a^2) / sqrt(pi)) / 2, used exactly.
  [[nodiscard]] S masking_over_cos(const Vec3<S>& w) const noexcept {
    return masking_over_cos(std::abs(w.z), std::sqrt(sqr(alpha_u * w.x) + sqr(alpha_v * w.y)));
  }
  /// Range over a set; only members of the upper side count. The denominators grow with c and with s (of Beckmann's the
  /// derivatives are 1 + erf(a) and exp(-a^2) / sqrt(pi)). On the sphere s = alpha sin, alpha the roughness towards w:
  /// GGX's denominator is then concave in c, as sqrt(alpha^2 + (1 - alpha^2) c^2) is for alpha > 1, or rises;
  /// Beckmann's rises up to alpha = 2, as alpha^2 a exp(-a^2) / sqrt(pi) < 1. Their minimum is at an end of c.
  [[nodiscard]] Interval<S> masking_over_cos(const DirectionSet<S>& w) const noexcept {
    const CosAndSlope box(*this, w);
    S most = masking_over_cos(box.c.lo, box.s.lo);
    const S alpha = std::min(alpha_u, alpha_v);
    if (type == MicrofacetType::ggx || alpha <= S(2)) {
      const S at_lo = masking_over_cos(box.c.lo, alpha * sine(box.c.lo));
      most = std::min(most, std::max(at_lo, masking_over_cos(box.c.hi, alpha * sine(box.c.hi))));
    }
    return widen(Interval<S>(masking_over_cos(box.c.hi, box.s.hi), most), k_rounding);
  }

  /// Smith's masking G1(w), in [0, 1].
  [[nodiscard]] S masking(const Vec3<S>& w) const noexcept {
    return std::min(masking_over_cos(w) * std::abs(w.z), S(1));
  }
  /// Range over a set; only members of the upper side count. A function of c / s alone, rising: on the sphere it grows
  /// with the cosine.
  [[nodiscard]] Interval<S> masking(const DirectionSet<S>& w) const noexcept {
    const CosAndSlope box(*this, w);
    const auto value = [&](S c, S s) { return c > S(0) ? c * masking_over_cos(c, s) : S(0); };
    const S steep = std::min(alpha_u, alpha_v) * sine(box.c.hi);
    const S flat = std::max(alpha_u, alpha_v) * sine(box.c.lo);
    const Interval<S> range(value(box.c.lo, std::min(box.s.hi, flat)), value(box.c.hi, std::max(box.s.lo, steep)));
    return min(widen(range, k_rounding), S(1));
  }

  /// Draws a normal with density D(h) G1(w) max(0, w . h) / w.z among those that `w` sees. Stretching by the roughness
  /// reduces the problem to roughness 1. [Heitz and d'Eon 2014, "Importance sampling microfacet-based BSDFs using the
  /// distribution of visible normals"]
  [[nodiscard]] Vec3<S> sample_visible(const Vec3<S>& w, const Vec2<S>& u) const noexcept {
    const Vec3<S> stretched = glm::normalize(Vec3<S>(alpha_u * w.x, alpha_v * w.y, w.z));
    const S length = safe_sqrt(local::sin2_theta(stretched));
    const S cos_phi = length > S(0) ? stretched.x / length : S(1);
    const S sin_phi = length > S(0) ? stretched.y / length : S(0);
    // The height of the unit normal is kept apart from its tangential part, so that grazing slopes never overflow.
    const Vec3<S> n =
        type == MicrofacetType::ggx ? visible_ggx(stretched.z, length, u) : visible_beckmann(stretched.z, length, u);
    const S x = cos_phi * n.x - sin_phi * n.y;
    const S y = sin_phi * n.x + cos_phi * n.y;
    return glm::normalize(Vec3<S>(alpha_u * x, alpha_v * y, n.z));
  }

  /// Largest D(h). With t = tan^2 of the angle of h and q >= 1 / alpha_max^2: GGX ((1 + t) / (1 + t q))^2 / area, monotone
  /// in t; Beckmann (1 + t)^2 exp(-t q) / area, with its peak at t = 2/q - 1.
  [[nodiscard]] S max_density() const noexcept {
    const S q = S(1) / sqr(std::max(alpha_u, alpha_v));
    const S area = k_pi<S> * alpha_u * alpha_v;
    if (type == MicrofacetType::ggx) return std::max(S(1), S(1) / (q * q)) / area;
    const S t = std::max(S(0), S(2) / q - S(1));
    return sqr(S(1) + t) * std::exp(-t * q) / area;
  }

 private:
  [[nodiscard]] S masking_over_cos(S c, S s) const noexcept {
    if (type == MicrofacetType::ggx) return S(2) / (c + std::sqrt(c * c + s * s));
    if (c > S(6) * s) return S(1) / c;  // erfc(6) = 2e-17
    const S a = c / s;
    return S(2) / (c * (S(1) + std::erf(a)) + s * std::exp(-a * a) / std::sqrt(k_pi<S>));
  }
  [[nodiscard]] static S sine(S cosine) noexcept { return safe_sqrt((S(1) - cosine) * (S(1) + cosine)); }
  /// What masking depends on, over the upper part of a set.
  struct CosAndSlope {
    Interval<S> c;
    Interval<S> s;
    CosAndSlope(const MicrofacetDistribution& d, const DirectionSet<S>& w) noexcept
        : c(max(min(w.z, S(1)), std::numeric_limits<S>::min())),  // a cosine of 0 could make 0 / 0
          s(sqrt(sqr(d.alpha_u * w.x) + sqr(d.alpha_v * w.y))) {}
  };

  /// Roughness 1, view in the x-z plane: project a disk point, squeezed to the visible half, onto the hemisphere.
  /// [Heitz 2018, "Sampling the GGX distribution of visible normals"]
  [[nodiscard]] static Vec3<S> visible_ggx(S cos_theta, S sin_theta, const Vec2<S>& u) noexcept {
    const Vec2<S> disk = warp::square_to_disk(u);
    const S across = disk.x;
    const S blend = S(0.5) * (S(1) + cos_theta);
    const S up = (S(1) - blend) * safe_sqrt(S(1) - across * across) + blend * disk.y;
    const S forward = safe_sqrt(S(1) - across * across - up * up);
    // Basis: `forward` along the view (sin, 0, cos), `up` along (-cos, 0, sin), `across` along y.
    return {sin_theta * forward - cos_theta * up, across, std::max(cos_theta * forward + sin_theta * up, S(1e-12))};
  }

  /// Roughness 1: the slope across the view is Gaussian; along it, with x the slope away from the viewer, the density
  /// is (cos - x sin)+ exp(-x^2). In e = erf(x) its distribution function is proportional to
  ///     g(e) = 1 + e + tan exp(-x^2) / sqrt(pi),   g'(e) = 1 - x tan >= 0, concave:
  /// Newton's steps approach the root from below after the first, and never leave (-1, erf(cot)].
  /// [Jakob 2014, "An improved visible normal sampling routine for the Beckmann distribution"]
  [[nodiscard]] static Vec3<S> visible_beckmann(S cos_theta, S sin_theta, const Vec2<S>& u) noexcept {
    const S across = inverse_erf(S(2) * std::clamp(u.y, S(1e-7), S(1) - S(1e-7)) - S(1));
    const S along = visible_beckmann_slope(cos_theta, sin_theta, u.x);
    return {-along, -across, S(1)};
  }
  [[nodiscard]] static S visible_beckmann_slope(S cos_theta, S sin_theta, S u) noexcept {
    u = std::clamp(u, S(1e-7), S(1) - S(1e-7));
    // Multiplied by cos, so that grazing views need no tangent.
    const S slope = sin_theta / std::sqrt(k_pi<S>);
    const S cot = sin_theta > S(0) ? cos_theta / sin_theta : k_infinity<S>;
    const S end = std::erf(std::min(cot, S(10)));
    const S total = cos_theta * (S(1) + end) + slope * std::exp(-std::min(cot * cot, S(100)));
    const S resolution = S(4) * std::numeric_limits<S>::epsilon() * total;
    S low = S(-1);
    S high = end;
    S e = end - (S(1) + end) * std::erf(std::sqrt(-std::log(u)));  // exact for a grazing view
    for (int step = 0; step < 12; ++step) {
      if (!(e > low && e < high)) e = S(0.5) * (low + high);
      const S x = inverse_erf(e);
      const S error = cos_theta * (S(1) + e) + slope * std::exp(-x * x) - u * total;
      (error > S(0) ? high : low) = e;
      if (std::abs(error) <= resolution) break;
      e -= error / (cos_theta - x * sin_theta);  // a step out of bounds, or from a flat end, is bisected above
    }
    return inverse_erf(std::clamp(e, low, high));
  }
};

}  // namespace manylight
