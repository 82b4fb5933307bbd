// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "support/quadrature.hpp"

namespace manylight::test {

/// Regularised upper incomplete gamma function Q(a, x): a series below a + 1, Lentz's continued fraction above.
[[nodiscard]] inline double regularised_gamma_q(double a, double x) {
  if (x <= 0.0) return 1.0;
  const double scale = std::exp(a * std::log(x) - x - std::lgamma(a));
  if (x < a + 1.0) {
    double term = 1.0 / a;
    double sum = term;
    for (int k = 1; k < 10000 && term > sum * 1e-17; ++k) {
      term *= x / (a + k);
      sum += term;
    }
    return 1.0 - scale * sum;
  }
  constexpr double k_tiny = 1e-300;
  double b = x + 1.0 - a;
  double c = 1.0 / k_tiny;
  double d = 1.0 / b;
  double fraction = d;
  for (int k = 1; k < 10000; ++k) {
    const double numerator = -k * (k - a);
    b += 2.0;
    d = numerator * d + b;
    if (std::abs(d) < k_tiny) d = k_tiny;
    c = b + numerator / c;
    if (std::abs(c) < k_tiny) c = k_tiny;
    d = 1.0 / d;
    fraction *= d * c;
    if (std::abs(d * c - 1.0) < 1e-16) break;
  }
  return scale * fraction;
}

/// Probability that a chi-square variable of that many degrees of freedom exceeds `statistic`.
[[nodiscard]] inline double chi_square_p_value(double degrees_of_freedom, double statistic) {
  return regularised_gamma_q(0.5 * degrees_of_freedom, 0.5 * statistic);
}

/// Level of one of `tests` independent tests whose family raises a false alarm with probability `family_level`.
[[nodiscard]] inline double sidak_level(double family_level, double tests) {
  return -std::expm1(std::log1p(-family_level) / tests);
}

struct ChiSquareResult {
  double p_value = 1.0;
  double statistic = 0.0;
  int degrees_of_freedom = 0;
  std::string failure;  ///< not empty: rejected outright (a draw where the density is 0, an integral above 1)
  std::string worst;    ///< the cell that contributes most, for the failure message

  [[nodiscard]] bool passes(double level) const { return failure.empty() && p_value >= level; }
  [[nodiscard]] std::string describe() const {
    std::ostringstream out;
    out << "p = " << p_value << ", chi^2 = " << statistic << ", dof = " << degrees_of_freedom << "; " << failure
        << " worst: " << worst;
    return out.str();
  }
};

struct ExpectedCount {
  double expected = 0.0;
  double observed = 0.0;
  std::string name;
};

/// Pearson's test. Cells are pooled in ascending order of expectation until each pool expects at least 5.
[[nodiscard]] inline ChiSquareResult chi_square(std::vector<ExpectedCount> cells) {
  ChiSquareResult result;
  for (const ExpectedCount& cell : cells) {
    if (cell.expected <= 0.0 && cell.observed > 0.0) result.failure = "draws where the density is 0: " + cell.name;
  }
  std::sort(cells.begin(), cells.end(),
            [](const ExpectedCount& a, const ExpectedCount& b) { return a.expected < b.expected; });
  std::vector<ExpectedCount> pools;
  ExpectedCount pool;
  for (const ExpectedCount& cell : cells) {
    pool.expected += cell.expected;
    pool.observed += cell.observed;
    pool.name = cell.name;
    if (pool.expected >= 5.0) pools.push_back(std::exchange(pool, {}));
  }
  if (!pools.empty()) {
    pools.back().expected += pool.expected;
    pools.back().observed += pool.observed;
  }
  double worst = 0.0;
  for (const ExpectedCount& p : pools) {
    const double term = (p.observed - p.expected) * (p.observed - p.expected) / p.expected;
    result.statistic += term;
    if (term > worst) {
      worst = term;
      std::ostringstream out;
      out << p.name << " expects " << p.expected << ", has " << p.observed;
      result.worst = out.str();
    }
  }
  result.degrees_of_freedom = static_cast<int>(pools.size()) - 1;
  result.p_value =
      result.degrees_of_freedom > 0 ? chi_square_p_value(result.degrees_of_freedom, result.statistic) : 1.0;
  return result;
}

/// Is `draw` distributed by `density`? The sphere is cut into 10 x 21 cells of equal area in cosine and azimuth; an odd
/// number of azimuths keeps edges off the symmetry planes of the lobes, and the horizon is an edge. One more cell
/// counts the draws that failed (std::nullopt) or took a delta lobe: it expects what the density lacks to 1. A draw at
/// which the density is 0 fails at once.
/// `draw`: -> optional<Vec3<double>>, called `count` times; `density`: Vec3<double> -> sr^-1.
template <class Draw, class Density>
[[nodiscard]] ChiSquareResult sphere_chi_square(const Draw& draw, const Density& density, std::uint64_t count) {
  constexpr int k_z = 10;
  constexpr int k_phi = 21;
  std::vector<ExpectedCount> cells(k_z * k_phi + 1);
  const double n = static_cast<double>(count);
  const double step = 2.0 * k_pi<double> / k_phi;
  double total = 0.0;
  for (int i = 0; i < k_z; ++i) {
    for (int j = 0; j < k_phi; ++j) {
      const SphereCell cell{2.0 * i / k_z - 1.0, 2.0 * (i + 1) / k_z - 1.0, j * step, (j + 1) * step};
      // 1e-7 of the mass is 0.1 draws of 1e6: far below the noise of a cell that expects at least 5. A cell that the
      // edge of a lobe only touches may be found empty: that is no verdict here, see below.
      const double mass = std::max(integrate_cell(density, cell, 1e-7, 7), 1e-12);
      total += mass;
      ExpectedCount& c = cells[static_cast<std::size_t>(i * k_phi + j)];
      c.expected = n * mass;
      c.name = "cell z " + std::to_string(i) + " phi " + std::to_string(j);
    }
  }
  ExpectedCount& missed = cells.back();
  missed.name = "missed";
  missed.expected = n * std::max(1.0 - total, 1e-12);  // pooled where it is within the accuracy of the quadrature
  std::string failure;
  for (std::uint64_t k = 0; k < count; ++k) {
    const std::optional<Vec3<double>> w = draw();
    if (!w) {
      missed.observed += 1.0;
      continue;
    }
    if (!(density(*w) > 0.0)) failure = "a draw where the density is 0";
    const int i = std::clamp(static_cast<int>(std::floor((w->z + 1.0) * 0.5 * k_z)), 0, k_z - 1);
    double phi = std::atan2(w->y, w->x);
    if (phi < 0.0) phi += 2.0 * k_pi<double>;
    const int j = std::min(static_cast<int>(phi / step), k_phi - 1);
    cells[static_cast<std::size_t>(i * k_phi + j)].observed += 1.0;
  }
  ChiSquareResult result = chi_square(std::move(cells));
  if (!failure.empty()) result.failure = failure;
  if (total > 1.0 + 1e-4) result.failure = "the density integrates to " + std::to_string(total);
  return result;
}

}  // namespace manylight::test
