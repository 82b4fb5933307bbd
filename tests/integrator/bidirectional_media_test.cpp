// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "integrator/bidirectional_scenes.hpp"
#include "manylight/scattering/rough_dielectric.hpp"
#include "manylight/scene/instants.hpp"

// Bidirectional path tracing through media, absorbing glass and masks, and in motion. False alarms: see
// bidirectional_path_test.cpp.

namespace manylight::test::bidirectional_media_test {
namespace {

using S = double;
using V = Vec3<S>;

TEST(BidirectionalMedia, BoxOfFog) { expect_equals_path(box_of_fog(false).build(), floor_camera(0), 100, 32, 0.02, 3); }

TEST(BidirectionalMedia, BoxOfSmokeUnderASky) {
  FoggyBuilder builder = box_of_fog(true);
  builder.lights.areas.clear();
  builder.lights.environments.emplace_back();
  expect_equals_path(builder.build(), floor_camera(0), 64, 32, 0.01, 3);
}

/// Endless smoke: no light walk starts at infinity, and the weights know it. White smoke under a white sky cannot be seen.
/// Caught: such walks started.
TEST(BidirectionalMedia, EndlessSmokeUnderAWhiteSky) {
  FoggyBuilder builder;
  builder.media = {even_smoke({-1, -1, -1}, {1, 1, 1}, 2, 1, 0.7)};
  builder.outside = 1;
  builder.lights.environments.emplace_back();
  builder.mesh(parallelogram<S>({0, 0, -20}, {0.01, 0, 0}, {0, 0.01, 0}), 1);
  RunningMoments mean;
  for (unsigned run = 0; run < 16; ++run) mean.add(render_bidirectional(builder.build(), floor_camera(0), 32, run).mean());
  EXPECT_NEAR(mean.mean(), 1, student_limit(1e-3, 15) * mean.standard_error() + 1e-9);
  EXPECT_LT(mean.standard_error(), 0.01);
}

/// Lambertian, perhaps half open, or frosted glass that absorbs.
struct GlassShader {
  using Material = AnyOf<Lambertian<S>, RoughDielectric<S>>;
  static constexpr bool k_may_be_transparent = true;
  static constexpr bool k_may_absorb = true;
  Material surface{};
  bool is_glass = false;
  S opaque = 1;

