// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "manylight/scattering/any_phase.hpp"
#include "manylight/scattering/gaussian_fiber.hpp"
#include "manylight/scattering/henyey_greenstein.hpp"
#include "manylight/scattering/isotropic_phase.hpp"

namespace manylight::test {

/// A fiber's axis that is near no coordinate axis.
template <std::floating_point S>
[[nodiscard]] inline Vec3<S> fiber_axis() {
  return glm::normalize(Vec3<S>(S(0.3), S(-0.5), S(0.8)));
}

/// Calls `f(name, phase)` for phase functions of every kind, up to the sharpest.
template <std::floating_point S, class Function>
void for_each_phase(const Function& f) {
  static const GaussianFiberTable<S> k_smooth(S(0.02));
  static const GaussianFiberTable<S> k_fiber(S(0.1));
  static const GaussianFiberTable<S> k_cotton(S(0.2575));
  static const GaussianFiberTable<S> k_rough(S(2));
  const Vec3<S> axis = fiber_axis<S>();
  f("isotropic", IsotropicPhase<S>{});
  f("HG 0", HenyeyGreenstein<S>{S(0)});
  f("HG .5", HenyeyGreenstein<S>{S(0.5)});
  f("HG -.7", HenyeyGreenstein<S>{S(-0.7)});
  f("HG .99", HenyeyGreenstein<S>{S(0.99)});
  f("fiber .02", GaussianFiber<S>(k_smooth, axis));
  f("fiber .1", GaussianFiber<S>(k_fiber, axis));
  f("fiber .2575", GaussianFiber<S>(k_cotton, axis));
  f("fiber 2", GaussianFiber<S>(k_rough, axis));
  f("AnyPhase fiber", AnyPhase<HenyeyGreenstein<S>, GaussianFiber<S>>(GaussianFiber<S>(k_fiber, -axis)));
}

}  // namespace manylight::test
