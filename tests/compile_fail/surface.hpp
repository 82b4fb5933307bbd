// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "manylight/geometry/bvh.hpp"
#include "manylight/scattering/lambertian.hpp"
#include "manylight/scene/scene.hpp"

/// A SurfaceShader with nothing behind it. A case defines WITHOUT_<MEMBER> to leave that one out.
struct Surface {
#ifndef WITHOUT_MATERIAL_TYPE
  using Material = manylight::Lambertian<float>;
#endif
#ifndef WITHOUT_MATERIAL
  manylight::Lambertian<float> material(const manylight::SurfacePoint<float>&, bool) const { return {}; }
#endif
#ifndef WITHOUT_IS_TWO_SIDED
  bool is_two_sided() const { return true; }
#endif
#ifndef WITHOUT_MAY_BE_TRANSPARENT
  static constexpr bool k_may_be_transparent = false;
#endif
#ifndef WITHOUT_MAY_ABSORB
  static constexpr bool k_may_absorb = false;
#endif
};