  [[nodiscard]] Material material(const SurfacePoint<S>&, bool) const noexcept { return surface; }
  [[nodiscard]] bool is_two_sided() const noexcept { return !is_glass; }
  [[nodiscard]] bool is_transparent() const noexcept { return opaque < 1; }
  [[nodiscard]] S opacity(const SurfacePoint<S>&) const noexcept { return opaque; }
  [[nodiscard]] Rgb<S> interior_absorption() const noexcept { return Rgb<S>(is_glass ? 1.5 : 0.0); }
};

Scene<Bvh<S>, GlassShader> glass_scene(const Shapes<S>& shapes, const std::vector<GlassShader>& shaders, S radiance) {
  EmitterList<S> lights;
  lights.areas.push_back({0, Texture<S>(Rgb<S>(radiance)), false});
  std::vector<std::uint32_t> ids;
  for (std::uint32_t i = 0; i < shaders.size(); ++i) ids.push_back(i);
  return {Bvh<S>(shapes), shaders, ids, lights};
}
PerspectiveCamera<S> narrow_camera() {
  PerspectiveConfig<S> config;
  config.to_world = {{1, 0, 0, 0}, {0, 0, 1, 0}, {0, 1, 0, 0}, {0, -2.5, 0, 1}};
  config.horizontal_fov = 22;
  config.width = config.height = 8;
  return PerspectiveCamera<S>(config);
}

/// A lamp seen through a frosted ball: connections through the inside of the ball absorb as walks do. Each strategy alone,
/// through the ball (3 segments) and with a reflection inside (4). Caught: no absorption along connections.
TEST(BidirectionalMedia, AbsorbingRoughGlass) {
  RoughDielectric<S> frosted;
  frosted.alpha_u = frosted.alpha_v = 0.5;
  Shapes<S> shapes;
  shapes.meshes = {parallelogram<S>({0, 1.5, 0}, {1, 0, 0}, {0, 0, 1})};
  shapes.spheres = {{{0, 0, 0}, 0.5, false}};
  const auto scene = glass_scene(shapes, {{Lambertian<S>{Rgb<S>(0.0)}, false, 1}, {frosted, true, 1}}, 6);
  const Comparison c = compare_with_path(scene, narrow_camera(), 100, 50, 4);
  const double limit = c.limit(12);
  EXPECT_LT(std::abs(z_between(c.bidirectional, c.path)), limit) << c.bidirectional.mean() << " for " << c.path.mean();
  for (unsigned n = 3; n <= 4; ++n) {
    EXPECT_LT(std::abs(z_between(c.weighted_of_length[n], c.path_of_length[n])), limit) << n << " segments";
    EXPECT_LT(c.weighted_of_length[n].standard_error(), 0.03 * c.path_of_length[n].mean());
    for (unsigned s = 0; s <= n; ++s) {
      EXPECT_LT(std::abs(z_between(c.unweighted[n][s], c.path_of_length[n])), limit)
          << "s = " << s << ", " << n << " segments: " << c.unweighted[n][s].mean() << " +- "
          << c.unweighted[n][s].standard_error() << " for " << c.path_of_length[n].mean();
    }
  }
}

/// A half-open mask before a lamp, passed by chance or in part.
TEST(BidirectionalMedia, Mask) {
  Shapes<S> shapes;
  shapes.meshes = {parallelogram<S>({-0.5, 0, 1.5}, {0, 0.5, 0}, {0.5, 0, 0}),
                   parallelogram<S>({0, 0, -0.5}, {2, 0, 0}, {0, 2, 0}),
                   parallelogram<S>({-0.5, 0, 1}, {0, 0.4, 0}, {0.4, 0, 0})};
  const auto scene = glass_scene(shapes,
                                 {{Lambertian<S>{Rgb<S>(0.0)}, false, 1},
                                  {Lambertian<S>{Rgb<S>(0.6)}, false, 1},
                                  {Lambertian<S>{Rgb<S>(0.5)}, false, 0.4}},
                                 6);
  expect_equals_path(scene, floor_camera(0), 150, 50, 0.02);
}

/// A lamp that is bright at one of two instants: walks of different instants are never joined.
TEST(BidirectionalMedia, InMotion) {
  using Moved = Scene<Bvh<S>, UniformShader<Lambertian<S>>, NoMedia, Moving>;
  std::vector<Moved> instants;
  std::vector<RunningMoments> path(2);
  const auto camera = floor_camera(0);
  Shapes<S> shapes;
  shapes.meshes = {parallelogram<S>({0, 0, -0.5}, {2, 0, 0}, {0, 2, 0}),
                   parallelogram<S>({0, 1, 0}, {2, 0, 0}, {0, 0, 1})};
  for (const S intensity : {1.0, 3.0}) {
    EmitterList<S> lights;
    lights.points.push_back({{intensity - 2, 0, 1}, Rgb<S>(intensity)});
    instants.emplace_back(Bvh<S>(shapes), std::vector<UniformShader<Lambertian<S>>>{{grey(0.6)}},
                          std::vector<std::uint32_t>{0, 0}, lights);
  }
  for (unsigned run = 0; run < 16; ++run) {
    for (std::size_t i = 0; i < 2; ++i) path[i].add(path_means(instants[i], camera, 32, 0, run).all);
  }
  const Instants<Moved> scenes(instants);
  RunningMoments moving;
  for (unsigned run = 0; run < 16; ++run) {
    const BidirectionalPathIntegrator<Instants<Moved>> integrator(scenes, {});
    BidirectionalSums sums(std::size_t{camera.width()} * camera.height());
    (void)accumulate_bidirectional_samples(integrator, camera, ReconstructionFilter<S>::box(), Window::of(camera),
                                           IndependentSampler<S>{run}, 0, 64, sums, SerialExecutor{});
    S mean = 0;
    for (std::size_t i = 0; i < sums.eye.size(); ++i) mean += sums.eye[i].x + sums.light[i].x;
    moving.add(mean / (64.0 * static_cast<S>(sums.eye.size())));
  }
  const S expected = (path[0].mean() + path[1].mean()) / 2;
  const S error = std::hypot(path[0].standard_error(), path[1].standard_error()) / 2;
  EXPECT_LT(std::abs(z_score(moving.mean(), moving.standard_error(), expected, error)), student_limit(1e-3, 15));
  EXPECT_LT(std::hypot(moving.standard_error(), error), 0.01 * expected);
}

}  // namespace
}  // namespace manylight::test::bidirectional_media_test
