// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "manylight/path/connect.hpp"
#include "manylight/path/eye_subpath.hpp"
#include "manylight/path/weighting.hpp"

namespace manylight {

/// w M T D of a pair, without visibility and without S and I; unit m^-2 sr^-2.
template <std::floating_point S>
struct Transfer {
  Rgb<S> value{0};
  bool is_valid = true;  ///< false: not finite; the value is 0 and the caller counts it
};

/// Longest path that counts, in segments.
inline constexpr unsigned k_unlimited_edges = 0xFFFFu;

/// Evaluates a pair; pairs whose path is longer than `max_edges` carry nothing.
template <class Scene, Weighting W>
[[nodiscard]] Transfer<typename Scene::Scalar> unoccluded_transfer(const W& weighting, const Sensor<Scene, W>& sensor,
                                                                   const VertexOf<Scene>& light,
                                                                   typename Scene::Scalar scene_radius,
                                                                   unsigned max_edges) {
  using S = typename Scene::Scalar;
  if (unsigned{sensor.vertex.edges} + 1u + light.edges > max_edges) return {};
  const Pair<S> pair = connect(sensor.vertex, light, scene_radius);
  if (pair.is_zero()) return {};
  const S m = max_channel(pair.m);
  const S d_light = max_channel(pair.d);
  const S weight = weighting.weight(sensor.record, PairPatterns<S>{m, pair.sensor_d, pair.t, d_light, light.exact});
  if (!(weight > S(0))) return {};
  // M T D may overflow next to a surface, where the clamp binds: then w M T D is the clamp itself.
  const S unweighted = pair.t * m * d_light;
  const S geometry = unweighted < k_infinity<S> ? unweighted * weight : weighting.clamp();
  const Rgb<S> value = (pair.m / m) * (pair.d / d_light) * geometry;
  if (!is_valid_radiance(value)) return {Rgb<S>(0), false};
  return {value, true};
}

}  // namespace manylight
