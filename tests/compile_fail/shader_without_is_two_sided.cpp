// SPDX-License-Identifier: Apache-2.0
// expect: manylight::Scene: the second argument must model SurfaceShader
// expect: shader.is_two_sided..[^ ]+ (is|would be) invalid
#ifndef MANYLIGHT_CORRECT
#define WITHOUT_IS_TWO_SIDED
#endif
#include "surface.hpp"

int main() { return sizeof(manylight::Scene<manylight::Bvh<float>, Surface>) > 0 ? 0 : 1; }
