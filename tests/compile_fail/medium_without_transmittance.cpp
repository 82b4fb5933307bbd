// SPDX-License-Identifier: Apache-2.0
// expect: Medium
// expect: m.transmittance.ray, t_max, stream.[^ ]+ (is|would be) invalid
#ifndef MANYLIGHT_CORRECT
#define WITHOUT_TRANSMITTANCE
#endif
#include "fog.hpp"

int main() { return use(Fog{}); }
