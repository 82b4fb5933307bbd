// SPDX-License-Identifier: Apache-2.0
#pragma once

// The gather tree of multidimensional lightcuts [Walter 2006, section 4.2]: clusters of one pixel's sensors. A node bounds
// the weighted pattern w M of its sensors over directions, without looking at its members.

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "manylight/bounds/box_pair.hpp"
#include "manylight/bounds/pattern_profile.hpp"
#include "manylight/bounds/sensor_map.hpp"
#include "manylight/core/direction_cone.hpp"
#include "manylight/many_light/representatives.hpp"
#include "manylight/path/eye_subpath.hpp"

namespace manylight {

/// A cluster of sensors. Leaves hold one.
template <std::floating_point S>
struct GatherNode {
  Box<S> box;                ///< of positions, m
  DirectionCone<S> normals;  ///< of the shading normals
  DirectionCone<S> lobes;    ///< of the mirror directions of wo
  Rgb<S> strength{0};        ///< sum of S
  S saturation = S(1);       ///< largest max_channel(S) / luminance(S) of the sensors
  PatternProfile<S> pattern;  ///< of M
  const CubeMap<S>* map = nullptr;  ///< of M, where a CubeMapBounds makes them
  S cap = S(0);              ///< limit of the weighted pattern, sr^-1; infinite if nothing is known
  S remaining = S(0);        ///< largest 1 - W of the sensors, see SensorLimit
  std::uint32_t child = 0;   ///< index of the first child, the second follows
  LeafRange leaves;          ///< the sensors, in leaf order
  bool is_leaf = true;
};

/// Upper bound of the weighted pattern over the cluster for directions with cosines of at most `to_normal` with the normals
/// (or their opposites, if the pattern has both sides) and at most `to_axis` with the lobes.
template <std::floating_point S>
[[nodiscard]] inline S sup_sensor_pattern(const GatherNode<S>& node, S to_normal, S to_axis) noexcept {
  return to_normal > S(0) ? std::min(node.pattern.sup(to_axis, to_normal), node.cap) : S(0);
}

/// The same for the directions `to_light`.
template <std::floating_point S>
[[nodiscard]] inline S sup_sensor_pattern(const GatherNode<S>& node, const BoxDirections<S>& to_light) noexcept {
  S cosine = max_cosine(node.normals, to_light);
  if (node.pattern.has_both_sides) cosine = std::max(cosine, max_cosine(node.normals, -to_light));
  if (!(cosine > S(0))) return S(0);
  const S to_axis = node.pattern.is_flat ? S(1) : max_cosine(node.lobes, to_light);
  const S bound = sup_sensor_pattern(node, cosine, to_axis);
  return node.map == nullptr ? bound : std::min(bound, node.map->sup(to_light.box()));
}

template <class Scene, class W>
class GatherTree {
 public:
  using S = typename Scene::Scalar;

  /// Rebuilds the tree over `sensors` (at least one), which must outlive it. Materials are bounded by `bounds`.
  template <PatternBounds<typename Scene::Material> B = AutomaticBounds>
  void build(const std::vector<Sensor<Scene, W>>& sensors, const W& weighting, const B& bounds = {});

  [[nodiscard]] const GatherNode<S>& node(std::uint32_t i) const noexcept { return nodes_[i]; }
  [[nodiscard]] std::size_t size() const noexcept { return nodes_.size(); }
  /// One tree per channel of the sensors (see Vertex::channel).
  [[nodiscard]] const std::vector<std::uint32_t>& roots() const noexcept { return roots_; }

  /// The sensor at a place of the leaf order.
  [[nodiscard]] const Sensor<Scene, W>& sensor_of_leaf(std::uint32_t leaf) const noexcept {
    return (*sensors_)[items_[leaf].id];
  }
  /// Place of the sensor that `u` in [0, 1) picks to represent node `i`: P = S / S_node, by luminance.
  [[nodiscard]] std::uint32_t representative(std::uint32_t i, double u) const noexcept {
    return representatives_.pick(nodes_[i].leaves, u);
  }
  [[nodiscard]] std::array<std::uint32_t, 2> children(std::uint32_t i) const noexcept {
    return {nodes_[i].child, nodes_[i].child + 1};
  }
  /// The child of inner node `i` that keeps its parent's representative.
  [[nodiscard]] std::uint32_t inheriting_child(std::uint32_t i, std::uint32_t leaf) const noexcept {
    const std::uint32_t child = nodes_[i].child;
    return leaf < nodes_[child].leaves.end ? child : child + 1;
  }

