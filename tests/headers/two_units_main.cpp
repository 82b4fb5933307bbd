// SPDX-License-Identifier: Apache-2.0
#include "manylight/manylight.hpp"

manylight::Rgb<float> radiance_from_the_other_unit();

int main() {
  const manylight::Lambertian<float> here{manylight::Rgb<float>(0.5F)};
  const manylight::Vec3<float> up(0, 0, 1);
  return here.eval(up, up) == radiance_from_the_other_unit() ? 0 : 1;
}
