// SPDX-License-Identifier: Apache-2.0
#pragma once

// pair_bound and splits_gather of many cluster pairs at once: distances and cosines in packs, a pair per lane; what is
// looked up (profiles, maps, limits) per pair. The same formulas and margins, so that results differ by rounding only.

#include <algorithm>
#include <cstddef>
#include <vector>

#include "manylight/bounds/box_pair_pack.hpp"
#include "manylight/many_light/pair_bound.hpp"

namespace manylight {

/// A list of cluster pairs and their bounds; keeps its memory from list to list.
template <std::floating_point S, class Subsurface = NoSubsurface>
class PairBounds {
 public:
  void clear() noexcept { pairs_.clear(); }
  /// Appends a pair. The nodes must stay where they are until the bounds are evaluated.
  void add(const GatherNode<S>& gather, const LightNode<S>& light);
  /// Of the last pair: what its inner vertices are connected through, or null.
  void set_object(const Subsurface* below) { pairs_.back().below = below; }
  void evaluate(const PairLimits<S>& limits);

  [[nodiscard]] std::size_t size() const noexcept { return pairs_.size(); }
  [[nodiscard]] const GatherNode<S>& gather(std::size_t i) const noexcept { return *pairs_[i].gather; }
  [[nodiscard]] const LightNode<S>& light(std::size_t i) const noexcept { return *pairs_[i].light; }
  /// See pair_bound.
  [[nodiscard]] S bound(std::size_t i) const noexcept { return pairs_[i].bound; }
  /// See splits_gather; also for pairs of leaves, where it means nothing.
  [[nodiscard]] bool splits_gather(std::size_t i) const noexcept { return pairs_[i].splits_gather; }

 private:
  static constexpr std::size_t k_lanes = detail::k_lanes<S>;

  struct Pair {
    const GatherNode<S>* gather;
    const LightNode<S>* light;
    S bound;
    bool splits_gather;
    const Subsurface* below;
  };
  /// What is computed in packs, of consecutive pairs. Lanes without a pair, or without a lobe, hold anything.
  struct Lanes {
    detail::BoxPack<S> gather;  ///< the point 0 where the light's box is one of directions
    detail::BoxPack<S> light;
    detail::ConePack<S> normals;
    detail::ConePack<S> lobes;
    detail::ConePack<S> light_normals;
    bool has_lobes = false;  ///< in some lane; the same below
    bool has_both_sides = false;
    bool is_two_sided = false;
  };

  struct Sizes {
    detail::Pack<S> gather, light;
    detail::Pack<S> gather_infinite, light_infinite;  ///< where the light is at infinity
  };
  [[nodiscard]] static Sizes sizes(const Lanes& lanes, const detail::BoxDirectionsPack<S>& to_light) noexcept;
  void evaluate(const Lanes& lanes, std::size_t first, const PairLimits<S>& limits);

  std::vector<Pair> pairs_;
  std::vector<Lanes> lanes_;
};

template <std::floating_point S, class Subsurface>
void PairBounds<S, Subsurface>::add(const GatherNode<S>& gather, const LightNode<S>& light) {
  const std::size_t lane = pairs_.size() % k_lanes;
  const std::size_t pack = pairs_.size() / k_lanes;
  pairs_.push_back({&gather, &light, S(0), false, nullptr});
  if (pack == lanes_.size()) lanes_.emplace_back();
  Lanes& lanes = lanes_[pack];
  if (lane == 0) lanes.has_lobes = lanes.has_both_sides = lanes.is_two_sided = false;
  lanes.gather.set(lane, light.is_infinite ? Box<S>{Vec3<S>(0), Vec3<S>(0)} : gather.box);
  lanes.light.set(lane, light.box);
  lanes.normals.set(lane, gather.normals);
  lanes.light_normals.set(lane, light.normals);
  lanes.has_both_sides |= gather.pattern.has_both_sides;
  lanes.is_two_sided |= light.is_two_sided;
  if (gather.pattern.is_flat) return;
  lanes.lobes.set(lane, gather.lobes);
  lanes.has_lobes = true;
}

template <std::floating_point S, class Subsurface>
void PairBounds<S, Subsurface>::evaluate(const PairLimits<S>& limits) {
  for (std::size_t first = 0; first < pairs_.size(); first += k_lanes) evaluate(lanes_[first / k_lanes], first, limits);
}

/// Sizes of both sides as splits_gather compares them.
template <std::floating_point S, class Subsurface>
typename PairBounds<S, Subsurface>::Sizes PairBounds<S, Subsurface>::sizes(const Lanes& lanes,
                                                   const detail::BoxDirectionsPack<S>& to_light) noexcept {
  using detail::Pack;
  const Pack<S> of_normals = detail::spread(lanes.normals);
  const Pack<S> of_light_normals = detail::spread(lanes.light_normals);
  const Pack<S> distance = detail::length<S>(to_light.center());
  const Pack<S> light = detail::diagonal(lanes.light);
  return {detail::diagonal(lanes.gather) + distance * of_normals, light + distance * of_light_normals * S(0.5),
          of_normals * S(2), light};
}

template <std::floating_point S, class Subsurface>
void PairBounds<S, Subsurface>::evaluate(const Lanes& lanes, std::size_t first, const PairLimits<S>& limits) {
  using detail::Pack;
  const detail::BoxPack<S> vectors = difference(lanes.gather, lanes.light);
  const detail::BoxDirectionsPack<S> to_light(vectors);
  const detail::BoxDirectionsPack<S> from_light = -to_light;
  const Pack<S> squared = min_squared_length(vectors);
  const Pack<S> front = max_cosine(lanes.normals, to_light);
  const Pack<S> back = lanes.has_both_sides ? max_cosine(lanes.normals, from_light) : front;
  const Pack<S> to_axis = lanes.has_lobes ? max_cosine(lanes.lobes, to_light) : front;
  const Pack<S> light_front = max_cosine(lanes.light_normals, from_light);
  const Pack<S> light_back = lanes.is_two_sided ? max_cosine(lanes.light_normals, to_light) : light_front;
  const Sizes size = sizes(lanes, to_light);
  const std::size_t count = std::min(k_lanes, pairs_.size() - first);
  for (std::size_t i = 0; i < count; ++i) {
    Pair& pair = pairs_[first + i];
    const GatherNode<S>& gather = *pair.gather;
    const LightNode<S>& light = *pair.light;
    pair.splits_gather = light.is_infinite ? size.gather_infinite[i] > size.light_infinite[i]
                                           : size.gather[i] > size.light[i];
    const S to_normal = gather.pattern.has_both_sides ? std::max(front[i], back[i]) : front[i];
    S m = sup_sensor_pattern(gather, to_normal, gather.pattern.is_flat ? S(1) : to_axis[i]);
    if (!(m > S(0))) continue;
    if (gather.map != nullptr) m = std::min(m, gather.map->sup(to_light.box(i)));
    const S from_normal = light.is_two_sided ? std::max(light_front[i], light_back[i]) : light_front[i];
    const S d = sup_light_pattern_at(light, from_normal, limits.light);
    if (!(m > S(0) && d > S(0))) continue;
    S distance = light.is_infinite ? sqr(limits.scene_radius) : squared[i];
    if constexpr (!std::is_same_v<Subsurface, NoSubsurface>) {
      // T = pi g(d) in place of 1 / d^2.
      if (pair.below != nullptr) distance = S(1) / pair.below->sup_transit(std::sqrt(squared[i]));
    }
    pair.bound = product_bound(gather, light, m, d, distance, limits);
  }
}

}  // namespace manylight
