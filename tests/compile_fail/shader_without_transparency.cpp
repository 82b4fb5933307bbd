// SPDX-License-Identifier: Apache-2.0
// expect: manylight::Scene: the second argument must model SurfaceShader
// expect: T::k_may_be_transparent[^ ]+ (is|would be) invalid
#ifndef MANYLIGHT_CORRECT
#define WITHOUT_MAY_BE_TRANSPARENT
#endif
#include "surface.hpp"

int main() { return sizeof(manylight::Scene<manylight::Bvh<float>, Surface>) > 0 ? 0 : 1; }
