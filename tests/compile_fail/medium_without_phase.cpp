// SPDX-License-Identifier: Apache-2.0
// expect: Medium
// expect: m.phase.x.[^ ]+ (is|would be) invalid
#ifndef MANYLIGHT_CORRECT
#define WITHOUT_PHASE
#endif
#include "fog.hpp"

int main() { return use(Fog{}); }
