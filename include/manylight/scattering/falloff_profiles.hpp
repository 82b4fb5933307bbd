// SPDX-License-Identifier: Apache-2.0
#pragma once

// Falloffs with one length per channel and closed-form radius laws.

#include <algorithm>
#include <cmath>
#include <concepts>

#include "manylight/scattering/subsurface_falloff.hpp"
#include "manylight/scattering/validation.hpp"

namespace manylight {

namespace detail {
/// -log(1 - u): exponentially distributed, of mean 1.
template <SampleStream Stream>
[[nodiscard]] inline typename Stream::Scalar exponential_variate(Stream& stream) noexcept {
  return -std::log1p(-stream.next());
}
}  // namespace detail

/// g = exp(-d / l) / (2 pi l^2). Radii have the density r^2 exp(-r / l) / (2 l^3), the sum of three exponential
/// variates.
template <std::floating_point S>
struct ExponentialProfile {
  using Scalar = S;
  S length = S(1e-3);  ///< l, m; the mean distance is 2 l

  ExponentialProfile() = default;
  explicit ExponentialProfile(S l) noexcept : length(l) {}

  /// Throws ParameterError.
  void validate() const { check::positive("exponential falloff's length", length); }
  [[nodiscard]] S eval(S d) const noexcept { return std::exp(-d / length) / length / length * (S(0.5) * k_inv_pi<S>); }
  template <SampleStream Stream>
  [[nodiscard]] S sample_radius(Stream& stream) const noexcept {
    const S first = detail::exponential_variate(stream);
    const S second = detail::exponential_variate(stream);
    return length * (first + second + detail::exponential_variate(stream));
  }
};

/// g = exp(-d^2 / (2 s^2)) / (2 pi s^2). r^2 / (2 s^2) has the density t exp(-t), the sum of two exponential variates.
template <std::floating_point S>
struct GaussianProfile {
  using Scalar = S;
  S deviation = S(1e-3);  ///< s, m

  GaussianProfile() = default;
  explicit GaussianProfile(S s) noexcept : deviation(s) {}

  /// Throws ParameterError.
  void validate() const { check::positive("Gaussian falloff's deviation", deviation); }
  [[nodiscard]] S eval(S d) const noexcept {
    const S x = d / deviation;
    return std::exp(S(-0.5) * x * x) / deviation / deviation * (S(0.5) * k_inv_pi<S>);
  }
  template <SampleStream Stream>
  [[nodiscard]] S sample_radius(Stream& stream) const noexcept {
    const S first = detail::exponential_variate(stream);
    return deviation * std::sqrt(S(2) * (first + detail::exponential_variate(stream)));
  }
};

/// g = (exp(-d / b) + exp(-d / (3 b))) / (8 pi b d), a fit to simulated scattering [Christensen and Burley 2015].
/// Radii have the density ((1 + r/b) exp(-r/b) + (1 + r/(3b)) exp(-r/(3b))) / (8 b): scale b with probability 1/4, else
/// 3 b, times one exponential variate or the sum of two, 1/2 each.
///
/// g grows like 1/d towards 0. Below 1e-6 b it stays what it is there, so that it is finite; that takes 2.5e-7 off its
/// integral.
template <std::floating_point S>
struct BurleyProfile {
  using Scalar = S;
  static constexpr S k_least = S(1e-6);  ///< in units of b
  S length = S(1e-3);                    ///< b, m; the mean distance is 2.5 b

  BurleyProfile() = default;
  explicit BurleyProfile(S b) noexcept : length(b) {}
  /// The fit for diffuse light: `mean_free_path` (m) of the volume, `albedo` of the surface in [0, 1], the rho of
  /// Subsurface. [Christensen and Burley 2015, Eq. 6]
  [[nodiscard]] static BurleyProfile of(S mean_free_path, S albedo) noexcept {
    return BurleyProfile(mean_free_path / (S(1.9) - albedo + S(3.5) * sqr(albedo - S(0.8))));
  }

  /// Throws ParameterError.
  void validate() const { check::positive("Burley falloff's length", length); }
  [[nodiscard]] S eval(S d) const noexcept {
    const S x = std::max(d / length, k_least);
    const S third = std::exp(-x / S(3));
    return (third * third * third + third) / x / length / length * (S(0.125) * k_inv_pi<S>);
  }
  template <SampleStream Stream>
  [[nodiscard]] S sample_radius(Stream& stream) const noexcept {
    const S u = S(8) * stream.next();
    const S first = detail::exponential_variate(stream);
    const S second = detail::exponential_variate(stream);
    const bool is_narrow = u < S(2);
    const bool has_two = is_narrow ? u >= S(1) : u >= S(5);
    return length * (is_narrow ? S(1) : S(3)) * (has_two ? first + second : first);
  }
};

template <std::floating_point S>
using ExponentialFalloff = RgbFalloff<ExponentialProfile<S>>;
template <std::floating_point S>
using GaussianFalloff = RgbFalloff<GaussianProfile<S>>;
template <std::floating_point S>
using BurleyFalloff = RgbFalloff<BurleyProfile<S>>;

static_assert(SubsurfaceFalloff<ExponentialFalloff<float>> && SubsurfaceFalloff<ExponentialFalloff<double>>);
static_assert(SubsurfaceFalloff<GaussianFalloff<float>> && SubsurfaceFalloff<GaussianFalloff<double>>);
static_assert(SubsurfaceFalloff<BurleyFalloff<float>> && SubsurfaceFalloff<BurleyFalloff<double>>);

}  // namespace manylight
