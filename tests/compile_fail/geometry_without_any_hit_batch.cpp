// SPDX-License-Identifier: Apache-2.0
// expect: manylight::Scene: the first argument must model Geometry
// expect: geometry.any_hit_batch.rays, blocked.[^ ]+ (is|would be) invalid
#ifndef MANYLIGHT_CORRECT
#define WITHOUT_ANY_HIT_BATCH
#endif
#include "backend.hpp"

int main() {
  using Shader = manylight::UniformShader<manylight::Lambertian<float>>;
  return sizeof(manylight::Scene<Backend, Shader>) > 0 ? 0 : 1;
}
