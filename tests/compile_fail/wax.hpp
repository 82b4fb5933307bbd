// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "manylight/scattering/any_falloff.hpp"

/// A SubsurfaceFalloff with nothing behind it. A case defines WITHOUT_<MEMBER> to leave that one out.
struct Wax {
  using Scalar = float;
#ifndef WITHOUT_EVAL
  manylight::Rgb<float> eval(float) const noexcept { return manylight::Rgb<float>(0); }
#endif
#ifndef WITHOUT_SAMPLE_RADIUS
  float sample_radius(manylight::SampleStream auto&) const noexcept { return 0; }
#endif
#ifndef WITHOUT_LINE_PDF
  float line_pdf(float) const noexcept { return 0; }
#endif
#ifndef WITHOUT_SUP
  float sup(float) const noexcept { return 0; }
#endif
};
