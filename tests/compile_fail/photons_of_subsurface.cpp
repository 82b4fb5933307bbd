// SPDX-License-Identifier: Apache-2.0
// expect: photon maps know no subsurface scattering
#include "manylight/many_light/photon_trace.hpp"
#include "manylight/scattering/falloff_profiles.hpp"
#include "manylight/scattering/subsurface.hpp"
#include "surface.hpp"

struct Jade : Surface {
#ifndef MANYLIGHT_CORRECT
  using Subsurface = manylight::Subsurface<manylight::ExponentialFalloff<float>>;
  const Subsurface* subsurface() const { return nullptr; }
#endif
};
using JadeScene = manylight::Scene<manylight::Bvh<float>, Jade>;

auto trace(const JadeScene& scene, manylight::RayCounts& rays) {
  return manylight::trace_photons(scene, manylight::PhotonPaths{}, 0, manylight::IndependentSampler<float>{},
                                  manylight::SerialExecutor{}, rays);
}

int main() { return 0; }
