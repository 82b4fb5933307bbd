// SPDX-License-Identifier: Apache-2.0
// expect: FalloffProfile
// expect: p.sample_radius.stream.[^ ]+ (is|would be) invalid
#include "manylight/scattering/subsurface_falloff.hpp"

/// One channel with nothing behind it.
struct Jade {
  using Scalar = float;
  float eval(float) const noexcept { return 0; }
#ifdef MANYLIGHT_CORRECT
  float sample_radius(manylight::SampleStream auto&) const noexcept { return 0; }
#endif
};

int main() { return sizeof(manylight::RgbFalloff<Jade>) > 0 ? 0 : 1; }
