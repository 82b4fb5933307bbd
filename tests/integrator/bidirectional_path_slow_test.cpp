// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "integrator/bidirectional_scenes.hpp"

// Bidirectional path tracing where it takes many samples. False alarms: see bidirectional_path_test.cpp.

namespace manylight::test::bidirectional_path_slow_test {
namespace {

using S = double;

/// With a mirror and a ball of glass, whose caustics path tracing finds by hitting the light.
TEST(BidirectionalPath, RoomWithGlassAndMirror) {
  BallBuilder builder = room_of_balls();
  builder.lights.points.clear();
  expect_equals_path(builder.build(), room_camera(), 128, 48, 0.01);
}

/// A sheet of glass between a small lamp and the floor: nothing but light walks and hits of the lamp get through.
TEST(BidirectionalPath, CausticOfAGlassSlab) {
  BallBuilder builder;
  builder.mesh(parallelogram<S>({0, 0, -0.5}, {2, 0, 0}, {0, 2, 0}), matte(0.6));
  builder.mesh(box_mesh<S>({-2, -2, 0.2}, {2, 2, 0.4}), BallMaterial(Dielectric<S>{1.5}), false);
  builder.emit(builder.mesh(parallelogram<S>({0, 0, 1}, {0, 0.4, 0}, {0.4, 0, 0}), matte(0)), Rgb<S>(5));
  const auto scene = builder.build();
  expect_equals_path(scene, floor_camera(0), 1200, 64, 0.01, 5);
  // Of all that reaches the floor through the sheet first, light walks do nearly everything.
  const BidirectionalFilm film = render_bidirectional(scene, floor_camera(0), 64, 1, 4);
  EXPECT_GT(film.weighted(4, 1), 10 * film.weighted(0, 5));
}

/// Cameras that offer no importance get all strategies but t = 1: the weights know it. The same by the switch.
TEST(BidirectionalPath, WithoutLens) {
  auto builder = cornell<BallMaterial>(gloss());
  const auto scene = builder.build();
  ProbeCamera<S> probes;
  probes.add({0, 1, 0}, {0, -0.5, 0.1});
  probes.add({0.5, 0.2, -1}, {0, -0.5, 0.1});
  expect_equals_path(scene, probes, 8000, 3000, 0.01);
  const BidirectionalFilm film = render_bidirectional(scene, probes, 10, 1, 3);
  EXPECT_EQ(film.mean(film.sums.light), 0);
  expect_equals_path(scene, room_camera(), 64, 48, 0.01, 4, {k_unlimited_edges, false});
}

/// Every filter, sharp and out of focus. Caught: film points rounded to their pixel before the filter; the lens point left out
/// of the film's place.
TEST(BidirectionalPath, LightImageOfAllFilters) {
  for (const double aperture : {0.0, 0.3}) {
    for (const auto& filter : {ReconstructionFilter<S>::box(), ReconstructionFilter<S>::tent(1.5),
                               ReconstructionFilter<S>::gaussian(0.5)}) {
      expect_light_image_equals_eye_image(aperture, filter, 400);
    }
  }
}

}  // namespace
}  // namespace manylight::test::bidirectional_path_slow_test
