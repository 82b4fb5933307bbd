// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a cut knows of a cluster pair (C, L) without looking at its members, O(1) [theory 6]:
//
//   UB = min( (w M)_ub  T_ub  D_ub , C_clamp )   with weights folded in as in the theory sheet, section 6.5.
//
// Error of a cluster, as luminance Y of S_C I_L UB. The estimate has the representatives' colours and the sum's luminances,
// so that it may exceed Y(S_C I_L) UB: with sigma = max channel / Y of a colour, Y(s i) <= min(sigma_s, sigma_i) Y(s) Y(i).
// The larger of both bounds estimate and truth, hence their difference.

#include <algorithm>
#include <limits>

#include "manylight/bounds/box_pair.hpp"
#include "manylight/many_light/gather_tree.hpp"
#include "manylight/many_light/light_tree.hpp"

namespace manylight {

/// What bounds every pair.
template <std::floating_point S>
struct PairLimits {
  S light;         ///< C_D, limit of D, sr^-1
  S clamp;         ///< C_clamp, limit of w M T D of lights that are not exact, sr^-2 m^-2
  S scene_radius;  ///< unit of lights at infinity, m
};

/// Bound of w M T D over the pair, sr^-2 m^-2 [theory 6.2, 6.5], by the bounds of its factors: `m` of w M and `d` of
/// min(D, C_D), both positive; `squared`: the squared distance, from below.
template <std::floating_point S>
[[nodiscard]] inline S product_bound(const GatherNode<S>& gather, const LightNode<S>& light, S m, S d, S squared,
                                     const PairLimits<S>& limits) noexcept {
  const S weighted_d = d < limits.light ? d * gather.remaining : limits.light;
  if (!(weighted_d > S(0))) return S(0);  // m may be infinite
  const S bound = squared > S(0) ? m * weighted_d / squared : k_infinity<S>;
  const S rounding = S(1) + S(64) * std::numeric_limits<S>::epsilon();
  return light.is_exact ? bound * rounding : std::min(bound * rounding, limits.clamp);
}

/// Bound of w M T D over the pair, sr^-2 m^-2. Many at once: PairBounds.
template <std::floating_point S>
[[nodiscard]] inline S pair_bound(const GatherNode<S>& gather, const LightNode<S>& light,
                                  const PairLimits<S>& limits) noexcept {
  const Box<S> vectors = light.is_infinite ? light.box : difference(gather.box, light.box);
  const BoxDirections<S> to_light(vectors);
  const S m = sup_sensor_pattern(gather, to_light);
  if (!(m > S(0))) return S(0);
  const S d = sup_light_pattern(light, -to_light, limits.light);
  if (!(d > S(0))) return S(0);
  const S squared = light.is_infinite ? sqr(limits.scene_radius) : min_squared_length(vectors);
  return product_bound(gather, light, m, d, squared, limits);
}

/// Bound of |estimate - truth| of the pair, luminance; 0 for a pair of leaves. `scale`: Y(S_C) Y(I_L); `bound`: UB.
template <std::floating_point S>
[[nodiscard]] inline S pair_error(const GatherNode<S>& gather, const LightNode<S>& light, S scale, S bound) noexcept {
  if (gather.is_leaf && light.is_leaf) return S(0);
  const S of_estimate = std::min(gather.saturation, light.saturation) * scale;
  return std::max(luminance(gather.strength * light.intensity), of_estimate) * bound;
}

/// Which side of two inner nodes to split: the one whose size, or spread of normals seen from the other side's distance,
/// is larger [theory 5.4].
template <std::floating_point S>
[[nodiscard]] inline bool splits_gather(const GatherNode<S>& gather, const LightNode<S>& light) noexcept {
  if (light.is_infinite) return S(2) * spread(gather.normals) > light.box.diagonal();
  const S distance = glm::length(gather.box.center() - light.box.center());
  const S gather_size = gather.box.diagonal() + distance * spread(gather.normals);
  const S light_size = light.box.diagonal() + distance * spread(light.normals) * S(0.5);
  return gather_size > light_size;
}

}  // namespace manylight
