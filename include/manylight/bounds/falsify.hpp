// SPDX-License-Identifier: Apache-2.0
#pragma once

// Tries to refute a bound: random directions of the set, then local ascents from the best of them. A bound that
// survives is not proved, but one that is 1 % too low where the pattern peaks does not survive. For authors of
// materials and of bounds; not for rendering.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "manylight/bounds/automatic.hpp"
#include "manylight/core/frame.hpp"
#include "manylight/core/sampler.hpp"
#include "manylight/core/warp.hpp"

namespace manylight {

/// How long to search.
struct FalsifySearch {
  std::uint32_t samples = 1000;  ///< random directions per set
  std::uint32_t ascents = 20;    ///< local ascents per set, each from the best of samples / ascents of them
  std::uint64_t seed = 0;
};

/// The largest value found in a set.
template <std::floating_point S>
struct Falsification {
  S bound = S(0);
  S value = S(0);       ///< largest found; above `bound`: refuted
  Vec3<S> at{0, 0, 1};  ///< where
  [[nodiscard]] bool is_refuted() const noexcept { return !(value <= bound); }
  /// Bound over the largest value found, at least the true slack; infinite where no positive value was found.
  [[nodiscard]] S slack() const noexcept { return value > S(0) ? bound / value : k_infinity<S>; }
};

namespace detail {
/// A direction of the set; half of them on one of its rims, where patterns peak.
template <std::floating_point S, class Stream>
[[nodiscard]] inline Vec3<S> random_member(const DirectionSet<S>& set, Stream& stream) noexcept {
  const S inner = std::atan2(set.sin_inner, set.cos_inner);
  const S outer = set.cone.half_angle();
  const S kind = stream.next();
  const S u = stream.next();
  const S angle = kind < S(0.25) ? outer : kind < S(0.5) ? inner : inner + (outer - inner) * u;
  const S phi = S(2) * k_pi<S> * stream.next();
  const Vec3<S> local(std::sin(angle) * std::cos(phi), std::sin(angle) * std::sin(phi), std::cos(angle));
  return glm::normalize(Frame<S>(set.cone.axis).to_world(local));
}
/// Whether `w` lies in the set, without the margin for rounding that its bounds have.
template <std::floating_point S>
[[nodiscard]] inline bool is_member(const DirectionSet<S>& set, const Vec3<S>& w) noexcept {
  const S angle = std::atan2(glm::length(glm::cross(set.cone.axis, w)), glm::dot(set.cone.axis, w));
  return angle <= set.cone.half_angle() && angle >= std::atan2(set.sin_inner, set.cos_inner);
}
/// Steps in random tangent directions that are kept if they rise and halved in length if they do not.
template <std::floating_point S, class Value, class Stream>
void ascend(const DirectionSet<S>& set, const Value& value, Stream& stream, Falsification<S>& best) noexcept {
  S step = std::min(S(1), set.cone.half_angle() / S(2));
  for (int i = 0; i < 60 && step > S(16) * std::numeric_limits<S>::epsilon(); ++i) {
    const S phi = S(2) * k_pi<S> * stream.next();
    const Frame<S> frame(best.at);
    const Vec3<S> w = glm::normalize(best.at + (frame.s * std::cos(phi) + frame.t * std::sin(phi)) * step);
    const S v = is_member(set, w) ? value(w) : S(-1);
    if (v > best.value) {
      best.value = v;
      best.at = w;
    } else {
      step *= S(0.7);
    }
  }
}
}  // namespace detail

/// Searches `set`, a cone or a ring, for directions at which `value(w)` is above `bound`.
template <std::floating_point S, class Value>
[[nodiscard]] Falsification<S> falsify(const DirectionSet<S>& set, S bound, const Value& value,
                                       const FalsifySearch& search = {}) noexcept {
  Falsification<S> worst{bound, S(-1), set.cone.axis};
  const std::uint32_t starts = std::max(search.ascents, 1U);
  for (std::uint32_t k = 0; k < starts; ++k) {
    IndependentStream<S> stream(search.seed, Stage::test, k, 0);
    Falsification<S> best{bound, S(-1), set.cone.axis};
    for (std::uint32_t i = 0; i < (search.samples + starts - 1) / starts; ++i) {
      const Vec3<S> w = detail::random_member(set, stream);
      const S v = value(w);
      if (!(v <= best.value)) best = {bound, v, w};  // a NaN is kept, and refutes
    }
    if (search.ascents > 0 && best.value > S(0)) detail::ascend(set, value, stream, best);
    if (!(best.value <= worst.value)) worst = best;
  }
  worst.value = std::max(worst.value, S(0));
  return worst;
}

/// What a search over a material's bounds found.
template <std::floating_point S>
struct BoundsReport {
  std::uint32_t configurations = 0;
  std::uint32_t refuted = 0;     ///< configurations with a value above its bound
  Falsification<S> worst;        ///< the one with the smallest slack
  DirectionSet<S> worst_set;     ///< its directions
  Vec3<S> worst_known{0, 0, 1};  ///< its fixed direction: `wo`, or `wi` where `wo` was the set
  double mean_bound = 0;         ///< of finite bounds, sr^-1
  double mean_value = 0;         ///< of the largest values found there: mean_bound / mean_value is the mean slack
  std::uint32_t infinite = 0;    ///< configurations without a finite bound
  [[nodiscard]] double slack() const noexcept { return mean_value > 0 ? mean_bound / mean_value : 1; }
};

/// Random configurations of `material`, each judged by `falsify`: one direction fixed, the other in a cone or ring of
/// any width, often around the mirror direction; of f (wi or wo in the set) and of f |wi.z|. `half_angle` (rad) fixes
/// the sets' width; 0: any.
template <Material M, PatternBounds<M> B>
[[nodiscard]] BoundsReport<typename M::Scalar> falsify_bounds(const M& material, const B& bounds,
                                                              std::uint32_t configurations,
                                                              const FalsifySearch& search = {},
                                                              typename M::Scalar half_angle = 0) noexcept {
  using S = typename M::Scalar;
  BoundsReport<S> report;
  S least_slack = k_infinity<S>;
  double bound_sum = 0;
  double value_sum = 0;
  for (std::uint32_t i = 0; i < configurations; ++i) {
    IndependentStream<S> stream(search.seed, Stage::test, i, 1);
    // Grazing ones, too: cosines down to 1e-3.
    const S cosine = std::pow(S(10), S(-3) * sqr(stream.next()));
    const S phi = S(2) * k_pi<S> * stream.next();
    const S sine = std::sqrt(S(1) - cosine * cosine);
    const Vec3<S> known = glm::normalize(Vec3<S>(sine * std::cos(phi), sine * std::sin(phi), cosine));
    const S outer = half_angle > S(0) ? half_angle : k_pi<S> * std::pow(S(10), S(-4) * stream.next());
    const S inner = half_angle > S(0) || stream.next() < S(0.5) ? S(0) : outer * stream.next();
    const Vec3<S> axis =
        stream.next() < S(0.5)
            ? warp::square_to_sphere(stream.next_2d())
            : glm::normalize(mirror(known) + outer * stream.next() * warp::square_to_sphere(stream.next_2d()));
    const auto set = DirectionSet<S>::ring(axis, inner, outer);
    FalsifySearch one = search;
    one.seed = mix_bits(search.seed ^ (std::uint64_t{i} << 20));
    const PatternSup<S> over_wi = bounds.sup(material, set, known);
    const Falsification<S> found[] = {
        falsify(
            set, over_wi.eval, [&](const Vec3<S>& w) { return max_channel(material.eval(w, known)); }, one),
        falsify(
            set, over_wi.eval_cos,
            [&](const Vec3<S>& w) { return max_channel(material.eval(w, known)) * std::abs(w.z); }, one),
        falsify(
            set, bounds.sup(material, known, set).eval,
            [&](const Vec3<S>& w) { return max_channel(material.eval(known, w)); }, one)};
    ++report.configurations;
    bool refuted = false;
    for (const Falsification<S>& f : found) {
      refuted = refuted || f.is_refuted();
      if (!(f.slack() >= least_slack)) {
        least_slack = f.slack();
        report.worst = f;
        report.worst_set = set;
        report.worst_known = known;
      }
    }
    report.refuted += refuted ? 1 : 0;
    if (over_wi.eval_cos < k_infinity<S>) {
      bound_sum += static_cast<double>(over_wi.eval_cos);
      value_sum += static_cast<double>(found[1].value);
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
