// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "manylight/core/direction_set.hpp"
#include "manylight/core/interval_math.hpp"

namespace manylight {

/// Squared slopes of the facets whose normals are the half vectors of two sets of directions, and what lobes of a
/// roughness per axis make of them. Every function takes both what is known by the axes (tight for anisotropic lobes)
/// and by t = tan^2 of the polar angle (exact for isotropic ones). With e = x^2 / alpha_u^2 + y^2 / alpha_v^2 = q t,
/// q lies between 1 / alpha^2 of the two axes.
template <std::floating_point S>
class SlopeRange {
 public:
  template <class Wi, class Wo>
  SlopeRange(const Wi& wi, const Wo& wo, S alpha_u, S alpha_v) noexcept
      : SlopeRange(slopes(half_vector(wi, wo)), alpha_u, alpha_v) {}
  SlopeRange(const Slopes<S>& s, S alpha_u, S alpha_v) noexcept
      : x_(s.x), y_(s.y), t_(s.tan2), alpha_u_(alpha_u), alpha_v_(alpha_v) {}

  /// exp(-e)
  [[nodiscard]] Interval<S> gauss() const noexcept {
    const auto rate = [](S alpha) { return Interval<S>(S(1)) / sqr(Interval<S>(alpha)); };
    const Interval<S> e = sqr(x_ / Interval<S>(alpha_u_)) + sqr(y_ / Interval<S>(alpha_v_));
    return exp(-refine(e, [&] { return t_ * hull(rate(alpha_u_), rate(alpha_v_)); }));
  }
  /// (1 + t) exp(-share e)
  [[nodiscard]] Interval<S> gauss_slope(S share = S(1)) const noexcept {
    const S p = share / sqr(alpha_u_);
    const S q = share / sqr(alpha_v_);
    const Interval<S> radial = manylight::gauss_slope(t_, Interval<S>(std::min(p, q), std::max(p, q)));
    return p == q ? radial : refine(radial, [&] { return manylight::gauss_slope(sqr(x_), sqr(y_), p, q); });
  }
  /// (1 + t) / (1 + e)
  [[nodiscard]] Interval<S> slope_ratio() const noexcept {
    const S p = S(1) / sqr(alpha_u_);
    const S q = S(1) / sqr(alpha_v_);
    const Interval<S> radial = manylight::slope_ratio(t_, Interval<S>(std::min(p, q), std::max(p, q)));
    return p == q ? radial : refine(radial, [&] { return manylight::slope_ratio(sqr(x_), sqr(y_), p, q); });
  }

 private:
  Interval<S> x_;
  Interval<S> y_;
  Interval<S> t_;
  S alpha_u_;
  S alpha_v_;
};

}  // namespace manylight
