// SPDX-License-Identifier: Apache-2.0
#pragma once

// Upper bounds of a material or a phase function over sets of directions. Where neither it nor its user states one, it
// follows from the very `eval` that renders, which is a template over its directions [theory 6.6].

#include <algorithm>

#include "manylight/core/direction_set.hpp"
#include "manylight/core/rgb_interval.hpp"
#include "manylight/scattering/any_of.hpp"
#include "manylight/scattering/any_phase.hpp"
#include "manylight/scattering/concepts.hpp"
#include "manylight/scattering/mixture.hpp"
#include "manylight/scattering/phase_concepts.hpp"

namespace manylight {

/// Bounds of a BSDF's largest channel over a set of directions; may be infinite.
template <std::floating_point S>
struct PatternSup {
  S eval = S(0);      ///< of f, sr^-1
  S eval_cos = S(0);  ///< of f |wi.z|, sr^-1
};

/// A bound written for a material that cannot be changed. Specialise it with
///   static S sup_eval(const M& m, const Wi& wi, const Wo& wo);       // >= f, sr^-1
///   static S sup_eval_cos(const M& m, const Wi& wi, const Wo& wo);   // optional: >= f |wi.z|, sr^-1
/// for a DirectionSet and a vector in either place. A material of one's own states them as members instead.
template <Material M>
struct MaterialBound {};

/// The same for a phase function that cannot be changed. Specialise it with
///   static S sup_eval(const P& p, const W& sampled, const V& known);   // >= f_p, sr^-1
/// for a DirectionSet and a vector in either place and for two sets.
template <PhaseFunction P>
struct PhaseBound {};

namespace detail {
template <class M, class Wi, class Wo>
concept StatesOwnBound = requires(const M& m, const Wi& wi, const Wo& wo) {
  { m.sup_eval(wi, wo) } -> std::convertible_to<typename M::Scalar>;
};
template <class M, class Wi, class Wo>
concept HasBoundOfUser = requires(const M& m, const Wi& wi, const Wo& wo) {
  { MaterialBound<M>::sup_eval(m, wi, wo) } -> std::convertible_to<typename M::Scalar>;
};

template <class P, class W, class V>
concept HasPhaseBoundOfUser = requires(const P& p, const W& sampled, const V& known) {
  { PhaseBound<P>::sup_eval(p, sampled, known) } -> std::convertible_to<typename P::Scalar>;
};

/// Largest |z| of the directions.
template <std::floating_point S>
[[nodiscard]] inline S max_abs_z(const Vec3<S>& w) noexcept {
  return std::abs(w.z);
}
template <std::floating_point S>
[[nodiscard]] inline S max_abs_z(const DirectionSet<S>& w) noexcept {
  return std::min(S(1), abs(w.z).hi);
}

template <class M>
inline constexpr bool k_is_any_of = false;
template <class... Ms>
inline constexpr bool k_is_any_of<AnyOf<Ms...>> = true;
template <class P>
inline constexpr bool k_is_any_phase = false;
template <class... Ps>
inline constexpr bool k_is_any_phase<AnyPhase<Ps...>> = true;
template <class M>
inline constexpr bool k_is_mixture = false;
template <class... Ms>
inline constexpr bool k_is_mixture<Mixture<Ms...>> = true;

/// Whether some part brings a bound of its own, so that a mixture's must be the sum of its parts'.
template <class M, class Wi, class Wo>
inline constexpr bool k_has_hand_written_part = StatesOwnBound<M, Wi, Wo> || HasBoundOfUser<M, Wi, Wo>;
template <class... Ms, class Wi, class Wo>
inline constexpr bool k_has_hand_written_part<AnyOf<Ms...>, Wi, Wo> = (k_has_hand_written_part<Ms, Wi, Wo> || ...);
template <class... Ms, class Wi, class Wo>
inline constexpr bool k_has_hand_written_part<Mixture<Ms...>, Wi, Wo> = (k_has_hand_written_part<Ms, Wi, Wo> || ...);

/// Weighted sum over a mixture's lobes of `sup(lobe)`; a lobe of weight 0 is skipped, so that its infinite bound makes
/// no NaN.
template <class M, class Sup>
[[nodiscard]] inline PatternSup<typename M::Scalar> sum_of_parts(const M& mixture, const Sup& sup) noexcept {
  PatternSup<typename M::Scalar> sum;
  mixture.for_each([&](const auto& part) {
    if (!(part.weight > 0)) return;
    const auto s = sup(part.lobe);
    sum.eval += part.weight * s.eval;
    sum.eval_cos += part.weight * s.eval_cos;
  });
  return sum;
}
}  // namespace detail

/// Bounds of any material, chosen at compile time: the material's own `sup_eval`, its user's MaterialBound, else what
/// intervals make of `eval`. A material whose `eval` takes no sets is bounded by infinity, which is always right:
/// limits of the weighting then bound the pair.
struct AutomaticBounds {
  /// `wi`, `wo`: vectors or sets, at least one a set.
  template <Material M, LocalDirection<typename M::Scalar> Wi, LocalDirection<typename M::Scalar> Wo>
  [[nodiscard]] PatternSup<typename M::Scalar> sup(const M& m, const Wi& wi, const Wo& wo) const noexcept {
    if constexpr (detail::StatesOwnBound<M, Wi, Wo>) {
      return with_cosine(m, wi, wo, m.sup_eval(wi, wo));
    } else if constexpr (detail::HasBoundOfUser<M, Wi, Wo>) {
      return with_cosine(MaterialBound<M>{}, wi, wo, MaterialBound<M>::sup_eval(m, wi, wo), m);
    } else if constexpr (detail::k_is_any_of<M>) {
      return m.visit([&](const auto& part) { return sup(part, wi, wo); });
    } else if constexpr (detail::k_is_mixture<M> && detail::k_has_hand_written_part<M, Wi, Wo>) {
      return detail::sum_of_parts(m, [&](const auto& part) { return sup(part, wi, wo); });
    } else {
      return {max_channel(eval_over(m, wi, wo)).hi, max_channel(eval_cos_over(m, wi, wo)).hi};
    }
  }

