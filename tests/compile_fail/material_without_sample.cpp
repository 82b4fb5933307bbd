// SPDX-License-Identifier: Apache-2.0
// expect: Material
// expect: m.sample.w, walk, u, u2.[^ ]+ (is|would be) invalid
#ifndef MANYLIGHT_CORRECT
#define WITHOUT_SAMPLE
#endif
#include "paint.hpp"

int main() { return sizeof(manylight::UniformShader<Paint>) > 0 ? 0 : 1; }
