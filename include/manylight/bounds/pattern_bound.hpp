// SPDX-License-Identifier: Apache-2.0
#pragma once

// Upper bounds of a material's pattern for one fixed direction. A material may bring its own (members below); where it
// brings none, the bound is infinite, which is always right: the clamp of the weighting then bounds the pair.
//   sup_eval_cos_wo(wo)            >= f(wi, wo) |wo.z|                      for every wi, largest channel, sr^-1
//   diffuse_albedo(), sup_gloss_beyond(wo, theta):
//     f(wi, wo) |wi.z| <= diffuse_albedo() max(0, wi.z)/pi + sup_gloss_beyond(wo, angle(wi, mirror of wo))

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "manylight/core/spectrum.hpp"
#include "manylight/scattering/concepts.hpp"

namespace manylight {

template <class M>
concept HasSupEvalCosWo = requires(const M& m, const Vec3<typename M::Scalar>& w) {
  { m.sup_eval_cos_wo(w) } -> std::convertible_to<typename M::Scalar>;
};

template <class M>
concept HasGlossProfile = requires(const M& m, const Vec3<typename M::Scalar>& w, typename M::Scalar theta) {
  { m.diffuse_albedo() } -> std::convertible_to<typename M::Scalar>;
  { m.sup_gloss_beyond(w, theta) } -> std::convertible_to<typename M::Scalar>;
};

/// Angles off the mirror direction at which a gloss profile is tabulated, rad.
template <std::floating_point S>
inline constexpr std::array<S, 8> k_profile_angles{S(0),    S(0.01), S(0.025), S(0.06),
                                                   S(0.14), S(0.3),  S(0.6),   S(1.2)};

/// Their cosines, rounded down: no angle whose cosine is below one of them is smaller than its angle.
template <std::floating_point S>
inline const std::array<S, 8> k_profile_cosines = [] {
  std::array<S, 8> cosines{};
  constexpr S k_down = S(1) - S(2) * std::numeric_limits<S>::epsilon();
  for (std::size_t i = 1; i < cosines.size(); ++i) cosines[i] = std::cos(k_profile_angles<S>[i]) * k_down;
  cosines[0] = S(1);
  return cosines;
}();

/// values[i] bounds the gloss at every angle >= k_profile_angles[i] off the lobe's axis, sr^-1.
template <std::floating_point S>
struct GlossProfile {
  std::array<S, k_profile_angles<S>.size()> values{};

  /// Bound at all angles whose cosine is at most `cosine`.
  [[nodiscard]] S beyond(S cosine) const noexcept {
    std::size_t i = values.size() - 1;
    while (i > 0 && cosine > k_profile_cosines<S>[i]) --i;
    return values[i];
  }
  void extend(const GlossProfile& other) noexcept {
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = std::max(values[i], other.values[i]);
  }
};

/// Bound of f |wi.z| for a fixed `wo`: diffuse * max(0, wi.z) / pi + gloss.
template <std::floating_point S>
struct PatternBound {
  S diffuse = S(0);
  bool has_gloss = false;
  bool has_both_sides = false;  ///< f may be positive for wi and wo of opposite sides
  GlossProfile<S> gloss{};
};

/// Bound of `m` for the local direction `wo`; infinite where the material brings none.
template <Material M>
[[nodiscard]] inline PatternBound<typename M::Scalar> pattern_bound(const M& m, const Vec3<typename M::Scalar>& wo) {
  using S = typename M::Scalar;
  PatternBound<S> bound;
  if constexpr (HasGlossProfile<M>) {
    bound.diffuse = m.diffuse_albedo();
    for (std::size_t i = 0; i < bound.gloss.values.size(); ++i) {
      bound.gloss.values[i] = m.sup_gloss_beyond(wo, k_profile_angles<S>[i]);
    }
    bound.has_gloss = bound.gloss.values[0] > S(0);
    bound.has_both_sides = scatters_through(m);
  } else {
    bound.has_gloss = true;
    bound.has_both_sides = true;
    bound.gloss.values.fill(k_infinity<S>);
  }
  return bound;
}

/// Bound over all `wi` of f |wo.z|, sr^-1; infinite where the material brings none.
template <Material M>
[[nodiscard]] inline typename M::Scalar sup_eval_cos_wo(const M& m, const Vec3<typename M::Scalar>& wo) {
  if constexpr (HasSupEvalCosWo<M>) {
    return m.sup_eval_cos_wo(wo);
  } else {
    return k_infinity<typename M::Scalar>;
  }
}

}  // namespace manylight
