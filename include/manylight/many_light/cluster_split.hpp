// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "manylight/core/box.hpp"
#include "manylight/core/executor.hpp"

namespace manylight {

/// A point to be clustered: position, dominant direction (or 0), weight.
template <std::floating_point S>
struct ClusterItem {
  Vec3<S> position;
  Vec3<S> axis;
  S weight;
  std::uint32_t id;
};

/// A node of a binary tree over reordered items: a leaf holds the item at `first`, an inner node has its children at
/// `first` and `first + 1`. Children always come after their parent.
struct ClusterNode {
  std::uint32_t first;
  bool is_leaf;
};

namespace detail {

/// Splits ranges of items in a 6-D space: position / diagonal of all items, direction / 8 [Walter 2005, section 3.1, with
/// the metric of the theory sheet, section 5.1].
template <std::floating_point S>
class ClusterSplitter {
 public:
  explicit ClusterSplitter(std::vector<ClusterItem<S>>& items) : items_(items) {
    Box<S> box;
    for (const ClusterItem<S>& item : items) box.extend(item.position);
    const S diagonal = box.diagonal();
    position_scale_ = diagonal > S(0) ? S(1) / diagonal : S(0);
  }

  /// Index at which [begin, end), at least two items, is cut; both sides are non-empty.
  std::size_t split(std::size_t begin, std::size_t end, unsigned depth) {
    std::array<S, 6> lo;
    std::array<S, 6> hi;
    lo.fill(k_infinity<S>);
    hi.fill(-k_infinity<S>);
    for (std::size_t i = begin; i < end; ++i) {
      for (unsigned axis = 0; axis < 6; ++axis) {
        const S x = coordinate(items_[i], axis);
        lo[axis] = std::min(lo[axis], x);
        hi[axis] = std::max(hi[axis], x);
      }
    }
    unsigned widest = 0;
    for (unsigned axis = 1; axis < 6; ++axis) {
      if (hi[axis] - lo[axis] > hi[widest] - lo[widest]) widest = axis;
    }
    const std::size_t middle = begin + (end - begin) / 2;
    if (!(hi[widest] > lo[widest])) return middle;  // all alike: by order
    const bool too_narrow = hi[widest] - lo[widest] < S(1e-30);  // the bins' scale would overflow
    if (end - begin <= 4 || depth >= k_median_depth || too_narrow) return median(begin, middle, end, widest);
    return binned(begin, end, widest, lo[widest], hi[widest]);
  }

 private:
  static constexpr unsigned k_median_depth = 32;  ///< from here on halves, so that the depth stays below 64
  static constexpr unsigned k_bins = 16;

  [[nodiscard]] S coordinate(const ClusterItem<S>& item, unsigned axis) const noexcept {
    return axis < 3 ? item.position[static_cast<int>(axis)] * position_scale_
                    : item.axis[static_cast<int>(axis - 3)] * S(0.125);
  }

  std::size_t median(std::size_t begin, std::size_t middle, std::size_t end, unsigned axis) {
    const auto at = [&](std::size_t i) { return items_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(begin), at(middle), at(end), [&](const ClusterItem<S>& a, const ClusterItem<S>& b) {
      for (unsigned k = 0; k < 6; ++k) {  // order decides only between equal items
        const S xa = coordinate(a, (axis + k) % 6);
        const S xb = coordinate(b, (axis + k) % 6);
        if (xa != xb) return xa < xb;
      }
      return a.id < b.id;
    });
    return middle;
  }

  struct Bin {
    std::array<S, 6> lo;
    std::array<S, 6> hi;
    S weight;
    std::size_t count;
    Bin() : weight(S(0)), count(0) {
      lo.fill(k_infinity<S>);
      hi.fill(-k_infinity<S>);
    }
    void extend(const Bin& other) {
      for (unsigned i = 0; i < 6; ++i) {
        lo[i] = std::min(lo[i], other.lo[i]);
        hi[i] = std::max(hi[i], other.hi[i]);
      }
      weight += other.weight;
      count += other.count;
    }
    /// Weight times squared diagonal: the error that a representative makes.
    [[nodiscard]] S cost() const {
      S squared = S(0);
      for (unsigned i = 0; i < 6 && count > 0; ++i) squared += sqr(hi[i] - lo[i]);
      return weight * squared;
    }
  };

