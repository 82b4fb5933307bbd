// SPDX-License-Identifier: Apache-2.0
#pragma once

// The light tree of [Walter 2005, section 3.1], built top-down: binary clusters of VPLs with the bounds and the sums
// that refinement needs. Finite lights, lights at infinity (boxes of unit directions) and exact lights (no clamp in
// their bound) have a tree each; all roots start in the same cut. Leaves are not stored: what a cut needs of one is
// made from its VPL when it is asked for. Bytes per VPL: its vertex, one node, a bound of its pattern, and 8 for drawing
// representatives.

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "manylight/bounds/pattern_profile.hpp"
#include "manylight/core/direction_cone.hpp"
#include "manylight/core/error.hpp"
#include "manylight/core/huge_pages.hpp"
#include "manylight/core/prefetch.hpp"
#include "manylight/many_light/representatives.hpp"
#include "manylight/many_light/vpl_set.hpp"

namespace manylight {

/// A cluster of VPLs. A leaf is one VPL.
template <std::floating_point S>
struct LightNode {
  Box<S> box;                ///< of positions, m; of unit directions towards the light if `is_infinite`
  DirectionCone<S> normals;  ///< of the geometric normals
  Rgb<S> intensity{0};       ///< sum of I, W
  S saturation = S(1);       ///< largest max_channel(I) / luminance(I) of the VPLs
  S peak = S(0);             ///< D <= min(limit, peak max(0, cos)), cos to the nearest normal, sr^-1; may be infinite
  S cos_cutoff = S(-1);      ///< above -1: spot lights, D <= peak where cos >= cos_cutoff, else 0
  std::array<std::uint32_t, 2> children{};  ///< ids of the children of an inner node
  LeafRange leaves;          ///< the VPLs, in leaf order
  bool is_leaf = true;
  bool is_infinite = false;
  bool is_exact = false;      ///< some VPL is exact: the bound of a pair has no clamp
  bool is_two_sided = false;  ///< light leaves on both sides of the normals somewhere in the cluster
};

/// Bound of D of one VPL; materials are bounded by `bounds`.
template <AnyVertex V, class B, std::floating_point S = typename V::Scalar>
[[nodiscard]] inline LightPeak<S> vpl_pattern(const V& v, const B& bounds) noexcept {
  switch (v.kind) {
    case VertexKind::medium:
      if constexpr (V::k_may_be_in_medium) return {bounds.sup_phase(v.phase, DirectionSet<S>(), v.w), false};
      break;
    case VertexKind::surface: {
      const LightPeak<S> f = light_peak(bounds, v.material, v.shading.frame().to_local(v.w));
      return {f.peak / v.alpha, f.has_both_sides};
    }
    case VertexKind::subsurface_outer:
    case VertexKind::subsurface_inner:
    case VertexKind::area_emitter:
      return {k_inv_pi<S>, false};
    case VertexKind::two_sided_area_emitter:
      return {k_inv_pi<S>, true};
    case VertexKind::point_emitter:
    case VertexKind::spot_emitter:
      return {S(0.25) * k_inv_pi<S>, false};
    case VertexKind::infinite_emitter:
      return {k_inv_pi<S>, false};
  }
  return {};
}

/// Upper bound of min(D, limit) over the cluster for directions with cosines of at most `cosine` with the normals, or their
/// opposites in a two-sided cluster.
template <std::floating_point S>
[[nodiscard]] inline S sup_light_pattern_at(const LightNode<S>& node, S cosine, S limit) noexcept {
  if (node.cos_cutoff > S(-1)) return cosine < node.cos_cutoff ? S(0) : std::min(limit, node.peak);
  return cosine > S(0) ? std::min(limit, node.peak * cosine) : S(0);
}

/// The same for the directions `from_light` (away from the VPLs), a DirectionCone or BoxDirections.
template <std::floating_point S, class Directions>
[[nodiscard]] inline S sup_light_pattern(const LightNode<S>& node, const Directions& from_light, S limit) noexcept {
  S cosine = max_cosine(node.normals, from_light);
  if (node.is_two_sided) cosine = std::max(cosine, max_cosine(node.normals, -from_light));
  return sup_light_pattern_at(node, cosine, limit);
}

/// Whether D depends on an angle to `v.ng`.
template <AnyVertex V>
[[nodiscard]] inline bool has_normal(const V& v) noexcept {
  return v.kind != VertexKind::point_emitter && !v.is_infinite() && !v.is_in_medium() && !v.is_inner();
}

template <class Scene>
class LightTree {
 public:
  using S = typename Scene::Scalar;

