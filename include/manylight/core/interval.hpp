// SPDX-License-Identifier: Apache-2.0
#pragma once

// Interval arithmetic for bounds. A formula that is a template over its scalar gives a value for a float and, for an
// Interval, a range that contains the values of every choice of numbers inside its operands: in exact arithmetic, and
// as computed in S by the same operations. Needs IEEE arithmetic: wrong under -ffast-math.

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "manylight/core/vector.hpp"

namespace manylight {

namespace detail {

/// phi = u (1 + 2 u), u = epsilon / 2: x - phi |x| rounds to the number next below x, or one further [Rump 2009]. No
/// bit is touched and nothing branches; fused multiply-adds are harmless.
template <std::floating_point S>
inline constexpr S k_step = std::numeric_limits<S>::epsilon() / 2 * (S(1) + std::numeric_limits<S>::epsilon());

/// What products and quotients lose at most by underflow. The smallest normal number, not the smallest of all: on many
/// processors arithmetic with subnormal ones takes a hundred times longer.
template <std::floating_point S>
inline constexpr S k_tiny = std::numeric_limits<S>::min();

/// A number below the exact value of which `x` is the rounded one. Infinity means overflow: the value was finite.
template <std::floating_point S>
[[nodiscard, gnu::always_inline]] inline S down(S x, S step = k_step<S>) noexcept {
  const S finite = std::min(x, std::numeric_limits<S>::max());
  return finite - step * std::abs(finite);
}
/// A number above the exact value of which `x` is the rounded one.
template <std::floating_point S>
[[nodiscard, gnu::always_inline]] inline S up(S x, S step = k_step<S>) noexcept {
  const S finite = std::max(x, -std::numeric_limits<S>::max());
  return finite + step * std::abs(finite);
}
/// The same for results of at least 0 that may have underflown; a lower end stays at 0.
template <std::floating_point S>
[[nodiscard, gnu::always_inline]] inline S down_to_zero(S x, S step = k_step<S>) noexcept {
  return std::max(S(0), down(x, step) - k_tiny<S>);
}
template <std::floating_point S>
[[nodiscard, gnu::always_inline]] inline S up_from_tiny(S x, S step = k_step<S>) noexcept {
  return up(x, step) + k_tiny<S>;
}

}  // namespace detail

/// Answer of a comparison of intervals: true, false, or true for some of their values and false for others. It does not
/// convert to bool, so that no `if` forgets a side: use `select` or `when`, which both take a plain bool, too.
struct Truth {
  bool can_be_true;
  bool can_be_false;

  constexpr Truth(bool known) noexcept : can_be_true(known), can_be_false(!known) {}  // implicit: joins with plain ones
  constexpr Truth(bool may_hold, bool may_fail) noexcept : can_be_true(may_hold), can_be_false(may_fail) {}
  explicit operator bool() const = delete;

  [[nodiscard]] constexpr Truth operator!() const noexcept { return {can_be_false, can_be_true}; }
  /// Both sides are always computed, unlike those of the built-in operators.
  [[nodiscard]] friend constexpr Truth operator&&(Truth a, Truth b) noexcept {
    return {a.can_be_true && b.can_be_true, a.can_be_false || b.can_be_false};
  }
  [[nodiscard]] friend constexpr Truth operator||(Truth a, Truth b) noexcept {
    return {a.can_be_true || b.can_be_true, a.can_be_false && b.can_be_false};
  }
  // With a plain side; without these the built-in operators would compete.
  [[nodiscard]] friend constexpr Truth operator&&(Truth a, bool b) noexcept { return a && Truth(b); }
  [[nodiscard]] friend constexpr Truth operator&&(bool a, Truth b) noexcept { return Truth(a) && b; }
  [[nodiscard]] friend constexpr Truth operator||(Truth a, bool b) noexcept { return a || Truth(b); }
  [[nodiscard]] friend constexpr Truth operator||(bool a, Truth b) noexcept { return Truth(a) || b; }
};

/// All numbers from `lo` to `hi`, ends included. Invariant: lo <= hi, lo < +infinity, hi > -infinity, no NaN;
/// operations keep it. An infinite end means unbounded; infinity itself is no member, so that 0 times anything is 0.
template <std::floating_point S>
struct Interval {
  S lo;
  S hi;

  Interval() = default;                                           // uninitialised, like a scalar
  constexpr Interval(S value) noexcept : lo(value), hi(value) {}  // implicit: formulas mix intervals with constants
  constexpr Interval(S low, S high) noexcept : lo(low), hi(high) {}
  [[nodiscard]] static constexpr Interval whole() noexcept { return {-k_infinity<S>, k_infinity<S>}; }

  [[nodiscard]] constexpr bool contains(S x) const noexcept { return lo <= x && x <= hi; }
  [[nodiscard]] constexpr bool is_zero() const noexcept { return lo == S(0) && hi == S(0); }

  // A sum that is subnormal is exact, so that sums need no tiny margin.
  [[nodiscard, gnu::always_inline]] friend inline Interval operator+(const Interval& a, const Interval& b) noexcept {
    return {detail::down(a.lo + b.lo), detail::up(a.hi + b.hi)};
  }
  [[nodiscard, gnu::always_inline]] friend inline Interval operator-(const Interval& a, const Interval& b) noexcept {
    return {detail::down(a.lo - b.hi), detail::up(a.hi - b.lo)};
  }
  [[nodiscard]] friend constexpr Interval operator-(const Interval& a) noexcept { return {-a.hi, -a.lo}; }

