// SPDX-License-Identifier: Apache-2.0
#pragma once

// The light tree of [Walter 2005, section 3.1], built top-down: binary clusters of VPLs with the bounds and the sums
// that refinement needs. Finite lights, lights at infinity (boxes of unit directions) and exact lights (no clamp in
// their bound) have a tree each; all roots start in the same cut. Bytes per VPL: its
// vertex, two nodes, and 8 for drawing representatives.

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "manylight/bounds/pattern_bound.hpp"
#include "manylight/core/direction_cone.hpp"
#include "manylight/core/huge_pages.hpp"
#include "manylight/core/prefetch.hpp"
#include "manylight/many_light/representatives.hpp"
#include "manylight/many_light/vpl_set.hpp"

namespace manylight {

/// A cluster of VPLs. Leaves hold one VPL.
template <std::floating_point S>
struct LightNode {
  Box<S> box;                ///< of positions, m; of unit directions towards the light if `is_infinite`
  DirectionCone<S> normals;  ///< of the geometric normals
  Rgb<S> intensity{0};       ///< sum of I, W
  S saturation = S(1);       ///< largest max_channel(I) / luminance(I) of the VPLs
  S diffuse = S(0);          ///< D <= min(limit, diffuse max(0, cos) / pi + gloss), cos to the nearest normal
  S gloss = S(0);            ///< sr^-1
  S cos_cutoff = S(-1);      ///< no light leaves at an angle to the normals whose cosine is below; -1: not known
  std::uint32_t child = 0;   ///< index of the first child, the second follows
  LeafRange leaves;          ///< the VPLs, in leaf order
  bool is_leaf = true;
  bool is_infinite = false;
  bool is_exact = false;      ///< some VPL is exact: the bound of a pair has no clamp
  bool is_two_sided = false;  ///< light leaves on both sides of the normals somewhere in the cluster
};

/// Bound of D of one VPL, for a leaf.
template <std::floating_point S, Material M>
void set_leaf_pattern(LightNode<S>& node, const Vertex<S, M>& v) noexcept {
  switch (v.kind) {
    case VertexKind::surface: {
      node.normals = DirectionCone<S>::of(v.ng);
      const Vec3<S> wi = v.shading.frame().to_local(v.w);
      const PatternBound<S> bound = pattern_bound(v.material, wi);
      node.diffuse = bound.diffuse / v.alpha;
      // The profile knows |wi.ns| f; where |wo.ng| replaces it the ratio is unknown, so gloss counts as unbounded: the
      // weighting's limit of D takes over.
      node.gloss = bound.has_gloss ? k_infinity<S> : S(0);
      node.is_two_sided = bound.has_both_sides;
      break;
    }
    case VertexKind::area_emitter:
    case VertexKind::two_sided_area_emitter:
      node.normals = DirectionCone<S>::of(v.ng);
      node.diffuse = S(1);
      node.is_two_sided = v.kind == VertexKind::two_sided_area_emitter;
      break;
    case VertexKind::point_emitter:
      node.gloss = S(0.25) * k_inv_pi<S>;
      break;
    case VertexKind::spot_emitter:
      node.normals = DirectionCone<S>::of(v.ng);
      node.gloss = S(0.25) * k_inv_pi<S>;
      node.cos_cutoff = std::cos(v.w.y) - S(8) * std::numeric_limits<S>::epsilon();
      break;
    case VertexKind::infinite_emitter:
      node.gloss = k_inv_pi<S>;
      break;
  }
}

/// Upper bound of min(D, limit) over the cluster for the directions `from_light` (away from the VPLs), a DirectionCone or
/// BoxDirections.
template <std::floating_point S, class Directions>
[[nodiscard]] inline S sup_light_pattern(const LightNode<S>& node, const Directions& from_light, S limit) noexcept {
  S cosine = S(1);
  if (node.cos_cutoff > S(-1) && max_cosine(node.normals, from_light) < node.cos_cutoff) return S(0);
  if (node.diffuse > S(0) || node.gloss == k_infinity<S>) {
    cosine = max_cosine(node.normals, from_light);
    if (node.is_two_sided) cosine = std::max(cosine, max_cosine(node.normals, -from_light));
    if (cosine <= S(0) && !(node.gloss < k_infinity<S> && node.gloss > S(0))) return S(0);
  }
  return std::min(limit, node.diffuse * std::max(S(0), cosine) * k_inv_pi<S> + node.gloss);
}

template <class Scene>
class LightTree {
 public:
  using S = typename Scene::Scalar;

  /// Builds the trees over `vpls` and keeps them in leaf order: lights of a cluster are neighbours in memory. O(N log N),
  /// iterative; the result depends on the order of the VPLs only.
  template <Executor Exec>
  LightTree(std::vector<VertexOf<Scene>> vpls, const Exec& executor);

