// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "manylight/core/interval_math.hpp"
#include "manylight/scattering/gauss_legendre.hpp"
#include "manylight/scattering/validation.hpp"

namespace manylight {

/// What fibers of one roughness share: the density of their flakes' normals and its mean projection.
/// The normals m of the mirroring flakes of a fiber along f have the density Df(m) = exp(-(m . f)^2 / (2 gamma^2)) / N,
/// sr^-1, N = (2 pi)^(3/2) gamma erf(1 / (sqrt(2) gamma)) [Zhao 2011]. Their mean projection
/// sigma(w) = int |w . m| Df(m) dm [Jakob 2010] depends on the sine between w and f alone. It rises with it and
/// is convex in it, so that linear interpolation never lies below it: what is normalised by it may lose light (by 2e-4
/// at gamma = 0.02, 4e-4 at 0.01, next to the axis), never gain. Immutable; made at set-up in about a millisecond.
template <std::floating_point S>
class GaussianFiberTable {
 public:
  using Scalar = S;
  /// `gamma`: deviation of m . f, 0.01 to 10. The smaller, the nearer to a smooth cylinder; the larger, the nearer to
  /// flakes in all directions. Throws ParameterError.
  explicit GaussianFiberTable(S gamma) : gamma_(gamma) {
    require(gamma >= S(0.01) && gamma <= S(10), "Gaussian fiber gamma", gamma, "0.01 to 10");
    const auto g = static_cast<double>(gamma);
    const double q = 1.0 / (2.0 * g * g);
    const double error = std::erf(std::sqrt(q));
    const double norm = std::pow(2.0 * k_pi<double>, 1.5) * g * error;
    q_ = static_cast<S>(q);
    erf_ = static_cast<S>(error);
    inv_norm_ = static_cast<S>(1.0 / norm);
    const std::vector<QuadratureNode> rule = gauss_legendre(48);
    for (std::size_t i = 0; i < k_size; ++i) {
      const double sine = sqr(static_cast<double>(i) / static_cast<double>(k_size - 1));
      const S value = static_cast<S>(4.0 * k_pi<double> / norm * half_integral(rule, g, sine));
      sigma_[i] = i > 0 ? std::max(value, sigma_[i - 1]) : value;  // rises in spite of rounding
    }
  }

  [[nodiscard]] S gamma() const noexcept { return gamma_; }
  [[nodiscard]] S inv_two_gamma2() const noexcept { return q_; }      ///< 1 / (2 gamma^2)
  [[nodiscard]] S erf_one() const noexcept { return erf_; }           ///< erf(1 / (sqrt(2) gamma))
  [[nodiscard]] S inv_norm() const noexcept { return inv_norm_; }     ///< 1 / N, sr^-1
  [[nodiscard]] S sigma_along() const noexcept { return sigma_[0]; }  ///< mean projection along the fiber
  /// Mean projection at that sine to the fiber, [0, 1]; of a range of sines the range of it.
  [[nodiscard]] S sigma(S sine) const noexcept {
    constexpr S k_last = S(k_size - 1);
    const S at = std::clamp(std::sqrt(max0(sine)) * k_last, S(0), k_last);
    const std::size_t i = std::min(static_cast<std::size_t>(at), k_size - 2);
    // Nodes are squares, dense next to the axis, where sigma bends: (s - i^2 h) / ((2 i + 1) h), h = 1 / last^2.
    const S index = static_cast<S>(i);
    const S t = std::clamp((sine * sqr(k_last) - sqr(index)) / (S(2) * index + S(1)), S(0), S(1));
    return sigma_[i] + t * (sigma_[i + 1] - sigma_[i]);
  }
  [[nodiscard]] Interval<S> sigma(const Interval<S>& sine) const noexcept {
    // Of rounding alone sigma(s) may fall between neighbours: t is a difference of numbers up to last^2.
    constexpr S k_margin = S(8) * std::numeric_limits<S>::epsilon();
    return widen(Interval<S>(sigma(sine.lo), sigma(sine.hi)), k_margin);
  }

 private:
  static constexpr std::size_t k_size = 256;

  /// int_0^1 exp(-x^2 / (2 gamma^2)) k dx, x = |m . f|, k the mean of |w . m| over the azimuth of m: with a = c x and
  /// b = s sqrt(1 - x^2), k = a where a >= b, that is from x = s on, else (2 / pi)(a asin(a / b) + sqrt(b^2 - a^2)).
  /// With x = s sin t the second is smooth: sqrt(b^2 - a^2) = s cos t and a / b is the sine of atan(c tan t).
  [[nodiscard]] static double half_integral(const std::vector<QuadratureNode>& rule, double gamma, double s) {
    const double q = 1.0 / (2.0 * gamma * gamma);
    const double c = std::sqrt((1.0 - s) * (1.0 + s));
    // The rest, int_s^1 exp(-q x^2) c x dx, is elementary.
    double sum = -c * gamma * gamma * std::exp(-q * s * s) * std::expm1(-q * (1.0 - s) * (1.0 + s));
    double from = 0.0;
    // Beyond 9 gamma the Gaussian is below 3e-18.
    for (const double deviations : {1.0, 2.5, 5.0, 9.0}) {
      const double x = deviations * gamma;
      const double to = x < s ? std::asin(x / s) : k_pi<double> / 2.0;
      for (const QuadratureNode& node : rule) {
        const double t = from + (to - from) * node.x;
        const double k = 2.0 * k_inv_pi<double> * s * (c * std::sin(t) * std::atan(c * std::tan(t)) + std::cos(t));
        sum += node.weight * (to - from) * std::exp(-q * sqr(s * std::sin(t))) * k * s * std::cos(t);
      }
      if (x >= s) break;
      from = to;
    }
    return sum;
  }

  S gamma_;
  S q_;
  S erf_;
  S inv_norm_;
  std::array<S, k_size> sigma_;
};

}  // namespace manylight
