// SPDX-License-Identifier: Apache-2.0
// The scene loader: what it makes of good files, and the one line it says about bad ones.
#include <algorithm>
#include <random>

#include <gmock/gmock.h>

#include "programs/program_run.hpp"
#include "scene_file/load_scene.hpp"

namespace manylight::scene_file::scene_file_test {
namespace {

using test::floor_scene;
using test::ScratchTest;

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class SceneFile : public ScratchTest {
 protected:
  SceneDescription load(const std::string& text, const LoadOptions& options = {}) const {
    return load_scene(write("scene.xml", text), options);
  }
  /// The message with which loading fails: one line.
  std::string error_of(const std::string& text) const {
    try {
      static_cast<void>(load(text));
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), Not(HasSubstr("\n")));
      return error.what();
    }
    return "loaded without an error";
  }
};

TEST_F(SceneFile, ReadsCameraShapesMaterialsAndLights) {
  const SceneDescription scene = load(floor_scene());
  EXPECT_EQ(scene.camera.width, 8U);
  EXPECT_EQ(scene.camera.height, 6U);
  EXPECT_FLOAT_EQ(scene.camera.fov_degrees, 40.0F);
  EXPECT_EQ(scene.max_depth, 3);
  EXPECT_EQ(scene.shapes.meshes.size(), 1U);
  ASSERT_EQ(scene.emitters.points.size(), 1U);
  EXPECT_FLOAT_EQ(scene.emitters.points[0].position.z, 2.0F);
  EXPECT_EQ(scene.materials[scene.shape_infos[0].material].kind, MaterialKind::diffuse);
}

TEST_F(SceneFile, OldAndNewSpellingsMeanTheSame) {
  std::string old_spelling = floor_scene("", "<bsdf type=\"roughplastic\"><float name=\"intIOR\" value=\"1.6\"/>"
                                             "<rgb name=\"diffuseReflectance\" value=\"0.1 0.2 0.3\"/></bsdf>");
  std::string new_spelling = floor_scene("", "<bsdf type=\"roughplastic\"><float name=\"int_ior\" value=\"1.6\"/>"
                                             "<rgb name=\"diffuse_reflectance\" value=\"0.1, 0.2, 0.3\"/></bsdf>");
  const MaterialDescription a = load(old_spelling).materials[0];
  const MaterialDescription b = load(new_spelling).materials[0];
  EXPECT_FLOAT_EQ(a.interior_ior, 1.6F);
  EXPECT_FLOAT_EQ(b.interior_ior, 1.6F);
  EXPECT_EQ(a.reflectance.mean(), b.reflectance.mean());
  EXPECT_FLOAT_EQ(a.reflectance.mean().y, 0.2F);
}

TEST_F(SceneFile, EmittersFollowTheirShapesWhenIdsAreSorted) {
  // Spheres stand before meshes in the file but behind them in the ids.
  const std::string extra =
      "<shape type=\"sphere\" id=\"lamp\"><emitter type=\"area\"><rgb name=\"radiance\" value=\"7\"/></emitter></shape>"
      "<shape type=\"disk\" id=\"plate\"/><shape type=\"cube\" id=\"box\"/>";
  const SceneDescription scene = load(floor_scene(extra));
  ASSERT_EQ(scene.shape_infos.size(), 4U);
  EXPECT_EQ(scene.shape_infos[1].name, "box");
  EXPECT_EQ(scene.shape_infos[2].name, "lamp");
  EXPECT_EQ(scene.shape_infos[3].name, "plate");
  ASSERT_EQ(scene.emitters.areas.size(), 1U);
  EXPECT_EQ(scene.emitters.areas[0].shape, 2U);  // planted bug: without the renumbering it is 1, the box
}

TEST_F(SceneFile, DefinesReplaceDefaults) {
  std::string text = floor_scene();
  const std::string from = "<integer name=\"max_depth\" value=\"3\"/>";
  text.replace(text.find(from), from.size(), "<integer name=\"max_depth\" value=\"$depth\"/>");
  text.insert(text.find("<integrator"), "<default name=\"depth\" value=\"5\"/>");
  EXPECT_EQ(load(text).max_depth, 5);
  LoadOptions options;
  options.defines["depth"] = "9";
  EXPECT_EQ(load(text, options).max_depth, 9);
}

TEST_F(SceneFile, LenientReplacesUnknownMaterialsWithAWarning) {
  const std::string text = floor_scene("", "<bsdf type=\"hologram\"><float name=\"x\" value=\"1\"/></bsdf>");
  EXPECT_THAT(error_of(text), AllOf(HasSubstr("scene.xml:1"), HasSubstr("hologram"), HasSubstr("supported are")));
  LoadOptions options;
  options.is_lenient = true;
  const SceneDescription scene = load(text, options);
  ASSERT_EQ(scene.warnings.size(), 1U);
  EXPECT_EQ(scene.materials[0].kind, MaterialKind::diffuse);
}

