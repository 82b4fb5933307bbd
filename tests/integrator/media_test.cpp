// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "integrator/image_and_ledger.hpp"
#include "integrator/media_scenes.hpp"
#include "manylight/path/four_constraints.hpp"

// Participating media through every integrator. False alarms: `agrees` 2e-4, `expect_closed` 1e-3 per comparison.

namespace manylight::test {
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
      EXPECT_TRUE(agrees(seen, 1, 1e-9)) << seen.mean() << " +- " << seen.standard_error();
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

/// A box of fog before a wall with a lamp. `media[0]` fills the box.
FoggyBuilder fog_box(const FoggyMedium& medium) {
  FoggyBuilder builder;
  builder.media = {medium};
  builder.open_mesh(box_mesh<S>({-1, -1, -1}, {1, 1, 1}), {k_vacuum, 1});
  builder.mesh(parallelogram<S>({0, 0, 1.5}, {3, 0, 0}, {0, 3, 0}), 0.6);
  builder.mesh(parallelogram<S>({0, -1.2, 0}, {3, 0, 0}, {0, 0, 3}), 0.6);
  builder.lamp(parallelogram<S>({0, 2, 0}, {0.5, 0, 0}, {0, 0, 0.5}), 10);
  return builder;
}
PerspectiveCamera<S> box_camera() { return look_at<S>({0.5, 0.2, -4}, {0, 0, 0}, 40, 4); }

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

/// O-21 in media: image + missing energy = path tracing. `least`: what must be missing with four constraints, which give
/// back all that the clamp takes as long as the phase function stays below C_V.
void expect_closed_in(const FoggyMedium& medium, double least) {
  const FoggyScene scene = fog_box(medium).build();
  const auto camera = box_camera();
  WeightingConfig<S> config;
  config.c_clamp = 0.02;
  const RunningMoments path = path_means(scene, camera, 1500, 12);
  Numbers numbers;
  numbers.eye_paths = 48;
  numbers.vpls = 2000;
  numbers.ledger_samples = 2000;
  expect_closed(scene, FourConstraints<S>(config), camera, path, numbers, true, least);
  expect_closed(scene, StandardWeighting<S>(config), camera, path, numbers, true, 0.01);
}
TEST(Media, FogImageAndLedger) { expect_closed_in(fog(0.3, 1.2, 0.4), -1); }
TEST(Media, SmokeImageAndLedger) { expect_closed_in(even_smoke({-1, -1, -1}, {1, 0.3, 1}, 2, 0.9, 0.8), 0.001); }

/// Stability case 27: dense fog that scatters almost straight on, with a lamp inside. Nothing invalid, no spikes, and the
/// energy that C_V takes from the forward peak is in the ledger.
TEST(Media, DenseForwardFog) {
  FoggyBuilder builder = fog_box(fog(0.5, 6, 0.95));
  builder.lamp(parallelogram<S>({0, 0.4, 0}, {0.3, 0, 0}, {0, 0, 0.3}), 3);
  const FoggyScene scene = builder.build();
  const auto camera = box_camera();
  Settings settings;
  settings.samples = 2000;
  const Film path = render(Method::path, scene, camera, settings);
  double brightest = 0;
  for (const auto& p : path.pixels) brightest = std::max(brightest, p.x);
  settings.samples = 32;
  settings.vpls = 2000;
  settings.clamp_scale = 1.0 / 800;
  for (const Method method : {Method::lightcuts, Method::bdlc}) {
    const Film film = render(method, scene, camera, settings);
    EXPECT_EQ(film.invalid, 0u) << name(method);
    EXPECT_EQ(film.bound_violations, 0u) << name(method);
    for (const auto& p : film.pixels) {
      EXPECT_TRUE(is_valid_radiance(p)) << name(method);
      EXPECT_LT(p.x, 1.5 * brightest) << name(method);
    }
  }
  WeightingConfig<S> config;
  config.c_clamp = 0.02;
  Numbers numbers;
  numbers.eye_paths = 64;
  numbers.vpls = 2000;
  numbers.ledger_samples = 2000;
  const FourConstraints<S> weighting(config);
  const RunningMoments truth = path_means(scene, camera, 1500, 12);
  const Ledger ledger = ledger_of(scene, weighting, camera, {}, numbers.ledger_samples);
  const RunningMoments image = image_means(scene, weighting, camera, numbers, true);
  const double missing = ledger.total.rgb.x;
  const double error = std::hypot(image.standard_error(), ledger.total.rgb_error.x);
  EXPECT_LT(std::abs(z_score(image.mean() + missing, error, truth.mean(), truth.standard_error())),
            student_limit(1e-3, 11))
      << image.mean() << " + " << missing << " +- " << error << ", path " << truth.mean();
  EXPECT_LT(error, 0.06 * truth.mean());
  EXPECT_GT(missing, 0.5 * truth.mean()) << "the forward peak is far above C_V";
}

}  // namespace
}  // namespace manylight::test
