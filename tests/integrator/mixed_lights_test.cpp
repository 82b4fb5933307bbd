// SPDX-License-Identifier: Apache-2.0
// Cuts against the sum over all pairs on the same VPLs, where everything comes together: textures, gloss, area, point,
// directional and environment lights, a lens, random scenes. What is claimed of a cut's error and what it is.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <iostream>
#include <memory>

#include "integrator/same_lights.hpp"
#include "support/random_vertices.hpp"

namespace manylight::test {
namespace {

using S = double;
using M = AnyOf<Lambertian<S>, DiffusePhong<S>, DiffuseWard<S>>;

/// A texture as the diffuse colour under a lobe of gloss, or none.
struct TexturedShader {
  enum class Kind { diffuse, phong, ward };
  using Material = M;
  static constexpr bool k_may_be_transparent = false;
  static constexpr bool k_may_absorb = false;
  Texture<S> color{};
  Kind kind = Kind::diffuse;
  S gloss = 0;      ///< albedo of the lobe
  S roughness = 1;  ///< exponent, or alpha

  [[nodiscard]] M material(const SurfacePoint<S>& point, bool) const noexcept {
    const Lambertian<S> base{color.eval(point.uv)};
    if (kind == Kind::phong) return DiffusePhong<S>({base, 1}, {Phong<S>{Rgb<S>(gloss), roughness}, 1});
    if (kind == Kind::ward) return DiffuseWard<S>({base, 1}, {Ward<S>{Rgb<S>(gloss), roughness, roughness / 2}, 1});
    return base;
  }
  [[nodiscard]] bool is_two_sided() const noexcept { return true; }
};
using SceneType = Scene<Bvh<S>, TexturedShader>;
using Kind = TexturedShader::Kind;

/// Shapes with a shader each. Meshes first, as Shapes numbers them.
struct Builder {
  Shapes<S> shapes;
  std::vector<TexturedShader> shaders;
  EmitterList<S> lights;

