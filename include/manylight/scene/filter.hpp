// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "manylight/core/error.hpp"
#include "manylight/core/warp.hpp"

namespace manylight {

/// Shape of the pixel filter.
enum class FilterKind { box, tent, gaussian };

/// Pixel filter as a sampler: film points are drawn around the pixel's centre with a density proportional to the
/// filter, and the pixel is the plain mean of its samples. No sample enters two pixels, so that a tile can be rendered
/// alone. All filters are separable, non-negative and integrate to 1 over the film (pixels^-2). [Ernst, Stamminger,
/// Greiner 2006, "Filter Importance Sampling"]
template <std::floating_point S>
class ReconstructionFilter {
 public:
  /// Constant on the pixel's square.
  [[nodiscard]] static ReconstructionFilter box() noexcept { return {FilterKind::box, S(0.5), S(0)}; }
  /// Falls linearly to 0 at `radius` pixels. Throws ParameterError unless radius is positive.
  [[nodiscard]] static ReconstructionFilter tent(S radius = S(1)) {
    require(radius > S(0) && std::isfinite(radius), "tent filter radius", radius, "a positive number of pixels");
    return {FilterKind::tent, radius, S(0)};
  }
  /// exp(-x^2 / (2 stddev^2)) less its value at 4 standard deviations, where it is cut off. Throws ParameterError
  /// unless the standard deviation (pixels) is positive.
  [[nodiscard]] static ReconstructionFilter gaussian(S stddev = S(0.5)) {
    require(stddev > S(0) && std::isfinite(stddev), "gaussian filter standard deviation", stddev,
            "a positive number of pixels");
    return {FilterKind::gaussian, k_cut * stddev, stddev};
  }

  [[nodiscard]] FilterKind kind() const noexcept { return kind_; }
  /// Half the side of the square that holds all samples, pixels.
  [[nodiscard]] S radius() const noexcept { return radius_; }

  /// Offset from the pixel's centre, pixels; monotone in each variate, which keeps stratified variates stratified.
  [[nodiscard]] Vec2<S> sample(const Vec2<S>& u) const noexcept { return {sample_1d(u.x), sample_1d(u.y)}; }

  /// The filter's value at an offset from the centre: also the density of `sample`, pixels^-2.
  [[nodiscard]] S eval(const Vec2<S>& offset) const noexcept { return eval_1d(offset.x) * eval_1d(offset.y); }

 private:
  static constexpr S k_cut = S(4);  ///< support of the Gaussian, standard deviations

  ReconstructionFilter(FilterKind kind, S radius, S stddev) noexcept : kind_(kind), radius_(radius), stddev_(stddev) {}

  [[nodiscard]] S sample_1d(S u) const noexcept {
    switch (kind_) {
      case FilterKind::box:
        return u - S(0.5);
      case FilterKind::tent:
        return radius_ * warp::interval_to_tent(u);
      case FilterKind::gaussian:
        break;
    }
    const S side = S(2) * u - S(1);
    return std::copysign(stddev_ * invert_gaussian(std::abs(side)), side);
  }

  [[nodiscard]] S eval_1d(S x) const noexcept {
    const S t = std::abs(x);
    if (t > radius_) return S(0);
    switch (kind_) {
      case FilterKind::box:
        return S(1);
      case FilterKind::tent:
        return (S(1) - t / radius_) / radius_;
      case FilterKind::gaussian:
        break;
    }
    return bell(t / stddev_) / (S(2) * bell_integral(k_cut) * stddev_);
  }

  /// The truncated Gaussian of unit standard deviation, not normalised, and its integral from 0.
  [[nodiscard]] static S bell(S t) noexcept { return std::exp(-t * t / S(2)) - std::exp(-k_cut * k_cut / S(2)); }
  [[nodiscard]] static S bell_integral(S t) noexcept {
    const S half_root = S(1.25331413731550025L);  // sqrt(pi / 2)
    return half_root * std::erf(t * S(0.70710678118654752L)) - t * std::exp(-k_cut * k_cut / S(2));
  }

  /// The t in [0, k_cut] below which the fraction `u` of the bell's half lies: Newton's method on the concave integral
  /// climbs to the root from 0 without overshooting; rounding near the flat end is caught by the clamp.
  [[nodiscard]] static S invert_gaussian(S u) noexcept {
    const S target = u * bell_integral(k_cut);
    S t = S(0);
    for (int i = 0; i < 24; ++i) {
      const S step = (target - bell_integral(t)) / std::max(bell(t), S(1e-6));
      t = std::clamp(t + step, S(0), k_cut);
      if (std::abs(step) < S(4) * std::numeric_limits<S>::epsilon() * t) break;
    }
    return t;
  }

  FilterKind kind_;
  S radius_;
  S stddev_;
};

}  // namespace manylight
