// SPDX-License-Identifier: Apache-2.0
// The peer's scene files, where they are at hand: all load strictly, textures lie as in the peer's
// picture.
#include <array>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "image_io/image_io.hpp"
#include "manylight/geometry/bvh.hpp"
#include "manylight/geometry/surface_point.hpp"
#include "manylight/scene/camera.hpp"
#include "programs/scratch.hpp"
#include "scene_file/load_scene.hpp"

namespace manylight::scene_file::reference_scenes_test {
namespace {

using testing::HasSubstr;

class ReferenceScenes : public testing::Test {
 protected:
  void SetUp() override {
    if (std::string(MANYLIGHT_REFERENCE_SCENES).empty()) GTEST_SKIP() << "MANYLIGHT_REFERENCE_SCENES is not set";
  }
  static std::filesystem::path path(const std::string& name) {
    return std::filesystem::path(MANYLIGHT_REFERENCE_SCENES) / name;
  }
};

struct Expected {
  const char* file;
  std::size_t shapes;
  std::size_t triangles;
  int max_depth;
};

std::size_t triangle_count(const SceneDescription& scene) {
  std::size_t count = 0;
  for (const TriangleMesh<float>& mesh : scene.shapes.meshes) count += mesh.triangles.size();
  return count;
}

// Oracle: counts of elements and faces in the files (rectangles have 2 triangles, cubes 12).
TEST_F(ReferenceScenes, LoadStrictly) {
  const std::string tests = "mitsuba-tests/tests/scenes/";
  const std::array<Expected, 10> scenes{{
      {"cornell-box/scene.xml", 8, 36, 65},
      {"veach-mis/scene.xml", 9, 52, 3},
      {"living-room/scene.xml", 65, 143'163, 65},
      {"modern-hall/scene.xml", 32, 30'911 + 16, 65},
      {"sponza/sponza.xml", 38, 66'445, -1},
      {"matpreview-roughplastic/docs/scenes/bsdf_roughplastic_ggx.xml", 3, 61'600, -1},
      {"matpreview-roughplastic/docs/scenes/bsdf_roughconductor_copper.xml", 3, 61'600, -1},
      {"hetvol/hetvol.xml", 3, 14, 8},
      {"vol-cbox/vol_cbox.xml", 8, 38, -1},
      {"sss-bunny/docs/scenes/medium_homogeneous_sss.xml", 2, 69'451 + 512, 64},
  }};
  for (const Expected& expected : scenes) {
    const SceneDescription scene = load_scene(path(expected.file));
    EXPECT_EQ(scene.shapes.size(), expected.shapes) << expected.file;
    EXPECT_EQ(scene.shape_infos.size(), expected.shapes) << expected.file;
    EXPECT_EQ(triangle_count(scene), expected.triangles) << expected.file;
    EXPECT_EQ(scene.max_depth, expected.max_depth) << expected.file;
    EXPECT_TRUE(scene.warnings.empty()) << expected.file;
  }
  for (const char* name :
       {"bsdf_spheres/test_roughplastic_linear_path.xml", "bsdf_spheres/test_textured_diffuse_path.xml",
        "bsdf_spheres/test_textured_roughconductor_path.xml", "floating_sphere/test_directional_direct.xml",
        "bsdf_spheres/test_constant_path.xml", "bsdf_spheres/test_arealight_path.xml",
        "bsdf_spheres/test_bumpmap_path.xml", "texture_interp/test_texture_interp_direct.xml",
        "participating_media/test_surf_area_light_volpath.xml", "participating_media/test_homo_area_light_volpath.xml",
        "participating_media/test_homo_null_envmap_volpath.xml",
        "participating_media/test_homo_obj_inside_medium_volpath.xml",
        "participating_media/test_homo_dielectric_envmap_volpath.xml",
        "participating_media/test_hetero_sigmat_volpath.xml",
        "participating_media/test_hetero_spectral_sigmat_no_scattering_volpath.xml"}) {
    const SceneDescription scene = load_scene(path(tests + name));
    EXPECT_GT(scene.shapes.size(), 1U) << name;
    EXPECT_GT(scene.emitters.size(), 0U) << name;
  }
}

// Oracle: products of what the files say.
TEST_F(ReferenceScenes, MediaAreThoseOfTheFiles) {
  const SceneDescription smoke = load_scene(path("hetvol/hetvol.xml"));
  ASSERT_EQ(smoke.media.size(), 1U);
  ASSERT_TRUE(smoke.media[0].density);
  EXPECT_EQ(smoke.media[0].scale, 100);
  EXPECT_EQ(smoke.media[0].albedo, Rgb<float>(0.9F));
  EXPECT_EQ(smoke.outside, k_vacuum);
  const SceneDescription box = load_scene(path("vol-cbox/vol_cbox.xml"));
  ASSERT_EQ(box.media.size(), 1U);
  EXPECT_EQ(box.media[0].sigma_s, Rgb<float>(0.001F));
  EXPECT_EQ(box.outside, 1);
  for (const ShapeDescription& info : box.shape_infos) EXPECT_EQ(info.media, (MediaSides{1, k_vacuum})) << info.name;
  const SceneDescription bunny = load_scene(path("sss-bunny/docs/scenes/medium_homogeneous_sss.xml"));
  ASSERT_EQ(bunny.media.size(), 1U);
  EXPECT_EQ(bunny.media[0].phase, PhaseKind::henyey_greenstein);
  EXPECT_FLOAT_EQ(bunny.media[0].sigma_s.x, 50.0F * 0.85F);
}

TEST_F(ReferenceScenes, ValuesAreThoseOfTheFiles) {
  const SceneDescription box = load_scene(path("cornell-box/scene.xml"));
  ASSERT_EQ(box.emitters.areas.size(), 1U);
  EXPECT_EQ(box.shape_infos[box.emitters.areas[0].shape].name, "Light");
  EXPECT_EQ(box.emitters.areas[0].radiance.mean(), Rgb<float>(17, 12, 4));
  EXPECT_FLOAT_EQ(horizontal_fov_degrees(box.camera), 19.5F);
  const SceneDescription hall = load_scene(path("modern-hall/scene.xml"));
  EXPECT_EQ(hall.emitters.areas.size(), 13U);
  std::size_t absorbing = 0;
  for (const ShapeDescription& info : hall.shape_infos) {
    if (is_black(info.interior_absorption)) continue;
    ++absorbing;
    EXPECT_EQ(info.interior_absorption, Rgb<float>(0.5F, 0.2F, 0.4F));
    EXPECT_EQ(hall.materials[info.material].kind, MaterialKind::dielectric);
  }
  EXPECT_EQ(absorbing, 1U);
  // No fov in the file: the peer's 50 mm lens on 36 x 24 mm film, whose diagonal fits the square's: 2 atan(21.63 / 50).
  const SceneDescription sphere =
      load_scene(path("mitsuba-tests/tests/scenes/floating_sphere/test_directional_direct.xml"));
  EXPECT_NEAR(horizontal_fov_degrees(sphere.camera), 34.0222F, 2e-3F);  // by hand with five digits
}

/// What the camera sees of an unoccluded scene of diffuse walls and one point light.
Rgb<float> direct_light(const SceneDescription& scene, const Bvh<float>& bvh, const Ray<float>& ray) {
  const auto hit = bvh.closest_hit(ray);
  if (!hit) return Rgb<float>(0);
  const SurfacePoint<float> point = surface_point(bvh.shapes(), ray, *hit);
  const PointEmitter<float>& light = scene.emitters.points.front();
  const Vec3<float> to_light = light.position - point.position;
  const float distance = glm::length(to_light);
  const float cosine = glm::dot(point.ns, to_light) / distance;
  const MaterialDescription& material = scene.materials[scene.shape_infos[hit->shape].material];
  return material.reflectance.eval(point.uv) * light.intensity * (k_inv_pi<float> * cosine / (distance * distance));
}

// Oracle: the peer's picture of six textured rectangles (both filters, three wraps), rebuilt from direct light alone
// with its Gaussian filter. It checks orientation, wrapping, interpolation, decoding, transforms and the camera at
// once. Planted bugs that it caught: v flipped (error 0.66), texels off by a half (0.22), colours left encoded (0.16).
TEST_F(ReferenceScenes, TexturesLieAsInThePeersPicture) {
  SceneDescription scene = load_scene(path("mitsuba-tests/tests/scenes/texture_interp/test_texture_interp_direct.xml"));
  const Image<float> reference =
      image_io::read_image(path("mitsuba-tests/tests/scenes/texture_interp/refs/test_texture_interp_ref_rgb.exr"));
  PerspectiveConfig<float> config;
  config.to_world = scene.camera.to_world;
  config.horizontal_fov = horizontal_fov_degrees(scene.camera);
  config.width = scene.camera.width;
  config.height = scene.camera.height;
  const PerspectiveCamera<float> camera(config);
  const Bvh<float> bvh(scene.shapes);
  ASSERT_EQ(reference.width, config.width);
  double squares = 0;
  double total = 0;
  constexpr int k_side = 12;  // points per pixel and axis, at equal steps of the filter's distribution
  for (std::uint32_t y = 0; y < reference.height; ++y) {
    for (std::uint32_t x = 0; x < reference.width; ++x) {
      Rgb<float> sum(0);
      for (int i = 0; i < k_side * k_side; ++i) {
        const Vec2<float> u((static_cast<float>(i % k_side) + 0.5F) / k_side,
                            (static_cast<float>(i / k_side) + 0.5F) / k_side);
        const Vec2<float> film =
            Vec2<float>(static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F) + scene.filter.sample(u);
        sum += direct_light(scene, bvh, camera.ray(film, {0.5F, 0.5F}));
      }
      const Rgb<float> difference = sum / static_cast<float>(k_side * k_side) - reference.at(x, y);
      squares += static_cast<double>(glm::dot(difference, difference));
      total += static_cast<double>(glm::dot(reference.at(x, y), reference.at(x, y)));
    }
  }
  // What is left are edges, seen by 144 points per pixel: 0.020 here, 0.011 with 784 points.
  EXPECT_LT(std::sqrt(squares / total), 0.03);
}

}  // namespace
}  // namespace manylight::scene_file::reference_scenes_test
