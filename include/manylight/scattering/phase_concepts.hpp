// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <optional>

#include "manylight/core/direction_set.hpp"
#include "manylight/core/rgb_interval.hpp"
#include "manylight/core/vector.hpp"

namespace manylight {

/// A direction drawn in a medium.
template <std::floating_point S>
struct PhaseSample {
  Vec3<S> direction;  ///< unit vector away from the vertex, world frame
  S pdf = S(0);       ///< solid-angle density, sr^-1
};

/// Scattering at a point of a medium. Contract:
///  - all directions are unit, in the world frame, and point away from the vertex: straight on is `sampled == -known`;
///  - `eval(sampled, known)`: the phase function f_p, sr^-1, finite for all pairs; never NaN, never negative. Its
///    integral over `sampled` is 1 for each `known`, less what the model states to lose, never more;
///  - reciprocity: projected_area(known) eval(sampled, known) stays the same if the two are exchanged, so that light
///  and
///    eye subpaths see one medium [Jakob 2010];
///  - `sample(known, u)`: draws `sampled` from two variates in [0, 1); none if the draw cannot be used;
///  - `pdf(sampled, known)`: solid-angle density of `sample`, sr^-1; integrates to at most 1;
///  - `projected_area(w)`: factor of direction in the medium's coefficients, sigma_t(x, w) = 2 density
///  projected_area(w):
///    the mean of |w . m| over the particles' normals m, 1/2 where all directions are equal.
/// Phase functions are small values; all members are const, noexcept, cheap, thread-safe.
template <class P>
concept PhaseFunction = std::copyable<P> &&
    requires(const P& p, const Vec3<typename P::Scalar>& w, const Vec2<typename P::Scalar>& u) {
  typename P::Scalar;
  { p.eval(w, w) }
  noexcept->std::same_as<typename P::Scalar>;
  { p.sample(w, u) }
  noexcept->std::same_as<std::optional<PhaseSample<typename P::Scalar>>>;
  { p.pdf(w, w) }
  noexcept->std::same_as<typename P::Scalar>;
  { p.projected_area(w) }
  noexcept->std::same_as<typename P::Scalar>;
};

/// A phase function whose `eval` also takes sets of directions for either or both, and then returns ranges that hold
/// every value over them: upper bounds follow from it.
template <class P>
concept SetEvaluablePhase = PhaseFunction<P> &&
    requires(const P& p, const DirectionSet<typename P::Scalar>& set, const Vec3<typename P::Scalar>& w) {
  { p.eval(set, w) }
  noexcept->std::same_as<Interval<typename P::Scalar>>;
  { p.eval(w, set) }
  noexcept->std::same_as<Interval<typename P::Scalar>>;
  { p.eval(set, set) }
  noexcept->std::same_as<Interval<typename P::Scalar>>;
};

/// `p.eval(sampled, known)` of vectors or sets; of a phase function that does not take sets, anything from 0 to
/// infinity.
template <PhaseFunction P, LocalDirection<typename P::Scalar> W, LocalDirection<typename P::Scalar> V>
[[nodiscard]] inline auto phase_over(const P& p, const W& sampled, const V& known) noexcept {
  using S = typename P::Scalar;
  if constexpr (SetEvaluablePhase<P> || std::is_same_v<PatternScalar<W, V, S>, S>) {
    return p.eval(sampled, known);
  } else {
    return Interval<S>(S(0), k_infinity<S>);
  }
}

/// A phase function may state `static constexpr bool k_isotropic_density = true`: its projected area is 1/2 in all
/// directions, and the medium's coefficients do not depend on them.
template <class P>
inline constexpr bool k_has_isotropic_density = requires {
  requires P::k_isotropic_density;
};

}  // namespace manylight