  /// Builds the trees over `vpls` and keeps them in leaf order: lights of a cluster are neighbours in memory. O(N log N),
  /// iterative; the result depends on the order of the VPLs only. Materials are bounded by `bounds`.
  template <Executor Exec, PatternBounds<typename Scene::Material> B = AutomaticBounds>
  LightTree(std::vector<VertexOf<Scene>> vpls, const Exec& executor, const B& bounds = {});

  [[nodiscard]] const std::vector<std::uint32_t>& roots() const noexcept { return roots_; }
  /// A leaf that was looked at last.
  struct Leaf {
    std::uint32_t id = 0;
    LightNode<S> node;
  };
  [[nodiscard]] static constexpr bool is_leaf(std::uint32_t id) noexcept { return (id & k_leaf) != 0; }
  /// The cluster of that id, a root's or a child's. A leaf is made in `leaf`, unless it is there from the last time.
  [[nodiscard]] const LightNode<S>& node(std::uint32_t id, Leaf& leaf) const noexcept {
    if (!is_leaf(id)) return nodes_[id];
    if (leaf.id != id) leaf = {id, leaf_node(id & ~k_leaf)};
    return leaf.node;
  }
  [[nodiscard]] LightNode<S> node(std::uint32_t id) const noexcept {
    return is_leaf(id) ? leaf_node(id & ~k_leaf) : nodes_[id];
  }
  /// Channel of the VPLs of a root (see Vertex::channel).
  [[nodiscard]] std::uint64_t channel(std::uint32_t root) const noexcept {
    return vpls_[is_leaf(root) ? root & ~k_leaf : nodes_[root].leaves.begin].channel();
  }
  /// All VPLs, in leaf order.
  [[nodiscard]] std::span<const VertexOf<Scene>> vpls() const noexcept { return vpls_; }
  [[nodiscard]] std::size_t bytes() const noexcept {
    return nodes_.size() * sizeof(LightNode<S>) + vpls_.size() * (sizeof(VertexOf<Scene>) + sizeof(S)) +
           representatives_.bytes();
  }

  void prefetch_node(std::uint32_t id) const noexcept {
    if (is_leaf(id)) {
      prefetch_vpl(id & ~k_leaf);
      prefetch(&peaks_[id & ~k_leaf], sizeof(S));
    } else {
      prefetch(&nodes_[id], sizeof(LightNode<S>));
    }
  }
  void prefetch_vpl(std::uint32_t leaf) const noexcept { prefetch(&vpls_[leaf], sizeof(VertexOf<Scene>)); }
  /// Place of the VPL that `u` in [0, 1) picks to represent node `id`: P = I / I_node, by luminance.
  [[nodiscard]] std::uint32_t representative(std::uint32_t id, double u) const noexcept {
    return is_leaf(id) ? id & ~k_leaf : representatives_.pick(nodes_[id].leaves, u);
  }
  void prefetch_representative(std::uint32_t id, double u) const noexcept {
    if (!is_leaf(id)) representatives_.prefetch_pick(nodes_[id].leaves, u);
  }
  /// The child of inner node `id` that keeps its parent's representative.
  [[nodiscard]] std::uint32_t inheriting_child(std::uint32_t id, std::uint32_t leaf) const noexcept {
    return inheriting_child(nodes_[id].children, leaf);
  }
  [[nodiscard]] std::uint32_t inheriting_child(const std::array<std::uint32_t, 2>& children,
                                               std::uint32_t leaf) const noexcept {
    const auto [first, second] = children;
    return leaf < (is_leaf(first) ? (first & ~k_leaf) + 1 : nodes_[first].leaves.end) ? first : second;
  }

 private:
  /// Ids of leaves: this bit and the place in the leaf order. Of inner nodes: their place in `nodes_`.
  static constexpr std::uint32_t k_leaf = 0x8000'0000U;

  template <class B>
  void append_tree(std::vector<ClusterItem<S>>& group, const std::vector<ClusterNode>& clusters,
                   const std::vector<VertexOf<Scene>>& vpls, const B& bounds);
  [[nodiscard]] LightNode<S> leaf_node(std::uint32_t leaf) const noexcept;
  void combine(LightNode<S>& parent) const noexcept;