  [[nodiscard]] const std::vector<std::uint32_t>& roots() const noexcept { return roots_; }
  [[nodiscard]] const LightNode<S>& node(std::uint32_t i) const noexcept { return nodes_[i]; }
  /// All VPLs, in leaf order.
  [[nodiscard]] std::span<const VertexOf<Scene>> vpls() const noexcept { return vpls_; }
  [[nodiscard]] std::size_t bytes() const noexcept {
    return nodes_.size() * sizeof(LightNode<S>) + vpls_.size() * sizeof(VertexOf<Scene>) + representatives_.bytes();
  }

  void prefetch_children(std::uint32_t i) const noexcept {
    if (!nodes_[i].is_leaf) prefetch(&nodes_[nodes_[i].child], 2 * sizeof(LightNode<S>));
  }
  void prefetch_vpl(std::uint32_t leaf) const noexcept { prefetch(&vpls_[leaf], sizeof(VertexOf<Scene>)); }
  /// Place of the VPL that `u` in [0, 1) picks to represent node `i`: P = I / I_node, by luminance.
  [[nodiscard]] std::uint32_t representative(std::uint32_t i, double u) const noexcept {
    return representatives_.pick(nodes_[i].leaves, u);
  }
  void prefetch_representative(std::uint32_t i, double u) const noexcept {
    representatives_.prefetch_pick(nodes_[i].leaves, u);
  }
  /// The child of inner node `i` that keeps its parent's representative.
  [[nodiscard]] std::uint32_t inheriting_child(std::uint32_t i, std::uint32_t leaf) const noexcept {
    const std::uint32_t child = nodes_[i].child;
    return leaf < nodes_[child].leaves.end ? child : child + 1;
  }

 private:
  void set_leaf(LightNode<S>& node, std::uint32_t leaf) const noexcept;
  void combine(LightNode<S>& parent) const noexcept;

  LargeVector<VertexOf<Scene>> vpls_;
  LargeVector<LightNode<S>> nodes_;
  std::vector<std::uint32_t> roots_;
  Representatives<S> representatives_;
};

template <class Scene>
template <Executor Exec>
LightTree<Scene>::LightTree(std::vector<VertexOf<Scene>> vpls, const Exec& executor) {
  vpls_.reserve(vpls.size());
  std::vector<ClusterItem<S>> groups[3];
  for (std::size_t i = 0; i < vpls.size(); ++i) {
    const VertexOf<Scene>& v = vpls[i];
    const Vec3<S> axis = v.is_infinite() || v.kind == VertexKind::point_emitter ? Vec3<S>(0) : v.ng;
    const int group = v.exact ? (v.is_infinite() ? 1 : 2) : (v.is_infinite() ? 1 : 0);
    groups[group].push_back({v.position, axis, luminance(v.strength), static_cast<std::uint32_t>(i)});
  }
  for (std::vector<ClusterItem<S>>& group : groups) {
    if (group.empty()) continue;
    const std::vector<ClusterNode> clusters = split_clusters(group, executor);
    const auto offset = static_cast<std::uint32_t>(nodes_.size());
    const auto first_leaf = static_cast<std::uint32_t>(vpls_.size());
    representatives_.append(group);
    for (const ClusterItem<S>& item : group) vpls_.push_back(vpls[item.id]);
    roots_.push_back(offset);
    nodes_.resize(nodes_.size() + clusters.size());
    for (std::size_t i = clusters.size(); i-- > 0;) {  // children come after their parent
      LightNode<S>& node = nodes_[offset + i];
      if (clusters[i].is_leaf) {
        set_leaf(node, first_leaf + clusters[i].first);
      } else {
        node.is_leaf = false;
        node.child = offset + clusters[i].first;
        combine(node);
      }
    }
  }
}

template <class Scene>
void LightTree<Scene>::set_leaf(LightNode<S>& node, std::uint32_t leaf) const noexcept {
  const VertexOf<Scene>& v = vpls_[leaf];
  node.leaves = {leaf, leaf + 1};
  node.box.extend(v.position);
  node.intensity = v.strength;
  node.saturation = saturation(v.strength);
  node.is_infinite = v.is_infinite();
  node.is_exact = v.exact;
  set_leaf_pattern(node, v);
}

template <class Scene>
void LightTree<Scene>::combine(LightNode<S>& parent) const noexcept {
  const LightNode<S>& a = nodes_[parent.child];
  const LightNode<S>& b = nodes_[parent.child + 1];
  parent.leaves = {a.leaves.begin, b.leaves.end};
  parent.box = a.box;
  parent.box.extend(b.box);
  parent.normals = unite(a.normals, b.normals);
  parent.intensity = a.intensity + b.intensity;
  parent.saturation = std::max(a.saturation, b.saturation);
  parent.diffuse = std::max(a.diffuse, b.diffuse);
  parent.gloss = std::max(a.gloss, b.gloss);
  parent.cos_cutoff = std::min(a.cos_cutoff, b.cos_cutoff);
  parent.is_infinite = a.is_infinite;
  parent.is_exact = a.is_exact || b.is_exact;
  parent.is_two_sided = a.is_two_sided || b.is_two_sided;
}

}  // namespace manylight
