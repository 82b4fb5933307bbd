// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <utility>
#include <vector>

#include "manylight/core/box.hpp"
#include "manylight/core/executor.hpp"
#include "manylight/core/vector.hpp"

/// Top-down binary tree by the binned surface area heuristic. [Wald 2007, "On fast Construction of SAH-based Bounding
/// Volume Hierarchies"]. No recursion; the same tree for every executor.
namespace manylight::detail {

/// What the builder sorts: a box and whose it is. `primitive` is k_analytic for a sphere or disk.
template <std::floating_point S>
struct PrimitiveRef {
  Vec3<S> lo;
  std::uint32_t shape;
  Vec3<S> hi;
  std::uint32_t primitive;

  static constexpr std::uint32_t k_analytic = ~std::uint32_t{0};
  [[nodiscard]] bool is_analytic() const noexcept { return primitive == k_analytic; }
  /// Twice the centre: halving would change nothing but rounding.
  [[nodiscard]] Vec3<S> center2() const noexcept { return lo + hi; }
};

/// Inner node: children at `child` and `child + 1`; leaf (count > 0): references [child, child + count).
template <std::floating_point S>
struct BinaryNode {
  Box<S> box;
  std::uint32_t child = 0;
  std::uint32_t count = 0;
  [[nodiscard]] bool is_leaf() const noexcept { return count > 0; }
};

struct BvhBuildConfig {
  std::uint32_t leaf_lanes = 8;      ///< primitives tested at the cost of one
  std::uint32_t max_leaf_size = 8;   ///< references
  float traversal_cost = 1.0f;       ///< of an inner node, in units of one test of `leaf_lanes` primitives
  std::uint32_t max_sah_depth = 64;  ///< below it, halving by index: bounds the depth to this + 32
};

template <std::floating_point S>
class BvhBuilder {
 public:
  using Ref = PrimitiveRef<S>;
  using Node = BinaryNode<S>;

  explicit BvhBuilder(const BvhBuildConfig& config) : config_(config) {}

  /// Sorts `refs` (not empty) so that each leaf's are neighbours and returns the nodes, the root first.
  template <Executor E>
  [[nodiscard]] std::vector<Node> build(std::vector<Ref>& refs, const E& executor) const {
    const auto size = static_cast<std::uint32_t>(refs.size());
    std::vector<Node> nodes{Node{box_of(refs, 0, size), 0, size}};
    // Large ranges are split here, in order; what is left are independent subtrees.
    const std::uint32_t task_size = std::max(k_min_task_size, size / k_tasks);
    std::vector<Task> tasks;
    split_all(refs, nodes, {{0, 0}}, task_size, tasks);
    std::vector<std::vector<Node>> subtrees(tasks.size());
    executor.for_each_index(tasks.size(), [&](std::size_t i) {
      subtrees[i] = {nodes[tasks[i].node]};
      std::vector<Task> none;
      split_all(refs, subtrees[i], {{0, tasks[i].depth}}, 0, none);
    });
    for (std::size_t i = 0; i < tasks.size(); ++i) graft(nodes, tasks[i].node, subtrees[i]);
    return nodes;
  }

 private:
  static constexpr std::uint32_t k_bins = 16;
  static constexpr std::uint32_t k_tasks = 64;
  static constexpr std::uint32_t k_min_task_size = 4096;

  struct Task {
    std::uint32_t node;
    std::uint32_t depth;
  };
  struct Bin {
    Box<S> box;
    std::uint32_t count = 0;
  };
  struct Split {
    float cost = std::numeric_limits<float>::infinity();
    int axis = -1;
    std::uint32_t bin = 0;  ///< first bin of the right side
  };
  /// Maps centres to bins along each axis.
  struct Binning {
    Vec3<S> lo;
    Vec3<S> scale;
    [[nodiscard]] std::uint32_t bin(const Ref& ref, int axis) const noexcept {
      const S position = (ref.center2()[axis] - lo[axis]) * scale[axis];
      return std::min(static_cast<std::uint32_t>(position), k_bins - 1);
    }
  };

  [[nodiscard]] static Box<S> box_of(const std::vector<Ref>& refs, std::uint32_t begin, std::uint32_t end) noexcept;
  [[nodiscard]] static Binning binning_of(const std::vector<Ref>& refs, std::uint32_t begin,
                                          std::uint32_t end) noexcept;
  [[nodiscard]] float leaf_cost(std::uint32_t count) const noexcept {
    return static_cast<float>((count + config_.leaf_lanes - 1) / config_.leaf_lanes);
  }
  [[nodiscard]] Split best_split(const std::vector<Ref>& refs, std::uint32_t begin, std::uint32_t end,
                                 const Binning& binning) const noexcept;
  [[nodiscard]] std::uint32_t split(std::vector<Ref>& refs, const Node& node, std::uint32_t depth) const noexcept;
  void split_all(std::vector<Ref>& refs, std::vector<Node>& nodes, std::vector<Task> open, std::uint32_t task_size,
                 std::vector<Task>& tasks) const;
  static void graft(std::vector<Node>& nodes, std::uint32_t at, const std::vector<Node>& subtree);

