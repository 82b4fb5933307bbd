// SPDX-License-Identifier: Apache-2.0
// manylight-render with participating media: every kind of medium that files know.
#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "image_io/image_io.hpp"
#include "manylight/core/spectrum.hpp"
#include "programs/program_run.hpp"
#include "programs/volume_files.hpp"
#include "support/z_test.hpp"

namespace manylight::media_render_test {
namespace {

using test::floor_scene;
using test::ProgramRun;
using test::run_program;
using test::RunningMoments;
using test::volume_file;

class MediaRender : public test::ScratchTest {
 protected:
  void SetUp() override {
    ScratchTest::SetUp();
    std::vector<float> density;
    for (int i = 0; i < 27; ++i) density.push_back(static_cast<float>(i % 4) / 2);
    write("density.vol", volume_file({3, 3, 3}, 1, {-1, -1, -1, 1, 1, 1}, density));
    write("white.vol", volume_file({2, 2, 2}, 3, {-2, -2, -2, 2, 2, 2}, std::vector<float>(24, 1.0F)));
    std::vector<float> axes;
    for (int i = 0; i < 27; ++i) axes.insert(axes.end(), {static_cast<float>(i % 3), 1, static_cast<float>(i / 9)});
    write("axes.vol", volume_file({3, 3, 3}, 3, {-1, -1, -1, 1, 1, 1}, axes));
  }
  /// Mean luminance per pixel of the image that the call makes.
  [[nodiscard]] RunningMoments pixels(const std::string& scene, const std::string& arguments) const {
    const ProgramRun run =
        run_program(std::string(MANYLIGHT_RENDER_PROGRAM) + " " + scene + " -q -o " + path("a.pfm").string() +
                    " --stats " + path("a.json").string() + " " + arguments);
    EXPECT_EQ(run.exit_code, 0) << run.output;
    RunningMoments moments;
    if (run.exit_code != 0) return moments;
    for (const Rgb<float>& pixel : image_io::read_image(path("a.pfm")).pixels) {
      moments.add(static_cast<double>(luminance(pixel)));
    }
    return moments;
  }
  [[nodiscard]] nlohmann::json statistics() const {
    std::ifstream in(path("a.json"));
    return nlohmann::json::parse(in);
  }
};

std::string grid(const std::string& name, const std::string& file) {
  return "<volume type=\"gridvolume\" name=\"" + name + "\"><string name=\"filename\" value=\"" + file +
         "\"/></volume>";
}

struct White {
  const char* name;
  const char* version;
  std::string medium;
};
class WhiteMedia : public MediaRender, public testing::WithParamInterface<White> {};

// Oracle: white matter under a uniform sky cannot be seen. False alarms: 1e-6 per medium.
// Planted bug seen to fail: a grid of albedo not looked up.
TEST_P(WhiteMedia, AreInvisibleUnderAWhiteSky) {
  const std::string scene =
      write("white.xml", std::string("<scene version=\"") + GetParam().version +
                             "\"><sensor type=\"perspective\"><float name=\"fov\" value=\"35\"/><transform "
                             "name=\"to_world\"><lookat origin=\"0,0.5,4\" target=\"0,0,0\" up=\"0,1,0\"/></transform>"
                             "<film type=\"hdrfilm\"><integer name=\"width\" value=\"16\"/><integer name=\"height\" "
                             "value=\"16\"/></film></sensor><emitter type=\"constant\"><rgb name=\"radiance\" "
                             "value=\"1\"/></emitter><shape type=\"cube\">" +
                             GetParam().medium + "</shape></scene>")
          .string();
  const RunningMoments seen = pixels(scene, "-m path --spp 64");
  // 1e-3: what tables of fibers may lose
  EXPECT_NEAR(seen.mean(), 1, test::normal_limit(1e-6) * seen.standard_error() + 1e-3);
  EXPECT_LT(seen.standard_error(), 0.01);
  EXPECT_GT(seen.standard_error(), 0) << "the medium is not there";
  EXPECT_EQ(statistics()["scene_kind"], "everything");
}

const char* const k_albedo = "<rgb name=\"albedo\" value=\"1\"/>";
const char* const k_scale = "<float name=\"scale\" value=\"3\"/>";

INSTANTIATE_TEST_SUITE_P(
    Kinds, WhiteMedia,
    testing::Values(
        White{"Homogeneous", "0.6.0",
              "<medium type=\"homogeneous\" name=\"interior\"><rgb name=\"sigmaS\" value=\"1,2,3\"/><rgb "
              "name=\"sigmaA\" value=\"0\"/><phase type=\"hg\"><float name=\"g\" value=\"0.7\"/></phase></medium>"},
        White{"Boxed", "3.0.0",
              std::string("<medium type=\"heterogeneous\" name=\"interior\"><rgb name=\"sigma_t\" value=\"1,2,3\"/>") +
                  k_albedo + "</medium>"},
        White{"Grid", "0.6.0",
              "<medium type=\"heterogeneous\" name=\"interior\">" + grid("density", "density.vol") + k_albedo +
                  k_scale + "</medium>"},
        White{"GridOfAlbedo", "0.6.0",
              "<medium type=\"heterogeneous\" name=\"interior\">" + grid("density", "density.vol") +
                  grid("albedo", "white.vol") + k_scale + "</medium>"},
        White{"Fibers", "0.6.0",
              "<medium type=\"heterogeneous\" name=\"interior\">" + grid("density", "density.vol") + k_albedo +
                  k_scale + grid("orientation", "axes.vol") +
                  "<phase type=\"microflake\"><float name=\"stddev\" value=\"0.3\"/></phase></medium>"},
        White{"FibersOfAlbedo", "0.6.0",
              "<medium type=\"heterogeneous\" name=\"interior\">" + grid("density", "density.vol") +
                  grid("albedo", "white.vol") + k_scale + grid("orientation", "axes.vol") +
                  "<phase type=\"microflake\"><float name=\"stddev\" value=\"0.1\"/></phase></medium>"}),
    [](const auto& each) { return std::string(each.param.name); });

/// A lit box full of fog with the camera in it, a ball of smoke and a ball of glass full of fog of its own.
std::string fog_box() {
  const std::string fog = "<ref name=\"exterior\" id=\"fog\"/>";
  const auto wall = [](const std::string& transform) {
    return "<shape type=\"rectangle\"><bsdf type=\"twosided\"><bsdf type=\"diffuse\"/></bsdf><transform "
           "name=\"to_world\">" +
           transform + "</transform></shape>";
  };
  return "<scene version=\"0.6.0\"><medium type=\"homogeneous\" id=\"fog\"><rgb name=\"sigmaA\" value=\"0.02\"/><rgb "
         "name=\"sigmaS\" value=\"0.2,0.15,0.1\"/><phase type=\"hg\"><float name=\"g\" value=\"0.5\"/></phase></medium>"
         "<sensor type=\"perspective\"><float name=\"fov\" value=\"60\"/><transform name=\"to_world\"><lookat "
         "origin=\"0,0,0.9\" target=\"0,-0.2,0\" up=\"0,1,0\"/></transform><film type=\"hdrfilm\"><integer "
         "name=\"width\" value=\"32\"/><integer name=\"height\" value=\"32\"/></film><ref id=\"fog\"/></sensor>" +
         wall("<translate z=\"-1\"/>") + wall("<translate z=\"1\"/>") +
         wall("<rotate y=\"1\" angle=\"90\"/><translate x=\"-1\"/>") +
         wall("<rotate y=\"1\" angle=\"90\"/><translate x=\"1\"/>") +
         wall("<rotate x=\"1\" angle=\"90\"/><translate y=\"-1\"/>") +
         wall("<rotate x=\"1\" angle=\"90\"/><translate y=\"1\"/>") +
         "<shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"0.4\"/><rotate x=\"1\" angle=\"90\"/>"
         "<translate y=\"0.99\"/></transform><emitter type=\"area\"><rgb name=\"radiance\" "
         "value=\"5\"/></emitter></shape>"
         "<shape type=\"sphere\"><point name=\"center\" x=\"-0.4\" y=\"-0.5\" z=\"-0.3\"/><float name=\"radius\" "
         "value=\"0.4\"/>" +
         fog + "<medium type=\"heterogeneous\" name=\"interior\">" + grid("density", "density.vol") +
         "<rgb name=\"albedo\" value=\"0.9,0.5,0.9\"/><float name=\"scale\" value=\"4\"/></medium></shape>"
         "<shape type=\"sphere\"><point name=\"center\" x=\"0.45\" y=\"-0.6\" z=\"-0.2\"/><float name=\"radius\" "
         "value=\"0.3\"/><bsdf type=\"roughdielectric\"><float name=\"alpha\" value=\"0.4\"/></bsdf>" +
         fog +
         "<medium type=\"homogeneous\" name=\"interior\"><float name=\"sigmaT\" value=\"3\"/><rgb name=\"albedo\" "
         "value=\"0.5,0.9,0.9\"/></medium></shape></scene>";
}

// Two estimators of one image, for these weights miss nothing: means of 8 images each, false alarms 1e-5 (Student t, 14
// degrees of freedom: 6.5).
TEST_F(MediaRender, PathsAndCutsAgreeInAFogBox) {
  const std::string scene = write("fog.xml", fog_box()).string();
  const auto mean = [&](const std::string& arguments) {
    RunningMoments runs;
    for (int seed = 0; seed < 8; ++seed) {
      runs.add(pixels(scene, "--max-depth 5 --seed " + std::to_string(seed) + " " + arguments).mean());
    }
    return runs;
  };
  const RunningMoments paths = mean("-m path --spp 32");
  const RunningMoments cuts = mean("-m bdlc --weights kollig_keller --eye-paths 8 --vpls 4000 --threshold 0.05");
  const double error = std::hypot(paths.standard_error(), cuts.standard_error());
  EXPECT_NEAR(paths.mean(), cuts.mean(), 6.5 * error);
  EXPECT_LT(error, 0.015 * paths.mean());
  EXPECT_EQ(statistics()["bound_violations"], 0);
  EXPECT_EQ(statistics()["invalid_samples"], 0);
}

TEST_F(MediaRender, EveryMethodAndImageWorksInFog) {
  const std::string scene = write("fog.xml", fog_box()).string();
  for (const std::string arguments :
       {"-m vpl --vpls 50", "-m lightcuts --weights standard --vpls 500",
        "-m bdlc --weights four --vpls 500 --ledger-spp 2", "-m bdlc --bounds analytic --vpls 500",
        "-m bdlc --bounds cube-map --weights kollig_keller --vpls 500"}) {
    EXPECT_GT(pixels(scene, "--size 8x8 --eye-paths 2 --aov normal=" + path("n.pfm").string() + " " + arguments).mean(),
              0)
        << arguments;
    EXPECT_EQ(statistics()["invalid_samples"], 0) << arguments;
  }
}

TEST_F(MediaRender, TheNarrowestKindOfSceneIsRendered) {
  const auto kind = [&](const std::string& bsdf, const std::string& extra = "") {
    const std::string scene = write("floor.xml", floor_scene(extra, bsdf)).string();
    EXPECT_GT(pixels(scene, "-m path --spp 1 --size 4x4").mean(), 0);
    return statistics()["scene_kind"].get<std::string>();
  };
  EXPECT_EQ(kind("<bsdf type=\"diffuse\"/>"), "diffuse");
  EXPECT_EQ(kind("<bsdf type=\"plastic\"/>"), "surfaces");
  EXPECT_EQ(kind("<bsdf type=\"blendbsdf\"><bsdf type=\"diffuse\"/><bsdf type=\"plastic\"/></bsdf>"), "everything");
  const std::string ball =
      "<shape type=\"sphere\"><float name=\"radius\" value=\"0.1\"/><medium name=\"interior\" "
      "type=\"homogeneous\"><float name=\"sigma_a\" value=\"1\"/></medium>";
  EXPECT_EQ(kind("<bsdf type=\"diffuse\"/>", ball + "<bsdf type=\"dielectric\"/></shape>"), "surfaces");
  EXPECT_EQ(kind("<bsdf type=\"diffuse\"/>", ball + "</shape>"), "everything");
}

TEST_F(MediaRender, GridsThatWouldTakeForeverAreNamed) {
  const std::string scene =
      write("thick.xml",
            floor_scene("<shape type=\"sphere\"><medium name=\"interior\" id=\"soot\" type=\"heterogeneous\">" +
                        grid("sigma_t", "density.vol") + "<float name=\"scale\" value=\"1e9\"/></medium></shape>"))
          .string();
  const ProgramRun run =
      run_program(std::string(MANYLIGHT_RENDER_PROGRAM) + " " + scene + " -o " + path("a.pfm").string());
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.output, testing::AllOf(testing::HasSubstr("medium 'soot'"), testing::HasSubstr("at most 1e6")));
}

}  // namespace
}  // namespace manylight::media_render_test
