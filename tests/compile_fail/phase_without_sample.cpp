// SPDX-License-Identifier: Apache-2.0
// expect: PhaseFunction
// expect: p.sample.w, u.[^ ]+ (is|would be) invalid
#ifndef MANYLIGHT_CORRECT
#define WITHOUT_SAMPLE
#endif
#include "droplets.hpp"

int main() { return sizeof(manylight::AnyPhase<Droplets>) > 0 ? 0 : 1; }
