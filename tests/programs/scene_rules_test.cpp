// SPDX-License-Identifier: Apache-2.0
// Rules of the scene format beyond single elements: references, includes, defaults that depend on the version, limits.
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "programs/program_run.hpp"
#include "programs/scratch.hpp"
#include "scene_file/load_scene.hpp"

namespace manylight::scene_file::scene_rules_test {
namespace {

using test::floor_scene;
using test::message_of;
using testing::AllOf;
using testing::HasSubstr;

class SceneRules : public test::ScratchTest {
 protected:
  SceneDescription load(const std::string& text, const LoadOptions& options = {}) const {
    return load_scene(write("scene.xml", text), options);
  }
  std::string error_of(const std::string& text, const LoadOptions& options = {}) const {
    return message_of<Error>([&] { static_cast<void>(load(text, options)); });
  }
};

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST_F(SceneRules, ReferencesToThemselvesAreRefused) {
  const std::string self = "<bsdf type=\"twosided\" id=\"a\"><ref id=\"a\"/></bsdf>";
  EXPECT_THAT(error_of(floor_scene(self)), HasSubstr("refers to itself"));
  const std::string pair =
      "<bsdf type=\"mask\" id=\"a\"><ref id=\"b\"/></bsdf><bsdf type=\"mask\" id=\"b\"><ref id=\"a\"/></bsdf>";
  EXPECT_THAT(error_of(floor_scene(pair)), HasSubstr("refers to itself"));
}

/// Thirty levels of "half of the one before and half of the one before" are 2^30 materials.
TEST_F(SceneRules, DoublingReferencesEnd) {
  std::string levels = "<bsdf type=\"diffuse\" id=\"m0\"/>";
  for (int i = 1; i <= 30; ++i) {
    const std::string below = "<ref id=\"m" + std::to_string(i - 1) + "\"/>";
    levels += "<bsdf type=\"blendbsdf\" id=\"m" + std::to_string(i) + "\">" + below + below + "</bsdf>";
  }
  EXPECT_THAT(error_of(floor_scene(levels)), HasSubstr("too many nested materials"));
}

TEST_F(SceneRules, ElementsNestedWithoutEndAreRefused) {
  std::string open;
  for (int i = 0; i < 100'000; ++i) open += "<bsdf type=\"mask\">";
  EXPECT_NE(error_of("<scene version=\"3.0.0\">" + open), "no error");
  std::string close;
  for (int i = 0; i < 100'000; ++i) close += "</bsdf>";
  EXPECT_THAT(error_of("<scene version=\"3.0.0\">" + open + close + "</scene>"), HasSubstr("nested too deeply"));
}

TEST_F(SceneRules, GrowingParametersEnd) {
  std::string defaults = "<default name=\"p0\" value=\"0123456789\"/>";
  for (int i = 1; i < 40; ++i) {
    const std::string below = "$p" + std::to_string(i - 1);
    defaults += "<default name=\"p" + std::to_string(i) + "\" value=\"" + below + " " + below + "\"/>";
  }
  EXPECT_THAT(error_of(floor_scene(defaults)), HasSubstr("grows beyond all measure"));
}

TEST_F(SceneRules, IncludesAreSplicedInAndFoundFromTheTop) {
  write("parts/light.xml", "<scene version=\"3.0.0\"><include filename=\"parts/more.xml\"/></scene>");
  write("parts/more.xml",
        "<scene version=\"3.0.0\"><emitter type=\"directional\"><rgb name=\"irradiance\" "
        "value=\"$power\"/></emitter></scene>");
  const std::string text = floor_scene("<default name=\"power\" value=\"3\"/><include filename=\"parts/light.xml\"/>");
  ASSERT_EQ(load(text).emitters.directionals.size(), 1U);
  EXPECT_EQ(load(text).emitters.directionals[0].irradiance, Rgb<float>(3));
  EXPECT_THAT(error_of(floor_scene("<include filename=\"parts/light.xml\"/>")),
              AllOf(HasSubstr("more.xml:1"), HasSubstr("'$power' has no value")));
}

TEST_F(SceneRules, IncludesOfThemselvesAreRefused) {
  write("a.xml", "<scene version=\"3.0.0\"><include filename=\"b.xml\"/></scene>");
  write("b.xml", "<scene version=\"3.0.0\"><include filename=\"a.xml\"/></scene>");
  EXPECT_THAT(error_of(floor_scene("<include filename=\"a.xml\"/>")), HasSubstr("the file includes itself"));
  EXPECT_THAT(error_of(floor_scene("<include filename=\"scene.xml\"/>")), HasSubstr("the file includes itself"));
  EXPECT_THAT(error_of(floor_scene("<include filename=\"none.xml\"/>")), HasSubstr("no such file: none.xml"));
}

TEST_F(SceneRules, DefinitionsThatNobodyUsesAreNamed) {
  LoadOptions options;
  options.defines["sp"] = "4";
  const std::string text =
      replaced(floor_scene(), "<integrator type=\"path\"><integer name=\"max_depth\" value=\"3\"/>",
               "<default name=\"spp\" value=\"3\"/><integrator type=\"path\">"
               "<integer name=\"max_depth\" value=\"$spp\"/>");
  EXPECT_THAT(error_of(text, options), HasSubstr("parameter 'sp' is not used; known are spp"));
}

TEST_F(SceneRules, PropertiesAndIdsGivenTwiceAreRefused) {
  const std::string twice =
      "<bsdf type=\"plastic\"><float name=\"int_ior\" value=\"1.5\"/><float name=\"intIOR\" value=\"2\"/></bsdf>";
  EXPECT_THAT(error_of(floor_scene("", twice)), HasSubstr("'int_ior' is given twice"));
  EXPECT_THAT(error_of(floor_scene("<bsdf type=\"diffuse\" id=\"a\"/><bsdf type=\"diffuse\" id=\"a\"/>")),
              HasSubstr("id 'a' is used before"));
}

// Oracle: the angle of a 50 mm lens on 36 x 24 mm film, 46.8 degrees over the diagonal (photographers' tables).
TEST_F(SceneRules, AngleOfViewDefaultsToAFiftyMillimetreLens) {
  const std::string text = replaced(floor_scene(), "<float name=\"fov\" value=\"40\"/>", "");
  EXPECT_NEAR(load(text).camera.fov_degrees, 46.79F, 0.01F);  // two decimals of the table
  EXPECT_EQ(load(text).camera.fov_axis, FovAxis::diagonal);
  const std::string wide = replaced(floor_scene(), "<float name=\"fov\" value=\"40\"/>",
                                    "<string name=\"focal_length\" value=\"21.633308mm\"/>");
  EXPECT_NEAR(load(wide).camera.fov_degrees, 90.0F, 1e-3F);  // half the diagonal: 90 degrees
}

// Oracle: for a 4:3 image the half angles' tangents stand as 4 : 3 : 5 (x, y, diagonal).
TEST_F(SceneRules, AxesOfTheAngleOfView) {
  CameraDescription camera;
  camera.width = 400;
  camera.height = 300;
  camera.fov_degrees = 60.0F;
  const auto tangent = [&](FovAxis axis) {
    camera.fov_axis = axis;
    return std::tan(horizontal_fov_degrees(camera) * k_pi<float> / 360.0F);
  };
  const float base = std::tan(k_pi<float> / 6.0F);
  const float tolerance = 1e-6F;  // float trigonometry
  EXPECT_NEAR(tangent(FovAxis::x), base, tolerance);
  EXPECT_NEAR(tangent(FovAxis::larger), base, tolerance);
  EXPECT_NEAR(tangent(FovAxis::y), base * 4.0F / 3.0F, tolerance);
  EXPECT_NEAR(tangent(FovAxis::smaller), base * 4.0F / 3.0F, tolerance);
  EXPECT_NEAR(tangent(FovAxis::diagonal), base * 4.0F / 5.0F, tolerance);
}

// Oracle: steps by hand. (1, 0, 0) scaled by 2, turned by 90 degrees about z, moved by 3 along x: (3, 2, 0).
TEST_F(SceneRules, TransformStepsApplyInOrder) {
  const std::string steps =
      "<shape type=\"sphere\"><point name=\"center\" x=\"1\"/><transform name=\"toWorld\"><scale value=\"2\"/>"
      "<rotate z=\"1\" angle=\"90\"/><translate x=\"+3\"/></transform></shape>";
  const SceneDescription scene = load(floor_scene(steps));
  ASSERT_EQ(scene.shapes.spheres.size(), 1U);
  const Vec3<float> center = scene.shapes.spheres[0].center;
  EXPECT_NEAR(center.x, 3.0F, 1e-6F);  // float rounding of a rotation
  EXPECT_NEAR(center.y, 2.0F, 1e-6F);
  EXPECT_NEAR(scene.shapes.spheres[0].radius, 2.0F, 1e-6F);
  const std::string flat = "<shape type=\"sphere\"><transform name=\"toWorld\"><scale x=\"2\"/></transform></shape>";
  EXPECT_THAT(error_of(floor_scene(flat)), AllOf(HasSubstr("scene.xml:1"), HasSubstr("sphere")));
  const std::string gone = "<shape type=\"cube\"><transform name=\"to_world\"><scale value=\"0\"/></transform></shape>";
  EXPECT_THAT(error_of(floor_scene(gone)), HasSubstr("cannot be inverted"));
}

// Oracle: local +x of a camera points to the left of its image; looking along -z with y up, that is -x.
TEST_F(SceneRules, LookAtHasLeftUpForwardColumns) {
  const glm::mat4 m = load(floor_scene()).camera.to_world;
  EXPECT_EQ(Vec3<float>(m[0]), Vec3<float>(-1, 0, 0));
  EXPECT_EQ(Vec3<float>(m[1]), Vec3<float>(0, 1, 0));
  EXPECT_EQ(Vec3<float>(m[2]), Vec3<float>(0, 0, -1));
  EXPECT_EQ(Vec3<float>(m[3]), Vec3<float>(0, 0, 5));
}

TEST_F(SceneRules, DefaultsFollowTheVersion) {
  const std::string metal = floor_scene("", "<bsdf type=\"conductor\"/>");
  EXPECT_TRUE(is_black(load(metal).materials[0].eta)) << "version 3: the perfect mirror";
  const std::string old = replaced(metal, "3.0.0", "0.5.0");
  EXPECT_GT(load(old).materials[0].eta.y, 0.9F) << "version 0.x: copper";
  const std::string light =
      floor_scene("<emitter type=\"constant\"><spectrum name=\"radiance\" value=\"2\"/></emitter>");
  EXPECT_EQ(load(replaced(light, "3.0.0", "0.6.0")).emitters.environments[0].radiance, Rgb<float>(2));
  EXPECT_GT(load(light).emitters.environments[0].radiance.x, 2.3F) << "equal energy is purple in sRGB";
  EXPECT_THAT(error_of(replaced(metal, "3.0.0", "4.0.0")), HasSubstr("version '4.0.0' is not supported"));
}

// Oracle: the peer's picture of a sphere with checkered roughness, which only fits with the two values exchanged.
TEST_F(SceneRules, CheckeredNumbersAreExchangedSinceVersionTwo) {
  const auto alpha_at_zero = [&](const std::string& version) {
    const std::string metal =
        "<bsdf type=\"roughconductor\"><texture type=\"checkerboard\" name=\"alpha\"><float name=\"color0\" "
        "value=\"0.25\"/><float name=\"color1\" value=\"0.5\"/></texture></bsdf>";
    return load(replaced(floor_scene("", metal), "3.0.0", version)).materials[0].alpha_u.eval({0.1F, 0.1F}).x;
  };
  EXPECT_EQ(alpha_at_zero("0.6.0"), 0.25F);
  EXPECT_EQ(alpha_at_zero("3.0.0"), 0.5F);
  const std::string floor =
      "<bsdf type=\"diffuse\"><texture type=\"checkerboard\" name=\"reflectance\"><rgb name=\"color0\" "
      "value=\"0.25\"/><rgb name=\"color1\" value=\"0.5\"/></texture></bsdf>";
  EXPECT_EQ(load(floor_scene("", floor)).materials[0].reflectance.eval({0.1F, 0.1F}).x, 0.25F) << "colours stay";
}

// Oracle: one triangle each, moved by its node (glTF) and by the shape's transform.
TEST_F(SceneRules, MeshFilesByTheirElements) {
  write("a.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face "
        "1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n3 0 1 2\n");
  write("a.gltf",
        R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"translation":[0,0,5]}],)"
        R"("meshes":[{"primitives":[{"attributes":{"POSITION":1},"indices":0}]}],)"
        R"("accessors":[{"bufferView":0,"componentType":5123,"count":3,"type":"SCALAR"},)"
        R"({"bufferView":1,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],)"
        R"("bufferViews":[{"buffer":0,"byteLength":6},{"buffer":0,"byteOffset":8,"byteLength":36}],)"
        R"("buffers":[{"byteLength":44,"uri":"data:application/octet-stream;base64,)"
        R"(AAABAAIAAAAAAAAAAAAAAAAAAAAAAIA/AAAAAAAAAAAAAAAAAACAPwAAAAA="}]})");
  const auto shape = [](const std::string& type) {
    return "<shape type=\"" + type + "\" id=\"" + type + "\"><string name=\"filename\" value=\"a." + type +
           "\"/><transform name=\"to_world\"><translate x=\"2\"/></transform><bsdf type=\"plastic\"/></shape>";
  };
  const SceneDescription scene = load(floor_scene(shape("ply") + shape("gltf")));
  ASSERT_EQ(scene.shapes.meshes.size(), 3U);
  const float heights[] = {0, 5};
  for (std::size_t i = 0; i < 2; ++i) {
    const TriangleMesh<float>& mesh = scene.shapes.meshes[1 + i];
    ASSERT_EQ(mesh.triangles.size(), 1U);
    EXPECT_EQ(mesh.positions[mesh.triangles[0][1]], Vec3<float>(3, 0, heights[i]));
    EXPECT_EQ(mesh.normals.size(), 3U) << "smooth, as neither file has any";
    EXPECT_EQ(scene.materials[scene.shape_infos[1 + i].material].kind, MaterialKind::plastic);
  }
  EXPECT_EQ(scene.shape_infos[1].name, "ply");
  EXPECT_EQ(scene.shape_infos[2].name, "gltf");
}

TEST_F(SceneRules, SubstancesAndNullSurfaces) {
  const SceneDescription scene =
      load(floor_scene("<shape type=\"cube\"><bsdf type=\"null\"/></shape>",
                       "<bsdf type=\"dielectric\"><string name=\"intIOR\" value=\"diamond\"/><string name=\"ext_ior\" "
                       "value=\"air\"/></bsdf>"));
  EXPECT_FLOAT_EQ(scene.materials[0].interior_ior, 2.419F);
  EXPECT_FLOAT_EQ(scene.materials[0].exterior_ior, 1.000277F);
  EXPECT_EQ(scene.materials[1].opacity->maximum(), Rgb<float>(0));
  EXPECT_THAT(error_of(floor_scene("", "<bsdf type=\"dielectric\"><string name=\"int_ior\" value=\"butter\"/></bsdf>")),
              AllOf(HasSubstr("'butter'"), HasSubstr("diamond")));
}

}  // namespace
}  // namespace manylight::scene_file::scene_rules_test
