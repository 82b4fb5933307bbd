// SPDX-License-Identifier: Apache-2.0
// expect: Medium
// expect: m.mean_transmittance.ray, t_max.[^ ]+ (is|would be) invalid
#ifndef MANYLIGHT_CORRECT
#define WITHOUT_MEAN_TRANSMITTANCE
#endif
#include "fog.hpp"

int main() { return use(Fog{}); }
