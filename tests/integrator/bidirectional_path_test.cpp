// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <span>

#include "integrator/bidirectional_scenes.hpp"

// Bidirectional path tracing against closed solutions and against path tracing, per path length and per strategy. False alarms
// over all seeds: 1e-3 per test (Sidak over its comparisons, 16 independent renderings each); the seeds are fixed.

namespace manylight::test::bidirectional_path_test {
namespace {

using S = double;
using V = Vec3<S>;

/// Reference sheet 7.4: walls that emit 1 and reflect 0.8 show 1 + 0.8 + ... + 0.8^k after k bounces, 5 without end. Every
/// strategy but s = 0 of the first segment takes part. Caught: a light walk one segment too short.
TEST(BidirectionalPath, ClosedFurnace) {
  SceneBuilder<Bvh<S>, Lambertian<S>> builder;
  builder.emit(builder.sphere({V(0), 1, true}, grey(0.8)), Rgb<S>(1));
  const auto scene = builder.build();
  const auto camera = look_at<S>({0.3, 0.2, 0.1}, {1, 0, 0}, 60, 8);
  const std::array<std::pair<unsigned, double>, 6> cases{
      {{1, 1}, {2, 1.8}, {3, 2.44}, {4, 2.952}, {6, 3.68928}, {k_unlimited_edges, 5}}};
  for (const auto& [edges, exact] : cases) {
    RunningMoments mean;
    for (unsigned run = 0; run < 16; ++run) {
      const BidirectionalFilm film = render_bidirectional(scene, camera, 8, run, 0, {edges});
      EXPECT_EQ(film.statistics.invalid, 0U);
      mean.add(film.mean());
    }
    EXPECT_LE(std::abs(mean.mean() - exact),
              student_limit(sidak_level(1e-3, cases.size()), 15) * mean.standard_error() + 1e-12)
        << edges << " segments: " << mean.mean();
    EXPECT_LT(mean.standard_error(), 0.01 * exact) << edges;
  }
}

/// The same in float, whatever the scale of the scene. 2e-5: float.
TEST(BidirectionalPath, ClosedFurnaceInFloatAtAnyScale) {
  for (const float scale : {1e-3F, 1.0F, 1e4F}) {
    SceneBuilder<Bvh<float>, Lambertian<float>> builder;
    builder.emit(builder.sphere({Vec3<float>(0), scale, true}, {Rgb<float>(0.8F)}), Rgb<float>(1));
    const auto scene = builder.build();
    const auto camera = look_at<float>(Vec3<float>(0.3F, 0.2F, 0.1F) * scale, {scale, 0, 0}, 60, 8);
    RunningMoments mean;
    for (unsigned run = 0; run < 16; ++run) {
      const BidirectionalFilm film = render_bidirectional(scene, camera, 8, run);
      EXPECT_EQ(film.statistics.invalid, 0U);
      mean.add(film.mean());
    }
    EXPECT_LE(std::abs(mean.mean() - 5), student_limit(sidak_level(1e-3, 3), 15) * mean.standard_error() + 2e-5 * 5);
    EXPECT_LT(mean.standard_error(), 0.05);
  }
}

/// Reference sheet 7.1: L = rho I / pi H / (H^2 + d^2)^(3/2) at d = 1; found by the drawn light and by the lens alone.
TEST(BidirectionalPath, PointLightOverAPlane) {
  SceneBuilder<Bvh<S>, Lambertian<S>> builder;
  builder.mesh(parallelogram<S>({0, 0, 0}, {5, 0, 0}, {0, 5, 0}), grey(0.5));
  builder.point_light({0, 0, 1}, 1);
  const auto scene = builder.build();
  const auto camera = look_at<S>({1, 0, 3}, {1, 0, 0}, 3, 1);
  RunningMoments mean, drawn, lens;
  for (unsigned run = 0; run < 16; ++run) {
    const BidirectionalFilm film = render_bidirectional(scene, camera, 10000, run, 2);
    mean.add(film.mean());
    drawn.add(film.unweighted(1, 2));
    lens.add(film.unweighted(2, 1));
  }
  const double limit = student_limit(sidak_level(1e-3, 3), 15);
  EXPECT_NEAR(drawn.mean(), 0.0562698, 1e-4);  // size of the pixel
  EXPECT_NEAR(mean.mean(), 0.0562698, limit * mean.standard_error() + 1e-4);
  EXPECT_NEAR(lens.mean(), 0.0562698, limit * lens.standard_error() + 1e-4);
  EXPECT_LT(mean.standard_error(), 2e-4);
  // Of so small a pixel light walks see little.
  EXPECT_LT(lens.standard_error(), 0.15 * lens.mean());
}

/// Every strategy alone makes the whole image of its path length, where no vertex is a Dirac's. Caught: the density of film
/// without its cubed cosine; connections with the lens from the first light vertex left out.
TEST(BidirectionalPath, EachStrategyAloneEqualsPathTracing) {
  auto builder = cornell<BallMaterial>(gloss());
  const auto scene = builder.build();
  constexpr unsigned k_lengths = 4;
  const Comparison c = compare_with_path(scene, room_camera(), 48, 24, k_lengths);
  const double limit = c.limit(16);
  for (unsigned n = 2; n <= k_lengths; ++n) {
    for (unsigned s = 0; s <= n; ++s) {
      const RunningMoments& alone = c.unweighted[n][s];
      EXPECT_LT(std::abs(z_between(alone, c.path_of_length[n])), limit)
          << "s = " << s << ", " << n << " segments: " << alone.mean() << " for " << c.path_of_length[n].mean();
      EXPECT_LT(alone.standard_error(), 0.15 * alone.mean());
    }
    EXPECT_LT(std::abs(z_between(c.weighted_of_length[n], c.path_of_length[n])), limit) << n << " segments";
    EXPECT_LT(c.weighted_of_length[n].standard_error(), 0.01 * c.weighted_of_length[n].mean());
  }
  EXPECT_LT(std::abs(z_between(c.bidirectional, c.path)), limit);
}

/// Shading normals that lean over: light walks correct for them, so that every strategy alone still makes the same image.
/// Caught: light walks without the correction.
TEST(BidirectionalPath, LeaningNormals) {
  BallBuilder builder;
  auto floor = parallelogram<S>({0, 0, -0.5}, {2, 0, 0}, {0, 2, 0});
  auto wall = parallelogram<S>({0, 1.5, 0.5}, {1.5, 0, 0}, {0, 0, 1});
  for (auto& normal : floor.normals) normal = glm::normalize(normal + V(0.5, 0.3, 0));
  wall.normals[0] = wall.normals[2] = glm::normalize(wall.normals[0] + V(-0.6, 0, 0.2));
  builder.mesh(floor, matte(0.7));
  builder.mesh(wall, gloss());
  builder.emit(builder.mesh(parallelogram<S>({-0.4, -0.2, 1}, {0, 0.4, 0}, {0.4, 0, 0}), matte(0)), Rgb<S>(5));
  const Comparison c = compare_with_path(builder.build(), floor_camera(0), 64, 64, 3);
  const double limit = c.limit(8);
  for (unsigned n = 2; n <= 3; ++n) {
    EXPECT_LT(std::abs(z_between(c.weighted_of_length[n], c.path_of_length[n])), limit) << n << " segments";
    for (unsigned s = 0; s <= n; ++s) {
      EXPECT_LT(std::abs(z_between(c.unweighted[n][s], c.path_of_length[n])), limit)
          << "s = " << s << ", " << n << " segments: " << c.unweighted[n][s].mean() << " for "
          << c.path_of_length[n].mean();
      EXPECT_LT(c.unweighted[n][s].standard_error(), 0.2 * c.path_of_length[n].mean());
    }
  }
}

TEST(BidirectionalPath, Sky) {
  BallBuilder builder = open_floor();
  add_sky(builder);
  expect_equals_path(builder.build(), floor_camera(0), 64, 64, 0.01);
}
TEST(BidirectionalPath, SunThroughAThinLens) {
  BallBuilder builder = open_floor();
  add_sun(builder);
  expect_equals_path(builder.build(), floor_camera(0.2), 150, 64, 0.01);
}
TEST(BidirectionalPath, SpotLightAndSphericalLight) {
  BallBuilder builder = open_floor();
  builder.lights.points.push_back({{0.5, -1.5, 1}, Rgb<S>(4), {-0.3, 1, -0.8}, 0.6, 0.3});
  builder.emit(builder.sphere({{-0.5, 0.3, 1}, 0.3, false}, matte(0.4)), Rgb<S>(5));
  expect_equals_path(builder.build(), floor_camera(0), 200, 64, 0.015);
}
/// A lamp that emits on both sides, and a wall on the way.
TEST(BidirectionalPath, TwoSidedLamp) {
  BallBuilder builder = open_floor();
  builder.emit(builder.mesh(parallelogram<S>({-0.2, 0, 0.2}, {0, 0.4, 0.1}, {0, 0, 0.4}), matte(0.3)), Rgb<S>(5), true);
  expect_equals_path(builder.build(), floor_camera(0), 128, 64, 0.015);
}

/// Caught: see the slow test of all filters.
TEST(BidirectionalPath, LightImageEqualsEyeImagePixelByPixel) {
  expect_light_image_equals_eye_image(0, ReconstructionFilter<S>::box(), 100);
  expect_light_image_equals_eye_image(0.3, ReconstructionFilter<S>::gaussian(0.5), 100);
}

/// A window's pixels and an image refined in steps have the same bits as the whole one.
TEST(BidirectionalPath, WindowsAndRangesChangeNoBit) {
  const auto scene = room_of_balls().build();
  const auto camera = look_at<S>({0, -0.95, 0}, {0, 1, -0.2}, 70, 24);
  using Integrator = BidirectionalPathIntegrator<BallScene>;
  const Integrator integrator(scene, {});
  const IndependentSampler<S> sampler{3};
  const auto filter = ReconstructionFilter<S>::gaussian(0.5);
  const auto render = [&](const Window& window, std::span<const std::uint32_t> counts) {
    BidirectionalSums sums(window.pixel_count(), 2);
    std::uint32_t first = 0;
    for (const std::uint32_t count : counts) {
      (void)accumulate_bidirectional_samples(integrator, camera, filter, window, sampler, first, count, sums,
                                             SerialExecutor{});
      first += count;
    }
    return sums;
  };
  const std::array<std::uint32_t, 1> at_once{5};
  const std::array<std::uint32_t, 3> in_steps{1, 3, 1};
  const Window all = Window::of(camera);
  const BidirectionalSums whole = render(all, at_once);
  const BidirectionalSums refined = render(all, in_steps);
  EXPECT_EQ(whole.eye, refined.eye);
  EXPECT_EQ(whole.light, refined.light);
  const Window part{5, 7, 19, 22};
  const BidirectionalSums window = render(part, at_once);
  for (std::uint32_t y = part.y0; y < part.y1; ++y) {
    for (std::uint32_t x = part.x0; x < part.x1; ++x) {
      EXPECT_EQ(window.eye[part.index(x, y)], whole.eye[all.index(x, y)]);
      EXPECT_EQ(window.light[part.index(x, y)], whole.light[all.index(x, y)]);
      EXPECT_EQ(window.strategies.at(2, 1).unweighted[part.index(x, y)],
                whole.strategies.at(2, 1).unweighted[all.index(x, y)]);
    }
  }
  EXPECT_THROW((void)render(Window{0, 0, 25, 1}, at_once), ParameterError);
  EXPECT_THROW(Integrator(scene, {0}), ParameterError);
}

}  // namespace
}  // namespace manylight::test::bidirectional_path_test
