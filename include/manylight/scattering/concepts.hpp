// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <optional>

#include "manylight/core/direction_set.hpp"
#include "manylight/core/interval_math.hpp"
#include "manylight/core/rgb_interval.hpp"
#include "manylight/core/spectrum.hpp"
#include "manylight/core/vector.hpp"

namespace manylight {

/// Which way a subpath is traced. `eye`: `wo` is known and `wi` is sampled; `light`: `wi` is known, `wo` is sampled.
enum class Walk { eye, light };

/// A direction drawn at a vertex.
template <std::floating_point S>
struct DirectionSample {
  Vec3<S> direction;      ///< local unit vector away from the vertex: `wi` in an eye walk, `wo` in a light walk
  S pdf = S(0);           ///< density, sr^-1; of a delta event its discrete probability
  bool is_delta = false;  ///< the direction is the only one that its lobe allows
  /// Delta events only: f |cos| / pdf of the event, including the radiance factor (eta_wo / eta_wi)^2 of refraction in
  /// an eye walk (eta on the side of that direction) and without it in a light walk.
  Rgb<S> delta_weight{0};
};

/// Scattering at one surface point, in the local shading frame (z = shading normal n_s). Contract:
///  - all directions are unit and point away from the vertex, `wi` towards the light, `wo` towards the eye; the roles
///    never swap, reciprocity is not assumed;
///  - `eval(wi, wo)`: the BSDF f, sr^-1, WITHOUT any cosine, without its delta part, 0 outside the lobes' sides;
///    finite wherever |wi.z| and |wo.z| are positive; never NaN, never negative;
///  - `sample(known, walk, u_lobe, u)`: draws the other direction (see `Walk`), from three variates in [0,1);
///    none if the draw falls outside the lobe (its probability is the missing mass of the pdf);
///  - `pdf(known, sampled, walk)`: solid-angle density of `sample` for non-delta events, sr^-1; integrates to at most
///  1;
///  - `albedo()`: per channel, the sum of the non-delta lobes' albedos at normal incidence: positive wherever eval can
///    be. It only normalises patterns (M, D); it need not be exact;
///  - `is_delta()`: eval is zero for all pairs (mirror, smooth glass): such a vertex is never connected.
/// Materials are small values (copied into every vertex); all members are const, noexcept, cheap, thread-safe.
template <class M>
concept Material = std::copyable<M> && requires(const M& m, const Vec3<typename M::Scalar>& w, Walk walk,
                                                typename M::Scalar u, const Vec2<typename M::Scalar>& u2) {
  typename M::Scalar;
  { m.eval(w, w) } -> std::same_as<Rgb<typename M::Scalar>>;
  { m.sample(w, walk, u, u2) } -> std::same_as<std::optional<DirectionSample<typename M::Scalar>>>;
  { m.pdf(w, w, walk) } -> std::same_as<typename M::Scalar>;
  { m.albedo() } -> std::same_as<Rgb<typename M::Scalar>>;
  { m.is_delta() } -> std::same_as<bool>;
};

/// A material whose `eval` also takes sets of directions for either or both, and then returns ranges that hold every
/// value over them: upper bounds follow from it.
template <class M>
concept SetEvaluable = Material<M> && requires(const M& m, const DirectionSet<typename M::Scalar>& set,
                                               const Vec3<typename M::Scalar>& w) {
  { m.eval(set, w) } -> std::same_as<RgbInterval<typename M::Scalar>>;
  { m.eval(w, set) } -> std::same_as<RgbInterval<typename M::Scalar>>;
  { m.eval(set, set) } -> std::same_as<RgbInterval<typename M::Scalar>>;
};

/// `m.eval(wi, wo)` of vectors or sets; of a material that does not take sets, anything from 0 to infinity.
template <Material M, LocalDirection<typename M::Scalar> Wi, LocalDirection<typename M::Scalar> Wo>
[[nodiscard]] inline auto eval_over(const M& m, const Wi& wi, const Wo& wo) noexcept {
  using S = typename M::Scalar;
  if constexpr (SetEvaluable<M> || std::is_same_v<PatternScalar<Wi, Wo, S>, S>) {
    return m.eval(wi, wo);
  } else {
    const Interval<S> anything(S(0), k_infinity<S>);
    return RgbInterval<S>(anything, anything, anything);
  }
}

/// The same of the BSDF times |wi.z|: `m.eval_cos(wi, wo)` if the material has it, which it should where the range of
/// the product is much closer than the product of the ranges.
template <Material M, LocalDirection<typename M::Scalar> Wi, LocalDirection<typename M::Scalar> Wo>
[[nodiscard]] inline auto eval_cos_over(const M& m, const Wi& wi, const Wo& wo) noexcept {
  if constexpr (requires { m.eval_cos(wi, wo); }) {
    return m.eval_cos(wi, wo);
  } else {
    return eval_over(m, wi, wo) * PatternScalar<Wi, Wo, typename M::Scalar>(abs(wi.z));
  }
}

/// A material may state `static constexpr bool k_isotropic = true`: a rotation of both directions about the normal
/// never changes `eval`, whatever its parameters. Its vertices then store a normal instead of a frame.
template <class M>
inline constexpr bool k_is_isotropic = requires {
  requires M::k_isotropic;
};

/// How strongly a material scatters light that meets `known`, delta lobes included: what a mixture chooses its lobes
/// by. The material's own `sampling_weight(known)` if it has one, else the largest channel of its albedo.
template <Material M>
[[nodiscard]] inline typename M::Scalar sampling_weight(const M& material,
                                                        const Vec3<typename M::Scalar>& known) noexcept {
  if constexpr (requires { material.sampling_weight(known); }) {
    return material.sampling_weight(known);
  } else {
    return max_channel(material.albedo());
  }
}

}  // namespace manylight
