// SPDX-License-Identifier: Apache-2.0
#pragma once

// Tries to refute bounds of phase functions, see falsify.hpp.

#include "manylight/bounds/falsify.hpp"
#include "manylight/scattering/phase_concepts.hpp"

namespace manylight {

/// Which of a phase function's directions are sets: the sampled one, the known one, or both.
enum class PhaseSets { sampled, known, both };

/// The largest value found over pairs.
template <std::floating_point S>
struct PairFalsification {
  Falsification<S> found;      ///< its `at` is the first direction
  Vec3<S> second_at{0, 0, 1};  ///< the second one
};

/// Searches pairs of members of two sets for `value(a, b)` above `bound`: b at random, a by `falsify`, then each in
/// turn with the other kept. `search.samples` directions in all.
template <std::floating_point S, class Value>
[[nodiscard]] PairFalsification<S> falsify(const DirectionSet<S>& first, const DirectionSet<S>& second, S bound,
                                           const Value& value, const FalsifySearch& search = {}) noexcept {
  constexpr std::uint32_t k_starts = 8;
  PairFalsification<S> worst{{bound, S(-1), first.cone.axis}, second.cone.axis};
  FalsifySearch part = search;
  part.samples = std::max(1U, search.samples / (3 * k_starts));
  part.ascents = std::min(1U, search.ascents);
  for (std::uint32_t k = 0; k < k_starts; ++k) {
    IndependentStream<S> stream(search.seed, Stage::test, k, 2);
    PairFalsification<S> pair{{}, detail::random_member(second, stream)};
    for (std::uint32_t turn = 0; turn < 3; ++turn) {
      part.seed = mix_bits(search.seed ^ (std::uint64_t{3 * k + turn} << 40));
      if (turn == 1) {
        const Vec3<S> a = pair.found.at;
        const auto over_second = falsify(
            second, bound, [&](const Vec3<S>& b) { return value(a, b); }, part);
        pair = {{bound, over_second.value, a}, over_second.at};
      } else {
        const Vec3<S> b = pair.second_at;
        pair.found = falsify(
            first, bound, [&](const Vec3<S>& a) { return value(a, b); }, part);
      }
      if (!(pair.found.value <= worst.found.value)) worst = pair;
    }
  }
  return worst;
}

/// Random configurations of a phase function: `known` anywhere, `sampled` drawn by it, next to straight on or back, or
/// anywhere; around either or both, cones or rings of any width, or cones of `half_angle` (rad) if that is positive.
/// `worst_set` of the report is the set around `sampled` or, if only `known` has one, around that; `worst_known` is the
/// direction that was fixed or, of two sets, found.
template <PhaseFunction P, PhaseBounds<P> B>
[[nodiscard]] BoundsReport<typename P::Scalar> falsify_phase(const P& phase, const B& bounds, PhaseSets sets,
                                                             std::uint32_t configurations,
                                                             const FalsifySearch& search = {},
                                                             typename P::Scalar half_angle = 0) noexcept {
  using S = typename P::Scalar;
  BoundsReport<S> report;
  S least_slack = k_infinity<S>;
  double bound_sum = 0;
  double value_sum = 0;
  const auto value = [&](const Vec3<S>& sampled, const Vec3<S>& known) { return phase.eval(sampled, known); };
  for (std::uint32_t i = 0; i < configurations; ++i) {
    IndependentStream<S> stream(search.seed, Stage::test, i, 3);
    const auto random_set = [&](const Vec3<S>& axis) {
      const S outer = half_angle > S(0) ? half_angle : k_pi<S> * std::pow(S(10), S(-4) * stream.next());
      const bool is_cone = half_angle > S(0) || stream.next() < S(0.5);
      return DirectionSet<S>::ring(axis, is_cone ? S(0) : outer * stream.next(), outer);
    };
    const Vec3<S> known = glm::normalize(warp::square_to_sphere(stream.next_2d()));
    Vec3<S> sampled = glm::normalize(warp::square_to_sphere(stream.next_2d()));
    const S kind = stream.next();
    if (kind < S(0.5)) {
      if (const auto drawn = phase.sample(known, stream.next_2d())) sampled = drawn->direction;
    } else if (kind < S(0.75)) {  // straight on or back, and next to it
      const S off = std::pow(S(10), S(-6) * stream.next());
      sampled = glm::normalize((kind < S(0.625) ? known : -known) + off * sampled);
    }
    const auto set = random_set(sets == PhaseSets::known ? known : sampled);
    FalsifySearch one = search;
    one.seed = mix_bits(search.seed ^ (std::uint64_t{i} << 20));
    PairFalsification<S> pair;
    if (sets == PhaseSets::sampled) {
      pair.second_at = known;
      pair.found = falsify(
          set, bounds.sup_phase(phase, set, known), [&](const Vec3<S>& w) { return value(w, known); }, one);
    } else if (sets == PhaseSets::known) {
      pair.second_at = sampled;
      pair.found = falsify(
          set, bounds.sup_phase(phase, sampled, set), [&](const Vec3<S>& w) { return value(sampled, w); }, one);
    } else {
      const auto known_set = random_set(known);
      pair = falsify(set, known_set, bounds.sup_phase(phase, set, known_set), value, one);
    }
    ++report.configurations;
    report.refuted += pair.found.is_refuted() ? 1 : 0;
    if (!(pair.found.slack() >= least_slack)) {
      least_slack = pair.found.slack();
      report.worst = pair.found;
      report.worst_set = set;
      report.worst_known = pair.second_at;
    }
    if (pair.found.bound < k_infinity<S>) {
      bound_sum += static_cast<double>(pair.found.bound);
      value_sum += static_cast<double>(pair.found.value);
    } else {
      ++report.infinite;
    }
  }
  const double finite = std::max(1.0, static_cast<double>(configurations - report.infinite));
  report.mean_bound = bound_sum / finite;
  report.mean_value = value_sum / finite;
  return report;
}

}  // namespace manylight
