// SPDX-License-Identifier: Apache-2.0
// Spot lights by every method, against closed forms: cones apart, opposed in one cluster, edges on the receiver.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "integrator/same_lights.hpp"

namespace manylight::test::spot_lights_test {
namespace {

using S = double;
using Builder = SceneBuilder<Bvh<S>, Lambertian<S>>;

PointEmitter<S> spot(const Vec3<S>& position, const Vec3<S>& axis, S cutoff, S beam_width, S intensity = 1) {
  return {position, Rgb<S>(intensity), axis, cutoff, beam_width};
}

/// Radiance that leaves a floor of reflectance 1/2 below all of `spots`.
S expected(const std::vector<PointEmitter<S>>& spots, const Vec3<S>& target) {
  S sum = 0;
  for (const PointEmitter<S>& light : spots) {
    const Vec3<S> down = target - light.position;
    const S distance = glm::length(down);
    const Vec3<S> axis = glm::normalize(light.axis);
    const S angle = std::acos(std::clamp(glm::dot(down, axis) / distance, -1.0, 1.0));
    const S penumbra = (light.cutoff - angle) / (light.cutoff - light.beam_width);
    const S falloff = angle >= light.cutoff ? 0 : std::min(1.0, penumbra);
    sum += 0.5 * k_inv_pi<S> * light.intensity.x * falloff * -down.z / (distance * distance * distance);
  }
  return sum;
}

// Direct light is exact where no random number takes part: in all methods but paths, which choose a light. Pairs of
// opposed axes at one place are one cluster for most of its refinement. At threshold 0 every pair with light is
// reached; a target right outside of every cone is exactly black. Planted bugs seen to fail: the beam width as cutoff,
// and the axis reversed, in the bound; the flux in place of 4 pi I; no falloff in next event estimation.
TEST(SpotLightMethods, DirectLightIsExact) {
  std::vector<PointEmitter<S>> spots;
  for (int i = 0; i < 40; ++i) {
    const Vec3<S> position(-2 + 0.1 * i, 0.3 * std::sin(i), 1 + 0.01 * i);
    const Vec3<S> axis(0.4 * std::sin(3.0 * i), 0.4 * std::cos(5.0 * i), -1);
    spots.push_back(spot(position, axis, 0.1 + 0.01 * i, 0.005 * i, 1 + i % 3));
    spots.push_back(spot(position, -axis, 0.3, 0.1, 5));  // away from the floor
  }
  spots.push_back(spot({0, 0, 1}, {0, 0, -1}, std::atan(0.5), std::atan(0.5)));  // a hard edge at 0.5 from the origin
  Builder builder;
  builder.mesh(parallelogram<S>({0, 0, 0}, {6, 0, 0}, {0, 6, 0}), {Rgb<S>(0.5)});
  builder.lights.points = spots;
  const auto scene = builder.build();
  ProbeCamera<S> camera;
  for (int i = 0; i < 60; ++i) {
    const Vec3<S> target(-2.5 + 0.08 * i, 0.9 * std::sin(2.0 * i), 0);
    camera.add(target, target + Vec3<S>(0, 0, 0.5));
  }
  for (const S r : {0.4999999, 0.5000001}) camera.add({r, 0, 0}, {r, 0, 0.5});
  camera.add({5, 5, 0}, {5, 5, 0.5});
  Settings settings;
  settings.samples = 1;
  settings.vpls = 1;  // of which light paths of two edges leave none
  settings.max_edges = 2;
  settings.threshold = 0;
  settings.max_cut = 1u << 30;
  for (const Method method : {Method::vpl, Method::lightcuts, Method::bdlc}) {
    const Film film = render(method, scene, camera, settings);
    EXPECT_EQ(film.bound_violations, 0u) << name(method);
    for (std::size_t i = 0; i < film.pixels.size(); ++i) {
      const S exact = expected(spots, camera.targets[i]);
      // acos of the oracle loses half the digits next to the axis: 1e-8 of an angle, over the narrowest penumbra, 0.1.
      EXPECT_NEAR(film.pixels[i].x, exact, 1e-6 * exact + 1e-14)  // of offset shadow rays
          << name(method) << " pixel " << i;
    }
    EXPECT_EQ(film.pixels.back().x, 0) << name(method);
  }
  // A path chooses one of the lights: test of its mean over 16 runs, false-alarm rate 1e-4 over the pixels.
  std::vector<RunningMoments> moments(camera.targets.size());
  for (std::uint64_t run = 0; run < 16; ++run) {
    settings.seed = run;
    settings.samples = 1000;
    const Film one = render_paths(scene, camera, settings);
    for (std::size_t i = 0; i < moments.size(); ++i) moments[i].add(one.pixels[i].x);
  }
  const double limit = student_limit(sidak_level(1e-4, static_cast<double>(moments.size())), 15);
  for (std::size_t i = 0; i < moments.size(); ++i) {
    const S exact = expected(spots, camera.targets[i]);
    EXPECT_NEAR(moments[i].mean(), exact, limit * moments[i].standard_error() + 1e-6 * exact)  // as above
        << "pixel " << i;
  }
  EXPECT_EQ(moments.back().mean(), 0);
}

// Two spots in a closed room: the methods agree where light bounces (z-test of the mean of all
// pixels over 16 runs each, false-alarm rate 1e-4). Planted bug seen to fail: light paths that
// leave with the density of the whole sphere.
TEST(SpotLightMethods, AgreeOnBouncedLight) {
  Builder builder;
  auto room = box_mesh<S>({-1, -1, -1}, {1, 1, 1});
  room.flip_normals = true;
  builder.mesh(room, {Rgb<S>(0.6)});
  builder.lights.points = {spot({0.2, 0, 0}, {0.5, 0.2, -1}, 0.4, 0.1, 3),
                           spot({0.2, 0, 0}, {-0.5, 0, 1}, 0.9, 0.9, 2)};
  const auto scene = builder.build();
  ProbeCamera<S> camera;
  for (const S x : {-0.7, -0.2, 0.3, 0.8}) camera.add({x, 0.1, -1}, {x, 0, 0});
  std::array<RunningMoments, 4> moments;
  for (std::size_t m = 0; m < k_methods.size(); ++m) {
    for (std::uint64_t run = 0; run < 16; ++run) {
      Settings settings;
      settings.seed = run;
      settings.samples = k_methods[m] == Method::path ? 1000 : 16;
      settings.vpls = 1000;
      settings.max_edges = 4;
      const Film film = render(k_methods[m], scene, camera, settings);
      EXPECT_EQ(film.bound_violations, 0u);
      moments[m].add(film.mean().x);
    }
  }
  const double limit = student_limit(sidak_level(1e-4, 3), 15);
  for (std::size_t m = 1; m < 4; ++m) {
    const double error = std::hypot(moments[0].standard_error(), moments[m].standard_error());
    EXPECT_NEAR(moments[m].mean(), moments[0].mean(), limit * error) << name(k_methods[m]);
    EXPECT_LT(error, 0.03 * moments[0].mean()) << "the test can see a difference";
  }
}

}  // namespace
}  // namespace manylight::test::spot_lights_test
