// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "manylight/core/vector.hpp"

namespace manylight::test {

/// Unit vector of cosine `z` and azimuth `phi` (rad).
[[nodiscard]] inline Vec3<double> direction(double z, double phi) {
  const double r = safe_sqrt(1.0 - z * z);
  return {r * std::cos(phi), r * std::sin(phi), z};
}

/// Unit vector at `degrees` from the normal.
[[nodiscard]] inline Vec3<double> at_degrees(double degrees, double phi = 0.0) {
  const double theta = degrees * k_pi<double> / 180.0;
  return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

/// A cell of the sphere in (cosine, azimuth); its solid angle is its area.
struct SphereCell {
  double z0, z1, phi0, phi1;
};

/// int over the cell by a product of 8-point Gauss-Legendre rules (exact to degree 15).
template <class Function>
[[nodiscard]] double gauss_on_cell(const Function& f, const SphereCell& cell) {
  static constexpr std::array<double, 4> k_node{0.1834346424956498, 0.5255324099163290, 0.7966664774136267,
                                                0.9602898564975363};
  static constexpr std::array<double, 4> k_weight{0.3626837833783620, 0.3137066458778873, 0.2223810344533745,
                                                  0.1012285362903763};
  const double zc = 0.5 * (cell.z0 + cell.z1);
  const double zh = 0.5 * (cell.z1 - cell.z0);
  const double pc = 0.5 * (cell.phi0 + cell.phi1);
  const double ph = 0.5 * (cell.phi1 - cell.phi0);
  double sum = 0;
  for (int i = 0; i < 8; ++i) {
    const auto a = static_cast<std::size_t>(i / 2);
    const double z = zc + (i % 2 == 0 ? zh : -zh) * k_node[a];
    for (int j = 0; j < 8; ++j) {
      const auto b = static_cast<std::size_t>(j / 2);
      const double phi = pc + (j % 2 == 0 ? ph : -ph) * k_node[b];
      sum += k_weight[a] * k_weight[b] * f(direction(z, phi));
    }
  }
  return sum * zh * ph;
}

/// int over the cell, halved in both coordinates until a step changes it by less than `tolerance` (absolute, per cell),
/// at least once and at most `depth` times.
template <class Function>
[[nodiscard]] double integrate_cell(const Function& f, const SphereCell& cell, double tolerance, int depth = 9,
                                    double coarse = -1.0) {
  if (coarse < 0.0) coarse = gauss_on_cell(f, cell);
  const double z = 0.5 * (cell.z0 + cell.z1);
  const double phi = 0.5 * (cell.phi0 + cell.phi1);
  const std::array<SphereCell, 4> quarters{{{cell.z0, z, cell.phi0, phi},
                                            {z, cell.z1, cell.phi0, phi},
                                            {cell.z0, z, phi, cell.phi1},
                                            {z, cell.z1, phi, cell.phi1}}};
  std::array<double, 4> value{};
  double fine = 0;
  for (std::size_t i = 0; i < 4; ++i) fine += value[i] = gauss_on_cell(f, quarters[i]);
  if (depth <= 1 || std::abs(fine - coarse) <= tolerance) return fine;
  double sum = 0;
  for (std::size_t i = 0; i < 4; ++i) sum += integrate_cell(f, quarters[i], 0.5 * tolerance, depth - 1, value[i]);
  return sum;
}

/// int over the upper hemisphere of `f(w)`, absolute accuracy about 100 `tolerance`. The cells shrink geometrically
/// towards the horizon, the pole and the half plane of azimuth `phi0` and its opposite, where lobes of grazing
/// directions are narrow: `phi0` is the azimuth of the other direction.
template <class Function>
[[nodiscard]] double integrate_hemisphere(const Function& f, double tolerance = 1e-7, double phi0 = 0.0) {
  constexpr int k_levels = 11;
  std::vector<double> z{0.0};
  for (int k = k_levels; k >= 1; --k) z.push_back(std::ldexp(1.0, -k));
  for (int k = 2; k <= k_levels; ++k) z.push_back(1.0 - std::ldexp(1.0, -k));
  z.push_back(1.0);
  std::vector<double> phi{0.0};
  for (int k = k_levels; k >= 1; --k) phi.push_back(std::ldexp(k_pi<double>, -k));
  for (int k = 2; k <= k_levels; ++k) phi.push_back(k_pi<double> - std::ldexp(k_pi<double>, -k));
  phi.push_back(k_pi<double>);
  double sum = 0;
  for (std::size_t i = 0; i + 1 < z.size(); ++i) {
    for (std::size_t j = 0; j + 1 < phi.size(); ++j) {
      sum += integrate_cell(f, {z[i], z[i + 1], phi0 + phi[j], phi0 + phi[j + 1]}, tolerance, 7);
      sum += integrate_cell(f, {z[i], z[i + 1], phi0 - phi[j + 1], phi0 - phi[j]}, tolerance, 7);
    }
  }
  return sum;
}

}  // namespace manylight::test