  [[nodiscard, gnu::always_inline]] friend inline Interval operator*(const Interval& a, const Interval& b) noexcept {
    if (a.is_zero() || b.is_zero()) return S(0);
    if (a.lo >= S(0) && b.lo >= S(0)) return {detail::down_to_zero(a.lo * b.lo), detail::up_from_tiny(a.hi * b.hi)};
    S least = k_infinity<S>;
    S most = -k_infinity<S>;
    for (const S p : {a.lo * b.lo, a.lo * b.hi, a.hi * b.lo, a.hi * b.hi}) {
      // 0 * infinity is NaN, loses both comparisons, and need not win: another corner is 0 or infinite.
      least = p < least ? p : least;
      most = p > most ? p : most;
    }
    return {detail::down(least) - detail::k_tiny<S>, detail::up(most) + detail::k_tiny<S>};
  }
  /// `s` must be finite.
  [[nodiscard, gnu::always_inline]] friend inline Interval operator*(S s, const Interval& a) noexcept {
    if (s == S(0)) return S(0);
    const S p = s * a.lo;
    const S q = s * a.hi;
    const S least = detail::down(std::min(p, q)) - detail::k_tiny<S>;
    const bool is_positive = s > S(0) && a.lo >= S(0);
    return {is_positive ? std::max(S(0), least) : least,
            a.is_zero() ? S(0) : detail::up(std::max(p, q)) + detail::k_tiny<S>};
  }
  [[nodiscard, gnu::always_inline]] friend inline Interval operator*(const Interval& a, S s) noexcept { return s * a; }

  /// By an interval around 0: the whole line. By one that ends at 0: a half line, if the numerator has one sign.
  [[nodiscard]] friend Interval operator/(const Interval& a, const Interval& b) noexcept {
    if (b.hi <= S(0) && b.lo < S(0)) return Interval(-a) / Interval(-b);
    if (b.lo < S(0) || b.hi == S(0)) return whole();
    if (b.lo == S(0) && a.lo < S(0) && a.hi > S(0)) return whole();
    // The largest divisor draws an end to 0, the smallest drives it away; 0 / 0 and infinity / infinity cannot occur.
    const S divisor = b.lo + S(0);  // -0, as negation makes it, would turn +infinity into -infinity
    const S least = a.lo >= S(0) ? detail::down_to_zero(a.lo / b.hi) : detail::down(a.lo / divisor) - detail::k_tiny<S>;
    const S most = a.hi <= S(0) ? -detail::down_to_zero(-a.hi / b.hi) : detail::up_from_tiny(a.hi / divisor);
    return {least, most};
  }

  [[nodiscard]] friend constexpr Truth operator>(const Interval& a, const Interval& b) noexcept {
    return {a.hi > b.lo, a.lo <= b.hi};
  }
  [[nodiscard]] friend constexpr Truth operator>=(const Interval& a, const Interval& b) noexcept {
    return {a.hi >= b.lo, a.lo < b.hi};
  }
  [[nodiscard]] friend constexpr Truth operator<(const Interval& a, const Interval& b) noexcept { return b > a; }
  [[nodiscard]] friend constexpr Truth operator<=(const Interval& a, const Interval& b) noexcept { return b >= a; }
};

static_assert(std::is_trivially_copyable_v<Interval<float>>);

/// Smallest interval that contains both.
template <std::floating_point S>
[[nodiscard]] constexpr Interval<S> hull(const Interval<S>& a, const Interval<S>& b) noexcept {
  return {std::min(a.lo, b.lo), std::max(a.hi, b.hi)};
}

/// `a` where `condition` holds, else `b`; the hull of both where intervals leave it open. Both are always computed.
template <class T>
[[nodiscard]] constexpr T select(bool condition, const T& a, const std::type_identity_t<T>& b) noexcept {
  return condition ? a : b;
}
template <class T>
[[nodiscard]] constexpr T select(Truth condition, const T& a, const std::type_identity_t<T>& b) noexcept {
  if (!condition.can_be_true) return b;
  return condition.can_be_false ? hull(a, b) : a;
}

/// `f()` where `condition` holds, else 0; the hull of both where intervals leave it open. `f` is called only if needed,
/// and only what it returns where the condition holds has to be right.
template <class F>
[[nodiscard]] constexpr auto when(bool condition, const F& f) noexcept -> decltype(f()) {
  using Result = decltype(f());
  return condition ? f() : Result(0);
}
template <class F>
[[nodiscard]] constexpr auto when(Truth condition, const F& f) noexcept -> decltype(f()) {
  using Result = decltype(f());
  if (!condition.can_be_true) return Result(0);
  return condition.can_be_false ? hull(Result(0), f()) : f();
}

/// What is known of a value from elsewhere, `bound()`, cuts an interval down to it; a plain value stays as it is and
/// `bound` is not called. Both must contain the value.
template <std::floating_point S, class F>
[[nodiscard]] constexpr S refine(S value, const F& /*bound*/) noexcept {
  return value;
}
template <std::floating_point S, class F>
[[nodiscard]] constexpr Interval<S> refine(const Interval<S>& value, const F& bound) noexcept {
  const Interval<S> known = bound();
  return {std::max(value.lo, known.lo), std::min(value.hi, known.hi)};
}

}  // namespace manylight
