// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "integrator/media_scenes.hpp"

// Participating media through every integrator. False alarms: `agrees` 2e-4 per comparison.

namespace manylight::test::media_test {
namespace {

using S = double;
using V = Vec3<S>;

/// One ray along +z from the origin.
ProbeCamera<S> along_z() {
  ProbeCamera<S> camera;
  camera.add({0, 0, 1}, {0, 0, 0});
  return camera;
}

/// Endless fog, sigma_s 0.1 and sigma_a 0.05 / m, a point light 1 m beside the ray, 2 m along it.
FoggyBuilder airlight(double end) {
  FoggyBuilder builder;
  builder.media = {fog(0.05, 0.1)};
  builder.outside = 1;
  builder.point_light({1, 0, 2}, 1);
  builder.mesh(parallelogram<S>({0, 0, end}, {0.01, 0, 0}, {0, 0.01, 0}), 0);
  return builder;
}

/// Oracle O-8. Caught: sigma_t in place of sigma_s at the collision; shadow rays without transmittance.
TEST(Media, AirlightOfAPointLight) {
  const std::pair<double, double> cases[] = {{100.0, 0.0115445}, {5.0, 0.0112312}};
  for (const auto& [end, exact] : cases) {
    const FoggyScene scene = airlight(end).build();
    Settings settings;
    settings.samples = 2000;
    settings.max_edges = 2;
    for (const Method method : k_methods) {
      const RunningMoments seen = repeat(method, scene, along_z(), settings, 16)[0];
      EXPECT_TRUE(agrees(seen, exact, 1e-5)) << name(method) << ": " << seen.mean() << " +- " << seen.standard_error();
      EXPECT_LT(seen.standard_error(), 0.01 * exact) << name(method);
    }
  }
}

/// Oracle O-38: the same with double scattering, 0.00293470 more.
TEST(Media, DoublyScatteredAirlight) {
  const FoggyScene scene = airlight(100).build();
  Settings settings;
  settings.samples = 20000;
  settings.max_edges = 3;
  const RunningMoments seen = repeat(Method::path, scene, along_z(), settings, 16)[0];
  EXPECT_TRUE(agrees(seen, 0.0115445 + 0.00293470, 1e-5)) << seen.mean() << " +- " << seen.standard_error();
  EXPECT_LT(seen.standard_error(), 1e-4);
}

/// A ball of white fog under a uniform sky cannot be seen.
TEST(Media, WhiteFogUnderAWhiteSkyIsInvisible) {
  for (const bool is_grid : {false, true}) {
    FoggyBuilder builder;
    builder.media = {fog(0, 2, 0.7)};
    if (is_grid) builder.media = {even_smoke({-1, -1, -1}, {1, 1, 1}, 2, 1, 0.7)};
    builder.open_sphere({0, 0, 0}, 1, {k_vacuum, 1});
    builder.lights.environments.emplace_back();
    const FoggyScene scene = builder.build();
    ProbeCamera<S> camera;
    camera.add({0, 0, 0}, {0, 0, -3});
    camera.add({0, 0.7, 0}, {0, 0.7, -3});
    camera.add({0, 0, 1}, {0.1, 0.2, 0.3});
    Settings settings;
    settings.samples = 200;
    for (const RunningMoments& seen : repeat(Method::path, scene, camera, settings, 16)) {
      EXPECT_TRUE(agrees(seen, 1, 1e-9))  // rounding over some hundred scatterings
          << seen.mean() << " +- " << seen.standard_error();
    }
  }
}

/// Boundaries nested in each other: the medium changes at each, for walks and for shadow rays alike, and the camera may
/// stand anywhere. Absorption only: exp(-sum of lengths times sigma_a).
TEST(Media, NestedBoundaries) {
  FoggyBuilder builder;
  builder.media = {fog(0.3, 0), fog(0.8, 0), fog(0.1, 0)};
  builder.outside = 3;
  builder.open_sphere({0, 0, 0}, 2, {3, 1});
  builder.open_sphere({0, 0, 0}, 1, {1, 2});
  builder.lamp(parallelogram<S>({0, 0, 4}, {5, 0, 0}, {0, -5, 0}), 1);
  const FoggyScene scene = builder.build();
  const std::pair<double, double> cases[] = {
      {-5.0, 5 * 0.1 + 2 * 0.3 + 2 * 0.8}, {-1.5, 2 * 0.1 + 1.5 * 0.3 + 2 * 0.8}, {0.5, 2 * 0.1 + 0.3 + 0.5 * 0.8}};
  for (const auto& [z, depth] : cases) {
    ProbeCamera<S> camera;
    camera.add({0, 0, 4}, {0, 0, z});
    for (const Method method : k_methods) {
      Settings settings;
      settings.samples = 4000;  // what the media absorb, walks lose by chance
      const RunningMoments seen = repeat(method, scene, camera, settings, 16)[0];
      EXPECT_TRUE(agrees(seen, std::exp(-depth), 1e-9)) << name(method) << " from " << z << ": " << seen.mean();
      EXPECT_LT(seen.standard_error(), 0.02 * std::exp(-depth)) << name(method) << " from " << z;
    }
  }
  // The same by shadow rays: a grey floor below the lamp's image in all media.
  FoggyBuilder lit = builder;
  lit.lights.areas.clear();
  lit.point_light({0, 0, 3}, 1);
  lit.mesh(parallelogram<S>({0, 0, -4}, {1, 0, 0}, {0, 1, 0}), 0.5);
  const FoggyScene below = lit.build();
  ProbeCamera<S> camera;
  camera.add({0, 0, -4}, {0.02, 0, -3.9});
  const double distance = std::hypot(0.02, 0.1);
  const double exact =
      0.5 / k_pi<S> / 49 * std::exp(-(3 * 0.1 + 2 * 0.3 + 2 * 0.8)) * std::exp(-distance * 0.1);
  for (const Method method : k_methods) {
    Settings settings;
    settings.max_edges = 2;
    const RunningMoments seen = repeat(method, below, camera, settings, 16)[0];
    EXPECT_TRUE(agrees(seen, exact, 1e-6)) << name(method) << ": " << seen.mean() << " for " << exact;
  }
}

/// Glass around an absorbing medium, seen through its centre at normal incidence: two transmissions, one way through, and
/// what is reflected inside comes back with three ways and more. T = 1 - F, q = exp(-sigma_a d):
/// T^2 q / (1 - F^2 q^2) + the mirror image of the sky, 1 in all directions: F + T^2 F q^2 / (1 - F^2 q^2).
TEST(Media, GlassBoundary) {
  FoggyBuilder builder;
  builder.media = {fog(0.4, 0)};
  builder.glass_sphere({0, 0, 0}, 1, 1.5, {k_vacuum, 1});
  builder.lights.environments.emplace_back();
  const FoggyScene scene = builder.build();
  ProbeCamera<S> camera;
  camera.add({0, 0, 0}, {0, 0, -3});
  const double f = 0.04;
  const double q = std::exp(-0.8);
  const double exact = f + sqr(1 - f) * (q + f * q * q) / (1 - sqr(f * q));
  Settings settings;
  settings.samples = 4000;
  for (const Method method : {Method::path, Method::bdlc}) {
    const RunningMoments seen = repeat(method, scene, camera, settings, 16)[0];
    EXPECT_TRUE(agrees(seen, exact, 1e-9)) << name(method) << ": " << seen.mean() << " for " << exact;
    EXPECT_LT(seen.standard_error(), 0.01 * exact) << name(method);
  }
}

/// Constant density in a grid is the homogeneous medium, and fog so thin that nothing happens is none.
TEST(Media, SameMediaBySeveralMeans) {
  const auto mean = [](const FoggyBuilder& builder, Method method) {
    Settings settings;
    settings.samples = 200;
    RunningMoments moments;
    const FoggyScene scene = builder.build();
    for (unsigned run = 0; run < 12; ++run) {
      ++settings.seed;
      moments.add(render(method, scene, box_camera(), settings).mean().x);
    }
    return moments;
  };
  const auto expect_same = [](const RunningMoments& a, const RunningMoments& b, const char* what) {
    const double z = z_score(a.mean(), a.standard_error(), b.mean(), b.standard_error());
    EXPECT_LT(std::abs(z), student_limit(1e-3, 11)) << what << ": " << a.mean() << " and " << b.mean();
  };
  expect_same(mean(fog_box(fog(0.2, 0.8, 0.5)), Method::path),
              mean(fog_box(even_smoke({-1, -1, -1}, {1, 1, 1}, 1, 0.8, 0.5)), Method::path), "grid");
  const RunningMoments none = mean(fog_box(fog(0, 0)), Method::path);
  expect_same(mean(fog_box(fog(1e-12, 1e-12)), Method::path), none, "thin fog");
}

}  // namespace
}  // namespace manylight::test::media_test
