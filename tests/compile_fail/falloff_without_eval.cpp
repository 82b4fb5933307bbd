// SPDX-License-Identifier: Apache-2.0
// expect: SubsurfaceFalloff
// expect: f.eval.d.[^ ]+ (is|would be) invalid
#ifndef MANYLIGHT_CORRECT
#define WITHOUT_EVAL
#endif
#include "wax.hpp"

int main() { return sizeof(manylight::AnyFalloff<Wax>) > 0 ? 0 : 1; }
