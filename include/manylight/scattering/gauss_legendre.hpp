// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "manylight/core/vector.hpp"

namespace manylight {

/// A point of a quadrature rule on [0, 1] and its weight; the weights sum to 1.
struct QuadratureNode {
  double x = 0.0;
  double weight = 0.0;
};

/// Gauss-Legendre rule of `count` >= 1 points on [0, 1], exact for polynomials of degree 2 count - 1. The roots of the
/// Legendre polynomial by Newton's method from Tricomi's estimate. For set-up, not for inner loops.
[[nodiscard]] inline std::vector<QuadratureNode> gauss_legendre(std::size_t count) {
  std::vector<QuadratureNode> rule(count);
  const auto n = static_cast<double>(count);
  for (std::size_t i = 0; i < count; ++i) {
    double x = std::cos(k_pi<double> * (static_cast<double>(i) + 0.75) / (n + 0.5));
    double derivative = 0.0;
    for (int step = 0; step < 10; ++step) {
      double previous = 1.0;  // P_{k-1}
      double current = x;     // P_k, by the three-term recurrence
      for (std::size_t k = 2; k <= count; ++k) {
        const auto d = static_cast<double>(k);
        const double next = ((2.0 * d - 1.0) * x * current - (d - 1.0) * previous) / d;
        previous = current;
        current = next;
      }
      derivative = n * (x * current - previous) / (x * x - 1.0);
      const double change = current / derivative;
      x -= change;
      if (std::abs(change) < 1e-15) break;
    }
    rule[i] = {0.5 * (1.0 - x), 1.0 / ((1.0 - x * x) * derivative * derivative)};
  }
  return rule;
}

}  // namespace manylight
