// SPDX-License-Identifier: Apache-2.0
#pragma once

// What no generator takes of one path, 1 - sum of its weights, and why: the ledger of the theory sheet, section 4. A
// path is followed from the eye; generator j is settled as soon as D_{j+1} is known, one vertex after its own. Segments
// with a Dirac end cannot be made by connection. Every path has exactly one entry, which holds all that is missing of
// it:
//
//   V after X      the variance constraint binds at some segment, or at the hit of the emitter; X is what had left the
//                  energy to it, the constraint of the last segment before
//   clamp, diffuse_light, dirac   it never binds; the constraint of the path's last segment

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "manylight/path/weighting.hpp"

namespace manylight {

/// Reasons why energy is missing.
enum class LedgerEntry : std::uint8_t {
  clamp,          ///< the clamp at the path's end
  diffuse_light,  ///< a light vertex too directional at the path's end
  dirac,          ///< mirrors or smooth glass at the path's end: nothing to connect
  depth,          ///< the path is longer than the image's longest
  variance_after_clamp,
  variance_after_diffuse_light,
  variance_after_dirac,
  variance_first,  ///< nothing had left the energy before
  other            ///< the weighting names no constraint, or `energy` while it leaves some
};
inline constexpr std::size_t k_ledger_entries = 9;
inline constexpr std::array<std::string_view, k_ledger_entries> k_ledger_entry_names{"clamp",
                                                                                     "diffuse light",
                                                                                     "dirac",
                                                                                     "depth",
                                                                                     "variance after clamp",
                                                                                     "variance after diffuse light",
                                                                                     "variance after dirac",
                                                                                     "variance first",
                                                                                     "other"};

[[nodiscard]] constexpr std::string_view name(LedgerEntry entry) noexcept {
  return k_ledger_entry_names[static_cast<std::size_t>(entry)];
}

/// What is missing of one path.
struct MissingShare {
  LedgerEntry entry = LedgerEntry::other;
  double share = 0;  ///< of the path's contribution, [0, 1]
};

/// The shares that the generators of `W` take of a path that grows from the eye. All patterns are largest channels; the
/// weighting must outlive this.
template <class W>
class PathShares {
  static_assert(
      Weighting<W>,
      "manylight::PathShares: the weighting must model Weighting: Scalar, Record, start, extend, extend_delta, "
      "weight, hit_weight, binding, hit_binding, takes_hits, prune, prune_delta, limit, clamp, light_limit");

 public:
  using S = typename W::Scalar;

  /// At v_1.
  explicit PathShares(const W& weighting) : weighting_(&weighting), record_(weighting.start()) {}

  /// Goes on to the next vertex by an ordinary segment of T^w = t, m^-2, in a direction of patterns M = m, D = d,
  /// sr^-1.
  void leave(S m, S d, S t) {
    settle(d, false);
    before_ = record_;
    record_ = weighting_->extend(record_, m, d, t);
    pair_ = {m, d, t, S(0), false};
    segment_ = Segment::ordinary;
  }
  /// Goes on to the next vertex from a Dirac one.
  void leave_delta() {
    if (segment_ != Segment::none) segment_ = Segment::dirac;
    settle(S(0), false);
    record_ = weighting_->extend_delta(record_);
    segment_ = Segment::dirac;
  }
  /// What is missing of the path if this vertex is its light, of pattern D = d_light, sr^-1; `exact`: a point or
  /// directional light, which no eye path hits.
  [[nodiscard]] MissingShare missing(S d_light, bool exact) const {
    PathShares end = *this;
    end.settle(d_light, exact);
    if (!exact) end.take(weighting_->hit_weight(record_, d_light), weighting_->hit_binding(record_, d_light));
    return {end.is_stopped_ ? end.entry_ : end.last_, std::max(0.0, 1.0 - end.sum_)};
  }

 private:
  enum class Segment : std::uint8_t { none, ordinary, dirac };

  /// Adds the generator of the segment that leads to this vertex, of pattern D = d.
  void settle(S d, bool exact) {
    if (segment_ == Segment::dirac) last_ = LedgerEntry::dirac;
    if (segment_ != Segment::ordinary) return;
    PairPatterns<S> pair = pair_;
    pair.d_light = d;
    pair.exact = exact;
    take(weighting_->weight(before_, pair), weighting_->binding(before_, pair));
  }
  void take(S weight, Constraint binding) {
    sum_ += static_cast<double>(weight);
    if (is_stopped_ || binding == Constraint::energy) return;
    if (binding == Constraint::variance) {
      entry_ = variance_after(last_);
      is_stopped_ = true;
    } else {
      last_ = binding == Constraint::clamp ? LedgerEntry::clamp : LedgerEntry::diffuse_light;
    }
  }
  [[nodiscard]] static constexpr LedgerEntry variance_after(LedgerEntry last) noexcept {
    switch (last) {
      case LedgerEntry::clamp:
        return LedgerEntry::variance_after_clamp;
      case LedgerEntry::diffuse_light:
        return LedgerEntry::variance_after_diffuse_light;
      case LedgerEntry::dirac:
        return LedgerEntry::variance_after_dirac;
      default:
        return LedgerEntry::variance_first;
    }
  }

  const W* weighting_;
  typename W::Record record_;    ///< of this vertex
  typename W::Record before_{};  ///< of the one before
  PairPatterns<S> pair_{};       ///< of the segment between, without the light's part
  double sum_ = 0;
  Segment segment_ = Segment::none;
  LedgerEntry last_ = LedgerEntry::other;
  LedgerEntry entry_ = LedgerEntry::other;
  bool is_stopped_ = false;  ///< the variance constraint has bound
};

}  // namespace manylight
