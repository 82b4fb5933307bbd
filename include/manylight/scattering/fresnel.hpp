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
/// Parts of a conductor's reflectance at one cosine, p^2 = (eta + i k)^2 - sin^2.
template <std::floating_point S>
struct ConductorPart {
  Interval<S> size;  ///< |p|
  S direction;       ///< Re p / |p|, rounded towards `sign`
  S perpendicular;   ///< R_s, rounded away from it
  S slope;           ///< sin^2 / cos
};
template <std::floating_point S>
[[nodiscard]] inline ConductorPart<S> conductor_part(S c, S eta, S k, S sign) noexcept {
  const S eta2 = eta * eta;
  const S k2 = k * k;
  const S s2 = S(1) - c * c;
  const S difference = eta2 - k2 - s2;
  const S size2 = std::sqrt(difference * difference + S(4) * eta2 * k2);
  // Their sum cancels where k outweighs eta, here and in the formula that is to be bounded.
  const S noise = S(4) * std::numeric_limits<S>::epsilon() * (S(1) + eta2 + k2 + std::abs(difference) + size2);
  const S a = safe_sqrt(S(0.5) * (size2 + difference) + sign * noise);
  const S divisor = std::max(size2 - sign * noise, S(0)) + c * c;
  const S m = divisor > S(0) ? S(2) * a * c / divisor : S(0.5) + S(0.5) * sign;
  const Interval<S> size(safe_sqrt(size2 - noise), std::sqrt(size2 + noise));
  const S length = sign < S(0) ? size.hi : size.lo;
  const S direction = length > S(0) ? std::min(a / length, S(1)) : S(0.5) + S(0.5) * sign;
  return {size, direction, mirrored(std::min(m, S(1))), c > S(0) ? s2 / c : k_infinity<S>};
}
}  // namespace detail

/// Range over an interval of cosines >= 0: F = R_s (1 + R_p / R_s) / 2, and
///  - R_s falls with the cosine. It is (1 - m) / (1 + m), m = 2 Re p cos / (|p|^2 + cos^2); with w = p / cos,
///    w^2 = 1 + K / cos^2, M = |w^2|, R = Re w^2, m^2 = 2 (M + R) / (1 + M)^2, and by 1 / cos^2 the derivative of m^2
///    has the sign of (M + R) (2 R - 1 - M^2) <= -(M + R) (1 - R)^2 <= 0;
///  - R_p / R_s = (1 - l) / (1 + l), l = 2 z / (1 + z^2) Re p / |p|, z = (sin^2 / cos) / |p|. Re p / |p| grows with the
///    cosine, as p^2 moves along a parallel to the real axis; sin^2 / cos falls; 2 z / (1 + z^2) peaks at z = 1.
/// F itself dips and rises, and z takes |p| apart from the cosine: exact up to that.
template <std::floating_point S>
[[nodiscard]] inline Interval<S> fresnel_conductor(const Interval<S>& cos_i, S eta, S k) noexcept {
  constexpr S k_margin = S(32) * std::numeric_limits<S>::epsilon();
  const S from = std::clamp(cos_i.lo, S(0), S(1));
  const S to = std::clamp(cos_i.hi, S(0), S(1));
  const detail::ConductorPart<S> low = detail::conductor_part(from, eta, k, S(-1));
  const detail::ConductorPart<S> high = detail::conductor_part(to, eta, k, S(1));
  Interval<S> size = hull(low.size, high.size);
  // |p|^2 is smallest where its real part, which grows with the cosine, changes sign.
  const S turn = S(1) - eta * eta + k * k;
  const S rounding = k_margin * (S(1) + eta * eta + k * k);
  if (turn >= from * from - rounding && turn <= to * to + rounding) {
    size.lo = std::min(size.lo, std::sqrt(S(2) * eta * k) * (S(1) - k_margin));
  }
  const S z_from = size.hi > S(0) ? high.slope / size.hi : S(0);
  const S z_to = size.lo > S(0) ? low.slope / size.lo : k_infinity<S>;
  const auto part = [](S z) { return z > S(1) ? S(2) / (z + S(1) / z) : S(2) * z / (S(1) + z * z); };
  const S l_from = std::min(part(z_from), part(z_to)) * low.direction - k_margin;
  const S l_to = part(std::clamp(S(1), z_from, z_to)) * high.direction + k_margin;
  const S most = S(0.5) * low.perpendicular * (S(1) + detail::mirrored(std::max(l_from, S(0))));
  const S least = S(0.5) * high.perpendicular * (S(1) + detail::mirrored(std::min(l_to, S(1))));
  return {std::max(S(0), least - k_margin), std::min(S(1), most + k_margin)};
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
