// SPDX-License-Identifier: Apache-2.0
#include "manylight/manylight.hpp"

manylight::Rgb<float> radiance_from_the_other_unit();

manylight::Rgb<float> radiance_from_the_other_unit() {
  const manylight::Lambertian<float> there{manylight::Rgb<float>(0.5F)};
  const manylight::Vec3<float> up(0, 0, 1);
  return there.eval(up, up);
}
