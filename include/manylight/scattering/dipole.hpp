// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <limits>

#include "manylight/core/alias_table.hpp"
#include "manylight/scattering/fresnel.hpp"
#include "manylight/scattering/subsurface_falloff.hpp"
#include "manylight/scattering/validation.hpp"

namespace manylight {

namespace detail {

/// Radius law of one pole at the depth z, in units of z. With s = sqrt(d^2 + z^2), x = s / z and a = sigma_tr z its
/// share of the plane is g = z exp(a) / (2 pi) (1 + sigma_tr s) exp(-sigma_tr s) / s^3, since d/ds (exp(-sigma s) / s)
/// = -(1 + sigma s) exp(-sigma s) / s^2, and radii of density -pi r^2 g'(r) have
///   density    p(x) = (x^2 - 1) exp(-a (x - 1)) (3 + 3 a x + a^2 x^2) / (2 x^4),
///   tail       Q(x) = exp(-a (x - 1)) / x (1 + (1 - 1 / x^2) (1 + a x) / 2),
/// by parts: Q is the plane's share beyond r plus pi r^2 g(r).
struct DipoleRadiusLaw {
  double a;

  [[nodiscard]] double tail(double x) const noexcept {
    return std::exp(-a * (x - 1)) / x * (1 + 0.5 * (1 - 1 / (x * x)) * (1 + a * x));
  }
  [[nodiscard]] double density(double x) const noexcept {
    const double ax = a * x;
    return 0.5 * (1 - 1 / (x * x)) * std::exp(-a * (x - 1)) * (3 + 3 * ax + ax * ax) / (x * x);
  }
  /// x - 1 where the share below is `u` in [0, 1): Newton's method on log Q, by bisection where that leaves the
  /// bracket.
  [[nodiscard]] double invert(double u) const noexcept {
    if (!(u > 0)) return 0;
    const double target = std::log1p(-u);
    double lo = 0;
    double hi = std::numeric_limits<double>::infinity();
    double y = std::sqrt(-2 * target / (3 + 3 * a + a * a));  // -log Q = (3 + 3 a + a^2) y^2 / 2 + ...
    for (int i = 0; i < 100; ++i) {
      const double q = tail(1 + y);
      const double excess = std::log(q) - target;
      (excess > 0 ? lo : hi) = y;
      double next = y + excess * q / density(1 + y);
      const bool is_newton = next > lo && next < hi;
      if (!is_newton) next = std::isinf(hi) ? 2 * y : 0.5 * (lo + hi);
      const double step = std::abs(next - y);
      y = next;
      if (step <= (is_newton ? 1e-7 : 1e-15) * y) break;  // Newton's next step would be of the order of its square
    }
    return y;
  }
};

}  // namespace detail

/// Diffusion dipole [Jensen 2001], one channel: a source at the depth z_r = 1 / sigma_t' below the surface and its
/// image at z_v = z_r (1 + 4 A / 3) above, A = (1 + F_dr) / (1 - F_dr), each falling with sigma_tr = sqrt(3 sigma_a
/// sigma_t'). R_d(d) = reflectance g(d); both poles' shares of the plane are closed forms, exp(-sigma_tr z) each, and
/// so are their radius laws: lines have the density g / 2 exactly. F_dr, the mean reflectance from inside, is computed
/// exactly instead of by Jensen's polynomial.
template <std::floating_point S>
struct DipoleProfile {
  using Scalar = S;
  S sigma_tr = S(0);         ///< effective transport coefficient, m^-1
  S z_real = S(1e-3);        ///< m
  S z_virtual = S(3e-3);     ///< m
  S real_share = S(0.5);     ///< of the plane's integral
  S virtual_share = S(0.5);  ///< 1 - real_share, without cancellation
  S reflectance = S(1);      ///< total diffuse reflectance, int_0^inf 2 pi r R_d dr, in [0, 1]

  DipoleProfile() = default;
  /// `sigma_a` >= 0, reduced `sigma_s` > 0, m^-1; `eta`: index of refraction inside over outside. Throws
  /// ParameterError.
  DipoleProfile(S sigma_a, S sigma_s, S eta) {
    check::non_negative("dipole's absorption coefficient", sigma_a);
    check::positive("dipole's reduced scattering coefficient", sigma_s);
    check::relative_ior("dipole's index of refraction", eta);
    const S sigma_t = sigma_a + sigma_s;
    const S inside = fresnel_diffuse_inside(eta);
    const S a = (S(1) + inside) / (S(1) - inside);
    sigma_tr = std::sqrt(S(3) * sigma_a) * std::sqrt(sigma_t);
    z_real = S(1) / sigma_t;
    z_virtual = z_real * (S(1) + S(4) / S(3) * a);
    const S ratio = std::exp(-sigma_tr * (z_virtual - z_real));
    real_share = S(1) / (S(1) + ratio);
    virtual_share = ratio / (S(1) + ratio);
    reflectance = S(0.5) * (sigma_s / sigma_t) * std::exp(-sigma_tr * z_real) * (S(1) + ratio);
  }

  [[nodiscard]] S eval(S d) const noexcept {
    const S near = std::min(d, S(0.25) * std::sqrt(std::numeric_limits<S>::max()));  // its square must not overflow
    return (real_share * pole(near, z_real) + virtual_share * pole(near, z_virtual)) * (S(0.5) * k_inv_pi<S>);
  }
  template <SampleStream Stream>
  [[nodiscard]] S sample_radius(Stream& stream) const noexcept {
    const S z = stream.next() < real_share ? z_real : z_virtual;
    // Radii near 0 are as rare as r^4: 24 bits would leave gaps.
    const S u = stream.next();
    const double y = detail::DipoleRadiusLaw{double(sigma_tr) * double(z)}.invert(widen_variate(u, stream.next()));
    return z * static_cast<S>(std::sqrt(y * (y + 2)));
  }

 private:
  /// 2 pi g of one pole that has the whole plane.
  [[nodiscard]] S pole(S d, S z) const noexcept {
    const S s = std::sqrt(d * d + z * z);
    // s - z without cancellation.
    return z / s * ((S(1) / s + sigma_tr) / s) * std::exp(-sigma_tr * d * (d / (s + z)));
  }
};

/// Dipoles of three channels.
template <std::floating_point S>
struct DipoleFalloff : RgbFalloff<DipoleProfile<S>> {
  DipoleFalloff() = default;
  /// Coefficients per channel, m^-1, as of DipoleProfile. Throws ParameterError.
  DipoleFalloff(const Rgb<S>& sigma_a, const Rgb<S>& sigma_s, S eta)
      : RgbFalloff<DipoleProfile<S>>(DipoleProfile<S>(sigma_a.x, sigma_s.x, eta),
                                     DipoleProfile<S>(sigma_a.y, sigma_s.y, eta),
                                     DipoleProfile<S>(sigma_a.z, sigma_s.z, eta)) {}

  /// Total diffuse reflectance per channel: the albedo rho that goes with these coefficients.
  [[nodiscard]] Rgb<S> reflectance() const noexcept {
    return {this->channels[0].reflectance, this->channels[1].reflectance, this->channels[2].reflectance};
  }
};

static_assert(SubsurfaceFalloff<DipoleFalloff<float>> && SubsurfaceFalloff<DipoleFalloff<double>>);

}  // namespace manylight
