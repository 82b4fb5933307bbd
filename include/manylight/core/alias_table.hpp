// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "manylight/core/config.hpp"
#include "manylight/core/error.hpp"

namespace manylight {

/// Discrete distribution sampled in constant time, 12 bytes per entry. [Walker 1977; Vose 1991]
/// An entry of weight 0 is never drawn, one of positive weight always may be.
class AliasTable {
 public:
  AliasTable() = default;

  /// Weights need not be normalised. All zero, or none at all, give an empty table. Throws ParameterError for a weight
  /// that is negative or not finite, and for more than 2^32 - 1 weights.
  explicit AliasTable(std::span<const double> weights) {
    require(weights.size() < 0xFFFFFFFFu, "number of weights", weights.size(), "less than 2^32 - 1");
    double total = 0;
    for (std::size_t i = 0; i < weights.size(); ++i) {
      require(weights[i] >= 0 && std::isfinite(weights[i]), "weight " + std::to_string(i), weights[i],
              "0 or a positive number");
      total += weights[i];
    }
    if (total > 0) build(weights, total);
  }

  [[nodiscard]] bool empty() const noexcept { return entries_.empty(); }
  [[nodiscard]] std::size_t size() const noexcept { return entries_.size(); }
  [[nodiscard]] std::size_t bytes() const noexcept { return entries_.capacity() * sizeof(Entry); }
  /// Probability of entry `i`.
  [[nodiscard]] float pmf(std::uint32_t i) const noexcept { return entries_[i].pmf; }

  /// The entry that `u` in [0, 1) selects; the table must not be empty. Precision matters here: see `widen_variate`.
  [[nodiscard]] std::uint32_t sample(double u) const noexcept {
    MANYLIGHT_ASSERT(!empty() && u >= 0 && u < 1);
    const double scaled = u * static_cast<double>(entries_.size());
    const auto column = std::min(static_cast<std::uint32_t>(scaled), static_cast<std::uint32_t>(entries_.size() - 1));
    const double rest = scaled - static_cast<double>(column);
    return rest < static_cast<double>(entries_[column].threshold) ? column : entries_[column].alias;
  }

 private:
  struct Entry {
    float threshold = 1.0F;  ///< share of the column that belongs to its own entry
    float pmf = 0.0F;
    std::uint32_t alias = 0;  ///< who owns the rest
  };

  /// Vose's method: each column that holds too little is filled up from one that holds too much.
  void build(std::span<const double> weights, double total) {
    const auto count = static_cast<std::uint32_t>(weights.size());
    entries_.resize(count);
    std::vector<double> share(count);
    std::vector<std::uint32_t> small, large;
    for (std::uint32_t i = 0; i < count; ++i) {
      share[i] = weights[i] / total * count;
      entries_[i].pmf = static_cast<float>(weights[i] / total);
      (share[i] < 1 ? small : large).push_back(i);
    }
    while (!small.empty() && !large.empty()) {
      const std::uint32_t poor = small.back(), rich = large.back();
      small.pop_back();
      entries_[poor].threshold = static_cast<float>(share[poor]);
      entries_[poor].alias = rich;
      share[rich] -= 1 - share[poor];
      if (share[rich] < 1) {
        large.pop_back();
        small.push_back(rich);
      }
    }
    // What is left are full columns up to rounding; an entry of weight 0 among them must still never be drawn.
    const auto heaviest =
        static_cast<std::uint32_t>(std::max_element(weights.begin(), weights.end()) - weights.begin());
    for (const std::uint32_t i : small) {
      if (weights[i] == 0) entries_[i].threshold = 0, entries_[i].alias = heaviest;
    }
  }

  std::vector<Entry> entries_;
};

/// A finer variate for choosing among many: a float variate has 2^24 values, too few to draw from a million entries
/// with the right probabilities. The missing bits come from the lowest bits of a second variate, whose own use (a
/// position) does not depend on them noticeably.
template <std::floating_point S>
[[nodiscard]] double widen_variate(S u, S spare) noexcept {
  const double fine = static_cast<double>(spare) * 4096;
  constexpr double k_step = sizeof(S) <= 4 ? 0x1p-24 : 0x1p-32;
  return std::min(static_cast<double>(u) + k_step * (fine - std::floor(fine)), 1 - 0x1p-53);
}

}  // namespace manylight