TEST_F(SceneFile, MaskTwoSidedAndBlendNest) {
  const SceneDescription scene =
      load(floor_scene("", "<bsdf type=\"mask\"><float name=\"opacity\" value=\"0.25\"/><bsdf type=\"twosided\">"
                           "<bsdf type=\"blendbsdf\"><float name=\"weight\" value=\"0.3\"/><bsdf type=\"diffuse\"/>"
                           "<bsdf type=\"conductor\"/></bsdf></bsdf></bsdf>"));
  const MaterialDescription& m = scene.materials[0];
  EXPECT_EQ(m.kind, MaterialKind::blend);
  EXPECT_TRUE(m.is_two_sided);
  ASSERT_TRUE(m.opacity.has_value());
  EXPECT_FLOAT_EQ(m.opacity->mean().x, 0.25F);
  EXPECT_EQ(m.nested.size(), 2U);
}

TEST_F(SceneFile, RoughDielectric) {
  const SceneDescription scene = load(floor_scene(
      "", "<bsdf type=\"roughdielectric\"><string name=\"distribution\" value=\"ggx\"/><string name=\"int_ior\" "
          "value=\"diamond\"/><float name=\"alpha_u\" value=\"0.3\"/><float name=\"alpha_v\" value=\"0.05\"/></bsdf>"));
  const MaterialDescription& m = scene.materials[0];
  EXPECT_EQ(m.kind, MaterialKind::rough_dielectric);
  EXPECT_EQ(m.distribution, MicrofacetType::ggx);
  EXPECT_FLOAT_EQ(m.interior_ior, 2.419F);
  EXPECT_FLOAT_EQ(m.alpha_u.mean().x, 0.3F);
  EXPECT_FLOAT_EQ(m.alpha_v.mean().x, 0.05F);
}

std::string relief(const std::string& type, const std::string& nested) {
  return "<bsdf type=\"" + type + "\"><texture name=\"any\" type=\"checkerboard\"/>" + nested + "</bsdf>";
}

TEST_F(SceneFile, BumpAndNormalMapsStandAroundAMaterial) {
  const std::string nested = "<float name=\"scale\" value=\"-0.5\"/><bsdf type=\"phong\"/>";
  const MaterialDescription bumped = load(floor_scene("", relief("bumpmap", nested))).materials[0];
  EXPECT_EQ(bumped.kind, MaterialKind::phong);
  EXPECT_EQ(bumped.relief, Relief::heights);
  EXPECT_FLOAT_EQ(bumped.relief_scale, -0.5F);
  const MaterialDescription mapped = load(floor_scene("", relief("normalmap", "<bsdf type=\"mask\"><bsdf "
                                                                              "type=\"diffuse\"/></bsdf>")))
                                         .materials[0];
  EXPECT_EQ(mapped.relief, Relief::normals);
  EXPECT_TRUE(mapped.opacity.has_value());
}

std::string spot(const std::string& inside) {
  return floor_scene("<emitter type=\"spot\"><transform name=\"to_world\"><lookat origin=\"1,2,3\" target=\"1,2,0\" "
                     "up=\"0,1,0\"/></transform>" +
                     inside + "</emitter>");
}

// Oracle: the peer's documentation: the light looks along local +z, 20 degrees and three quarters of it by default.
TEST_F(SceneFile, SpotLights) {
  const PointEmitter<float> light = load(spot("<rgb name=\"intensity\" value=\"7\"/>")).emitters.points.at(1);
  EXPECT_EQ(light.position, Vec3<float>(1, 2, 3));
  EXPECT_NEAR(glm::length(glm::normalize(light.axis) - Vec3<float>(0, 0, -1)), 0, 1e-6);  // some ulp
  EXPECT_FLOAT_EQ(light.intensity.x, 7.0F);
  EXPECT_FLOAT_EQ(light.cutoff, 20 * k_pi<float> / 180);
  EXPECT_FLOAT_EQ(light.beam_width, 15 * k_pi<float> / 180);
  const PointEmitter<float> hard = load(spot("<float name=\"cutoffAngle\" value=\"40\"/><float name=\"beamWidth\" "
                                             "value=\"40\"/>"))
                                       .emitters.points.at(1);
  EXPECT_EQ(hard.cutoff, hard.beam_width);
}

struct BadCase {
  const char* name;
  std::string text;
  const char* mentions;
};

class BadScene : public SceneFile, public ::testing::WithParamInterface<BadCase> {};

TEST_P(BadScene, IsReportedInOneLine) {
  write("empty.obj", "# nothing\n");
  write("range.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n");
  write("broken.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n");
  write("broken.serialized", std::string("\x1c\x04\x04\x00half", 8));
  write("broken.png", "\x89PNG\r\n");
  EXPECT_THAT(error_of(GetParam().text), HasSubstr(GetParam().mentions));
}

std::string shape(const std::string& type, const std::string& file) {
  return floor_scene("<shape type=\"" + type + "\"><string name=\"filename\" value=\"" + file + "\"/></shape>");
}
std::string without(std::string text, const std::string& from, const std::string& to) {
  const std::size_t begin = text.find(from);
  return text.erase(begin, text.find(to, begin) + to.size() - begin);
}

