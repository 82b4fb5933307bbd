// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a cluster of sensors knows of its materials: bounds over rings around the mirror direction, a few numbers that
// merge by their maxima. They take about ten bounds per sensor; a cube-map would take some hundred.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "manylight/bounds/automatic.hpp"
#include "manylight/scattering/phase_concepts.hpp"

namespace manylight {

/// Angles off the mirror direction at which a profile is tabulated, rad.
template <std::floating_point S>
inline constexpr std::array<S, 8> k_profile_angles{S(0), S(0.01), S(0.025), S(0.06), S(0.14), S(0.3), S(0.6), S(1.2)};

/// Their cosines, rounded down: no angle whose cosine is at most one of them is smaller than its angle. And sines.
template <std::floating_point S>
inline const std::array<detail::Turn<S>, 8> k_profile_turns = [] {
  std::array<detail::Turn<S>, 8> turns{};
  turns[0] = {S(1), S(0)};
  for (std::size_t i = 1; i < turns.size(); ++i) {
    constexpr S k_down = S(1) - S(2) * std::numeric_limits<S>::epsilon();
    turns[i] = {std::cos(k_profile_angles<S>[i]) * k_down, std::sin(k_profile_angles<S>[i])};
  }
  return turns;
}();

/// Bound of M = f |wi.z| by two angles: that of wi to the lobe's axis and that to the normal.
template <std::floating_point S>
struct PatternProfile {
  std::array<S, k_profile_angles<S>.size()> eval{};  ///< of f at all angles >= k_profile_angles[i] off the axis, sr^-1
  std::array<S, k_profile_angles<S>.size()> eval_cos{};  ///< of f |wi.z|, the same
  bool is_flat = true;                                   ///< the same at all angles: nobody needs the axis
  bool has_both_sides = false;                           ///< f may be positive for wi.z < 0

