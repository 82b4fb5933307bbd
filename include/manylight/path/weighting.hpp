// SPDX-License-Identifier: Apache-2.0
#pragma once

// Weights of [Walter 2012, section 4]: generator k connects eye vertex v_k with light vertex v_{k+1} and gets weight
// w_k in [0, 1]; sum over k <= 1 for every path. Notation: M_k, D_k patterns of v_k, D_{k+1} pattern of the VPL, T^w the
// deterministic transit 1/d^2 (never the sampled transmittance: two generators of one path must see the same weight).
//
//   symbol          here                symbol             here
//   C_clamp, C_D    c_clamp, c_d        W_k = sum w_i       w_sum
//   C_V, C_M        c_v, c_m            M_{k-1} T^w        q
//   Gamma_k         gamma               prod min(...)      p
//   Theta_k         theta               b_{k-1} P_{k-2}    k
//
// The record kept at an eye vertex makes every weight O(1) (theory sheet, section 3.5).

#include <algorithm>
#include <cmath>
#include <concepts>

#include "manylight/core/vector.hpp"

namespace manylight {

/// What a weight depends on besides the record: scalars are largest channels.
template <std::floating_point S>
struct PairPatterns {
  S m;        ///< M_k towards the VPL, sr^-1
  S d;        ///< D_k of the sensor itself, sr^-1
  S t;        ///< T^w, m^-2
  S d_light;  ///< D_{k+1}, sr^-1
  bool exact = false;  ///< the VPL is free of generation noise and out of reach of other generators: no clamp
};

/// What is known of a sensor's weights for every light: w M min(D, C_D) <= factor * min(M, cap) * min(D, C_D), and if
/// D < C_D also <= M * remaining * D (theory 6.5).
template <std::floating_point S>
struct SensorLimit {
  S factor = S(1);
  S cap = k_infinity<S>;
  S remaining = S(1);
};

/// A rule that shares each path among its generators. Contract:
///  - `start()`: record of the first eye vertex; `extend(record, m, d, t)`: of the next one, reached by an ordinary
///    segment of T^w = t in a direction of patterns M_k = m, D_k = d; `extend_delta(record)`: after a Dirac vertex;
///  - `weight(record, patterns)`: w_k of a connection, in [0, 1];
///  - `hit_weight(record, d_emitter)`: weight of the eye path having hit an emitter at this vertex itself;
///  - `prune(record, d_sup)`: every weight from this vertex on is provably 0, whatever the direction, given that its
///    D_k <= d_sup; `prune_delta(record)`: the same for a Dirac continuation;
///  - `limit(record)`: see SensorLimit; `clamp()`, `light_limit()`: w M T D <= clamp (not for exact VPLs) and
///    w D <= light_limit for every pair.
template <class W>
concept Weighting = requires(const W& weighting, const typename W::Record& record, typename W::Scalar x,
                             const PairPatterns<typename W::Scalar>& patterns) {
  typename W::Scalar;
  { weighting.start() } -> std::same_as<typename W::Record>;
  { weighting.extend(record, x, x, x) } -> std::same_as<typename W::Record>;
  { weighting.extend_delta(record) } -> std::same_as<typename W::Record>;
  { weighting.weight(record, patterns) } -> std::same_as<typename W::Scalar>;
  { weighting.hit_weight(record, x) } -> std::same_as<typename W::Scalar>;
  { weighting.prune(record, x) } -> std::same_as<bool>;
  { weighting.prune_delta(record) } -> std::same_as<bool>;
  { weighting.limit(record) } -> std::same_as<SensorLimit<typename W::Scalar>>;
  { weighting.clamp() } -> std::same_as<typename W::Scalar>;
  { weighting.light_limit() } -> std::same_as<typename W::Scalar>;
};

/// Which emitter hits of eye paths count (theory 3.8).
enum class EmitterHits {
  after_dirac,  ///< only seen directly or through Dirac vertices: the paper's behaviour
  all           ///< wherever the four constraints leave energy: restores clamped light of near emitters
};

namespace detail {
/// min(limit / x, 1) for x >= 0; 1 for limit = inf whatever x, 0 for x = inf.
template <std::floating_point S>
[[nodiscard]] inline S at_most_one(S limit, S x) noexcept {
  return x <= limit ? S(1) : limit / x;
}
}  // namespace detail

/// Parameters shared by the weightings.
template <std::floating_point S>
struct WeightingConfig {
  S c_clamp = k_infinity<S>;  ///< clamp of M T D, m^-2 sr^-2: L_a / (800 I_avg) [Eq. 6]
  S c_d = S(1);               ///< diffuse VPL limit, sr^-1 [Eq. 7]
  S c_v = S(1);               ///< limit of directionality after a wide bounce, sr^-1, <= c_d [Eq. 10]
  S c_m = S(100);             ///< M above which a bounce counts as narrow, sr^-1 [Eq. 10]
  EmitterHits hits = EmitterHits::all;
};

/// Classical virtual point lights: only the first non-Dirac eye vertex connects, w = min(w^C, w^D).
template <std::floating_point S>
class StandardWeighting {
 public:
  using Scalar = S;
  struct Record {
    bool used = false;  ///< a non-Dirac vertex lies before this one
  };

