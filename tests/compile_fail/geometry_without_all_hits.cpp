// SPDX-License-Identifier: Apache-2.0
// expect: manylight::Scene: the first argument must model Geometry
// expect: geometry.all_hits.ray, visit.[^ ]+ (is|would be) invalid
#ifndef MANYLIGHT_CORRECT
#define WITHOUT_ALL_HITS
#endif
#include "backend.hpp"

int main() {
  using Shader = manylight::UniformShader<manylight::Lambertian<float>>;
  return sizeof(manylight::Scene<Backend, Shader>) > 0 ? 0 : 1;
}
