// SPDX-License-Identifier: Apache-2.0
#pragma once

// Subsurface scattering as two vertices and a segment of its own [Walter 2012, section 7]: with light that enters the
// body at x_i from psi and leaves it at x_o towards omega,
//   f_ss = rho / pi g(|x_i - x_o|) Ft(psi) Ft(omega),
//   |psi.ng| f_ss |omega.ng| = s_i tau s_o,   s = sqrt(rho) |cos| Ft / pi at either end,   tau = pi g(d) between.
// The segment sees no visibility and no 1 / d^2, and joins points of one body alone. Drawn by n random lines (see
// path/random_lines.hpp) tau / p is 2 pi / n where the channels of g are alike, at most 6 pi / n.

#include <cmath>

#include "manylight/core/interval_math.hpp"
#include "manylight/scattering/fresnel.hpp"
#include "manylight/scattering/subsurface_falloff.hpp"
#include "manylight/scattering/validation.hpp"

namespace manylight {

/// A body that light enters at one place and leaves at another.
template <SubsurfaceFalloff F>
struct Subsurface {
  using Scalar = typename F::Scalar;
  using S = Scalar;
  using Falloff = F;
  F falloff{};
  Rgb<S> rho{S(0.8)};  ///< albedo: share that comes back, of what enters, on a plane; per channel, [0, 1]
  S eta = S(1);  ///< index of refraction inside over outside of a smooth boundary; 1: Ft = 1, as if there were none

  /// Throws ParameterError.
  void validate() const {
    if constexpr (requires { falloff.validate(); }) falloff.validate();
    check::reflectance("subsurface albedo", rho);
    check::relative_ior("subsurface index of refraction", eta);
  }

  /// What either end has of the albedo.
  [[nodiscard]] Rgb<S> sqrt_rho() const noexcept { return {std::sqrt(rho.x), std::sqrt(rho.y), std::sqrt(rho.z)}; }
  /// Normaliser of an end's pattern: the largest channel of sqrt(rho), as of a Lambertian surface.
  [[nodiscard]] S alpha() const noexcept { return max_channel(sqrt_rho()); }

  /// |cos| Ft / pi, sr^-1, the pattern of either end: integrates to 1 over the hemisphere if eta is 1, else to less.
  /// `cosine`: of the direction away from the vertex (psi where light enters, omega where it leaves) and the body's
  /// outward geometric normal; 0 for directions into the body. A scalar or an Interval, for bounds over directions.
  template <class Cosine>
  [[nodiscard]] Cosine pattern(const Cosine& cosine) const noexcept {
    const Cosine outside = min(max0(cosine), S(1));
    if (eta == S(1)) return outside * k_inv_pi<S>;
    return outside * (S(1) - reflectance_dielectric(outside, eta)) * k_inv_pi<S>;
  }
  /// s, sr^-1 per channel, of either end, `cosine` as above.
  [[nodiscard]] Rgb<S> end_factor(S cosine) const noexcept { return sqrt_rho() * pattern(cosine); }

  /// tau = pi g(d), m^-2 per channel, of the segment between the ends, `d` m apart.
  [[nodiscard]] Rgb<S> transit(S d) const noexcept { return falloff.eval(d) * k_pi<S>; }
  /// Upper bound of every channel of tau over distances of at least `d_min` (m), m^-2: of two boxes of ends
  /// sqrt(min_squared_length(difference(a, b))).
  [[nodiscard]] S sup_transit(S d_min) const noexcept { return falloff.sup(d_min) * k_pi<S>; }
};

}  // namespace manylight
