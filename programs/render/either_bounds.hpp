// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "manylight/bounds/analytic.hpp"
#include "manylight/bounds/sensor_map.hpp"
#include "render/options.hpp"

namespace manylight::render {

/// The bounds that the command line chose, as one type: cuts are instantiated once instead of once per kind, for a
/// branch per sensor.
struct EitherBounds {
  BoundsKind kind = BoundsKind::automatic;
  CubeMapLimits limits{};

  [[nodiscard]] bool makes_maps() const noexcept { return kind == BoundsKind::cube_map; }
  template <Material M, class Wi, class Wo>
  [[nodiscard]] PatternSup<typename M::Scalar> sup(const M& m, const Wi& wi, const Wo& wo) const noexcept {
    return kind == BoundsKind::analytic ? AnalyticBounds{}.sup(m, wi, wo) : AutomaticBounds{}.sup(m, wi, wo);
  }
  template <PhaseFunction P, class W, class V>
  [[nodiscard]] typename P::Scalar sup_phase(const P& p, const W& sampled, const V& known) const noexcept {
    return kind == BoundsKind::analytic ? AnalyticBounds{}.sup_phase(p, sampled, known)
                                        : AutomaticBounds{}.sup_phase(p, sampled, known);
  }
};

}  // namespace manylight::render
