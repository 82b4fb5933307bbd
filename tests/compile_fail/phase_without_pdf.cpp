// SPDX-License-Identifier: Apache-2.0
// expect: PhaseFunction
// expect: p.pdf.w, w.[^ ]+ (is|would be) invalid
#ifndef MANYLIGHT_CORRECT
#define WITHOUT_PDF
#endif
#include "droplets.hpp"

int main() { return sizeof(manylight::AnyPhase<Droplets>) > 0 ? 0 : 1; }
