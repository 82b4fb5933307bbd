// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "manylight/core/interval_math.hpp"
#include "manylight/core/rgb_interval.hpp"
#include "manylight/core/spectrum.hpp"

namespace manylight {

/// What a smooth dielectric interface does with a ray.
template <std::floating_point S>
struct DielectricInterface {
  S reflectance = S(0);  ///< unpolarised Fresnel reflectance, [0, 1]
  S cos_t = S(0);        ///< cosine at the far side, signed: opposite to the incident side; 0 under total reflection
  S eta_ratio = S(1);    ///< index on the incident side / index on the far side: scales the tangential components
};

/// Fresnel equations for unpolarised light. `cos_i` is signed: > 0 outside. `eta` = index inside / index outside.
template <std::floating_point S>
[[nodiscard]] inline DielectricInterface<S> fresnel_dielectric(S cos_i, S eta) noexcept {
  const bool outside = cos_i >= S(0);
  const S ratio = outside ? S(1) / eta : eta;
  const S ci = std::min(std::abs(cos_i), S(1));
  const S cos2_t = S(1) - ratio * ratio * (S(1) - ci * ci);
  if (cos2_t <= S(0)) return {S(1), S(0), ratio};
  const S ct = std::sqrt(cos2_t);
  const S perpendicular = (ratio * ci - ct) / (ratio * ci + ct);
  const S parallel = (ci - ratio * ct) / (ci + ratio * ct);
  const S reflectance = S(0.5) * (perpendicular * perpendicular + parallel * parallel);
  return {std::min(reflectance, S(1)), outside ? -ct : ct, ratio};
}

/// Fresnel reflectance of a conductor of complex index eta + i k relative to the outside, for one wavelength.
/// `cos_i` in [0, 1]. Exact; even in eta and k. [Born and Wolf 1999]
template <std::floating_point S>
[[nodiscard]] inline S fresnel_conductor(S cos_i, S eta, S k) noexcept {
  const S c2 = std::min(cos_i * cos_i, S(1));
  const S s2 = S(1) - c2;
  const S difference = eta * eta - k * k - s2;
  const S a2_plus_b2 = std::sqrt(difference * difference + S(4) * eta * eta * k * k);
  const S a = safe_sqrt(S(0.5) * (a2_plus_b2 + difference));
  const S twice_ac = S(2) * std::sqrt(c2) * a;
  const S perpendicular = (a2_plus_b2 + c2 - twice_ac) / std::max(a2_plus_b2 + c2 + twice_ac, S(1e-30));
  const S sum = a2_plus_b2 * c2 + s2 * s2;
  const S parallel_ratio = (sum - twice_ac * s2) / std::max(sum + twice_ac * s2, S(1e-30));
  return std::clamp(S(0.5) * perpendicular * (S(1) + parallel_ratio), S(0), S(1));
}

template <std::floating_point S>
[[nodiscard]] inline Rgb<S> fresnel_conductor(S cos_i, const Rgb<S>& eta, const Rgb<S>& k) noexcept {
  return {fresnel_conductor(cos_i, eta.x, k.x), fresnel_conductor(cos_i, eta.y, k.y),
          fresnel_conductor(cos_i, eta.z, k.z)};
}

// ---- ranges over an interval of cosines
// ------------------------------------------------------------------------------

/// Reflectance alone; of an interval of cosines >= 0 its range. With r = cos_t / cos_i and n = eta,
///     F = ((n r - 1)^2 / (n r + 1)^2 + (n - r)^2 / (n + r)^2) / 2,
///     dF/dr = c (r^2 - 1) (r + 1/r - (n^4 - 6 n^2 + 1) / (n + n^3)),   c > 0.
/// r moves away from 1 with the angle, hence r + 1/r grows from 2: as the angle grows, F falls at most once and then
/// rises, so that its maximum over a range is at one of the ends. Below n + 1/n = 4 it only rises. Total internal
/// reflection, F = 1, continues the rise.
template <std::floating_point S>
[[nodiscard]] inline S reflectance_dielectric(S cos_i, S eta) noexcept {
  return fresnel_dielectric(cos_i, eta).reflectance;
}
template <std::floating_point S>
[[nodiscard]] inline Interval<S> reflectance_dielectric(const Interval<S>& cos_i, S eta) noexcept {
  // The cosines' own margin covers where F is steep; amplitudes are off by a few epsilon, their squares by twice that.
  constexpr S k_margin = S(16) * std::numeric_limits<S>::epsilon();
  const auto error = [](S f) { return k_margin * (std::sqrt(f) + k_margin); };
  const S at_lo = reflectance_dielectric(std::clamp(cos_i.lo - k_margin, S(0), S(1)), eta);
  const S at_hi = reflectance_dielectric(std::clamp(cos_i.hi + k_margin, S(0), S(1)), eta);
  const S most = std::max(at_lo, at_hi);
  const S least = eta + S(1) / eta < S(4) ? std::min(at_lo, at_hi) : S(0);
  return {std::max(S(0), least - error(least)), std::min(S(1), most + error(most))};
}

namespace detail {
/// (1 - x) / (1 + x), falling.
template <std::floating_point S>
[[nodiscard]] constexpr S mirrored(S x) noexcept {
  return (S(1) - x) / (S(1) + x);
}
/// Parts of a conductor's reflectance at one cosine, all with the errors of a computation in S.
template <std::floating_point S>
struct ConductorPart {
  Interval<S> size;           ///< |p|, p^2 = (eta + i k)^2 - sin^2
  Interval<S> direction;      ///< Re p / |p|
  Interval<S> perpendicular;  ///< R_s
  Interval<S> slope;          ///< sin^2 / cos
};
template <std::floating_point S>
[[nodiscard]] inline ConductorPart<S> conductor_part(S cos_i, S eta, S k) noexcept {
  using I = Interval<S>;
  const I c(cos_i);
  const I c2 = min(sqr(c), S(1));
  const I s2 = max0(I(S(1)) - c2);
  const I eta2 = sqr(I(eta));
  const I k2 = sqr(I(k));
  const I difference = eta2 - k2 - s2;
  const I size2 = sqrt(sqr(difference) + S(4) * (eta2 * k2));
  const I a = sqrt(max0(S(0.5) * (size2 + difference)));
  const I size = sqrt(size2);
  const I twice_ac = S(2) * (c * a);
  const I m = clamp(twice_ac / (size2 + c2), S(0), S(1));
  const I direction = size.lo > S(0) ? clamp(a / size, S(0), S(1)) : I(S(0), S(1));
  const I perpendicular(mirrored(m.hi), mirrored(m.lo));
  return {size, direction, perpendicular, cos_i > S(0) ? s2 / c : I(S(0), k_infinity<S>)};
}
}  // namespace detail

/// Range over an interval of cosines >= 0: F = R_s (1 + R_p / R_s) / 2, and
///  - R_s falls with the cosine. It is (1 - m) / (1 + m); with w = p / cos, w^2 = 1 + K / cos^2, M = |w^2|,
///    R = Re w^2, m^2 = 2 (M + R) / (1 + M)^2, and by tau = 1 / cos^2 the derivative of m^2 has the sign of
///    (M + R) (2 R - 1 - M^2) <= -(M + R) (1 - R)^2 <= 0;
///  - R_p / R_s = (1 - l) / (1 + l), l = 2 z / (1 + z^2) Re p / |p|, z = (sin^2 / cos) / |p|. Re p / |p| grows with the
///    cosine, as p^2 moves along a parallel to the real axis; sin^2 / cos falls; 2 z / (1 + z^2) peaks at z = 1.
/// F itself dips and rises, and z takes |p| apart from the cosine: exact up to that.
template <std::floating_point S>
[[nodiscard]] inline Interval<S> fresnel_conductor(const Interval<S>& cos_i, S eta, S k) noexcept {
  using I = Interval<S>;
  const S from = std::clamp(cos_i.lo, S(0), S(1));
  const S to = std::clamp(cos_i.hi, S(0), S(1));
  const detail::ConductorPart<S> low = detail::conductor_part(from, eta, k);
  const detail::ConductorPart<S> high = detail::conductor_part(to, eta, k);
  const I perpendicular(high.perpendicular.lo, low.perpendicular.hi);
  const I direction(low.direction.lo, high.direction.hi);
  constexpr S k_margin = S(32) * std::numeric_limits<S>::epsilon();
  // |p|^2 is smallest where its real part, which grows with the cosine, changes sign.
  const S turn = S(1) - eta * eta + k * k;
  const S rounding = k_margin * (S(1) + eta * eta + k * k);
  const bool has_turn = turn >= from * from - rounding && turn <= to * to + rounding;
  const I ends = hull(low.size, high.size);
  const I size = has_turn ? hull(ends, sqrt(S(2) * I(eta) * I(k))) : ends;
  const I slope(high.slope.lo, low.slope.hi);
  const I z = size.lo > S(0) ? slope / size : I(S(0), k_infinity<S>);
  const auto part = [](S x) { return x > S(1) ? S(2) / x / (S(1) + S(1) / x / x) : S(2) * x / (S(1) + x * x); };
  const S least = std::max(S(0), std::min(part(z.lo), part(z.hi)) - k_margin);
  const S most = std::min(S(1), part(std::clamp(S(1), z.lo, z.hi)) + k_margin);
  const S l_from = std::max(S(0), least * direction.lo - k_margin);
  const S l_to = std::min(S(1), most * direction.hi + k_margin);
  const I ratio(detail::mirrored(l_to), detail::mirrored(l_from));
  const I f = S(0.5) * (perpendicular * (I(S(1)) + ratio));
  return clamp(I(f.lo - k_margin, f.hi + k_margin), S(0), S(1));
}
template <std::floating_point S>
[[nodiscard]] inline RgbInterval<S> fresnel_conductor(const Interval<S>& cos_i, const Rgb<S>& eta,
                                                      const Rgb<S>& k) noexcept {
  return {fresnel_conductor(cos_i, eta.x, k.x), fresnel_conductor(cos_i, eta.y, k.y),
          fresnel_conductor(cos_i, eta.z, k.z)};
}

/// Hemispherical-hemispherical reflectance 2 int_0^1 F(mu) mu dmu of a dielectric met from outside, for eta >= 1.
/// Closed form [Walsh 1926; Duntley 1942]; from inside it is 1 - (1 - this) / eta^2 (reciprocity).
template <std::floating_point S>
[[nodiscard]] inline S fresnel_diffuse_outside(S eta) noexcept {
  // In double: the terms cancel to a few per cent of their size near eta = 1, where F is of order (eta - 1)^2 ... log.
  const double n = eta;
  if (n <= 1.0 + 1e-4) return S(0);
  const double n2 = n * n;
  const double n4 = n2 * n2;
  const double first = 0.5 + (n - 1) * (3 * n + 1) / (6 * (n + 1) * (n + 1));
  const double second = n2 * (n2 - 1) * (n2 - 1) / ((n2 + 1) * (n2 + 1) * (n2 + 1)) * std::log((n - 1) / (n + 1));
  const double third = 2 * n2 * n * (n2 + 2 * n - 1) / ((n2 + 1) * (n4 - 1));
  const double fourth = 8 * n4 * (n4 + 1) / ((n2 + 1) * (n4 - 1) * (n4 - 1)) * std::log(n);
  return static_cast<S>(first + second - third + fourth);
}

/// 2 int_0^1 F(mu) mu dmu met from inside a medium of relative index `eta` (any positive value).
template <std::floating_point S>
[[nodiscard]] inline S fresnel_diffuse_inside(S eta) noexcept {
  if (eta < S(1)) return fresnel_diffuse_outside(S(1) / eta);
  return S(1) - (S(1) - fresnel_diffuse_outside(eta)) / (eta * eta);
}

}  // namespace manylight
