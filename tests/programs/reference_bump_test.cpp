// SPDX-License-Identifier: Apache-2.0
// Bump-mapped normals against the peer's picture (folder MANYLIGHT_REFERENCE_SCENES).
#include <cmath>

#include <gtest/gtest.h>

#include "image_io/image_io.hpp"
#include "manylight/core/frame.hpp"
#include "manylight/core/sampler.hpp"
#include "manylight/geometry/bvh.hpp"
#include "manylight/scattering/lambertian.hpp"
#include "manylight/scene/bent_normal.hpp"
#include "manylight/scene/camera.hpp"
#include "manylight/scene/emitters.hpp"
#include "manylight/scene/scene.hpp"
#include "scene_file/load_scene.hpp"
#include "support/chi_square.hpp"
#include "support/z_test.hpp"

namespace manylight::scene_file::reference_bump_test {
namespace {

/// The peer's direct light at a diffuse point with a bumped normal, one sample. From version 3.7.1 on it mirrors the bent
/// normal about the shading normal where the view lies below it, and dims light towards the horizon by
/// 2 / (1 + sqrt(1 + a tan^2)), a = tan^2(bent, shading normal) / 8 up to 1. The picture agrees with both; the program
/// does neither, as eye and light paths share one frame, and is 0.5 % darker in the mean, most of it at the silhouette.
Rgb<float> direct_light(const SceneDescription& scene, const Bvh<float>& bvh, const Emitters<float>& emitters,
                        const SurfacePoint<float>& point, const Vec3<float>& wo, IndependentStream<float>& stream) {
  using FileScene = Scene<Bvh<float>, UniformShader<Lambertian<float>>>;
  const MaterialDescription& material = scene.materials[scene.shape_infos[point.shape].material];
  const float u_select = stream.next();
  const auto light = emitters.sample_direct(point.position, u_select, stream.next_2d());
  if (!light) return Rgb<float>(0);
  Vec3<float> n = point.ns;
  if (material.relief == Relief::heights) {
    n = bumped_normal(point, material.relief_map.gradient(point.uv) * material.relief_scale);
    if (glm::dot(wo, n) <= 0) n = 2.0F * glm::dot(n, point.ns) * point.ns - n;
  }
  const float cosine = glm::dot(light->wi, n);
  const float flat_cosine = glm::dot(light->wi, point.ns);
  if (!(cosine > 0 && flat_cosine > 0 && glm::dot(wo, n) > 0)) return Rgb<float>(0);
  const auto tan2 = [](float c) { return std::max(0.0F, 1 / (c * c) - 1); };
  const float a = std::min(0.125F * tan2(glm::dot(n, point.ns)), 1.0F);
  const float shadowing = 2 / (1 + std::sqrt(1 + a * tan2(flat_cosine)));
  const Anchor<float> from{point.position, point.error, point.ng};
  const Ray<float> ray = light->infinite
                             ? FileScene::shadow_ray(from, light->wi)
                             : FileScene::shadow_ray(from, Anchor<float>{light->position, light->error, light->ng});
  if (bvh.any_hit(ray)) return Rgb<float>(0);
  return material.reflectance.eval(point.uv) * light->radiance * (k_inv_pi<float> * cosine * shadowing / light->pdf);
}

// Per pixel z of the luminance from 868 samples of ours against the peer's 32,000; at most 0.25 % of the pixels may
// fail a Sidak level of 1 %: the peer's own limits. Planted bugs seen to fail: dh/du of the other sign; dp/dv of the
// other sign.
TEST(ReferenceBump, NormalsAreThoseOfThePeersPicture) {
  if (std::string(MANYLIGHT_REFERENCE_SCENES).empty()) GTEST_SKIP() << "MANYLIGHT_REFERENCE_SCENES is not set";
  const std::filesystem::path folder =
      std::filesystem::path(MANYLIGHT_REFERENCE_SCENES) / "mitsuba-tests/tests/scenes/bsdf_spheres";
  SceneDescription scene = load_scene(folder / "test_bumpmap_path.xml");
  const Image<float> reference = image_io::read_image(folder / "refs/test_bumpmap_ref_rgb.exr");
  const Image<float> variance = image_io::read_image(folder / "refs/test_bumpmap_ref_rgb_var.exr");
  PerspectiveConfig<float> config;
  config.to_world = scene.camera.to_world;
  config.horizontal_fov = horizontal_fov_degrees(scene.camera);
  config.width = scene.camera.width;
  config.height = scene.camera.height;
  const PerspectiveCamera<float> camera(config);
  const Bvh<float> bvh(scene.shapes);
  const Emitters<float> emitters(scene.emitters, bvh.shapes(), bvh.bounds());
  constexpr std::uint32_t k_samples = 868;
  const double limit = test::normal_limit(test::sidak_level(0.01, static_cast<double>(reference.pixels.size())));
  std::size_t failures = 0;
  for (std::uint32_t y = 0; y < reference.height; ++y) {
    for (std::uint32_t x = 0; x < reference.width; ++x) {
      test::RunningMoments moments;
      for (std::uint32_t i = 0; i < k_samples; ++i) {
        IndependentStream<float> stream(1, Stage::test, y * reference.width + x, i);
        const Vec2<float> film = Vec2<float>(static_cast<float>(x), static_cast<float>(y)) + stream.next_2d();
        const Ray<float> ray = camera.ray(film, {0.5F, 0.5F});
        const auto hit = bvh.closest_hit(ray);
        Rgb<float> radiance(0);
        if (!hit) {
          radiance = emitters.environment(ray.direction);
        } else {
          const SurfacePoint<float> point = surface_point(bvh.shapes(), ray, *hit);
          radiance = emitters.emitted(point, -ray.direction) +
                     direct_light(scene, bvh, emitters, point, -ray.direction, stream);
        }
        moments.add(static_cast<double>(luminance(radiance)));
      }
      const double reference_variance = static_cast<double>(luminance(variance.at(x, y)));
      const double error = std::sqrt(moments.variance() / k_samples + std::max(reference_variance, 1e-4) / 32000);
      const double z = std::abs(moments.mean() - static_cast<double>(luminance(reference.at(x, y)))) / error;
      if (z > limit) ++failures;
    }
  }
  EXPECT_LE(failures, reference.pixels.size() / 400) << "of " << reference.pixels.size();
}

}  // namespace
}  // namespace manylight::scene_file::reference_bump_test
