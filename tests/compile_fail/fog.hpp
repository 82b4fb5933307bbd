// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "manylight/media/concepts.hpp"

struct FogPhase {
  using Scalar = float;
};

/// A Medium with nothing behind it. A case defines WITHOUT_<MEMBER> to leave that one out.
struct Fog {
  using Scalar = float;
  using Phase = FogPhase;
  using Color = manylight::Rgb<float>;
  using Vec3 = manylight::Vec3<float>;
  using Ray = manylight::Ray<float>;
#ifndef WITHOUT_K_CLOSED_FORM
  static constexpr bool k_closed_form = true;
#endif
#ifndef WITHOUT_SIGMA_T
  Color sigma_t(const Vec3&, const Vec3&) const noexcept { return Color(0); }
#endif
#ifndef WITHOUT_SIGMA_S
  Color sigma_s(const Vec3&, const Vec3&) const noexcept { return Color(0); }
#endif
#ifndef WITHOUT_PHASE
  Phase phase(const Vec3&) const noexcept { return {}; }
#endif
#ifndef WITHOUT_SAMPLE
  manylight::MediumSample<float> sample(const Ray&, float t_max, manylight::SampleStream auto&) const noexcept {
    return {t_max, Color(1), false};
  }
#endif
#ifndef WITHOUT_TRANSMITTANCE
  Color transmittance(const Ray&, float, manylight::SampleStream auto&) const noexcept { return Color(1); }
#endif
#ifndef WITHOUT_MEAN_TRANSMITTANCE
  Color mean_transmittance(const Ray&, float) const noexcept { return Color(1); }
#endif
#ifndef WITHOUT_MIN_SIGMA_T
  float min_sigma_t() const noexcept { return 0; }
#endif
};

constexpr int use(const manylight::Medium auto&) { return 0; }
