// SPDX-License-Identifier: Apache-2.0
// expect: Material
// expect: m.pdf.w, w, walk.[^ ]+ (is|would be) invalid
#ifndef MANYLIGHT_CORRECT
#define WITHOUT_PDF
#endif
#include "paint.hpp"

int main() { return sizeof(manylight::UniformShader<Paint>) > 0 ? 0 : 1; }
