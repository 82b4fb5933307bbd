// SPDX-License-Identifier: Apache-2.0
#pragma once

// The clusters that a batch of splits makes. What a cut needs to know of a cluster, down to how it will be split, is settled
// while its nodes are at hand: a split goes straight to the children.

#include <array>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "manylight/many_light/gather_tree.hpp"
#include "manylight/many_light/light_tree.hpp"
#include "manylight/many_light/pair_bound.hpp"
#include "manylight/many_light/pair_bound_pack.hpp"

namespace manylight {

/// A pair (C, L) of clusters.
template <std::floating_point S>
struct ClusterPair {
  std::uint32_t gather = 0;                ///< C, in the gather tree
  std::uint32_t light = 0;                 ///< L, in the light trees
  S scale = S(0);                          ///< luminance(S_C) luminance(I_L)
  bool splits_gather = false;              ///< the side that a split divides
  std::array<std::uint32_t, 2> children{};  ///< of that side, unless both are leaves
};

/// A pair on its way into the cut.
template <std::floating_point S>
struct CutPart {
  static constexpr std::uint32_t k_new = ~std::uint32_t{0};
  std::uint32_t cluster = k_new;  ///< the slot of the parent whose representatives it keeps, or k_new
  ClusterPair<S> pair;
  S bound = S(0);  ///< UB
  S error = S(0);  ///< see pair_error
};

/// A cluster that may be split. Heap order: worst error first, ties by age, never by address.
template <std::floating_point S>
struct CutCandidate {
  S error;
  std::uint32_t cluster;
  friend bool operator<(const CutCandidate& a, const CutCandidate& b) noexcept {
    return a.error != b.error ? a.error < b.error : a.cluster > b.cluster;
  }
};

/// Parts of the cut through the product of a gather tree, which may be rebuilt while there are none, and light trees.
template <class Scene, class W>
class CutParts {
 public:
  using S = typename Scene::Scalar;

  CutParts(const GatherTree<Scene, W>& gather, const LightTree<Scene>& lights) : gather_(gather), lights_(lights) {}

  /// Asks for the memory that adding the parts of `pair` will read.
  void prefetch(const ClusterPair<S>& pair) const noexcept {
    if (pair.splits_gather) {
      lights_.prefetch_node(pair.light);
    } else {
      for (const std::uint32_t child : pair.children) lights_.prefetch_node(child);
    }
  }
  void clear() noexcept {
    parts_.clear();
    bounds_.clear();
  }
  /// Channel of a gather node's sensors.
  [[nodiscard]] std::uint64_t channel(std::uint32_t gather) const noexcept {
    return gather_.sensor_of_leaf(gather_.node(gather).leaves.begin).vertex.channel();
  }
  void add(std::uint32_t cluster, std::uint32_t gather, std::uint32_t light) {
    if (leaves_.size() == parts_.size()) leaves_.emplace_back();
    bounds_.add(gather_.node(gather), lights_.node(light, leaves_[parts_.size()]));
    if constexpr (Scene::k_has_subsurface) bounds_.set_object(subsurface(gather));
    parts_.push_back({cluster, {gather, light, S(0), false, {}}, S(0), S(0)});
  }
  /// All parts in the order they were added.
  [[nodiscard]] std::span<const CutPart<S>> evaluate(const PairLimits<S>& limits) {
    bounds_.evaluate(limits);
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      const GatherNode<S>& g = bounds_.gather(i);
      const LightNode<S>& l = bounds_.light(i);
      ClusterPair<S>& pair = parts_[i].pair;
      pair.scale = luminance(g.strength) * luminance(l.intensity);
      pair.splits_gather = !g.is_leaf && (l.is_leaf || bounds_.splits_gather(i));
      pair.children = pair.splits_gather ? gather_.children(pair.gather) : l.children;
      parts_[i].bound = bounds_.bound(i);
      parts_[i].error = pair_error(g, l, pair.scale, parts_[i].bound);
    }
    return parts_;
  }

 private:
  /// What the sensors of inner vertices of a gather node look through, else null.
  [[nodiscard]] const typename Scene::Subsurface* subsurface(std::uint32_t gather) const noexcept {
    const VertexOf<Scene>& v = gather_.sensor_of_leaf(gather_.node(gather).leaves.begin).vertex;
    return v.is_inner() ? v.below : nullptr;
  }

  const GatherTree<Scene, W>& gather_;
  const LightTree<Scene>& lights_;
  std::vector<CutPart<S>> parts_;
  PairBounds<S, typename Scene::Subsurface> bounds_;
  std::deque<typename LightTree<Scene>::Leaf> leaves_;  ///< light nodes of parts, which stay in place
};

}  // namespace manylight
