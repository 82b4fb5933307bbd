// SPDX-License-Identifier: Apache-2.0
// expect: PhaseFunction
// expect: noexcept|may throw
#include "manylight/scattering/any_phase.hpp"

struct Smoke {
  using Scalar = float;
  using Vec3 = manylight::Vec3<float>;
#ifdef MANYLIGHT_CORRECT
  float eval(const Vec3&, const Vec3&) const noexcept { return 0.1F; }
#else
  float eval(const Vec3&, const Vec3&) const { return 0.1F; }
#endif
  std::optional<manylight::PhaseSample<float>> sample(const Vec3&, const manylight::Vec2<float>&) const noexcept {
    return std::nullopt;
  }
  float pdf(const Vec3&, const Vec3&) const noexcept { return 0; }
  float projected_area(const Vec3&) const noexcept { return 0.5F; }
};

int main() { return sizeof(manylight::AnyPhase<Smoke>) > 0 ? 0 : 1; }