INSTANTIATE_TEST_SUITE_P(
    Cases, BadScene,
    ::testing::Values(
        BadCase{"Malformed", "<scene version=\"3.0.0\"><shape></scene>", "scene.xml"},
        BadCase{"Truncated", floor_scene().substr(0, 200), "scene.xml"}, BadCase{"Empty", "", "scene.xml"},
        BadCase{"UnknownShape", shape("teapot", "x.obj"), "teapot"},
        BadCase{"UnknownEmitter", floor_scene("<emitter type=\"laser\"/>"), "laser"},
        BadCase{"UnknownElement", floor_scene("<gizmo/>"), "gizmo"},
        BadCase{"UnknownProperty", floor_scene("", "<bsdf type=\"diffuse\"><float name=\"shine\" value=\"1\"/></bsdf>"),
                "shine"},
        BadCase{"NotANumber", floor_scene("", "<bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"nan\"/></bsdf>"),
                "nan"},
        BadCase{"Negative", floor_scene("", "<bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"-0.5\"/></bsdf>"),
                "-0.5"},
        BadCase{"AboveOne", floor_scene("", "<bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"1.5\"/></bsdf>"),
                "1.5"},
        BadCase{"ZeroRoughness", floor_scene("", "<bsdf type=\"roughconductor\"><float name=\"alpha\" value=\"0\"/></bsdf>"),
                "oughness"},
        BadCase{"NegativeLight", floor_scene("<emitter type=\"constant\"><rgb name=\"radiance\" value=\"-1\"/></emitter>"),
                "-1"},
        BadCase{"SpotTexture", spot("<texture name=\"texture\" type=\"checkerboard\"/>"), "texture on a spot light"},
        BadCase{"SpotBeamTooWide", spot("<float name=\"beam_width\" value=\"21\"/>"), "beam_width is out of range"},
        BadCase{"SpotCutoff", spot("<float name=\"cutoff_angle\" value=\"-1\"/>"), "cutoff_angle is out of range"},
        BadCase{"SameIndices",
                floor_scene("", "<bsdf type=\"roughdielectric\"><float name=\"int_ior\" value=\"1.2\"/><float "
                                "name=\"ext_ior\" value=\"1.2\"/></bsdf>"),
                "both indices are the same"},
        BadCase{"BumpWithoutTexture", floor_scene("", "<bsdf type=\"bumpmap\"><bsdf type=\"diffuse\"/></bsdf>"),
                "exactly one nested <texture>"},
        BadCase{"BumpOfBump", floor_scene("", relief("bumpmap", relief("normalmap", "<bsdf type=\"diffuse\"/>"))),
                "inside another"},
        BadCase{"BumpMirrorsNormals",
                floor_scene("", relief("bumpmap", "<bsdf type=\"diffuse\"/><boolean name=\"flip_invalid_normals\" "
                                                  "value=\"true\"/>")),
                "flip_invalid_normals is not supported"},
        BadCase{"NoCamera", without(floor_scene(), "<sensor", "</sensor>"), "no camera"},
        BadCase{"NoEmitter", without(floor_scene(), "<emitter", "</emitter>"), "no emitters"},
        BadCase{"NoShapes", without(floor_scene(), "<shape", "</shape>"), "no shapes"},
        BadCase{"MissingMesh", shape("obj", "nowhere.obj"), "nowhere.obj"},
        BadCase{"EmptyMesh", shape("obj", "empty.obj"), "empty.obj"},
        BadCase{"IndexOutOfRange", shape("obj", "range.obj"), "range.obj"},
        BadCase{"TruncatedPly", shape("ply", "broken.ply"), "broken.ply"},
        BadCase{"TruncatedSerialized", shape("serialized", "broken.serialized"), "broken.serialized"},
        BadCase{"TruncatedPng",
                floor_scene("", "<bsdf type=\"diffuse\"><texture type=\"bitmap\" name=\"reflectance\"><string "
                                "name=\"filename\" value=\"broken.png\"/></texture></bsdf>"),
                "broken.png"},
        BadCase{"UnknownReference", floor_scene("", "<ref id=\"gone\"/>"), "gone"},
        BadCase{"ImpossibleSize",
                [] {
                  std::string text = floor_scene();
                  text.replace(text.find("value=\"8\""), 9, "value=\"0\"");
                  return text;
                }(),
                "width"}),
    [](const auto& each) { return std::string(each.param.name); });

/// No truncation or mutation of a file crashes the loader: it loads or throws a typed error of one line.
TEST_F(SceneFile, SurvivesDamage) {
  const std::string good = floor_scene("<shape type=\"sphere\"/>", "<bsdf type=\"plastic\"/>");
  std::mt19937 random(7);  // NOLINT(cert-msc51-cpp): fixed on purpose
  for (int i = 0; i < 300; ++i) {
    std::string text = good;
    if (i % 2 == 0) text.resize(random() % text.size());
    for (int k = 0; k < i % 5 && !text.empty(); ++k) text[random() % text.size()] = static_cast<char>(random() % 128);
    try {
      static_cast<void>(load(text));
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), Not(HasSubstr("\n"))) << text;
    }
  }
}

}  // namespace
}  // namespace manylight::scene_file::scene_file_test