  StandardWeighting() = default;
  explicit StandardWeighting(const WeightingConfig<S>& config) : config_(config) {}

  [[nodiscard]] Record start() const noexcept { return {}; }
  [[nodiscard]] Record extend(const Record&, S, S, S) const noexcept { return {true}; }
  [[nodiscard]] Record extend_delta(const Record& record) const noexcept { return record; }
  [[nodiscard]] S weight(const Record& record, const PairPatterns<S>& pair) const noexcept {
    if (record.used) return S(0);
    const S clamp = pair.exact ? S(1) : detail::at_most_one(config_.c_clamp, pair.m * pair.t * pair.d_light);
    return std::min(clamp, detail::at_most_one(config_.c_d, pair.d_light));
  }
  [[nodiscard]] S hit_weight(const Record& record, S) const noexcept { return record.used ? S(0) : S(1); }
  [[nodiscard]] bool prune(const Record& record, S) const noexcept { return record.used; }
  [[nodiscard]] bool prune_delta(const Record& record) const noexcept { return record.used; }
  [[nodiscard]] SensorLimit<S> limit(const Record&) const noexcept { return {}; }
  [[nodiscard]] S clamp() const noexcept { return config_.c_clamp; }
  [[nodiscard]] S light_limit() const noexcept { return config_.c_d; }

 private:
  WeightingConfig<S> config_{};
};

/// The paper's four constraints: energy, clamp, diffuse VPLs, no high-variance eye subpaths [Eq. 4-10].
template <std::floating_point S>
class FourConstraints {
 public:
  using Scalar = S;
  /// State at v_k before its light-side direction is known (theory 3.5).
  struct Record {
    S w_sum = S(0);             ///< W: sum of w_i, i <= k-2
    S q = S(0);                 ///< M_{k-1} T^w_{k-1,k}
    S k = S(1);                 ///< b_{k-1} P_{k-2}
    S gamma_before = k_infinity<S>;  ///< Gamma_{k-1}
    S gamma = k_infinity<S>;    ///< Gamma_k
    S p = S(1);                 ///< P_{k-1}
    S theta = S(0);             ///< Theta_k, rad
    bool connectable = false;   ///< segment k-1 can be made by connection
    bool only_dirac = true;     ///< v_1 .. v_{k-1} are all Dirac
  };

  FourConstraints() = default;
  explicit FourConstraints(const WeightingConfig<S>& config) : config_(config) {}

