// SPDX-License-Identifier: Apache-2.0
// expect: Material
// expect: m.albedo..[^ ]+ (is|would be) invalid
#ifndef MANYLIGHT_CORRECT
#define WITHOUT_ALBEDO
#endif
#include "paint.hpp"

int main() { return sizeof(manylight::UniformShader<Paint>) > 0 ? 0 : 1; }
