// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <vector>

#include "manylight/core/vector.hpp"
#include "manylight/scattering/dipole.hpp"
#include "manylight/scattering/falloff_profiles.hpp"
#include "manylight/scattering/gauss_legendre.hpp"

namespace manylight::test {

/// int_from^to 2 pi r g(r) dr of `g`: 16-point Gauss-Legendre rules over a third of an octave each; 1e-12 or better for
/// what is smooth on that scale. `from` > 0.
template <class Function>
[[nodiscard]] double plane_share(const Function& g, double from, double to) {
  static const std::vector<QuadratureNode> k_rule = gauss_legendre(16);
  const int panels = static_cast<int>(std::ceil(3 * std::log2(to / from)));
  const double step = std::log(to / from) / panels;
  double sum = 0;
  for (int i = 0; i < panels; ++i) {
    for (const QuadratureNode& node : k_rule) {
      const double r = from * std::exp(step * (i + node.x));
      sum += node.weight * r * r * g(r);
    }
  }
  return 2 * k_pi<double> * step * sum;
}

/// Falloffs by name, of unequal channels around 1 m.
template <std::floating_point S>
[[nodiscard]] ExponentialFalloff<S> exponential() {
  return ExponentialFalloff<S>(Rgb<S>(S(1), S(0.3), S(2.5)));
}
template <std::floating_point S>
[[nodiscard]] GaussianFalloff<S> gaussian() {
  return GaussianFalloff<S>(Rgb<S>(S(0.7), S(1.5), S(0.2)));
}
template <std::floating_point S>
[[nodiscard]] BurleyFalloff<S> burley() {
  return BurleyFalloff<S>(Rgb<S>(S(1), S(0.25), S(0.6)));
}
/// Without absorption, with some, with much.
template <std::floating_point S>
[[nodiscard]] DipoleFalloff<S> dipole() {
  return DipoleFalloff<S>({S(0), S(0.02), S(1.5)}, {S(2), S(5), S(0.8)}, S(1.4));
}

}  // namespace manylight::test
