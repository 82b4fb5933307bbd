// SPDX-License-Identifier: Apache-2.0
// Images of VPLs that were put there by hand, or changed after they were traced: coincident, split, reordered, two of
// unlike colour, of one generator only.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numeric>

#include "integrator/same_lights.hpp"

namespace manylight::test::hand_made_lights_test {
namespace {

using S = double;
using Builder = SceneBuilder<Bvh<S>, Lambertian<S>>;
using Light = VertexOf<Builder::SceneType>;

constexpr double k_infinite = std::numeric_limits<double>::infinity();

Light reflecting_light(const Vec3<S>& position, const Vec3<S>& ng, S strength) {
  Light light;
  light.position = position;
  light.ng = light.w = ng;
  light.shading = detail::ShadingFrame<S, true>(Frame<S>(ng));
  light.material = Lambertian<S>{Rgb<S>(0.5)};
  light.alpha = 0.5;
  light.strength = Rgb<S>(strength);
  light.edges = 1;
  return light;
}

/// Stability case 3: virtual lights at the very point that a pixel sees, or 1e-300 to 1e-3 m above it, facing it.
/// Asserted for brute force, lightcuts and bidirectional lightcuts: no sample is invalid, no pixel is infinite;
/// coincident lights add nothing at all; a close one adds no more than the clamp lets through, S C_clamp I; without a
/// clamp the sum stays finite down to distances of 1e-100 m. Caught: coincident pairs connected (0/0).
TEST(HandMadeLights, AtThePointThatIsSeen) {
  Builder builder;
  builder.mesh(parallelogram<S>({0, 0, 0}, {5, 0, 0}, {0, 5, 0}), {Rgb<S>(0.5)});
  builder.point_light({0, 0, 1}, 1);
  const auto scene = builder.build();
  ProbeCamera<S> camera;
  camera.add({0, 0, 0}, {0, 0, 1});
  IndependentStream<S> stream(0, Stage::test, 0, 0);
  RayCounts rays;
  const auto seen = scene.intersect(camera.ray({0.5, 0.5}, {0, 0}), stream, rays);
  ASSERT_TRUE(seen);
  ASSERT_EQ(glm::length(seen->position), 0);
  Settings settings;
  settings.samples = 3;
  settings.vpls = 1;
  SameLights lights(scene, camera, settings);
  std::vector<Light> only_exact = lights.side.lights.vpls;
  std::erase_if(only_exact, [](const Light& light) { return !light.exact; });
  ASSERT_EQ(only_exact.size(), 1u);
  const double base = 0.5 * k_inv_pi<S>;
  const auto images = [&] { return std::array{lights.all_pairs(), lights.lightcuts(), lights.bdlc()}; };
  for (const double clamp : {0.01, k_infinite}) {
    lights.side.weights.c_clamp = clamp;
    for (const double height : {0.0, 1e-300, 1e-160, 1e-154, 1e-100, 1e-16, 1e-8, 1e-3}) {
      lights.side.lights.vpls = only_exact;
      for (const int count : {1, 5}) {
        for (int i = 0; i < count; ++i) {
          lights.side.lights.vpls.push_back(reflecting_light({0, 0, height}, {0, 0, -1}, 1));
        }
        if (clamp == k_infinite && height > 0 && height < 1e-100) continue;  // what overflows is invalid by rights
        for (const auto& image : images()) {
          EXPECT_EQ(image.statistics.invalid_samples, 0u) << height;
          EXPECT_EQ(image.statistics.pairs.bound_violations, 0u) << height;
          const S pixel = image.image.pixels[0].x;
          EXPECT_TRUE(std::isfinite(pixel)) << height;
          EXPECT_GE(pixel, base * (1 - 1e-12)) << height;  // rounding
          const auto most = static_cast<double>(lights.side.lights.vpls.size() - 1) * 0.5 * clamp;
          EXPECT_LE(pixel, (base + (height > 0 ? most : 0)) * (1 + 1e-12)) << height;  // rounding
        }
      }
    }
  }
}

/// Stability case 9 as an image: 10,000 pixels of one and the same point, lit by a red and a blue light of powers 1:9
/// that a cut of one cluster never tells apart. Every pixel has a key of its own; their mean is the sum of both lights
/// (z-test, false-alarm rate 1e-4 over channels and methods). Caught: the pixel's key not passed on (all alike).
TEST(HandMadeLights, RedAndBlueInTheMeanOverPixels) {
  Builder builder;
  builder.mesh(parallelogram<S>({0, 0, 0}, {5, 0, 0}, {0, 5, 0}), {Rgb<S>(0.5)});
  builder.lights.points.push_back({{-1, 0, 1}, {1, 0, 0}});
  builder.lights.points.push_back({{1, 0, 2}, {0, 0, 9}});
  const auto scene = builder.build();
  ProbeCamera<S> camera;
  for (int i = 0; i < 10'000; ++i) camera.add({0, 0, 0}, {0, 0, 1});
  Settings settings;
  settings.samples = 1;
  settings.vpls = 2;
  settings.threshold = 0;
  settings.max_cut = 1;
  const double red = 0.5 * k_inv_pi<S> / std::pow(2, 1.5);
  const double blue = 0.5 * k_inv_pi<S> * 9 * 2 / std::pow(5, 1.5);
  std::vector<double> mean, error, reference;
  for (const Method method : k_cut_methods) {
    std::array<RunningMoments, 2> moments;
    for (const auto& pixel : render(method, scene, camera, settings).pixels) {
      moments[0].add(pixel.x);
      moments[1].add(pixel.z);
    }
    for (std::size_t c = 0; c < 2; ++c) {
      mean.push_back(moments[c].mean());
      error.push_back(moments[c].standard_error());
      reference.push_back(c == 0 ? red : blue);
      EXPECT_GT(error.back(), 0) << "pixels differ";
    }
  }
  const ZTestResult z = z_test(mean, error, reference, std::vector<double>(mean.size(), 0.0), 1e-4);
  EXPECT_EQ(z.failures, 0u) << "worst z " << z.worst << ": " << mean[z.worst_index] << " for "
                            << reference[z.worst_index];
}

/// Oracle O-30 with cuts: inside a sphere every pair has w = min(1, 4 pi^2 R^2 C_clamp), so that what virtual lights
/// reflect is scaled by just that; the exact light is not. A cut's estimates do not depend on their representatives
/// then and must be exact at any threshold, up to rounding. C_clamp grows with the number of VPLs: the factor doubles
/// with it until it is 1. Caught: D left out of the weight; the clamp set against T I.
TEST(HandMadeLights, ClampInTheSphereIsOneFactor) {
  const S radius = 1.5;
  Builder builder;
  builder.sphere({Vec3<S>(0), radius, true}, {Rgb<S>(0.5)});
  builder.point_light(Vec3<S>(0), k_pi<S>);
  const auto scene = builder.build();
  ProbeCamera<S> camera;
  camera.add({radius, 0, 0}, {0.3, 0.2, 0.1});
  camera.add({0, -radius, 0}, {0.3, 0.2, 0.1});
  const S pair = 1 / sqr(2 * k_pi<S> * radius);
  std::vector<double> factors;
  for (const std::size_t count : {100u, 200u, 400u, 800u, 1600u}) {
    Settings settings;
    settings.vpls = count;
    settings.samples = 4;
    settings.clamp_scale = 1.0 / 800;
    settings.adaptation = 1.0;
    SameLights lights(scene, camera, settings);
    const double factor = std::min(1.0, lights.side.weights.c_clamp / pair);
    factors.push_back(factor);
    double intensity = 0;
    for (const Light& v : lights.side.lights.vpls) intensity += v.exact ? 0.0 : v.strength.x;
    const double expected = 0.5 / sqr(radius) + factor * pair * intensity * 0.5;
    for (const double threshold : {1.0, 0.02, 0.0}) {
      lights.config.threshold = threshold;
      // Sums of 6400 terms, cosines of chords at rounding distance from the sphere.
      for (const auto& pixel : lights.lightcuts().image.pixels)
        EXPECT_NEAR(pixel.x, expected, 1e-10) << count;  // see above
    }
    for (const auto& pixel : lights.all_pairs().image.pixels)
      EXPECT_NEAR(pixel.x, expected, 1e-10) << count;  // as above
  }
  for (std::size_t i = 1; i < factors.size(); ++i) {
    // I_avg N is the flux that the VPLs happen to hold, 1.4 / sqrt(N) of it by roulette: 14 % at 100.
    EXPECT_NEAR(factors[i], std::min(1.0, 2 * factors[i - 1]), 0.25 * factors[i]) << i;
  }
  EXPECT_LT(factors.front(), 0.4);  // a quarter, 14 % uncertain
  EXPECT_EQ(factors.back(), 1);
}

/// Both pairs sums and both cuts at threshold 0.
template <class Lights>
std::array<Image<S>, 4> exact_images(Lights& lights) {
  lights.config.threshold = 0;
  lights.config.max_cut = 1u << 30;
  return {lights.all_pairs().image, lights.lightcuts().image, lights.all_recursive_pairs().image, lights.bdlc().image};
}

/// Oracle O-32: every VPL split in two of half its intensity at the same place, C_clamp as it was: no pixel changes, by
/// brute force and by cuts at threshold 0, with a clamp that binds. 1e-12: sums of other order. Caught: the clamp set
/// against T I instead of T.
TEST(HandMadeLights, SplitInTwoChangeNothing) {
  auto builder = diffuse_room();
  builder.point_light({-0.5, -0.5, 0.5}, 0.2);
  const auto scene = builder.build();
  const auto camera = diffuse_room_camera(5);
  Settings settings;
  settings.vpls = 60;
  settings.samples = 3;
  settings.adaptation = 0.5;
  settings.clamp_scale = 1.0 / 800;
  SameLights lights(scene, camera, settings);
  const auto whole = exact_images(lights);
  std::vector<Light> halves;
  for (Light v : lights.side.lights.vpls) {
    v.strength /= 2;
    halves.push_back(v);
    halves.push_back(v);
  }
  lights.side.lights.vpls = halves;
  const auto split = exact_images(lights);
  for (std::size_t i = 0; i < whole.size(); ++i)
    EXPECT_LT(largest_difference(split[i], whole[i]), 1e-12) << i;  // order
  EXPECT_LT(largest_difference(whole[1], whole[0]), 1e-12);         // order of sums
  EXPECT_LT(largest_difference(whole[3], whole[2]), 1e-12);         // order of sums
  lights.side.weights.c_clamp = k_infinite;
  EXPECT_GT(largest_difference(lights.all_pairs().image, whole[0]), 0.1) << "the clamp binds";
}

/// Oracle O-33: the order of VPLs does not matter, to rounding of the sums. (Threads and tiles: Threads, to the bit.)
/// Caught: the last batch of shadow rays dropped; leaves numbered by their place in the tree's own list.
TEST(HandMadeLights, InAnyOrder) {
  auto builder = diffuse_room();
  builder.point_light({-0.5, -0.5, 0.5}, 0.2);
  const auto scene = builder.build();
  const auto camera = diffuse_room_camera(5);
  Settings settings;
  settings.vpls = 101;
  settings.samples = 3;
  settings.adaptation = 0.5;
  settings.clamp_scale = 1.0 / 800;
  SameLights lights(scene, camera, settings);
  const auto before = exact_images(lights);
  const std::vector<Light> ordered = lights.side.lights.vpls;
  const std::size_t n = ordered.size();
  const std::size_t stride = n % 37 == 0 ? 41 : 37;  // coprime to n, so that every light is met once
  for (std::size_t i = 0; i < n; ++i) lights.side.lights.vpls[i] = ordered[(i * stride + 5) % n];
  const auto after = exact_images(lights);
  for (std::size_t i = 0; i < before.size(); ++i)
    EXPECT_LT(largest_difference(after[i], before[i]), 1e-12) << i;  // order
  // Trees are built by place, representatives drawn by node: coarse cuts do not see the order either.
  lights.config.threshold = 0.02;
  const auto permuted_cut = lights.lightcuts().image;
  lights.side.lights.vpls = ordered;
  EXPECT_LT(largest_difference(permuted_cut, lights.lightcuts().image), 1e-12);  // order of sums
}

/// Oracle O-37: floor of albedo 0.5, ceiling of 0.8 at z = 2, a light of 100 W at (0.6, 0, 0.7); light that comes over
/// the ceiling alone makes 0.147992 at the floor's origin. The two generators of that path give it alike, each taken
/// with weight 1: k = 1 by virtual lights on the ceiling (no clamp), k = 2 by eye vertices on the ceiling (a clamp that
/// takes everything from k = 1). 16 runs, see `agrees`. Caught: A_2 without albedo; the strength of a VPL without it;
/// the second sensor pruned.
TEST(HandMadeLights, TwoGeneratorsOfOnePath) {
  Builder builder;
  builder.mesh(parallelogram<S>({0, 0, 0}, {500, 0, 0}, {0, 500, 0}), {Rgb<S>(0.5)});
  builder.mesh(parallelogram<S>({0, 0, 2}, {0, 500, 0}, {500, 0, 0}), {Rgb<S>(0.8)});
  const S intensity = 100 / (4 * k_pi<S>);
  builder.point_light({0.6, 0, 0.7}, intensity);
  const auto scene = builder.build();
  ProbeCamera<S> camera;
  camera.add({0, 0, 0}, {0.001, 0.002, 0.01});
  const double direct = 0.5 * k_inv_pi<S> * intensity * 0.7 / std::pow(0.6 * 0.6 + 0.7 * 0.7, 1.5);
  Settings settings;
  settings.max_edges = 3;
  for (const Method method : k_methods) {
    const bool by_eye = method == Method::path || method == Method::bdlc;
    settings.samples = by_eye ? 2000 : 1;
    settings.vpls = by_eye ? 2 : 5000;  // of bdlc the exact light and some that C_clamp refers to, all of weight 0
    settings.clamp_scale = method == Method::bdlc ? 1e-30 : k_infinite;
    settings.threshold = by_eye ? 0 : 1e-3;  // 2 % would be of the direct light, seven times as bright
    const RunningMoments moments = repeat(method, scene, camera, settings, 16)[0];
    // 5e-7: digits of the oracle.
    EXPECT_NEAR(moments.mean() - direct, 0.147992, 5 * moments.standard_error() + 5e-7) << name(method);
    EXPECT_LT(moments.standard_error(), 0.01 * 0.147992) << name(method);
    RecordProperty(name(method), std::to_string(moments.mean() - direct));
  }
}

}  // namespace
}  // namespace manylight::test::hand_made_lights_test
