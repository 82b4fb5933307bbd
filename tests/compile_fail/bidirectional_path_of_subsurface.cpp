// SPDX-License-Identifier: Apache-2.0
// expect: bidirectional path tracing knows no subsurface scattering
#include "manylight/integrator/bidirectional_path.hpp"
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
using Walk = manylight::BidirectionalWalk<JadeScene, manylight::IndependentStream<float>>;

void trace(Walk& walk, manylight::Subpath<JadeScene>& path) { walk.trace_light(3, path); }

int main() { return 0; }
