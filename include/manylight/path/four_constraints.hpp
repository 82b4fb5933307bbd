// SPDX-License-Identifier: Apache-2.0
#pragma once

// The weights of bidirectional lightcuts [Walter 2012, Eq. 4-10], and the same without the last constraint. Notation:
// M_k, D_k patterns of v_k, D_{k+1} pattern of the VPL, T^w the deterministic transit.
//
//   symbol          here                symbol             here
//   C_clamp, C_D    c_clamp, c_d        W_k = sum w_i       w_sum
//   C_V, C_M        c_v, c_m            M_{k-1} T^w        q
//   Gamma_k         gamma               prod min(...)      p
//   Theta_k         theta               b_{k-1} P_{k-2}    k
//
// The record kept at an eye vertex makes every weight O(1) (theory sheet, section 3.5).

#include "manylight/path/weighting.hpp"

namespace manylight {

/// The paper's four constraints: energy, clamp, diffuse VPLs, no high-variance eye subpaths [Eq. 4-10].
template <std::floating_point S>
class FourConstraints {
 public:
  using Scalar = S;
  /// State at v_k before its light-side direction is known (theory 3.5).
  struct Record {
    S w_sum = S(0);                  ///< W: sum of w_i, i <= k-2
    S q = S(0);                      ///< M_{k-1} T^w_{k-1,k}
    S k = S(1);                      ///< b_{k-1} P_{k-2}
    S gamma_before = k_infinity<S>;  ///< Gamma_{k-1}
    S gamma = k_infinity<S>;         ///< Gamma_k
    S p = S(1);                      ///< P_{k-1}
    S theta = S(0);                  ///< Theta_k, rad
    bool connectable = false;        ///< segment k-1 can be made by connection
    bool only_dirac = true;          ///< v_1 .. v_{k-1} are all Dirac
  };

  FourConstraints() = default;
  explicit FourConstraints(const WeightingConfig<S>& config) : config_(config) {}

  [[nodiscard]] Record start() const noexcept { return {}; }
  [[nodiscard]] Record extend(const Record& record, S m, S d, S t) const noexcept;
  [[nodiscard]] Record extend_delta(const Record& record) const noexcept;
  [[nodiscard]] S weight(const Record& record, const PairPatterns<S>& pair) const noexcept;
  [[nodiscard]] Constraint binding(const Record& record, const PairPatterns<S>& pair) const noexcept;
  [[nodiscard]] S hit_weight(const Record& record, S d_emitter) const noexcept;
  [[nodiscard]] Constraint hit_binding(const Record& record, S d_emitter) const noexcept;
  [[nodiscard]] bool takes_hits() const noexcept { return config_.hits == EmitterHits::all; }
  [[nodiscard]] bool prune(const Record& record, S d_sup) const noexcept;
  [[nodiscard]] bool prune_delta(const Record& record) const noexcept {
    return record.gamma < k_infinity<S> || record.k <= record.w_sum;
  }
  [[nodiscard]] SensorLimit<S> limit(const Record& record) const noexcept;
  [[nodiscard]] S clamp() const noexcept { return config_.c_clamp; }
  [[nodiscard]] S light_limit() const noexcept { return config_.c_d; }

 private:
  /// A segment by its two patterns and what was fixed before it.
  struct Segment {
    S w_sum;
    S q;  ///< M T^w
    S k;  ///< mu without the light's factor
    S gamma;
    S d_light;
    bool exact;
  };
  /// The four constraints of a segment [Eq. 5-8].
  struct Limits {
    S energy, clamp, diffuse, variance;
  };
  [[nodiscard]] Limits limits(const Segment& segment) const noexcept {
    const PairPatterns<S> pair{segment.q, S(0), S(1), segment.d_light, segment.exact};
    return {S(1) - segment.w_sum, detail::clamp_limit(config_, pair), detail::diffuse_limit(config_, pair),
            detail::at_most_one(segment.gamma, segment.d_light) * segment.k - segment.w_sum};
  }
  [[nodiscard]] S weight(const Segment& segment) const noexcept {
    const Limits limit = limits(segment);
    return std::max(S(0), std::min(std::min(limit.energy, limit.clamp), std::min(limit.diffuse, limit.variance)));
  }
  [[nodiscard]] S previous_weight(const Record& record, S d) const noexcept {
    if (!record.connectable) return S(0);
    return weight({record.w_sum, record.q, record.k, record.gamma_before, d, false});
  }
  [[nodiscard]] static S ratio(S gamma, S d, S m) noexcept {
    return std::min(detail::at_most_one(gamma, d), detail::at_most_one(gamma, m));
  }
  [[nodiscard]] Segment segment(const Record& record, const PairPatterns<S>& pair) const noexcept {
    return {record.w_sum + previous_weight(record, pair.d),
            pair.m * pair.t,
            ratio(record.gamma, pair.d, pair.m) * record.p,
            record.gamma,
            pair.d_light,
            pair.exact};
  }
  /// mu of an emitter hit (theory 3.8).
  [[nodiscard]] static S hit_limit(const Record& record, S d_emitter) noexcept {
    return detail::at_most_one(record.gamma, d_emitter) * record.p;
  }

