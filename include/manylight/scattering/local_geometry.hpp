// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "manylight/core/direction_set.hpp"
#include "manylight/core/interval_math.hpp"
#include "manylight/core/vector.hpp"
#include "manylight/scattering/concepts.hpp"

/// Small geometry of the local shading frame (normal = +z) shared by the materials.
namespace manylight::local {

using manylight::half_vector;
using manylight::mirror;

/// Both directions lie on the side of the normal.
template <std::floating_point S>
[[nodiscard]] constexpr bool both_above(const Vec3<S>& wi, const Vec3<S>& wo) noexcept {
  return wi.z > S(0) && wo.z > S(0);
}

/// Cosine of the angle between either of two directions of the upper side and their half vector, half of that between
/// them: over sets closer than the dot product with the set of half vectors, which forgets that the half vector moves
/// along. Only members of the upper side count: they are at most theta_i + theta_o apart, both at most 90 degrees,
/// which keeps Fresnel's reflectance from its grazing value in rings that reach below the horizon.
template <class Wi, class Wo>
[[nodiscard]] inline auto cos_to_half(const Wi& wi, const Wo& wo) noexcept {
  const auto cosine = manylight::dot(wi, wo);
  using Cosine = std::remove_const_t<decltype(cosine)>;
  const auto half = [](const Cosine& c) { return manylight::sqrt(manylight::max0(Cosine(0.5f) * (Cosine(1.0f) + c))); };
  if constexpr (std::is_floating_point_v<Cosine>) {
    return half(cosine);
  } else {
    using S = decltype(cosine.lo);
    const S zi = std::clamp(Cosine(wi.z).lo, S(0), S(1));
    const S zo = std::clamp(Cosine(wo.z).lo, S(0), S(1));
    const S least = zi * zo - std::sqrt((S(1) - zi * zi) * (S(1) - zo * zo));
    return half(
        {std::max(cosine.lo, std::min(least - S(2) * manylight::detail::k_cosine_margin<S>, cosine.hi)), cosine.hi});
  }
}

/// Squared sine of the angle to the normal, without the cancellation of 1 - z^2.
template <std::floating_point S>
[[nodiscard]] constexpr S sin2_theta(const Vec3<S>& w) noexcept {
  return w.x * w.x + w.y * w.y;
}

}  // namespace manylight::local