  std::uint32_t mesh(TriangleMesh<S> shape, const TexturedShader& shader) {
    shapes.meshes.push_back(std::move(shape));
    shaders.push_back(shader);
    return static_cast<std::uint32_t>(shaders.size() - 1);
  }
  void sphere(const Sphere<S>& shape, const TexturedShader& shader) {
    shapes.spheres.push_back(shape);
    shaders.push_back(shader);
  }
  [[nodiscard]] SceneType build() const {
    std::vector<std::uint32_t> ids(shaders.size());
    for (std::size_t i = 0; i < ids.size(); ++i) ids[i] = static_cast<std::uint32_t>(i);
    return SceneType(Bvh<S>(shapes), shaders, ids, lights);
  }
};

/// A room without a ceiling: floor with a glossy checkerboard, a wall with a bitmap, a Ward ball; lit by a panel, a
/// point light, the sun and a sky with one bright texel.
SceneType mixed_room() {
  Builder b;
  const auto checks = Texture<S>::checkerboard({0.7, 0.6, 0.5}, {0.1, 0.15, 0.2}, {4, 0, 0, 0, 4, 0});
  auto texels = std::make_shared<Texels<S>>();
  *texels = {2, 2, {{0.8, 0.2, 0.1}, {0.2, 0.7, 0.2}, {0.1, 0.2, 0.8}, {0.7, 0.7, 0.7}}};
  b.mesh(parallelogram<S>({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), {checks, Kind::phong, 0.2, 80});
  b.mesh(parallelogram<S>({0, 1, 0.7}, {1, 0, 0}, {0, 0, 0.7}), {Texture<S>::bitmap(texels)});
  b.mesh(parallelogram<S>({-1, 0, 0.7}, {0, 1, 0}, {0, 0, 0.7}), {Texture<S>(Rgb<S>(0.6, 0.3, 0.2))});
  b.mesh(parallelogram<S>({1, 0, 0.7}, {0, 0, 0.7}, {0, 1, 0}), {Texture<S>(Rgb<S>(0.3)), Kind::phong, 0.3, 20});
  const auto panel = b.mesh(parallelogram<S>({0.3, 0.2, 1.3}, {0, 0.2, 0}, {0.2, 0, 0}), {Texture<S>(Rgb<S>(0))});
  b.sphere({{0.3, -0.1, 0.3}, 0.3, false}, {Texture<S>(Rgb<S>(0.1, 0.2, 0.3)), Kind::ward, 0.3, 0.15});
  b.lights.areas.push_back({panel, Texture<S>(Rgb<S>(12, 10, 8)), false});
  b.lights.points.push_back({{-0.6, 0.1, 0.8}, {0.2, 0.3, 0.4}});
  b.lights.directionals.push_back({{0.4, 0.5, -1}, {1.5, 1.3, 1.0}});
  auto sky = std::make_shared<Image<S>>(8, 5);
  for (auto& texel : sky->pixels) texel = {0.2, 0.25, 0.35};
  sky->at(2, 1) = {6, 5, 4};
  b.lights.environments.push_back({Rgb<S>(1), sky});
  return b.build();
}

PerspectiveCamera<S> mixed_camera(std::uint32_t side, double aperture) {
  const Vec3<S> eye(0.1, -2.4, 1.1);
  const Vec3<S> z = glm::normalize(Vec3<S>(0, 0.2, 0.4) - eye);
  const Vec3<S> x = glm::normalize(glm::cross(Vec3<S>(0, 0, 1), z));
  PerspectiveConfig<S> config;
  config.to_world[0] = {x, 0};
  config.to_world[1] = {glm::cross(z, x), 0};
  config.to_world[2] = {z, 0};
  config.to_world[3] = {eye, 1};
  config.horizontal_fov = 45;
  config.width = config.height = side;
  config.aperture_radius = aperture;
  config.focus_distance = 1.6;  // before the ball; the back wall's disc of confusion is a fifth of the image
  return PerspectiveCamera<S>(config);
}

Settings mixed_settings(std::size_t vpls, std::uint32_t samples) {
  Settings settings;
  settings.vpls = vpls;
  settings.samples = samples;
  settings.adaptation = 0.4;
  settings.clamp_scale = 1.0 / 800;
  return settings;
}

/// Oracle O-24, and stability case 30 without its motion: at threshold 0 without a cap a cut ends at single pairs.
/// Asserted: lightcuts equal brute force on the same VPLs and sensors with all kinds of lights at once, through a
/// pinhole and through a lens, and so do bidirectional lightcuts and theirs; no pair is above its bound. 1e-10: sums of
/// other order, and products taken over luminances. Caught: the cone of normals, or of lobes, of
/// one child only; the clamp in the bound of exact lights.
TEST(MixedLights, CutsOfSinglePairsEqualBruteForce) {
  const auto scene = mixed_room();
  for (const double aperture : {0.0, 0.15}) {
    const auto camera = mixed_camera(6, aperture);
    SameLights lights(scene, camera, mixed_settings(150, 4));
    lights.config.threshold = 0;
    lights.config.max_cut = 1u << 30;
    for (const Method method : k_cut_methods) {
      const auto cut = lights.cut(method);
      const auto brute = lights.brute(method);
      EXPECT_LT(largest_difference(cut.image, brute.image), 1e-10) << name(method) << " aperture " << aperture;
      EXPECT_EQ(cut.statistics.sensors, brute.statistics.sensors);
      EXPECT_EQ(cut.statistics.pairs.bound_violations, 0u);
      EXPECT_EQ(cut.statistics.invalid_samples, 0u);
      EXPECT_EQ(cut.statistics.capped_pixels, 0u);
    }
  }
}

/// The same at the usual threshold of 2 % per cluster: what a pixel's luminance is off brute force. Measured over 100
/// pixels each, pinhole and lens alike: median 1.3 to 1.5 %, 90 % below 3.7 to 4.2 %, largest 9 %; the mean image is
/// within 0.2 %, by 2 % of the pairs. Pinned with a margin of a third. Caught: one sensor for all light clusters that
/// meet a gather node, as in the paper (errors of one sign); a threshold of twice the size.
TEST(MixedLights, ErrorsAtTwoPercent) {
  const auto scene = mixed_room();
  for (const double aperture : {0.0, 0.15}) {
    const auto camera = mixed_camera(10, aperture);
    SameLights lights(scene, camera, mixed_settings(1000, 8));
    for (const Method method : k_cut_methods) {
      const auto cut = lights.cut(method);
      const auto brute = lights.brute(method);
      Quantiles errors;
      add_relative_errors(cut.image, brute.image, k_perceptual_floor * 0.4, errors);
      Rgb<double> sum_cut(0), sum_brute(0);
      for (std::size_t i = 0; i < brute.image.pixels.size(); ++i) {
        sum_cut += cut.image.pixels[i];
        sum_brute += brute.image.pixels[i];
      }
      std::cout << name(method) << ", aperture " << aperture << ": " << errors.text() << "; mean image "
                << luminance(sum_cut) / luminance(sum_brute) << "; mean cut " << mean_cut(cut) << " of "
                << mean_cut(brute) << '\n';
      EXPECT_EQ(cut.statistics.pairs.bound_violations, 0u);
      EXPECT_LT(errors.at(0.5), 0.025) << name(method);
      EXPECT_LT(errors.at(0.9), 0.06) << name(method);
      EXPECT_LT(errors.at(1), 0.12) << name(method);
      EXPECT_NEAR(luminance(sum_cut) / luminance(sum_brute), 1, 0.01) << name(method);
    }
  }
}

/// A random small room: a floor, some walls, blocks and balls of random materials, one to four random lights.
SceneType random_scene(RandomVertices<S>& random) {
  Builder b;
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
TEST(MixedLights, ClaimedAndTrueErrorsOfRandomScenes) {
  RandomVertices<S> random(34);
  std::array<Quantiles, 2> errors;
  std::array<RunningMoments, 2> shares, bias;
  std::uint64_t violations = 0;
  for (int n = 0; n < 200; ++n) {
    const auto scene = random_scene(random);
    const auto camera = look_at<S>(Vec3<S>(random.uniform(-0.8, 0.8), -2.2, random.uniform(-0.5, 0.8)),
                                   Vec3<S>(0, 0.5, -0.3), S(45), 2);
    Settings settings = mixed_settings(300, 4);
    settings.seed = static_cast<std::uint64_t>(n);
    settings.adaptation = 1;
    SameLights lights(scene, camera, settings);
    // L_a is the mean of a mildly clamped image: the pilot of prepare_lights would be 262,144 pairs a scene.
    lights.side.weights.c_clamp *= 800;
    lights.config.eye_paths = 1;
    double adaptation = 1e-3;
    for (const auto& pixel : lights.all_pairs().image.pixels) adaptation += luminance(pixel) / 4;
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
}  // namespace manylight::test
