// SPDX-License-Identifier: Apache-2.0
// expect: SubsurfaceFalloff
// expect: f.line_pdf.d.[^ ]+ (is|would be) invalid
#ifndef MANYLIGHT_CORRECT
#define WITHOUT_LINE_PDF
#endif
#include "wax.hpp"

int main() { return sizeof(manylight::AnyFalloff<Wax>) > 0 ? 0 : 1; }