  BvhBuildConfig config_;
};

// ---- bodies ---------------------------------------------------------------------------------

template <std::floating_point S>
Box<S> BvhBuilder<S>::box_of(const std::vector<Ref>& refs, std::uint32_t begin, std::uint32_t end) noexcept {
  Box<S> box;
  for (std::uint32_t i = begin; i < end; ++i) box.extend(Box<S>{refs[i].lo, refs[i].hi});
  return box;
}

template <std::floating_point S>
auto BvhBuilder<S>::binning_of(const std::vector<Ref>& refs, std::uint32_t begin, std::uint32_t end) noexcept
    -> Binning {
  Box<S> centers;
  for (std::uint32_t i = begin; i < end; ++i) centers.extend(refs[i].center2());
  Binning binning{centers.lo, Vec3<S>(0)};
  for (int axis = 0; axis < 3; ++axis) {
    const S extent = centers.hi[axis] - centers.lo[axis];
    // An extent so small that its inverse overflows counts as none: every centre then falls into bin 0.
    const S scale = static_cast<S>(k_bins) / extent;
    binning.scale[axis] = extent > S(0) && std::isfinite(scale) ? scale : S(0);
  }
  return binning;
}

template <std::floating_point S>
auto BvhBuilder<S>::best_split(const std::vector<Ref>& refs, std::uint32_t begin, std::uint32_t end,
                               const Binning& binning) const noexcept -> Split {
  std::array<std::array<Bin, k_bins>, 3> bins{};
  for (std::uint32_t i = begin; i < end; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      Bin& bin = bins[static_cast<std::size_t>(axis)][binning.bin(refs[i], axis)];
      bin.box.extend(Box<S>{refs[i].lo, refs[i].hi});
      ++bin.count;
    }
  }
  Split best;
  for (int axis = 0; axis < 3; ++axis) {
    if (binning.scale[axis] == S(0)) continue;
    const std::array<Bin, k_bins>& row = bins[static_cast<std::size_t>(axis)];
    std::array<float, k_bins> right_cost{};
    Bin right;
    for (std::uint32_t b = k_bins - 1; b > 0; --b) {
      right.box.extend(row[b].box);
      right.count += row[b].count;
      right_cost[b] = right.count == 0 ? 0.0f : static_cast<float>(right.box.half_area()) * leaf_cost(right.count);
    }
    Bin left;
    for (std::uint32_t b = 1; b < k_bins; ++b) {
      left.box.extend(row[b - 1].box);
      left.count += row[b - 1].count;
      if (left.count == 0 || left.count == end - begin) continue;
      const float cost = static_cast<float>(left.box.half_area()) * leaf_cost(left.count) + right_cost[b];
      if (cost < best.cost) best = {cost, axis, b};
    }
  }
  return best;
}

/// Partitions the node's references; returns the first of the right side, or the node's begin to keep it a leaf.
template <std::floating_point S>
std::uint32_t BvhBuilder<S>::split(std::vector<Ref>& refs, const Node& node, std::uint32_t depth) const noexcept {
  const std::uint32_t begin = node.child;
  const std::uint32_t end = node.child + node.count;
  const auto first = refs.begin() + begin;
  const auto last = refs.begin() + end;
  if (node.count == 1) return begin;
  if (depth < config_.max_sah_depth) {
    const Binning binning = binning_of(refs, begin, end);
    const Split best = best_split(refs, begin, end, binning);
    if (best.axis >= 0) {
      const float area = static_cast<float>(node.box.half_area());
      const float split_cost = config_.traversal_cost * area + best.cost;
      if (node.count > config_.max_leaf_size || split_cost < leaf_cost(node.count) * area) {
        const auto middle =
            std::partition(first, last, [&](const Ref& ref) { return binning.bin(ref, best.axis) < best.bin; });
        return static_cast<std::uint32_t>(middle - refs.begin());
      }
    }
  }
  if (node.count > config_.max_leaf_size) return begin + node.count / 2;
  // A leaf holds either triangles or analytic shapes.
  const auto middle = std::partition(first, last, [](const Ref& ref) { return ref.is_analytic(); });
  return middle == last ? begin : static_cast<std::uint32_t>(middle - refs.begin());
}

/// Splits the open nodes down to leaves, or down to `task_size` references: those become tasks.
template <std::floating_point S>
void BvhBuilder<S>::split_all(std::vector<Ref>& refs, std::vector<Node>& nodes, std::vector<Task> open,
                              std::uint32_t task_size, std::vector<Task>& tasks) const {
  while (!open.empty()) {
    const Task task = open.back();
    open.pop_back();
    const Node node = nodes[task.node];
    if (node.count <= task_size) {
      tasks.push_back(task);
      continue;
    }
    const std::uint32_t begin = node.child;
    const std::uint32_t end = node.child + node.count;
    const std::uint32_t middle = split(refs, node, task.depth);
    if (middle == begin) continue;
    const auto left = static_cast<std::uint32_t>(nodes.size());
    nodes[task.node].child = left;
    nodes[task.node].count = 0;
    nodes.push_back({box_of(refs, begin, middle), begin, middle - begin});
    nodes.push_back({box_of(refs, middle, end), middle, end - middle});
    open.push_back({left, task.depth + 1});
    open.push_back({left + 1, task.depth + 1});
  }
}

/// Puts a subtree, whose root replaces nodes[at], behind the nodes.
template <std::floating_point S>
void BvhBuilder<S>::graft(std::vector<Node>& nodes, std::uint32_t at, const std::vector<Node>& subtree) {
  const auto offset = static_cast<std::uint32_t>(nodes.size()) - 1;  // the subtree's node 1 comes next
  const auto moved = [offset](Node node) {
    if (!node.is_leaf()) node.child += offset;
    return node;
  };
  nodes[at] = moved(subtree.front());
  std::transform(subtree.begin() + 1, subtree.end(), std::back_inserter(nodes), moved);
}

}  // namespace manylight::detail
