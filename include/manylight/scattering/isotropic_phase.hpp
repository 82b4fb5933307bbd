// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "manylight/core/warp.hpp"
#include "manylight/scattering/phase_concepts.hpp"

namespace manylight {

/// Equal scattering into all directions, f_p = 1 / (4 pi).
template <std::floating_point S>
struct IsotropicPhase {
  using Scalar = S;
  static constexpr bool k_isotropic_density = true;
  static constexpr S k_value = k_inv_pi<S> / S(4);

  /// Of vectors the phase function, sr^-1; of direction sets the range of its values over them.
  template <LocalDirection<S> W = Vec3<S>, LocalDirection<S> V = Vec3<S>>
  [[nodiscard]] PatternScalar<W, V, S> eval(const W& /*sampled*/, const V& /*known*/) const noexcept {
    return k_value;
  }
  [[nodiscard]] std::optional<PhaseSample<S>> sample(const Vec3<S>& /*known*/, const Vec2<S>& u) const noexcept {
    return PhaseSample<S>{glm::normalize(warp::square_to_sphere(u)), k_value};
  }
  [[nodiscard]] S pdf(const Vec3<S>& /*sampled*/, const Vec3<S>& /*known*/) const noexcept { return k_value; }
  [[nodiscard]] S projected_area(const Vec3<S>& /*w*/) const noexcept { return S(0.5); }
};

static_assert(SetEvaluablePhase<IsotropicPhase<float>> && SetEvaluablePhase<IsotropicPhase<double>>);

}  // namespace manylight
