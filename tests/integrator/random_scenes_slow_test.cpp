// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <iostream>

#include "integrator/textured_scene.hpp"

namespace manylight::test::random_scenes_slow_test {
namespace {

using S = double;
using Kind = TexturedShader::Kind;

/// A random small room: a floor, some walls, blocks and balls of random materials, one to four random lights.
TexturedScene random_scene(RandomVertices<S>& random) {
  TexturedBuilder b;
  const auto shader = [&]() -> TexturedShader {
    const auto color = random.chance(0.3)
                           ? Texture<S>::checkerboard(random.color(0.3, 0.8), random.color(0, 0.3),
                                                      {random.uniform(1, 8), 0, 0, 0, random.uniform(1, 8), 0})
                           : Texture<S>(random.color(0.05, 0.7));
    if (random.chance(0.6)) return {color};
    if (random.chance(0.5)) return {color, Kind::phong, random.uniform(0.05, 0.3), random.log_uniform(2, 300)};
    return {color, Kind::ward, random.uniform(0.05, 0.3), random.log_uniform(0.05, 0.6)};
  };
  b.mesh(parallelogram<S>({0, 0, -1}, {1, 0, 0}, {0, 1, 0}), shader());
  if (random.chance(0.8)) b.mesh(parallelogram<S>({0, 1, 0}, {1, 0, 0}, {0, 0, 1}), shader());
  if (random.chance(0.8)) b.mesh(parallelogram<S>({-1, 0, 0}, {0, 1, 0}, {0, 0, 1}), shader());
  if (random.chance(0.5)) b.mesh(parallelogram<S>({1, 0, 0}, {0, 0, 1}, {0, 1, 0}), shader());
  if (random.chance(0.3)) b.mesh(parallelogram<S>({0, 0, 1}, {0, 1, 0}, {1, 0, 0}), shader());
  for (int i = static_cast<int>(random.uniform(0, 3)); i > 0; --i) {
    const Vec3<S> lo = random.point({0, 0.2, -0.4}, 0.5);
    b.mesh(box_mesh<S>(lo, lo + Vec3<S>(random.uniform(0.1, 0.5), random.uniform(0.1, 0.5), random.uniform(0.1, 0.5))),
           shader());
  }
  bool is_lit = false;
  while (!is_lit) {
    for (int i = static_cast<int>(random.uniform(0, 3)); i > 0; --i) {
      const Vec3<S> u = random.direction() * random.log_uniform(0.03, 0.4);
      const Vec3<S> v = glm::normalize(glm::cross(u, random.direction())) * random.log_uniform(0.03, 0.4);
      const auto id = b.mesh(parallelogram<S>(random.point({0, 0, 0.3}, 0.6), u, v), {Texture<S>(Rgb<S>(0))});
      b.lights.areas.push_back(
          {id, Texture<S>(random.color(0.2, 1) * random.log_uniform(0.5, 20)), random.chance(0.5)});
      is_lit = true;
    }
    for (int i = static_cast<int>(random.uniform(0, 2.5)); i > 0; --i) {
      b.lights.points.push_back({random.point({0, 0, 0.2}, 0.7), random.color(0.2, 1) * random.log_uniform(0.05, 2)});
      is_lit = true;
    }
    if (random.chance(0.25)) {
      b.lights.directionals.push_back({{random.uniform(-1, 1), random.uniform(-1, 1), -1}, random.color(0.5, 2)});
      is_lit = true;
    }
    if (random.chance(0.25)) {
      b.lights.environments.push_back({random.color(0.05, 1), nullptr});
      is_lit = true;
    }
  }
  if (random.chance(0.6)) b.sphere({random.point({0, 0.2, -0.5}, 0.4), random.uniform(0.1, 0.4), false}, shader());
  return b.build();
}

/// Stability case 34, honest errors over 200 random scenes, 300 VPLs and 4 eye paths. Claimed is 2 % of the pixel for
/// each cluster of the cut, which as a bound of the pixel's error holds always (asserted for every pixel) and says
/// little. True is, relative to the pixel or the floor: median 0.8 %, 84 % of pixels within 2 %, 97 % within 4 %, all
/// within 11 %; the mean error is below 0.1 %, by a tenth of the pairs (lightcuts) and a twentieth (bidirectional).
/// Pinned. So 2 % per cluster is 4 % per pixel. Caught: one sensor per gather node; a threshold of twice the size.
TEST(RandomScenes, ClaimedAndTrueErrors) {
  RandomVertices<S> random(34);
  std::array<Quantiles, 2> errors;
  std::array<RunningMoments, 2> shares, bias;
  std::uint64_t violations = 0;
  for (int n = 0; n < 200; ++n) {
    const auto scene = random_scene(random);
    const auto camera = look_at<S>(Vec3<S>(random.uniform(-0.8, 0.8), -2.2, random.uniform(-0.5, 0.8)),
                                   Vec3<S>(0, 0.5, -0.3), S(45), 3);
    Settings settings;
    settings.vpls = 300;
    settings.samples = 4;
    settings.clamp_scale = 1.0 / 800;
    settings.seed = static_cast<std::uint64_t>(n);
    settings.adaptation = 1;
    SameLights lights(scene, camera, settings);
    // L_a is the mean of a mildly clamped image: the pilot of prepare_lights would be 262,144 pairs a scene.
    lights.side.weights.c_clamp *= 800;
    lights.config.eye_paths = 1;
    double adaptation = 1e-3;
    for (const auto& pixel : lights.all_pairs().image.pixels) adaptation += luminance(pixel) / 9;
    lights.side.weights.c_clamp *= adaptation / 800;
    lights.side.adaptation_luminance = adaptation;
    lights.config.eye_paths = settings.samples;
    for (std::size_t m = 0; m < k_cut_methods.size(); ++m) {
      const auto cut = lights.cut(k_cut_methods[m]);
      const auto brute = lights.brute(k_cut_methods[m]);
      const double floor = k_perceptual_floor * adaptation;
      add_relative_errors(cut.image, brute.image, floor, errors[m]);
      for (std::size_t i = 0; i < brute.image.pixels.size(); ++i) {
        const double estimate = luminance(cut.image.pixels[i]);
        const double exact = luminance(brute.image.pixels[i]);
        const double claimed = settings.threshold * std::max(estimate, floor) * cut.statistics.cut_sizes[i];
        EXPECT_LE(std::abs(estimate - exact), claimed + 1e-12) << "scene " << n << " pixel " << i;
        bias[m].add((estimate - exact) / std::max(exact, floor));
      }
      shares[m].add(static_cast<double>(cut.statistics.pairs.pairs) /
                    static_cast<double>(brute.statistics.pairs.pairs));
      violations += cut.statistics.pairs.bound_violations;
    }
  }
  EXPECT_EQ(violations, 0u);
  for (std::size_t m = 0; m < k_cut_methods.size(); ++m) {
    const char* method = name(k_cut_methods[m]);
    std::cout << method << ": " << errors[m].count() << " pixels, within 2 %: " << errors[m].share_up_to(0.02)
              << ", 4 %: " << errors[m].share_up_to(0.04) << "; " << errors[m].text() << "; mean " << bias[m].mean()
              << " +- " << bias[m].standard_error() << "; pairs " << shares[m].mean() << '\n';
    EXPECT_GT(errors[m].share_up_to(0.02), 0.8) << method;
    EXPECT_GT(errors[m].share_up_to(0.04), 0.95) << method;
    EXPECT_LT(errors[m].at(1), 0.2) << method;
    EXPECT_LT(std::abs(bias[m].mean()), 0.004) << method;
    EXPECT_LT(shares[m].mean(), 0.15) << method;
  }
}

}  // namespace
}  // namespace manylight::test::random_scenes_slow_test
