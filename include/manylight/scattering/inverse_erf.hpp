// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <limits>

#include "manylight/core/vector.hpp"

namespace manylight {

/// Inverse of the error function on (-1, 1); arguments beyond +-(1 - epsilon) are pulled in.
/// A polynomial fit of single precision [Giles 2010, "Approximating the erfinv function"]; in double two Newton steps
/// on erf bring it to some ulp.
template <std::floating_point S>
[[nodiscard]] inline S inverse_erf(S x) noexcept {
  const S limit = S(1) - std::numeric_limits<S>::epsilon();
  x = std::clamp(x, -limit, limit);
  S w = -std::log((S(1) - x) * (S(1) + x));
  S p;
  if (w < S(5)) {
    w -= S(2.5);
    p = S(2.81022636e-08);
    p = S(3.43273939e-07) + p * w;
    p = S(-3.5233877e-06) + p * w;
    p = S(-4.39150654e-06) + p * w;
    p = S(0.00021858087) + p * w;
    p = S(-0.00125372503) + p * w;
    p = S(-0.00417768164) + p * w;
    p = S(0.246640727) + p * w;
    p = S(1.50140941) + p * w;
  } else {
    w = std::sqrt(w) - S(3);
    p = S(-0.000200214257);
    p = S(0.000100950558) + p * w;
    p = S(0.00134934322) + p * w;
    p = S(-0.00367342844) + p * w;
    p = S(0.00573950773) + p * w;
    p = S(-0.0076224613) + p * w;
    p = S(0.00943887047) + p * w;
    p = S(1.00167406) + p * w;
    p = S(2.83297682) + p * w;
  }
  S y = p * x;
  if constexpr (sizeof(S) > 4) {
    for (int step = 0; step < 2; ++step) {
      // erfc keeps the digits of 1 - |x| in the tails.
      const S error = y < S(0) ? std::erfc(-y) - (S(1) + x) : (S(1) - x) - std::erfc(y);
      y -= error * std::sqrt(k_pi<S>) / S(2) * std::exp(y * y);
    }
  }
  return y;
}

}  // namespace manylight
