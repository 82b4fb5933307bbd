// SPDX-License-Identifier: Apache-2.0
// expect: Medium
// expect: m.min_sigma_t..[^ ]+ (is|would be) invalid
#ifndef MANYLIGHT_CORRECT
#define WITHOUT_MIN_SIGMA_T
#endif
#include "fog.hpp"

int main() { return use(Fog{}); }
