// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string_view>

#include "manylight/core/error.hpp"
#include "manylight/media/concepts.hpp"
#include "manylight/media/free_flight.hpp"

namespace manylight {

/// The same coefficients everywhere, without end. Transmittance exp(-sigma_t t) per channel.
///
/// The flight follows the extinction of one channel, drawn uniformly, and is divided by the mean of the three densities
/// (balance heuristic [Veach 1997, 9.2.2.1]): no channel's weight exceeds 3 / sigma_t of that channel, whatever the
/// others are; a channel with sigma_t = 0 always gets through.
template <class P>
requires MediumPhase<P, typename P::Scalar>
class Homogeneous {
 public:
  using Scalar = typename P::Scalar;
  using Phase = P;
  using S = Scalar;
  static constexpr bool k_closed_form = true;

  /// Vacuum.
  Homogeneous() = default;
  /// `sigma_a`, `sigma_s`: absorption and scattering coefficients, m^-1, each 0 or 1e-20 to 1e20: flights must be
  /// finite in single precision. Throws ParameterError.
  Homogeneous(const Rgb<S>& sigma_a, const Rgb<S>& sigma_s, const Phase& phase = Phase())
      : sigma_s_(sigma_s), sigma_t_(sigma_a + sigma_s), phase_(phase) {
    check_coefficient("absorption coefficient", sigma_a);
    check_coefficient("scattering coefficient", sigma_s);
  }

  [[nodiscard]] Rgb<S> sigma_t(const Vec3<S>& /*x*/, const Vec3<S>& /*w*/) const noexcept { return sigma_t_; }
  [[nodiscard]] Rgb<S> sigma_s(const Vec3<S>& /*x*/, const Vec3<S>& /*w*/) const noexcept { return sigma_s_; }
  [[nodiscard]] Phase phase(const Vec3<S>& /*x*/) const noexcept { return phase_; }
  [[nodiscard]] S min_sigma_t() const noexcept { return std::min({sigma_t_.x, sigma_t_.y, sigma_t_.z}); }

  [[nodiscard]] Rgb<S> mean_transmittance(const Ray<S>& /*ray*/, S t_max) const noexcept {
    return {exponential_transmittance(sigma_t_.x, t_max), exponential_transmittance(sigma_t_.y, t_max),
            exponential_transmittance(sigma_t_.z, t_max)};
  }
  template <SampleStream Stream>
  [[nodiscard]] Rgb<S> transmittance(const Ray<S>& ray, S t_max, Stream& /*stream*/) const noexcept {
    return mean_transmittance(ray, t_max);
  }

  /// Takes two variates.
  template <SampleStream Stream>
  [[nodiscard]] MediumSample<S> sample(const Ray<S>& ray, S t_max, Stream& stream) const noexcept {
    const int channel = std::min(static_cast<int>(stream.next() * S(3)), 2);
    const S flight = optical_flight(stream.next());
    const S sigma = sigma_t_[channel];
    const S t = sigma > S(0) ? flight / sigma : k_infinity<S>;
    const bool scattered = t < t_max;
    const Rgb<S> through = mean_transmittance(ray, scattered ? t : t_max);
    // What was drawn cannot have probability 0: its own channel's transmittance is at least a variate's step.
    const Rgb<S> density = scattered ? sigma_t_ * through : through;
    return {scattered ? t : t_max, through / ((density.x + density.y + density.z) / S(3)), scattered};
  }

 private:
  static void check_coefficient(std::string_view element, const Rgb<S>& value) {
    for (int channel = 0; channel < 3; ++channel) {
      const S v = value[channel];
      require(v == S(0) || (v >= S(1e-20) && v <= S(1e20)), element, v, "0 or 1e-20 to 1e20 in each channel");
    }
  }

  Rgb<S> sigma_s_{S(0)};
  Rgb<S> sigma_t_{S(0)};
  Phase phase_{};
};

}  // namespace manylight
