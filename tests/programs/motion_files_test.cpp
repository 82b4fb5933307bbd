// SPDX-License-Identifier: Apache-2.0
// Motion and subsurface scattering in scene files and in the program.
#include <cmath>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "image_io/image_io.hpp"
#include "programs/program_run.hpp"
#include "programs/scratch.hpp"
#include "scene_file/load_scene.hpp"

namespace manylight::scene_file::motion_files_test {
namespace {

using test::message_of;
using testing::HasSubstr;

std::string scene_of(const std::string& extra, const std::string& in_sensor = "") {
  return "<scene version=\"3.0.0\"><sensor type=\"perspective\"><film type=\"hdrfilm\"><integer name=\"width\" "
         "value=\"8\"/><integer name=\"height\" value=\"8\"/><rfilter type=\"box\"/></film>" +
         in_sensor + "</sensor><shape type=\"rectangle\" id=\"floor\"/><emitter type=\"constant\"/>" + extra + "</scene>";
}
std::string key(const std::string& time, const std::string& steps) {
  return "<transform time=\"" + time + "\">" + steps + "</transform>";
}
std::string animation(const std::string& keys) { return "<animation name=\"to_world\">" + keys + "</animation>"; }
std::string open_for(const std::string& open, const std::string& close) {
  return "<float name=\"shutter_open\" value=\"" + open + "\"/><float name=\"shutter_close\" value=\"" + close + "\"/>";
}
const std::string k_glide = animation(key("0", "<translate x=\"1\"/>") + key("1", "<translate x=\"3\" z=\"4\"/>"));

class MotionFiles : public test::ScratchTest {
 protected:
  SceneDescription load(const std::string& text) const { return load_scene(write("scene.xml", text)); }
  std::string error_of(const std::string& text) const {
    return message_of<Error>([&] { static_cast<void>(load(text)); });
  }
};

TEST_F(MotionFiles, ShapesGlideBetweenKeyFrames) {
  const SceneDescription scene = load(scene_of(
      "<shape type=\"sphere\" id=\"ball\">" + k_glide + "</shape><shape type=\"cube\" id=\"box\">" +
          animation(key("0", "<rotate z=\"1\" angle=\"0\"/>") + key("2", "<rotate z=\"1\" angle=\"90\"/>")) + "</shape>",
      open_for("0", "1")));
  ASSERT_TRUE(scene.moves());
  const SceneDescription half = at_time(scene, 0.5F);
  EXPECT_FLOAT_EQ(half.shapes.spheres[0].center.x, 2);
  EXPECT_FLOAT_EQ(half.shapes.spheres[0].center.z, 2);
  EXPECT_FLOAT_EQ(scene.shapes.spheres[0].center.x, 1) << "as when the shutter opens";
  EXPECT_FLOAT_EQ(at_time(scene, 7.0F).shapes.spheres[0].center.x, 3) << "rests after the last key frame";
  // A cube's corner on its turn by 45 degrees; meshes: floor, box.
  const Vec3<float> before = scene.shapes.meshes[1].positions[0];
  const Vec3<float> after = at_time(scene, 1.0F).shapes.meshes[1].positions[0];
  EXPECT_NEAR(after.x, std::sqrt(0.5F) * (before.x - before.y), 1e-5);
  EXPECT_NEAR(after.y, std::sqrt(0.5F) * (before.x + before.y), 1e-5);
  EXPECT_FLOAT_EQ(after.z, before.z);
}

TEST_F(MotionFiles, CameraAndShutter) {
  const SceneDescription scene = load(scene_of("", k_glide + open_for("0.25", "0.75")));
  EXPECT_TRUE(scene.moves());
  EXPECT_FLOAT_EQ(scene.camera.to_world[3].x, 1.5F);
  EXPECT_FLOAT_EQ(at_time(scene, 0.75F).camera.to_world[3].x, 2.5F);
  EXPECT_FALSE(load(scene_of("", k_glide)).moves()) << "the shutter does not open";
  EXPECT_FALSE(load(scene_of("", open_for("0", "1"))).moves()) << "nothing moves";
}

TEST_F(MotionFiles, MeshesDeform) {
  const std::string triangle = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
                               "z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
  write("open.ply", triangle + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  write("closed.ply", triangle + "0 0 2\n1 0 0\n0 1 0\n3 0 1 2\n");
  write("other.ply", triangle + "0 0 2\n1 0 0\n0 1 0\n3 0 2 1\n");
  const auto mesh = [](const std::string& closing) {
    return "<shape type=\"ply\"><string name=\"filename\" value=\"open.ply\"/><string name=\"closing_filename\" value=\"" +
           closing + "\"/></shape>";
  };
  const SceneDescription scene = load(scene_of(mesh("closed.ply"), open_for("1", "3")));
  EXPECT_FLOAT_EQ(at_time(scene, 1.5F).shapes.meshes[1].positions[0].z, 0.5F);
  EXPECT_THAT(error_of(scene_of(mesh("other.ply"))), HasSubstr("closing_filename has other triangles"));
}

std::string below(const std::string& inside, const std::string& type = "exponential") {
  return "<shape type=\"sphere\"><subsurface type=\"" + type + "\">" + inside + "</subsurface></shape>";
}
const std::string k_length = "<rgb name=\"length\" value=\"0.1, 0.2, 0.3\"/>";

TEST_F(MotionFiles, SubsurfaceScattering) {
  const SceneDescription scene = load(scene_of(
      below(k_length + "<float name=\"int_ior\" value=\"1.4\"/>") +
      below("<rgb name=\"sigma_s\" value=\"1, 2, 3\"/><float name=\"g\" value=\"0.5\"/><float name=\"scale\" value=\"10\"/>",
            "dipole")));
  ASSERT_EQ(scene.subsurfaces.size(), 2U);
  EXPECT_EQ(scene.subsurfaces[0].kind, FalloffKind::exponential);
  EXPECT_FLOAT_EQ(scene.subsurfaces[0].length.z, 0.3F);
  EXPECT_FLOAT_EQ(scene.subsurfaces[0].ior, 1.4F);
  EXPECT_FLOAT_EQ(scene.subsurfaces[1].sigma_s.y, 10.0F) << "reduced and scaled";
  EXPECT_EQ(scene.shape_infos[2].subsurface, 1U);
}

struct BadCase {
  const char* name;
  std::string scene;
  const char* message;
};
class BadMotion : public MotionFiles, public testing::WithParamInterface<BadCase> {};
TEST_P(BadMotion, SaysWhatIsWrong) { EXPECT_THAT(error_of(GetParam().scene), HasSubstr(GetParam().message)); }

std::string moving(const std::string& keys) { return scene_of("<shape type=\"cube\">" + animation(keys) + "</shape>"); }
INSTANTIATE_TEST_SUITE_P(
    Cases, BadMotion,
    testing::Values(BadCase{"NoKey", moving(""), "needs at least one"},
                    BadCase{"KeysOutOfOrder", moving(key("1", "") + key("0", "")), "time must be above"},
                    BadCase{"Sheared", moving(key("0", "<matrix value=\"1 1 0 0 0 1 0 0 0 0 1 0 0 0 0 1\"/>") + key("1", "")),
                            "sheared"},
                    BadCase{"Shutter", scene_of("", open_for("1", "0")), "shutter_close is before"},
                    BadCase{"NoLength", scene_of(below("")), "length must be above 0"},
                    BadCase{"Reflectance", scene_of(below(k_length + "<rgb name=\"reflectance\" value=\"1, 2, 1\"/>")),
                            "reflectance is above 1"},
                    BadCase{"Kind", scene_of(below("", "wax")), "unknown subsurface scattering"},
                    BadCase{"Dipole", scene_of(below("<float name=\"g\" value=\"1\"/>", "dipole")), "g is out of range"}),
    [](const auto& chosen) { return std::string(chosen.param.name); });

/// A ball that moves by its width under a uniform sky: seen by a quarter at each of four instants. Oracle: the same image
/// from four scenes at rest. False alarms: none, the same random numbers.
TEST_F(MotionFiles, ProgramRendersInstants) {
  const auto mean = [&](const std::string& scene, const std::string& arguments) {
    const auto run = test::run_program(std::string(MANYLIGHT_RENDER_PROGRAM) + " " + write("scene.xml", scene).string() +
                                       " -q -o " + path("a.pfm").string() + " --stats " + path("a.json").string() + " " +
                                       arguments);
    EXPECT_EQ(run.exit_code, 0) << run.output;
    double sum = 0;
    for (const Rgb<float>& pixel : image_io::read_image(path("a.pfm")).pixels) sum += static_cast<double>(pixel.x) / 64;
    return sum;
  };
  const auto ball = [](const std::string& place) {
    return "<shape type=\"sphere\"><bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"0,0,0\"/></bsdf>" + place +
           "</shape>";
  };
  const std::string glide = animation(key("0", "<translate x=\"-4\" z=\"9\"/>") + key("1", "<translate x=\"4\" z=\"9\"/>"));
  for (const char* method : {"-m path --spp 256", "-m bdlc --vpls 10 --eye-paths 256"}) {
    const double blurred = mean(scene_of(ball(glide), open_for("0", "1")), std::string(method) + " --instants 4");
    std::ifstream in(path("a.json"));
    EXPECT_EQ(nlohmann::json::parse(in)["scene_kind"], "everything");
    double still = 0;
    for (const char* x : {"-3", "-1", "1", "3"}) {
      still += mean(scene_of(ball("<point name=\"center\" x=\"" + std::string(x) + "\" y=\"0\" z=\"9\"/>")), method) / 4;
    }
    EXPECT_LT(still, 0.95) << "the ball is seen";
    EXPECT_NEAR(blurred, still, 0.01) << method;
  }
}

}  // namespace
}  // namespace manylight::scene_file::motion_files_test
