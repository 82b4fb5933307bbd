// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "integrator/bidirectional_scenes.hpp"
#include "integrator/bidirectional_weight_check.hpp"

// Weights of traced paths against the slow form. Caught: roulette in one walk's density only; the directions of the other
// walk's density exchanged; a point light's selection left out of its walks; cosines at vertices in media.

namespace manylight::test::bidirectional_oracle_test {
namespace {

using S = double;

TEST(BidirectionalOracle, RoomWithGlassAndMirror) {
  expect_weights(room_of_balls().build(), room_camera(), 200, true);
}
TEST(BidirectionalOracle, SkyAndSun) {
  BallBuilder builder = open_floor();
  add_sky(builder);
  add_sun(builder);
  builder.sphere({{0, -0.8, -0.2}, 0.3, false}, BallMaterial(Dielectric<S>{1.5}), false);
  builder.sphere({{0.9, 0.9, 0}, 0.5, false}, BallMaterial(Mirror<S>{Rgb<S>(0.9)}));
  builder.mesh(parallelogram<S>({0, 1.5, 0.5}, {1.5, 0, 0}, {0, 0, 1}), matte(0.8));
  expect_weights(builder.build(), floor_camera(0), 1500, true);
}
TEST(BidirectionalOracle, SphericalLight) {
  BallBuilder builder = open_floor();
  builder.mesh(parallelogram<S>({0, 1.5, 0.5}, {1.5, 0, 0}, {0, 0, 1}), matte(0.8));
  builder.emit(builder.sphere({{-0.5, 0.3, 1}, 0.3, false}, matte(0.4)), Rgb<S>(5));
  expect_weights(builder.build(), floor_camera(0), 1000, true);
}
TEST(BidirectionalOracle, Fog) {
  FoggyBuilder builder = box_of_fog(false);
  builder.point_light({0.3, 0.2, 0.4}, 0.4);
  expect_weights(builder.build(), floor_camera(0), 300, false);
}

}  // namespace
}  // namespace manylight::test::bidirectional_oracle_test
