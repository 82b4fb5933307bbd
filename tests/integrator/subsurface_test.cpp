// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <iostream>

#include "integrator/subsurface_scenes.hpp"

// Subsurface scattering through every integrator. False alarms: `agrees` 2e-4 per comparison.

namespace manylight::test::subsurface_test {
namespace {

using S = double;
using V = Vec3<S>;

/// A floor so large against the falloff's length that it counts as a half-space.
TriangleMesh<S> floor_of(double half_side) {
  return parallelogram<S>({0, 0, 0}, {half_side, 0, 0}, {0, half_side, 0});
}
ProbeCamera<S> from_above() {
  ProbeCamera<S> camera;
  camera.add({0, 0, 0}, {0.3, 0.2, 1});
  return camera;
}

/// Oracle O-15: under a uniform sky a half-space of albedo rho looks like a Lambertian one, whatever the falloff.
TEST(Subsurface, HalfSpaceUnderAUniformSky) {
  for (const double rho : {0.3, 0.9}) {
    JadeBuilder builder;
    builder.mesh(floor_of(20), jade(rho, 0.2));
    builder.sky(2);
    const JadeScene scene = builder.build();
    Settings settings;
    settings.samples = 1000;
    settings.clamp_scale = 1.0 / 800;  // the recursion gives back what few VPLs cannot show
    for (const Method method : {Method::path, Method::bdlc}) {
      const RunningMoments seen = repeat(method, scene, from_above(), settings, 16)[0];
      EXPECT_TRUE(agrees(seen, 2 * rho, 1e-3)) << name(method) << ": " << seen.mean() << " +- " << seen.standard_error();
      EXPECT_LT(seen.standard_error(), 0.02 * rho) << name(method);
    }
  }
}

/// Stability case 28: a slab lit from behind, seen from the front. At few VPLs the clamp takes nearly all pairs through the
/// slab; standard virtual points lose that energy, the recursion gives it back.
TEST(Subsurface, SlabLitFromBehind) {
  for (const double thickness : {0.02, 0.5}) {
    JadeBuilder builder;
    builder.mesh(box_mesh<S>({-2, -2, -thickness}, {2, 2, 0}), jade(0.9, 0.1));
    builder.lamp(parallelogram<S>({0, 0, -1.5}, {1, 0, 0}, {0, 1, 0}), 20);
    const JadeScene scene = builder.build();
    ProbeCamera<S> camera;
    camera.add({0, 0, 0}, {0.2, 0.1, 1});
    Settings settings;
    settings.samples = 1000;
    settings.vpls = 300;
    settings.clamp_scale = 1.0 / 800;
    settings.max_edges = 3;  // through the slab once
    const RunningMoments path = repeat(Method::path, scene, camera, settings, 16)[0];
    const RunningMoments bdlc = repeat(Method::bdlc, scene, camera, settings, 16)[0];
    const RunningMoments standard = repeat(Method::lightcuts, scene, camera, settings, 16)[0];
    EXPECT_GT(path.mean(), 0) << thickness;
    EXPECT_LT(std::abs(z_score(path.mean(), path.standard_error(), bdlc.mean(), bdlc.standard_error())),
              student_limit(1e-3, 15))
        << thickness << ": path " << path.mean() << ", bdlc " << bdlc.mean() << " +- " << bdlc.standard_error();
    if (thickness < 0.1) {
      EXPECT_LT(standard.mean(), 0.5 * path.mean()) << standard.mean() << " of " << path.mean();
    }
    std::cout << "slab of " << thickness << " m: path " << path.mean() << ", bdlc " << bdlc.mean() << " +- "
              << bdlc.standard_error() << ", standard " << standard.mean() << "\n";
  }
}

}  // namespace
}  // namespace manylight::test::subsurface_test
