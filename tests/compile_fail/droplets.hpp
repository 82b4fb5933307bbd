// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "manylight/scattering/any_phase.hpp"

/// A PhaseFunction with nothing behind it. A case defines WITHOUT_<MEMBER> to leave that one out.
struct Droplets {
  using Scalar = float;
  using Vec3 = manylight::Vec3<float>;
#ifndef WITHOUT_EVAL
  float eval(const Vec3&, const Vec3&) const noexcept { return 0.1F; }
#endif
#ifndef WITHOUT_SAMPLE
  std::optional<manylight::PhaseSample<float>> sample(const Vec3&, const manylight::Vec2<float>&) const noexcept {
    return std::nullopt;
  }
#endif
#ifndef WITHOUT_PDF
  float pdf(const Vec3&, const Vec3&) const noexcept { return 0; }
#endif
#ifndef WITHOUT_PROJECTED_AREA
  float projected_area(const Vec3&) const noexcept { return 0.5F; }
#endif
};