  WeightingConfig<S> config_{};
};

template <std::floating_point S>
S FourConstraints<S>::weight(const Record& record, const PairPatterns<S>& pair) const noexcept {
  return weight(segment(record, pair));
}

template <std::floating_point S>
Constraint FourConstraints<S>::binding(const Record& record, const PairPatterns<S>& pair) const noexcept {
  const Limits limit = limits(segment(record, pair));
  const S smallest = std::min(limit.clamp, limit.diffuse);
  if (limit.energy <= std::min(limit.variance, smallest)) return Constraint::energy;
  return limit.variance <= smallest ? Constraint::variance : detail::smaller_limit(limit.clamp, limit.diffuse);
}

template <std::floating_point S>
auto FourConstraints<S>::extend(const Record& record, S m, S d, S t) const noexcept -> Record {
  Record next;
  next.w_sum = record.w_sum + previous_weight(record, d);
  next.q = m * t;
  next.k = ratio(record.gamma, d, m) * record.p;
  next.gamma_before = record.gamma;
  // A pattern above m covers at most 1/m sr, a cone of half-angle sqrt(1/(pi m)); spreads add [Eq. 9].
  next.theta = record.theta + std::sqrt(k_inv_pi<S> / m);
  next.gamma = next.theta <= std::sqrt(k_inv_pi<S> / config_.c_m) ? k_infinity<S> : config_.c_v;
  next.p = record.p * ratio(next.gamma, d, m);
  next.connectable = true;
  next.only_dirac = false;
  return next;
}

/// M = D = inf: no spread, w = 0 for the two segments at the vertex, and mu = 0 once Gamma is finite (theory 3.7).
template <std::floating_point S>
auto FourConstraints<S>::extend_delta(const Record& record) const noexcept -> Record {
  Record next = record;
  next.k = record.gamma < k_infinity<S> ? S(0) : record.p;
  next.p = next.k;
  next.gamma_before = record.gamma;
  next.connectable = false;
  return next;
}

template <std::floating_point S>
S FourConstraints<S>::hit_weight(const Record& record, S d_emitter) const noexcept {
  if (record.only_dirac) return S(1);
  if (config_.hits == EmitterHits::after_dirac) return S(0);
  const S w_sum = record.w_sum + previous_weight(record, d_emitter);
  return std::max(S(0), std::min(S(1), hit_limit(record, d_emitter)) - w_sum);
}

template <std::floating_point S>
Constraint FourConstraints<S>::hit_binding(const Record& record, S d_emitter) const noexcept {
  if (record.only_dirac || config_.hits == EmitterHits::after_dirac) return Constraint::energy;
  return hit_limit(record, d_emitter) < S(1) ? Constraint::variance : Constraint::energy;
}

/// Necessary and sufficient for "the variance constraint binds at segment k-1 for every D_k in (0, d_sup]", after which
/// all further weights are 0. The paper's sentence has the inequality the wrong way round (theory 3.6).
template <std::floating_point S>
bool FourConstraints<S>::prune(const Record& record, S d_sup) const noexcept {
  if (!record.connectable) return record.k <= record.w_sum;
  const S c = std::min(config_.c_d, config_.c_clamp / record.q);
  return record.k - record.w_sum <= detail::at_most_one(c, std::min(d_sup, record.gamma_before));
}

template <std::floating_point S>
SensorLimit<S> FourConstraints<S>::limit(const Record& record) const noexcept {
  if (record.gamma < k_infinity<S>) return {std::max(S(0), record.p - record.w_sum), record.gamma, S(1)};
  return {S(1), k_infinity<S>, S(1) - record.w_sum};
}

/// The four constraints without the last: w = max(0, min(w^E, w^C, w^D)). With EmitterHits::all every path that some
/// generator can make is shared out in full, hence no bias, but noise wherever eye subpaths are of high variance. The
/// paper's unbiased variant after [Kollig and Keller 2004] multiplies prod (1 - w_i) in as a fourth constraint, which
/// never binds next to w^E: the weights are the same (theory 3.9).
template <std::floating_point S>
class ResidualWeighting : public FourConstraints<S> {
 public:
  ResidualWeighting() : ResidualWeighting(WeightingConfig<S>{}) {}
  /// `c_v` and `c_m` of `config` have no effect: Gamma is infinite, hence mu = 1 and w^V = w^E.
  explicit ResidualWeighting(const WeightingConfig<S>& config) : FourConstraints<S>(without_variance(config)) {}

 private:
  [[nodiscard]] static WeightingConfig<S> without_variance(WeightingConfig<S> config) noexcept {
    config.c_v = k_infinity<S>;
    return config;
  }
};

static_assert(Weighting<FourConstraints<float>> && Weighting<ResidualWeighting<float>>);

}  // namespace manylight