 private:
  template <class B>
  [[nodiscard]] GatherNode<S> leaf(const W& weighting, const B& bounds, std::uint32_t place) const;
  [[nodiscard]] GatherNode<S> combine(std::uint32_t child) const;
  template <MapsPatterns B>
  void add_maps(const W& weighting, const B& bounds);

  template <class B>
  void append_tree(std::vector<ClusterItem<S>>& group, const W& weighting, const B& bounds);

  const std::vector<Sensor<Scene, W>>* sensors_ = nullptr;
  std::vector<ClusterItem<S>> items_;
  std::vector<ClusterItem<S>> group_;  ///< scratch memory
  std::vector<GatherNode<S>> nodes_;
  std::vector<std::uint32_t> roots_;
  std::vector<CubeMap<S>> maps_;  ///< one per node, or unused
  Representatives<S> representatives_;
};

template <class Scene, class W>
template <PatternBounds<typename Scene::Material> B>
void GatherTree<Scene, W>::build(const std::vector<Sensor<Scene, W>>& sensors, const W& weighting, const B& bounds) {
  sensors_ = &sensors;
  items_.clear();
  nodes_.clear();
  roots_.clear();
  representatives_.clear();
  const auto item = [](const Sensor<Scene, W>& sensor, std::uint32_t id) {
    const VertexOf<Scene>& v = sensor.vertex;
    const Vec3<S> axis = v.is_in_medium() ? Vec3<S>(0) : v.pattern_normal();
    return ClusterItem<S>{v.position, axis, luminance(v.strength), id};
  };
  if constexpr (!VertexOf<Scene>::k_has_channels) {
    group_.clear();
    for (std::uint32_t i = 0; i < sensors.size(); ++i) group_.push_back(item(sensors[i], i));
    append_tree(group_, weighting, bounds);
  } else {
    std::map<std::uint64_t, std::vector<ClusterItem<S>>> groups;
    for (std::uint32_t i = 0; i < sensors.size(); ++i) {
      groups[sensors[i].vertex.channel()].push_back(item(sensors[i], i));
    }
    for (auto& [channel, group] : groups) append_tree(group, weighting, bounds);
  }
  if constexpr (MapsPatterns<B>) {
    // Flat patterns are bounded by their cosine well enough.
    const bool all_flat =
        std::all_of(roots_.begin(), roots_.end(), [&](std::uint32_t root) { return nodes_[root].pattern.is_flat; });
    if (bounds.makes_maps() && !all_flat) add_maps(weighting, bounds);
  }
}

/// The nodes of one tree, in the order of its clusters, which puts children behind their parent.
template <class Scene, class W>
template <class B>
void GatherTree<Scene, W>::append_tree(std::vector<ClusterItem<S>>& group, const W& weighting, const B& bounds) {
  const std::vector<ClusterNode> clusters = split_clusters(group, SerialExecutor{});
  const auto first_item = static_cast<std::uint32_t>(items_.size());
  const auto first_node = static_cast<std::uint32_t>(nodes_.size());
  items_.insert(items_.end(), group.begin(), group.end());
  representatives_.append(group);
  roots_.push_back(first_node);
  nodes_.resize(first_node + clusters.size());
  for (std::size_t i = clusters.size(); i-- > 0;) {
    nodes_[first_node + i] = clusters[i].is_leaf ? leaf(weighting, bounds, first_item + clusters[i].first)
                                                 : combine(first_node + clusters[i].first);
  }
}

template <class Scene, class W>
template <class B>
GatherNode<typename Scene::Scalar> GatherTree<Scene, W>::leaf(const W& weighting, const B& bounds,
                                                              std::uint32_t place) const {
  const VertexOf<Scene>& v = sensor_of_leaf(place).vertex;
  const SensorLimit<S> limit = weighting.limit(sensor_of_leaf(place).record);
  GatherNode<S> node;
  node.leaves = {place, place + 1};
  node.box.extend(v.position);
  node.strength = v.strength;
  node.saturation = saturation(v.strength);
  node.cap = limit.cap < k_infinity<S> ? limit.cap * limit.factor : k_infinity<S>;
  node.remaining = limit.remaining;
  if constexpr (VertexOf<Scene>::k_may_be_in_medium) {
    if (v.is_in_medium()) {
      // No cosine: any direction is the normal. The axis is the way straight on.
      node.pattern = phase_profile(bounds, v.phase, v.w);
      node.pattern.scale(limit.factor);
      node.lobes = DirectionCone<S>::of(-v.w);
      return node;
    }
  }
  if constexpr (VertexOf<Scene>::k_may_be_subsurface) {
    if (v.is_outer() || v.is_inner()) {
      node.pattern = PatternProfile<S>::flat(k_inv_pi<S> * limit.factor);
      if (v.is_outer()) node.normals = DirectionCone<S>::of(v.ng);  // from inside, all directions are alike
      node.lobes = node.normals;
      return node;
    }
  }
  node.normals = DirectionCone<S>::of(v.shading.normal());
  const Frame<S> frame = v.shading.frame();
  const Vec3<S> wo = frame.to_local(v.w);
  node.pattern = pattern_profile(bounds, v.material, wo);
  node.pattern.scale(limit.factor / v.alpha);
  // The axis of a flat pattern is never asked; any cone that does not widen the parent's.
  node.lobes = node.pattern.is_flat ? node.normals : DirectionCone<S>::of(glm::normalize(frame.to_world(mirror(wo))));
  return node;
}

template <class Scene, class W>
GatherNode<typename Scene::Scalar> GatherTree<Scene, W>::combine(std::uint32_t child) const {
  const GatherNode<S>& a = nodes_[child];
  const GatherNode<S>& b = nodes_[child + 1];
  GatherNode<S> node = a;
  node.is_leaf = false;
  node.child = child;
  node.leaves.end = b.leaves.end;
  node.box.extend(b.box);
  node.normals = unite(a.normals, b.normals);
  node.strength += b.strength;
  node.saturation = std::max(a.saturation, b.saturation);
  if (!a.pattern.is_flat && !b.pattern.is_flat) {
    node.lobes = unite(a.lobes, b.lobes);
  } else if (!b.pattern.is_flat) {
    node.lobes = b.lobes;
  }
  node.pattern.extend(b.pattern);
  node.cap = std::max(a.cap, b.cap);
  node.remaining = std::max(a.remaining, b.remaining);
  return node;
}

template <class Scene, class W>
template <MapsPatterns B>
void GatherTree<Scene, W>::add_maps(const W& weighting, const B& bounds) {
  if (maps_.size() < nodes_.size()) maps_.resize(nodes_.size());
  for (std::size_t i = nodes_.size(); i-- > 0;) {  // children come after their parent
    GatherNode<S>& node = nodes_[i];
    if (node.is_leaf) {
      const Sensor<Scene, W>& sensor = sensor_of_leaf(node.leaves.begin);
      const VertexOf<Scene>& v = sensor.vertex;
      if constexpr (VertexOf<Scene>::k_may_be_in_medium || VertexOf<Scene>::k_may_be_subsurface) {
        if (v.kind != VertexKind::surface) continue;  // its profile will do
      }
      const S factor = weighting.limit(sensor.record).factor / v.alpha;
      build_sensor_map(bounds, v.material, v.shading.frame(), v.w, factor, maps_[i]);
    } else {
      if (nodes_[node.child].map == nullptr || nodes_[node.child + 1].map == nullptr) continue;
      maps_[i].merge(maps_[node.child], maps_[node.child + 1], bounds.limits.nodes);
    }
    node.map = &maps_[i];
  }
}

}  // namespace manylight
