// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "manylight/core/chord.hpp"
#include "manylight/core/frame.hpp"
#include "manylight/scattering/phase_concepts.hpp"
#include "manylight/scattering/validation.hpp"

namespace manylight {

/// f_p = (1 - g^2) / (4 pi (1 + g^2 - 2 g cos Theta)^(3/2)), Theta the angle by which light is turned: both directions
/// point away from the vertex, hence cos Theta = -sampled . known. [Henyey and Greenstein 1941]
template <std::floating_point S>
struct HenyeyGreenstein {
  using Scalar = S;
  static constexpr bool k_isotropic_density = true;
  S g = S(0);  ///< mean of cos Theta, [-0.999, 0.999]: positive scatters on, negative back

  /// Throws ParameterError.
  void validate() const {
    require(std::abs(g) <= S(0.999), "Henyey-Greenstein g", g, "-0.999 to 0.999 (beyond, nothing but a peak is left)");
  }

  /// Of vectors the phase function, sr^-1; of direction sets the range of its values over them.
  /// 1 + g^2 - 2 g cos Theta = (1 - |g|)^2 + |g| |w - peak|^2 for unit vectors: a sum of squares, which keeps its
  /// digits where the other form cancels.
  template <LocalDirection<S> W = Vec3<S>, LocalDirection<S> V = Vec3<S>>
  [[nodiscard]] PatternScalar<W, V, S> eval(const W& sampled, const V& known) const noexcept {
    const S a = std::abs(g);
    const auto towards = [&](const auto& peak) {
      const PatternScalar<W, V, S> d = sqr(S(1) - a) + a * PatternScalar<W, V, S>(sqr_distance(sampled, peak));
      return PatternScalar<W, V, S>((S(1) - a) * (S(1) + a) * (k_inv_pi<S> / S(4))) / (d * sqrt(d));
    };
    return g > S(0) ? towards(V(-known)) : towards(known);
  }

  /// By inversion [Pharr 2016, section 15.2.3], with 1 - cos Theta in place of cos Theta, so that there is nothing to
  /// divide by at g = 0 and nothing cancels in the peak. A negative g draws about the opposite direction.
  [[nodiscard]] std::optional<PhaseSample<S>> sample(const Vec3<S>& known, const Vec2<S>& u) const noexcept {
    const S a = std::abs(g);
    const S t = S(1) - a + S(2) * a * u.x;
    const S q = (S(1) - a) * (S(1) + a) / t;
    const S versine = std::min(S(2), (S(1) - a) * (S(1) - u.x) * (q + S(1) - a) / t);
    const S sine = safe_sqrt(versine * (S(2) - versine));
    const S phi = S(2) * k_pi<S> * u.y;
    const Frame<S> frame(g > S(0) ? -known : known);
    const Vec3<S> w =
        glm::normalize(frame.to_world(Vec3<S>(sine * std::cos(phi), sine * std::sin(phi), S(1) - versine)));
    return PhaseSample<S>{w, eval(w, known)};
  }

  [[nodiscard]] S pdf(const Vec3<S>& sampled, const Vec3<S>& known) const noexcept { return eval(sampled, known); }
  [[nodiscard]] S projected_area(const Vec3<S>& /*w*/) const noexcept { return S(0.5); }
};

static_assert(SetEvaluablePhase<HenyeyGreenstein<float>> && SetEvaluablePhase<HenyeyGreenstein<double>>);

}  // namespace manylight
