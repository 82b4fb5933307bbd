// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "manylight/integrator/film.hpp"

/// A Camera with nothing behind it. A case defines WITHOUT_<MEMBER> to leave that one out.
struct Pinhole {
  using Scalar = float;
#ifndef WITHOUT_RAY
  manylight::Ray<float> ray(const manylight::Vec2<float>&, const manylight::Vec2<float>&) const { return {}; }
#endif
#ifndef WITHOUT_WIDTH
  std::uint32_t width() const { return 1; }
#endif
#ifndef WITHOUT_HEIGHT
  std::uint32_t height() const { return 1; }
#endif
};