  /// Of a phase function, chosen alike: >= f_p, sr^-1, over all pairs of the two. Vectors or sets, world frame, at
  /// least one a set.
  template <PhaseFunction P, LocalDirection<typename P::Scalar> W, LocalDirection<typename P::Scalar> V>
  [[nodiscard]] typename P::Scalar sup_phase(const P& p, const W& sampled, const V& known) const noexcept {
    if constexpr (detail::StatesOwnBound<P, W, V>) {
      return p.sup_eval(sampled, known);
    } else if constexpr (detail::HasPhaseBoundOfUser<P, W, V>) {
      return PhaseBound<P>::sup_eval(p, sampled, known);
    } else if constexpr (detail::k_is_any_phase<P>) {
      return p.visit([&](const auto& part) { return sup_phase(part, sampled, known); });
    } else {
      return Interval<typename P::Scalar>(phase_over(p, sampled, known)).hi;
    }
  }

 private:
  template <class S, class Wi>
  [[nodiscard]] static S times_cosine(S f, const Wi& wi) noexcept {
    const S cosine = detail::max_abs_z(wi);
    return cosine > S(0) ? f * cosine : S(0);  // f may be infinite
  }
  template <class Bounds, class Wi, class Wo, class S, class... M>
  [[nodiscard]] static PatternSup<S> with_cosine(const Bounds& bounds, const Wi& wi, const Wo& wo, S f,
                                                 const M&... m) noexcept {
    if constexpr (requires { bounds.sup_eval_cos(m..., wi, wo); }) {
      return {f, bounds.sup_eval_cos(m..., wi, wo)};
    } else {
      return {f, times_cosine(f, wi)};
    }
  }
};

/// What bounds materials for the clusters' trees: AutomaticBounds, AnalyticBounds, or a user's type.
template <class B, class M>
concept PatternBounds = requires(const B& bounds, const M& m, const DirectionSet<typename M::Scalar>& set,
                                 const Vec3<typename M::Scalar>& w) {
  { bounds.sup(m, set, w) } -> std::same_as<PatternSup<typename M::Scalar>>;
  { bounds.sup(m, w, set) } -> std::same_as<PatternSup<typename M::Scalar>>;
};

/// What bounds phase functions: the same policies.
template <class B, class P>
concept PhaseBounds = requires(const B& bounds, const P& p, const DirectionSet<typename P::Scalar>& set,
                               const Vec3<typename P::Scalar>& w) {
  { bounds.sup_phase(p, set, w) } -> std::same_as<typename P::Scalar>;
  { bounds.sup_phase(p, w, set) } -> std::same_as<typename P::Scalar>;
  { bounds.sup_phase(p, set, set) } -> std::same_as<typename P::Scalar>;
};

}  // namespace manylight