  [[nodiscard]] Record start() const noexcept { return {}; }
  [[nodiscard]] Record extend(const Record& record, S m, S d, S t) const noexcept;
  [[nodiscard]] Record extend_delta(const Record& record) const noexcept;
  [[nodiscard]] S weight(const Record& record, const PairPatterns<S>& pair) const noexcept;
  [[nodiscard]] S hit_weight(const Record& record, S d_emitter) const noexcept;
  [[nodiscard]] bool prune(const Record& record, S d_sup) const noexcept;
  [[nodiscard]] bool prune_delta(const Record& record) const noexcept {
    return record.gamma < k_infinity<S> || record.k <= record.w_sum;
  }
  [[nodiscard]] SensorLimit<S> limit(const Record& record) const noexcept;
  [[nodiscard]] S clamp() const noexcept { return config_.c_clamp; }
  [[nodiscard]] S light_limit() const noexcept { return config_.c_d; }

 private:
  /// Weight of a segment: the smallest of the four constraints (energy, clamp, diffuse VPL, variance).
  [[nodiscard]] S segment_weight(S w_sum, S q, S k, S gamma, S d_light, bool exact) const noexcept {
    const S clamp = exact ? S(1) : detail::at_most_one(config_.c_clamp, q * d_light);
    const S energy = S(1) - w_sum;
    const S diffuse = detail::at_most_one(config_.c_d, d_light);
    const S variance = detail::at_most_one(gamma, d_light) * k - w_sum;
    return std::max(S(0), std::min(std::min(energy, clamp), std::min(diffuse, variance)));
  }
  [[nodiscard]] S previous_weight(const Record& record, S d) const noexcept {
    if (!record.connectable) return S(0);
    return segment_weight(record.w_sum, record.q, record.k, record.gamma_before, d, false);
  }

  WeightingConfig<S> config_{};
};

template <std::floating_point S>
S FourConstraints<S>::weight(const Record& record, const PairPatterns<S>& pair) const noexcept {
  const S w_sum = record.w_sum + previous_weight(record, pair.d);
  const S k = std::min(detail::at_most_one(record.gamma, pair.d), detail::at_most_one(record.gamma, pair.m)) * record.p;
  return segment_weight(w_sum, pair.m * pair.t, k, record.gamma, pair.d_light, pair.exact);
}

template <std::floating_point S>
auto FourConstraints<S>::extend(const Record& record, S m, S d, S t) const noexcept -> Record {
  Record next;
  next.w_sum = record.w_sum + previous_weight(record, d);
  next.q = m * t;
  next.k = std::min(detail::at_most_one(record.gamma, d), detail::at_most_one(record.gamma, m)) * record.p;
  next.gamma_before = record.gamma;
  // A pattern above m covers at most 1/m sr, a cone of half-angle sqrt(1/(pi m)); spreads add [Eq. 9].
  next.theta = record.theta + std::sqrt(k_inv_pi<S> / m);
  next.gamma = next.theta <= std::sqrt(k_inv_pi<S> / config_.c_m) ? k_infinity<S> : config_.c_v;
  next.p = record.p * std::min(detail::at_most_one(next.gamma, d), detail::at_most_one(next.gamma, m));
  next.connectable = true;
  next.only_dirac = false;
  return next;
}

/// M = D = inf: no spread, w = 0 for the two segments at the vertex, and mu = 0 once Gamma is finite (theory 3.7).
template <std::floating_point S>
auto FourConstraints<S>::extend_delta(const Record& record) const noexcept -> Record {
  Record next = record;
  const S ratio = record.gamma < k_infinity<S> ? S(0) : S(1);
  next.k = ratio * record.p;
  next.p = ratio * record.p;
  next.gamma_before = record.gamma;
  next.connectable = false;
  return next;
}

template <std::floating_point S>
S FourConstraints<S>::hit_weight(const Record& record, S d_emitter) const noexcept {
  if (record.only_dirac) return S(1);
  if (config_.hits == EmitterHits::after_dirac) return S(0);
  const S w_sum = record.w_sum + previous_weight(record, d_emitter);
  const S mu = detail::at_most_one(record.gamma, d_emitter) * record.p;
  return std::max(S(0), std::min(S(1), mu) - w_sum);
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

static_assert(Weighting<StandardWeighting<float>> && Weighting<FourConstraints<float>>);

}  // namespace manylight
