// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "integrator/image_and_ledger.hpp"
#include "integrator/subsurface_scenes.hpp"
#include "manylight/path/four_constraints.hpp"

// Subsurface scattering: what bidirectional lightcuts leave out. False alarms: 1e-3 per comparison.

namespace manylight::test::subsurface_slow_test {
namespace {

using S = double;

/// A room with a jade block and a jade ball, one of them diffuse on top.
JadeBuilder jade_room(double length, double eta) {
  JadeBuilder builder;
  auto walls = box_mesh<S>({-1, -1, -1}, {1, 1, 1});
  walls.flip_normals = true;
  builder.mesh(walls, 0.6);
  builder.mesh(box_mesh<S>({-0.7, 0, -0.999}, {-0.2, 0.5, -0.2}), jade(0.8, length, eta));
  builder.sphere({0.4, 0.2, -0.5}, 0.4, jade(0.6, length, eta), 0.2);
  builder.lamp(parallelogram<S>({0, 0, 0.98}, {0, 0.4, 0}, {0.4, 0, 0}), 10);
  return builder;
}
PerspectiveCamera<S> room_camera() { return look_at<S>({0, -0.95, 0}, {0, 1, -0.4}, 70, 4); }

/// O-21 with objects: image + missing energy = path tracing.
void expect_closed_in(const JadeScene& scene, double c_clamp) {
  const auto camera = room_camera();
  WeightingConfig<S> config;
  config.c_clamp = c_clamp;
  const RunningMoments path = path_means(scene, camera, 3000, 12);
  Numbers numbers;
  numbers.eye_paths = 32;
  numbers.vpls = 2000;
  numbers.ledger_samples = 3000;
  for (const bool by_cuts : {false, true}) {
    expect_closed(scene, FourConstraints<S>(config), camera, path, numbers, by_cuts, -1);
  }
  expect_closed(scene, StandardWeighting<S>(config), camera, path, numbers, true, 0.005);
}
TEST(Subsurface, LongFalloffImageAndLedger) { expect_closed_in(jade_room(0.3, 1).build(), 0.05); }
TEST(Subsurface, ShortFalloffImageAndLedger) { expect_closed_in(jade_room(0.02, 1.4).build(), 0.05); }

}  // namespace
}  // namespace manylight::test::subsurface_slow_test
