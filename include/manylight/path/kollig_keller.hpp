// SPDX-License-Identifier: Apache-2.0
#pragma once

// The original bias compensation of [Kollig and Keller 2004]: each generator takes the part c_k = min(w^C, w^D) of what
// the ones before it left,
//
//   w_k = c_k prod_{i<k} (1 - c_i),      sum_{i<=k} w_i = 1 - prod_{i<=k} (1 - c_i),
//
// and an emitter hit takes the rest. With EmitterHits::all unbiased for every path that some generator can make; later
// generators, of higher variance, get more than ResidualWeighting gives them (theory sheet, section 3.9).

#include "manylight/path/weighting.hpp"

namespace manylight {

template <std::floating_point S>
class KolligKeller {
 public:
  using Scalar = S;
  /// State at v_k before its light-side direction is known.
  struct Record {
    S left = S(1);             ///< prod of (1 - c_i), i <= k-2
    S q = S(0);                ///< M_{k-1} T^w_{k-1,k}
    bool connectable = false;  ///< segment k-1 can be made by connection
    bool only_dirac = true;    ///< v_1 .. v_{k-1} are all Dirac
  };

  KolligKeller() = default;
  /// `c_v` and `c_m` of `config` have no effect.
  explicit KolligKeller(const WeightingConfig<S>& config) : config_(config) {}

  [[nodiscard]] Record start() const noexcept { return {}; }
  [[nodiscard]] Record extend(const Record& record, S m, S d, S t) const noexcept {
    return {left_after(record, d), m * t, true, false};
  }
  /// Neither of the two segments at a Dirac vertex can be connected.
  [[nodiscard]] Record extend_delta(const Record& record) const noexcept {
    return {record.left, S(0), false, record.only_dirac};
  }
  [[nodiscard]] S weight(const Record& record, const PairPatterns<S>& pair) const noexcept {
    return left_after(record, pair.d) *
           std::min(detail::clamp_limit(config_, pair), detail::diffuse_limit(config_, pair));
  }
  [[nodiscard]] Constraint binding(const Record& record, const PairPatterns<S>& pair) const noexcept {
    if (!(left_after(record, pair.d) > S(0))) return Constraint::energy;
    return detail::smaller_limit(detail::clamp_limit(config_, pair), detail::diffuse_limit(config_, pair));
  }
  [[nodiscard]] S hit_weight(const Record& record, S d_emitter) const noexcept {
    if (record.only_dirac) return S(1);
    return config_.hits == EmitterHits::all ? left_after(record, d_emitter) : S(0);
  }
  [[nodiscard]] Constraint hit_binding(const Record&, S) const noexcept { return Constraint::energy; }
  [[nodiscard]] bool takes_hits() const noexcept { return config_.hits == EmitterHits::all; }
  /// Nothing is left, or nothing will be since segment k-1 takes all for every D_k <= d_sup.
  [[nodiscard]] bool prune(const Record& record, S d_sup) const noexcept { return !(left_after(record, d_sup) > S(0)); }
  [[nodiscard]] bool prune_delta(const Record& record) const noexcept { return !(record.left > S(0)); }
  [[nodiscard]] SensorLimit<S> limit(const Record& record) const noexcept { return {record.left, k_infinity<S>, S(1)}; }
  [[nodiscard]] S clamp() const noexcept { return config_.c_clamp; }
  [[nodiscard]] S light_limit() const noexcept { return config_.c_d; }

 private:
  /// prod of (1 - c_i), i <= k-1, once D_k = d is known; never falls with d, as c_{k-1} never grows with it.
  [[nodiscard]] S left_after(const Record& record, S d) const noexcept {
    if (!record.connectable) return record.left;
    const PairPatterns<S> pair{record.q, S(0), S(1), d};
    return record.left * (S(1) - std::min(detail::clamp_limit(config_, pair), detail::diffuse_limit(config_, pair)));
  }

  WeightingConfig<S> config_{};
};

static_assert(Weighting<KolligKeller<float>>);

}  // namespace manylight