  std::size_t binned(std::size_t begin, std::size_t end, unsigned axis, S lo, S hi) {
    std::array<Bin, k_bins> bins;
    const S scale = S(k_bins) / (hi - lo);
    const auto bin_of = [&](const ClusterItem<S>& item) {
      const S x = (coordinate(item, axis) - lo) * scale;  // fused multiply-add may take it below 0
      return x > S(0) ? std::min(k_bins - 1, static_cast<unsigned>(std::min(x, S(k_bins)))) : 0U;
    };
    for (std::size_t i = begin; i < end; ++i) {
      Bin single;
      for (unsigned a = 0; a < 6; ++a) single.lo[a] = single.hi[a] = coordinate(items_[i], a);
      single.weight = items_[i].weight;
      single.count = 1;
      bins[bin_of(items_[i])].extend(single);
    }
    const unsigned best = best_plane(bins);
    const auto first = items_.begin() + static_cast<std::ptrdiff_t>(begin);
    const auto last = items_.begin() + static_cast<std::ptrdiff_t>(end);
    const auto cut = std::stable_partition(first, last, [&](const auto& item) { return bin_of(item) < best; });
    // In ranges as narrow as rounding all items may share a side; an empty one would never end.
    if (cut == first || cut == last) return median(begin, begin + (end - begin) / 2, end, axis);
    return static_cast<std::size_t>(cut - items_.begin());
  }

  /// First bin of the right side at the cheapest plane. The outermost bins are never empty, so both sides have items.
  [[nodiscard]] static unsigned best_plane(const std::array<Bin, k_bins>& bins) {
    std::array<S, k_bins> right_cost{};
    Bin right;
    for (unsigned b = k_bins - 1; b > 0; --b) {
      right.extend(bins[b]);
      right_cost[b] = right.cost();
    }
    Bin left;
    unsigned best = 1;
    S best_cost = k_infinity<S>;
    for (unsigned b = 1; b < k_bins; ++b) {
      left.extend(bins[b - 1]);
      const S cost = left.cost() + right_cost[b];
      if (cost < best_cost) {
        best_cost = cost;
        best = b;
      }
    }
    return best;
  }

  std::vector<ClusterItem<S>>& items_;
  S position_scale_ = S(1);
};

struct ClusterRange {
  std::size_t begin;
  std::size_t end;
  std::uint32_t node;
  unsigned depth;
};

/// Splits `range` and all below it into `nodes`, whose element `range.node` exists already.
template <std::floating_point S>
void split_all(ClusterSplitter<S>& splitter, ClusterRange range, std::vector<ClusterNode>& nodes) {
  std::vector<ClusterRange> stack{range};
  while (!stack.empty()) {
    const ClusterRange r = stack.back();
    stack.pop_back();
    if (r.end - r.begin == 1) {
      nodes[r.node] = {static_cast<std::uint32_t>(r.begin), true};
      continue;
    }
    const std::size_t cut = splitter.split(r.begin, r.end, r.depth);
    const auto child = static_cast<std::uint32_t>(nodes.size());
    nodes[r.node] = {child, false};
    nodes.resize(nodes.size() + 2);
    stack.push_back({cut, r.end, child + 1, r.depth + 1});
    stack.push_back({r.begin, cut, child, r.depth + 1});
  }
}

}  // namespace detail

/// Clusters `items` (at least one), reordering them; element 0 is the root. The tree does not depend on the executor.
template <std::floating_point S, Executor Exec>
[[nodiscard]] std::vector<ClusterNode> split_clusters(std::vector<ClusterItem<S>>& items, const Exec& executor) {
  constexpr std::size_t k_serial_size = 4096;
  detail::ClusterSplitter<S> splitter(items);
  std::vector<ClusterNode> nodes(1);
  std::vector<detail::ClusterRange> open{{0, items.size(), 0, 0}};
  // The top of the tree, breadth first, until every range is small enough for a task of its own.
  std::vector<detail::ClusterRange> tasks;
  while (!open.empty()) {
    std::vector<detail::ClusterRange> next;
    for (const detail::ClusterRange& r : open) {
      if (r.end - r.begin <= k_serial_size) {
        tasks.push_back(r);
        continue;
      }
      const std::size_t cut = splitter.split(r.begin, r.end, r.depth);
      const auto child = static_cast<std::uint32_t>(nodes.size());
      nodes[r.node] = {child, false};
      nodes.resize(nodes.size() + 2);
      next.push_back({r.begin, cut, child, r.depth + 1});
      next.push_back({cut, r.end, child + 1, r.depth + 1});
    }
    open = std::move(next);
  }
  std::vector<std::vector<ClusterNode>> subtrees(tasks.size());
  executor.for_each_index(tasks.size(), [&](std::size_t i) {
    subtrees[i].resize(1);
    detail::split_all(splitter, {tasks[i].begin, tasks[i].end, 0, tasks[i].depth}, subtrees[i]);
  });
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    // Local node k > 0 moves to offset + k - 1; the local root replaces the task's node.
    const auto offset = static_cast<std::uint32_t>(nodes.size());
    for (std::size_t k = 0; k < subtrees[i].size(); ++k) {
      ClusterNode node = subtrees[i][k];
      if (!node.is_leaf) node.first = offset + node.first - 1;
      if (k == 0) {
        nodes[tasks[i].node] = node;
      } else {
        nodes.push_back(node);
      }
    }
  }
  return nodes;
}

}  // namespace manylight
