// SPDX-License-Identifier: Apache-2.0
#pragma once

// Functions that formulas are written with to be evaluated and bounded by the same text. Each takes a plain scalar or
// an Interval. Composite ones are here because interval arithmetic is loose where a variable occurs twice: x * x on
// [-1, 2] is [-2, 4], sqr(x) is [0, 4].

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "manylight/core/interval.hpp"

namespace manylight {

namespace detail {
/// Margin of functions of the C library, which are not rounded correctly: 4 ulp, against the 1 or 2 that
/// the manual of glibc states.
template <std::floating_point S>
inline constexpr S k_library_step = S(4) * std::numeric_limits<S>::epsilon();
}  // namespace detail

// ---- plain scalars: the C++ library's functions under the names that intervals have -------------------------------

template <std::floating_point S>
[[nodiscard]] inline S sqrt(S x) noexcept {
  return std::sqrt(x);
}
template <std::floating_point S>
[[nodiscard]] inline S exp(S x) noexcept {
  return std::exp(x);
}
template <std::floating_point S>
[[nodiscard]] inline S log(S x) noexcept {
  return std::log(x);
}
template <std::floating_point S>
[[nodiscard]] constexpr S max0(S x) noexcept {
  return x > S(0) ? x : S(0);
}
/// max(0, x)^n.
template <std::floating_point S>
[[nodiscard]] inline S pow(S x, std::type_identity_t<S> n) noexcept {
  return std::pow(max0(x), n);
}
template <std::floating_point S>
[[nodiscard]] inline S abs(S x) noexcept {
  return std::abs(x);
}
template <std::floating_point S>
[[nodiscard]] constexpr S min(S a, std::type_identity_t<S> b) noexcept {
  return std::min(a, b);
}
template <std::floating_point S>
[[nodiscard]] constexpr S max(S a, std::type_identity_t<S> b) noexcept {
  return std::max(a, b);
}
template <std::floating_point S>
[[nodiscard]] constexpr S clamp(S x, std::type_identity_t<S> lo, std::type_identity_t<S> hi) noexcept {
  return std::clamp(x, lo, hi);
}

// ---- intervals: ends of monotone functions --------------------------------------------------------------------------

/// x^2.
template <std::floating_point S>
[[nodiscard]] inline Interval<S> sqr(const Interval<S>& x) noexcept {
  if (x.is_zero()) return S(0);
  const S a = std::abs(x.lo);
  const S b = std::abs(x.hi);
  const S least = x.contains(S(0)) ? S(0) : std::min(a, b);
  const S most = std::max(a, b);
  return {detail::down_to_zero(least * least), detail::up_from_tiny(most * most)};
}

/// Square root of what is not negative in `x`.
template <std::floating_point S>
[[nodiscard]] inline Interval<S> sqrt(const Interval<S>& x) noexcept {
  return {detail::down(std::sqrt(max0(x.lo))), detail::up(std::sqrt(max0(x.hi)))};
}

template <std::floating_point S>
[[nodiscard]] inline Interval<S> exp(const Interval<S>& x) noexcept {
  return {detail::down_to_zero(std::exp(x.lo), detail::k_library_step<S>),
          detail::up_from_tiny(std::exp(x.hi), detail::k_library_step<S>)};
}

/// Natural logarithm of what is positive in `x`.
template <std::floating_point S>
[[nodiscard]] inline Interval<S> log(const Interval<S>& x) noexcept {
  return {detail::down(std::log(max0(x.lo)), detail::k_library_step<S>),
          detail::up(std::log(max0(x.hi)), detail::k_library_step<S>)};
}

/// max(0, x)^n, n finite.
template <std::floating_point S>
[[nodiscard]] inline Interval<S> pow(const Interval<S>& x, std::type_identity_t<S> n) noexcept {
  const S a = std::pow(max0(x.lo), n);
  const S b = std::pow(max0(x.hi), n);
  return {detail::down_to_zero(std::min(a, b), detail::k_library_step<S>),
          detail::up_from_tiny(std::max(a, b), detail::k_library_step<S>)};
}

/// max(0, x); exact, as are abs, min, max and clamp.
template <std::floating_point S>
[[nodiscard]] constexpr Interval<S> max0(const Interval<S>& x) noexcept {
  return {max0(x.lo), max0(x.hi)};
}
template <std::floating_point S>
[[nodiscard]] constexpr Interval<S> abs(const Interval<S>& x) noexcept {
  return {std::max(S(0), std::max(x.lo, -x.hi)), std::max(-x.lo, x.hi)};
}
template <std::floating_point S>
[[nodiscard]] constexpr Interval<S> min(const Interval<S>& a, const std::type_identity_t<Interval<S>>& b) noexcept {
  return {std::min(a.lo, b.lo), std::min(a.hi, b.hi)};
}
template <std::floating_point S>
[[nodiscard]] constexpr Interval<S> max(const Interval<S>& a, const std::type_identity_t<Interval<S>>& b) noexcept {
  return {std::max(a.lo, b.lo), std::max(a.hi, b.hi)};
}
template <std::floating_point S>
[[nodiscard]] constexpr Interval<S> clamp(const Interval<S>& x, std::type_identity_t<S> lo,
                                          std::type_identity_t<S> hi) noexcept {
  return {std::clamp(x.lo, lo, hi), std::clamp(x.hi, lo, hi)};
}

/// `x` widened by that relative error, for what is computed by other operations than its bound.
template <std::floating_point S>
[[nodiscard]] inline Interval<S> widen(const Interval<S>& x, std::type_identity_t<S> relative) noexcept {
  return {detail::down(x.lo, relative), detail::up(x.hi, relative)};
}

// ---- composites with a maximum inside -------------------------------------------------------------------------------

/// c / (c + c0)^2 for c, c0 >= 0: the cosine over the squared sum of cosines of slope-based lobes. It rises up to c =
/// c0, then falls.
template <std::floating_point S>
[[nodiscard]] constexpr S ratio_peak(S c, std::type_identity_t<S> c0) noexcept {
  return c / (c + c0) / (c + c0);  // the square could overflow
}
template <std::floating_point S>
[[nodiscard]] inline Interval<S> ratio_peak(const Interval<S>& c,
                                            const std::type_identity_t<Interval<S>>& c0) noexcept {
  // In two steps, so that no square overflows. Both cosines 0: unbounded. Sum and quotients of `value` are off
  // by 2 epsilon, and so is the plain formula above, which must lie inside, too.
  constexpr S k_margin = S(4) * std::numeric_limits<S>::epsilon();
  const auto value = [](S x, S x0) { return x + x0 > S(0) ? x / (x + x0) / (x + x0) : k_infinity<S>; };
  const S from = max0(c.lo);
  const S to = max0(c.hi);
  const S c0_from = max0(c0.lo);
  // Falling in c0, so that the least c0 has the largest values.
  const S most = value(std::clamp(c0_from, from, to), c0_from);
  const bool reaches_zero = to == k_infinity<S> || c0.hi == k_infinity<S>;
  const S least = reaches_zero ? S(0) : std::min(value(from, max0(c0.hi)), value(to, max0(c0.hi)));
  return {detail::down_to_zero(least, k_margin), detail::up_from_tiny(most, k_margin)};
}

/// (1 + t) exp(-q t) for t, q >= 0: a Gaussian of slopes (t = tan^2, q = 1 / alpha^2) over the cosine squared. It rises
/// up to t = 1 / q - 1, if that is positive, then falls.
template <std::floating_point S>
[[nodiscard]] inline S gauss_slope(S t, std::type_identity_t<S> q) noexcept {
  return (S(1) + t) * std::exp(-q * t);
}
template <std::floating_point S>
[[nodiscard]] inline Interval<S> gauss_slope(const Interval<S>& t,
                                             const std::type_identity_t<Interval<S>>& q) noexcept {
  // exp(log(1 + t) - q t): the factors alone over- and underflow. Rounding of the exponent turns into a relative error
  // of the result as large as the exponent's terms are. Beyond 1e4 every scalar has underflown.
  const auto value = [](S x, S rate, S sign) {
    if (x == k_infinity<S>) return rate > S(0) || sign < S(0) ? S(0) : k_infinity<S>;
    const S fall = std::min(rate * x, S(1e4));
    const S rise = std::log1p(x);
    const S margin = (S(8) + S(2) * (fall + S(4) * rise)) * std::numeric_limits<S>::epsilon();
    const S result = std::exp(rise - fall);
    return sign < S(0) ? detail::down_to_zero(result, margin) : detail::up_from_tiny(result, margin);
  };
  const S from = max0(t.lo);
  const S to = max0(t.hi);
  const S q_from = max0(q.lo);
  const S peak = std::min(S(1) / q_from, std::numeric_limits<S>::max()) - S(1);
  const S q_to = max0(q.hi);
  const S least = q_to == k_infinity<S> ? S(0) : std::min(value(from, q_to, S(-1)), value(to, q_to, S(-1)));
  return {least, value(std::clamp(peak, from, to), q_from, S(1))};
}

/// (1 + x + y) exp(-p x - q y) for x, y >= 0: the same of squared slopes along two axes of unequal roughness (x + y =
/// t, p and q = 1 / alpha^2). Its logarithm is concave; for a given x + y it is largest with as much as possible on the
/// axis of the lower rate, so that the maximum over a box goes along that axis first.
template <std::floating_point S>
[[nodiscard]] inline S gauss_slope(S x, S y, S p, S q) noexcept {
  return (S(1) + x + y) * std::exp(-(p * x + q * y));
}
template <std::floating_point S>
[[nodiscard]] inline Interval<S> gauss_slope(const Interval<S>& x, const Interval<S>& y, S p, S q) noexcept {
  const bool x_is_slow = p <= q;
  const Interval<S> slow = max0(x_is_slow ? x : y);
  const Interval<S> fast = max0(x_is_slow ? y : x);
  const S slow_rate = x_is_slow ? p : q;
  const S fast_rate = x_is_slow ? q : p;
  // By the logarithm, with a margin for the rounding of exponents, as above.
  const auto value = [&](S a, S b, S rise_a, S rise_b, S sign) {
    const S fall = std::min(slow_rate * a + fast_rate * b, S(1e4));
    const S rise = std::log1p(std::min(rise_a + rise_b, std::numeric_limits<S>::max()));
    const S margin = (S(8) + S(4) * (fall + S(2) * rise)) * std::numeric_limits<S>::epsilon();
    const S result = std::exp(rise - fall);
    return sign < S(0) ? detail::down_to_zero(result, margin) : detail::up_from_tiny(result, margin);
  };
  const S a = std::clamp(S(1) / slow_rate - S(1) - fast.lo, slow.lo, slow.hi);
  const S b = std::clamp(S(1) / fast_rate - S(1) - a, fast.lo, fast.hi);
  // The lower end takes each factor at its worst: it is loose for wide boxes.
  return {value(slow.hi, fast.hi, slow.lo, fast.lo, S(-1)), value(a, b, a, b, S(1))};
}

/// (1 + t) / (1 + q t) for t, q >= 0: the same of slopes whose distribution falls like a power. Monotone in either.
template <std::floating_point S>
[[nodiscard]] constexpr S slope_ratio(S t, std::type_identity_t<S> q) noexcept {
  return t > S(1) ? (S(1) + S(1) / t) / (q + S(1) / t) : (S(1) + t) / (S(1) + q * t);  // products could overflow
}
template <std::floating_point S>
[[nodiscard]] inline Interval<S> slope_ratio(const Interval<S>& t,
                                             const std::type_identity_t<Interval<S>>& q) noexcept {
  constexpr S k_margin = S(8) * std::numeric_limits<S>::epsilon();
  const S from = max0(t.lo);
  const S to = max0(t.hi);
  const S q_from = max0(q.lo);
  const S q_to = max0(q.hi);
  const S most = std::max(slope_ratio(from, q_from), slope_ratio(to, q_from));
  const S least = q_to == k_infinity<S> ? S(0) : std::min(slope_ratio(from, q_to), slope_ratio(to, q_to));
  return {detail::down_to_zero(least, k_margin), detail::up_from_tiny(most, k_margin)};
}

/// (1 + x + y) / (1 + p x + q y) for x, y >= 0; p, q > 0. Along each axis the sign of the slope depends on the other
/// alone: the extremes over a box are at its corners.
template <std::floating_point S>
[[nodiscard]] constexpr S slope_ratio(S x, S y, S p, S q) noexcept {
  if (x == k_infinity<S>) return S(1) / p;  // both infinite: anything from 1 / p to 1 / q
  if (y == k_infinity<S>) return S(1) / q;
  const S most = std::max(S(1), std::max(x, y));  // products could overflow
  return (S(1) / most + x / most + y / most) / (S(1) / most + p * (x / most) + q * (y / most));
}
template <std::floating_point S>
[[nodiscard]] inline Interval<S> slope_ratio(const Interval<S>& x, const Interval<S>& y, S p, S q) noexcept {
  constexpr S k_margin = S(8) * std::numeric_limits<S>::epsilon();
  const Interval<S> u = max0(x);
  const Interval<S> v = max0(y);
  const S corners[4] = {slope_ratio(u.lo, v.lo, p, q), slope_ratio(u.hi, v.lo, p, q), slope_ratio(u.lo, v.hi, p, q),
                        slope_ratio(u.hi, v.hi, p, q)};
  return {detail::down_to_zero(*std::min_element(corners, corners + 4), k_margin),
          detail::up_from_tiny(*std::max_element(corners, corners + 4), k_margin)};
}

}  // namespace manylight
