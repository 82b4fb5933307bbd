// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "integrator/image_and_ledger.hpp"
#include "integrator/media_scenes.hpp"
#include "manylight/path/four_constraints.hpp"

// Participating media: what bidirectional lightcuts leave out. False alarms: 1e-3 per comparison.

namespace manylight::test::media_slow_test {
namespace {

using S = double;

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

TEST(Media, ClothImageAndLedger) {
  expect_closed_in(striped_cloth({-1, -1, -0.2}, {1, 0.4, 0.2}, 20, 0.9, 0.2575), -1);
}

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
}  // namespace manylight::test::media_slow_test
