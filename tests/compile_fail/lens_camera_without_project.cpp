// SPDX-License-Identifier: Apache-2.0
// expect: LensCamera
// expect: camera.project.v, lens_u.[^ ]+ (is|would be) invalid
#include "pinhole.hpp"

struct Lens : Pinhole {
  float film_density(const manylight::Vec3<float>&) const { return 1; }
#ifdef MANYLIGHT_CORRECT
  std::optional<manylight::LensSample<float>> project(const manylight::Vec3<float>&, const manylight::Vec2<float>&) const {
    return {};
  }
#endif
};

float density(const manylight::LensCamera auto& camera) { return camera.film_density({}); }

int main() { return density(Lens{}) > 0 ? 0 : 1; }
