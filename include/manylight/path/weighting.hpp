// SPDX-License-Identifier: Apache-2.0
#pragma once

// Weights of [Walter 2012, section 4]: generator k connects eye vertex v_k with light vertex v_{k+1} and gets weight
// w_k in [0, 1]; sum over k <= 1 for every path. A weighting is the rule that shares a path among its generators:
//
//   weighting           header                sensors              sum of weights
//   StandardWeighting   weighting.hpp         first ordinary one   min(clamp, diffuse limit) of the first generator
//   FullWeighting       weighting.hpp         first ordinary one   1, with infinite variance
//   FourConstraints     four_constraints.hpp  recursive            1 where no eye subpath of high variance is needed
//   ResidualWeighting   four_constraints.hpp  recursive            1 with emitter hits: no bias
//   KolligKeller        kollig_keller.hpp     recursive            1 with emitter hits: no bias
//
// T^w in weights is the deterministic transit 1/d^2, never the sampled transmittance: two generators of one path must
// see the same weight.

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdint>

#include "manylight/core/vector.hpp"

namespace manylight {

/// What a weight depends on besides the record: scalars are largest channels.
template <std::floating_point S>
struct PairPatterns {
  S m;                 ///< M_k towards the VPL, sr^-1
  S d;                 ///< D_k of the sensor itself, sr^-1
  S t;                 ///< T^w, m^-2
  S d_light;           ///< D_{k+1}, sr^-1
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

/// What keeps a generator from taking more of a path than its weight.
enum class Constraint : std::uint8_t {
  energy,         ///< nothing: it takes all that is left. Also of generators that the weighting does not have
  clamp,          ///< M T D is too large [Walter 2012, Eq. 6]
  diffuse_light,  ///< the light vertex is too directional [Walter 2012, Eq. 7]
  variance        ///< the eye subpath has too high a variance, now and later [Walter 2012, Eq. 8]
};

/// A rule that shares each path among its generators. Contract:
///  - `start()`: record of the first eye vertex; `extend(record, m, d, t)`: of the next one, reached by an ordinary
///    segment of T^w = t in a direction of patterns M_k = m, D_k = d; `extend_delta(record)`: after a Dirac vertex;
///  - `weight(record, patterns)`: w_k of a connection, in [0, 1];
///  - `hit_weight(record, d_emitter)`: weight of the eye path having hit an emitter at this vertex itself, D of the
///    emitter given; with the weights before, no more than 1;
///  - `binding(record, patterns)`: the constraint that `weight` is the minimum of; of equal ones the first in the order
///    energy, variance, clamp, diffuse_light, so that `energy` says that nothing is left or that the weighting has no
///    such generator, and `variance` that no later one takes anything; `hit_binding(record, d_emitter)`: the same for
///    `hit_weight`. Only the ledger of missing energy asks;
///  - `takes_hits()`: `hit_weight` may be other than 0 after an ordinary vertex. Lights are then drawn for the vertices too;
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
  { weighting.binding(record, patterns) } -> std::same_as<Constraint>;
  { weighting.hit_binding(record, x) } -> std::same_as<Constraint>;
  { weighting.takes_hits() } -> std::same_as<bool>;
  { weighting.prune(record, x) } -> std::same_as<bool>;
  { weighting.prune_delta(record) } -> std::same_as<bool>;
  { weighting.limit(record) } -> std::same_as<SensorLimit<typename W::Scalar>>;
  { weighting.clamp() } -> std::same_as<typename W::Scalar>;
  { weighting.light_limit() } -> std::same_as<typename W::Scalar>;
};

/// Which emitter hits of eye paths count (theory 3.8).
enum class EmitterHits {
  after_dirac,  ///< only seen directly or through Dirac vertices: the paper's behaviour
  all           ///< wherever the other generators leave energy: restores clamped light of near emitters
};

namespace detail {
/// min(limit / x, 1) for x >= 0; 1 for limit = inf whatever x (inf and 0 * inf too), 0 for x = inf otherwise.
template <std::floating_point S>
[[nodiscard]] inline S at_most_one(S limit, S x) noexcept {
  return !(x > limit) ? S(1) : limit / x;
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

namespace detail {
/// w^C: what the clamp lets a pair carry, [0, 1] [Walter 2012, Eq. 6].
template <std::floating_point S>
[[nodiscard]] inline S clamp_limit(const WeightingConfig<S>& config, const PairPatterns<S>& pair) noexcept {
  return pair.exact ? S(1) : at_most_one(config.c_clamp, pair.m * pair.t * pair.d_light);
}
/// w^D: what the limit of the light's directionality lets a pair carry, [0, 1] [Walter 2012, Eq. 7].
template <std::floating_point S>
[[nodiscard]] inline S diffuse_limit(const WeightingConfig<S>& config, const PairPatterns<S>& pair) noexcept {
  return at_most_one(config.c_d, pair.d_light);
}
/// Which of the two binds where no other constraint does.
template <std::floating_point S>
[[nodiscard]] inline Constraint smaller_limit(S clamp, S diffuse) noexcept {
  if (std::min(clamp, diffuse) >= S(1)) return Constraint::energy;
  return clamp <= diffuse ? Constraint::clamp : Constraint::diffuse_light;
}
}  // namespace detail

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
    return record.used ? S(0) : std::min(detail::clamp_limit(config_, pair), detail::diffuse_limit(config_, pair));
  }
  [[nodiscard]] Constraint binding(const Record& record, const PairPatterns<S>& pair) const noexcept {
    if (record.used) return Constraint::energy;
    return detail::smaller_limit(detail::clamp_limit(config_, pair), detail::diffuse_limit(config_, pair));
  }
  [[nodiscard]] S hit_weight(const Record& record, S) const noexcept { return record.used ? S(0) : S(1); }
  [[nodiscard]] Constraint hit_binding(const Record&, S) const noexcept { return Constraint::energy; }
  [[nodiscard]] bool takes_hits() const noexcept { return false; }
  [[nodiscard]] bool prune(const Record& record, S) const noexcept { return record.used; }
  [[nodiscard]] bool prune_delta(const Record& record) const noexcept { return record.used; }
  [[nodiscard]] SensorLimit<S> limit(const Record&) const noexcept { return {}; }
  [[nodiscard]] S clamp() const noexcept { return config_.c_clamp; }
  [[nodiscard]] S light_limit() const noexcept { return config_.c_d; }

 private:
  WeightingConfig<S> config_{};
};

/// Virtual point lights without any limit: the first non-Dirac eye vertex connects, w = 1. Unbiased and of infinite
/// variance: an oracle for small scenes.
template <std::floating_point S>
class FullWeighting : public StandardWeighting<S> {
 public:
  FullWeighting() : StandardWeighting<S>(WeightingConfig<S>{k_infinity<S>, k_infinity<S>}) {}
};

static_assert(Weighting<StandardWeighting<float>> && Weighting<FullWeighting<float>>);

}  // namespace manylight
