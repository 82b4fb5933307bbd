// SPDX-License-Identifier: Apache-2.0
// expect: Material
// expect: m.is_delta..[^ ]+ (is|would be) invalid
#ifndef MANYLIGHT_CORRECT
#define WITHOUT_IS_DELTA
#endif
#include "paint.hpp"

int main() { return sizeof(manylight::UniformShader<Paint>) > 0 ? 0 : 1; }
