// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

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
