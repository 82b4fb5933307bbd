// SPDX-License-Identifier: Apache-2.0
#pragma once

// Representatives of clusters [Walter 2006, section 4.3; theory 5.3]: an item of a cluster drawn with probability
// weight / weight of the cluster. Clusters are ranges of the tree's leaf order, so that one table of sums serves all.
// When a cluster is split, its representative stays that of the child that holds it: given that, it is distributed there
// as if drawn afresh. Only the other child draws.

#include <algorithm>
#include <cstdint>
#include <vector>

#include "manylight/core/huge_pages.hpp"
#include "manylight/core/prefetch.hpp"
#include "manylight/many_light/cluster_split.hpp"

namespace manylight {

/// A range of leaves, [begin, end), in leaf order.
struct LeafRange {
  std::uint32_t begin = 0;
  std::uint32_t end = 0;
};

template <std::floating_point S>
class Representatives {
 public:
  void clear() { sums_.assign(1, 0.0); }
  /// Appends items in leaf order.
  void append(const std::vector<ClusterItem<S>>& items) {
    sums_.reserve(sums_.size() + items.size());
    for (const ClusterItem<S>& item : items) sums_.push_back(sums_.back() + static_cast<double>(item.weight));
  }

  [[nodiscard]] std::size_t bytes() const noexcept { return sums_.size() * sizeof(double); }

  /// Place of the leaf that `u` in [0, 1) picks from the range, with probability proportional to weight (uniformly where
  /// all weights are below 1e-16 of the sum before them). Starts at the place that equal weights would give, which roulette
  /// makes VPLs come near to: a few steps, whatever the range.
  [[nodiscard]] std::uint32_t pick(const LeafRange& range, double u) const noexcept {
    const double first = sums_[range.begin];
    const double total = sums_[range.end] - first;
    const std::uint32_t guess = first_guess(range, u);
    if (!(total > 0)) return guess;
    return bracketed(range, guess, first + u * total);
  }
  /// Asks for the memory that `pick` will read.
  void prefetch_pick(const LeafRange& range, double u) const noexcept {
    prefetch(&sums_[range.begin], sizeof(double));
    prefetch(&sums_[range.end], sizeof(double));
    prefetch(&sums_[first_guess(range, u)], 2 * sizeof(double));
  }

 private:
  [[nodiscard]] static std::uint32_t first_guess(const LeafRange& range, double u) noexcept {
    return std::min(range.end - 1,
                    range.begin + static_cast<std::uint32_t>(u * static_cast<double>(range.end - range.begin)));
  }
  /// The last leaf whose sum before it is at most `target` and which has a weight; gallops from `guess`.
  [[nodiscard]] std::uint32_t bracketed(const LeafRange& range, std::uint32_t guess, double target) const noexcept {
    std::uint32_t lo = guess;
    std::uint32_t hi = guess + 1;
    std::uint32_t step = 1;
    while (lo > range.begin && sums_[lo] > target) {
      hi = lo;
      lo = lo - range.begin > step ? lo - step : range.begin;
      step *= 2;
    }
    step = 1;
    while (hi < range.end && sums_[hi] <= target) {
      lo = hi;
      hi = range.end - hi > step ? hi + step : range.end;
      step *= 2;
    }
    // sums_[lo] <= target < sums_[hi], but for rounding at the ends of the range.
    const auto above = std::upper_bound(sums_.begin() + lo, sums_.begin() + hi, target) - sums_.begin();
    auto leaf = static_cast<std::uint32_t>(std::clamp<std::ptrdiff_t>(above - 1, lo, std::ptrdiff_t{hi} - 1));
    while (leaf > range.begin && !(sums_[leaf + 1] > sums_[leaf])) --leaf;  // rounding led behind the last weight
    return leaf;
  }

  LargeVector<double> sums_ = LargeVector<double>(1, 0.0);  ///< of the weights before each leaf; one more at the end
};

}  // namespace manylight
