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
  /// false: not usable, or too large for sums of S w M T D I to be finite; the value is 0, the caller counts it
  bool is_valid = true;
};

/// Longest path that counts, in segments.
inline constexpr unsigned k_unlimited_edges = 0xFFFFu;

namespace detail {
/// A pixel sums fewer pairs than this: it stays finite if every S w M T D I times this is.
template <std::floating_point S>
inline constexpr S k_room_for_sums = S(0x1p40);
}  // namespace detail

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
  // Next to a surface M T D may overflow. The clamp has then left w = C / inf = 0, which is also what the later
  // vertices of the eye path reckon with; without a clamp (C = inf, exact lights) the pair is dropped: such pairs have
  // measure 0.
  const Rgb<S> value = (pair.m / m) * (pair.d / d_light) * (pair.t * m * d_light * weight);
  const Rgb<S> with_room = sensor.vertex.strength * value * light.strength * detail::k_room_for_sums<S>;
  if (!is_valid_radiance(value) || !is_finite(with_room)) return {Rgb<S>(0), false};
  return {value, true};
}

}  // namespace manylight
