// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "manylight/scene/shader.hpp"

/// A Material with nothing behind it. A case defines WITHOUT_<MEMBER> to leave that one out.
struct Paint {
  using Scalar = float;
  using Color = manylight::Rgb<float>;
  using Vec3 = manylight::Vec3<float>;
#ifndef WITHOUT_EVAL
  Color eval(const Vec3&, const Vec3&) const noexcept { return Color(0.1F); }
#endif
#ifndef WITHOUT_SAMPLE
  std::optional<manylight::DirectionSample<float>> sample(const Vec3&, manylight::Walk, float,
                                                          const manylight::Vec2<float>&) const noexcept {
    return std::nullopt;
  }
#endif
#ifndef WITHOUT_PDF
  float pdf(const Vec3&, const Vec3&, manylight::Walk) const noexcept { return 0; }
#endif
#ifndef WITHOUT_ALBEDO
  Color albedo() const noexcept { return Color(0.3F); }
#endif
#ifndef WITHOUT_IS_DELTA
  bool is_delta() const noexcept { return false; }
#endif
};