  /// The same at all angles: f, sr^-1, with the cosine or, if every direction counts as the normal, without.
  [[nodiscard]] static PatternProfile flat(S f) noexcept {
    PatternProfile profile;
    profile.eval.fill(f);
    profile.eval_cos.fill(f);
    return profile;
  }
  /// Bound at all wi with cosines of at most `to_axis` with the lobe's axis and at most `to_normal`, positive, with the
  /// normal (or its opposite, if f has both sides).
  [[nodiscard]] S sup(S to_axis, S to_normal) const noexcept {
    std::size_t i = eval.size() - 1;
    while (i > 0 && to_axis > k_profile_turns<S>[i].cosine) --i;
    return std::min(eval[i] * to_normal, eval_cos[i]);
  }
  void extend(const PatternProfile& other) noexcept {
    for (std::size_t i = 0; i < eval.size(); ++i) {
      eval[i] = std::max(eval[i], other.eval[i]);
      eval_cos[i] = std::max(eval_cos[i], other.eval_cos[i]);
    }
    is_flat = is_flat && other.is_flat;
    has_both_sides = has_both_sides || other.has_both_sides;
  }
  void scale(S factor) noexcept {
    for (std::size_t i = 0; i < eval.size(); ++i) {
      eval[i] = factor > S(0) ? eval[i] * factor : S(0);  // it may be infinite
      eval_cos[i] = factor > S(0) ? eval_cos[i] * factor : S(0);
    }
  }
};

/// Profile of `m` for the local direction `wo`, by `bounds`.
template <Material M, PatternBounds<M> B>
[[nodiscard]] inline PatternProfile<typename M::Scalar> pattern_profile(const B& bounds, const M& m,
                                                                        const Vec3<typename M::Scalar>& wo) noexcept {
  using S = typename M::Scalar;
  using Set = DirectionSet<S>;
  constexpr S k_flat = S(0.8);  // a lobe that falls by less is not worth seven more bounds and an axis
  PatternProfile<S> profile;
  const PatternSup<S> all = bounds.sup(m, Set(), wo);
  if (!(all.eval > S(0))) return profile;
  profile.has_both_sides = bounds.sup(m, Set::hemisphere(false), wo).eval > S(0);
  const Vec3<S> axis = mirror(wo);
  const std::array<detail::Turn<S>, 8>& turns = k_profile_turns<S>;
  PatternSup<S> beyond = bounds.sup(m, Set({axis, S(-1), S(0)}, turns[7].cosine, turns[7].sine), wo);
  profile.is_flat = !(beyond.eval < k_flat * all.eval);
  if (profile.is_flat) {
    profile.eval.fill(all.eval);
    profile.eval_cos.fill(all.eval_cos);
    return profile;
  }
  const auto ring = [&](std::size_t i, std::size_t j) {
    return bounds.sup(m, Set({axis, turns[j].cosine, turns[j].sine}, turns[i].cosine, turns[i].sine), wo);
  };
  const PatternSup<S> core = ring(0, 1);
  for (std::size_t i = profile.eval.size(); i-- > 0;) {
    if (i < 7) {
      // Where the lobe has nearly reached its height, one bound serves all the rest.
      const bool is_top = !(beyond.eval < k_flat * core.eval || beyond.eval_cos < k_flat * core.eval_cos);
      const PatternSup<S> next = is_top ? ring(0, i + 1) : i == 0 ? core : ring(i, i + 1);
      beyond = {std::max(beyond.eval, next.eval), std::max(beyond.eval_cos, next.eval_cos)};
      if (is_top) {
        std::fill_n(profile.eval.begin(), i + 1, std::min(all.eval, beyond.eval));
        std::fill_n(profile.eval_cos.begin(), i + 1, std::min(all.eval_cos, beyond.eval_cos));
        break;
      }
    }
    profile.eval[i] = std::min(all.eval, beyond.eval);
    profile.eval_cos[i] = std::min(all.eval_cos, beyond.eval_cos);
  }
  return profile;
}

/// Profile of a phase function for the known direction, around the opposite one; there is no cosine. `bounds` as above.
template <PhaseFunction P, class B>
[[nodiscard]] inline PatternProfile<typename P::Scalar> phase_profile(const B& bounds, const P& phase,
                                                                      const Vec3<typename P::Scalar>& known) noexcept {
  using S = typename P::Scalar;
  using Set = DirectionSet<S>;
  const std::array<detail::Turn<S>, 8>& turns = k_profile_turns<S>;
  PatternProfile<S> profile;
  S beyond = bounds.sup_phase(phase, Set({-known, S(-1), S(0)}, turns[7].cosine, turns[7].sine), known);
  const S least = beyond;
  for (std::size_t i = profile.eval.size(); i-- > 0;) {
    if (i < 7) {
      const Set ring({-known, turns[i + 1].cosine, turns[i + 1].sine}, turns[i].cosine, turns[i].sine);
      beyond = std::max(beyond, bounds.sup_phase(phase, ring, known));
    }
    profile.eval[i] = profile.eval_cos[i] = beyond;
  }
  profile.is_flat = !(least < beyond);
  return profile;
}

/// Bound of D of a light for its local direction `wi`, over all `wo`: D <= peak |wo.n_g|.
template <std::floating_point S>
struct LightPeak {
  S peak = S(0);                ///< of f, sr^-1; may be infinite
  bool has_both_sides = false;  ///< f may be positive for wo.z < 0
};
template <Material M, PatternBounds<M> B>
[[nodiscard]] inline LightPeak<typename M::Scalar> light_peak(const B& bounds, const M& m,
                                                              const Vec3<typename M::Scalar>& wi) noexcept {
  using Set = DirectionSet<typename M::Scalar>;
  const auto peak = bounds.sup(m, wi, Set()).eval;
  return {peak, peak > 0 && bounds.sup(m, wi, Set::hemisphere(false)).eval > 0};
}

}  // namespace manylight