  LargeVector<VertexOf<Scene>> vpls_;
  LargeVector<S> peaks_;  ///< of D of each VPL, negative if it leaves on both sides of the normal
  LargeVector<LightNode<S>> nodes_;
  std::vector<std::uint32_t> roots_;
  Representatives<S> representatives_;
};

template <class Scene>
template <Executor Exec, PatternBounds<typename Scene::Material> B>
LightTree<Scene>::LightTree(std::vector<VertexOf<Scene>> vpls, const Exec& executor, const B& bounds) {
  require(vpls.size() < k_leaf, "number of virtual point lights", vpls.size(), "below 2^31");
  vpls_.reserve(vpls.size());
  peaks_.reserve(vpls.size());
  std::vector<ClusterItem<S>> groups[3];
  std::map<std::uint64_t, std::array<std::vector<ClusterItem<S>>, 3>> channels;
  for (std::size_t i = 0; i < vpls.size(); ++i) {
    const VertexOf<Scene>& v = vpls[i];
    const ClusterItem<S> item{v.position, has_normal(v) ? v.ng : Vec3<S>(0), luminance(v.strength),
                              static_cast<std::uint32_t>(i)};
    const std::size_t group = v.is_infinite() ? 1 : v.exact ? 2 : 0;
    if constexpr (VertexOf<Scene>::k_has_channels) {
      channels[v.channel()][group].push_back(item);
    } else {
      groups[group].push_back(item);
    }
  }
  for (std::vector<ClusterItem<S>>& group : groups) {
    if (!group.empty()) append_tree(group, split_clusters(group, executor), vpls, bounds);
  }
  for (auto& [channel, groups_of] : channels) {
    for (std::vector<ClusterItem<S>>& group : groups_of) {
      if (!group.empty()) append_tree(group, split_clusters(group, executor), vpls, bounds);
    }
  }
}

/// The nodes of one tree, in the order of `clusters`, which puts children behind their parent, without the leaves.
template <class Scene>
template <class B>
void LightTree<Scene>::append_tree(std::vector<ClusterItem<S>>& group, const std::vector<ClusterNode>& clusters,
                                   const std::vector<VertexOf<Scene>>& vpls, const B& bounds) {
  const auto first_leaf = static_cast<std::uint32_t>(vpls_.size());
  representatives_.append(group);
  for (const ClusterItem<S>& item : group) {
    const VertexOf<Scene>& v = vpls[item.id];
    const LightPeak<S> pattern = vpl_pattern(v, bounds);
    vpls_.push_back(v);
    peaks_.push_back(pattern.has_both_sides ? -pattern.peak : pattern.peak);
  }
  std::vector<std::uint32_t> ids(clusters.size());
  auto next = static_cast<std::uint32_t>(nodes_.size());
  for (std::size_t i = 0; i < clusters.size(); ++i) {
    ids[i] = clusters[i].is_leaf ? k_leaf | (first_leaf + clusters[i].first) : next++;
  }
  nodes_.resize(next);
  for (std::size_t i = clusters.size(); i-- > 0;) {
    if (clusters[i].is_leaf) continue;
    LightNode<S>& node = nodes_[ids[i]];
    node.is_leaf = false;
    node.children = {ids[clusters[i].first], ids[clusters[i].first + 1]};
    combine(node);
  }
  roots_.push_back(ids[0]);
}

template <class Scene>
LightNode<typename Scene::Scalar> LightTree<Scene>::leaf_node(std::uint32_t leaf) const noexcept {
  const VertexOf<Scene>& v = vpls_[leaf];
  LightNode<S> node;
  node.leaves = {leaf, leaf + 1};
  node.box.extend(v.position);
  node.intensity = v.strength;
  node.saturation = saturation(v.strength);
  node.is_infinite = v.is_infinite();
  node.is_exact = v.exact;
  node.peak = std::abs(peaks_[leaf]);
  node.is_two_sided = peaks_[leaf] < S(0);
  // An emitter without a normal keeps the full cone: its D does not depend on the direction.
  if (has_normal(v)) node.normals = DirectionCone<S>::of(v.ng);
  if (v.kind == VertexKind::spot_emitter) node.cos_cutoff = std::cos(v.w.y) - S(8) * std::numeric_limits<S>::epsilon();
  return node;
}

template <class Scene>
void LightTree<Scene>::combine(LightNode<S>& parent) const noexcept {
  Leaf leaves[2];
  const LightNode<S>& a = node(parent.children[0], leaves[0]);
  const LightNode<S>& b = node(parent.children[1], leaves[1]);
  parent.leaves = {a.leaves.begin, b.leaves.end};
  parent.box = a.box;
  parent.box.extend(b.box);
  parent.normals = unite(a.normals, b.normals);
  parent.intensity = a.intensity + b.intensity;
  parent.saturation = std::max(a.saturation, b.saturation);
  parent.peak = std::max(a.peak, b.peak);
  parent.cos_cutoff = std::min(a.cos_cutoff, b.cos_cutoff);
  // Spot lights and others in one cluster have no bound by angles: the full cone makes the cosine 1.
  if ((a.cos_cutoff > S(-1)) != (b.cos_cutoff > S(-1))) parent.normals = {};
  parent.is_infinite = a.is_infinite;
  parent.is_exact = a.is_exact || b.is_exact;
  parent.is_two_sided = a.is_two_sided || b.is_two_sided;
}

}  // namespace manylight
