// SPDX-License-Identifier: Apache-2.0
// expect: Medium
// expect: m.sigma_s.x, x.[^ ]+ (is|would be) invalid
#ifndef MANYLIGHT_CORRECT
#define WITHOUT_SIGMA_S
#endif
#include "fog.hpp"

int main() { return use(Fog{}); }
