// SPDX-License-Identifier: Apache-2.0
// manylight-render against images that other renderers made (folder MANYLIGHT_REFERENCE_SCENES).
#include <cmath>
#include <vector>

#include <gmock/gmock.h>

#include "manylight/integrator/film.hpp"
#include "metrics/z_test.hpp"
#include "programs/reference.hpp"

namespace manylight::reference_slow_test {
namespace {

using test::Reference;
using test::shrink;

struct ZCase {
  const char* name;    ///< of the test and the files
  const char* folder;  ///< inside mitsuba-tests/tests/scenes
  const char* scene;
};

class ZTest : public Reference, public ::testing::WithParamInterface<ZCase> {};

/// The peer's own test: floor(2e6 / pixels) samples per pixel, z per XYZ channel against the mean and the variance of
/// 32,000 independent samples; at most 0.25 % of the pixel-channels may fail a Sidak level of 1 %.
TEST_P(ZTest, PathMatchesThePeer) {
  const std::string base = "mitsuba-tests/tests/scenes/" + std::string(GetParam().folder);
  const std::string refs = folder() + "/" + base + "/refs/" + GetParam().name;
  const Image<float> reference = image_io::read_image(refs + "_ref_rgb.exr");
  const Image<float> variance = image_io::read_image(refs + "_ref_rgb_var.exr");
  const auto spp = static_cast<unsigned>(2'000'000 / reference.pixels.size());
  const Image<float> image =
      render(base + "/" + GetParam().scene, "-m path --sampler independent --spp " + std::to_string(spp));
  const metrics::ZTestResult result = metrics::z_test(image, reference, variance, spp);
  EXPECT_TRUE(result.passes) << result.failures << " of " << result.tests << " fail, allowed " << result.allowed
                             << "; worst z " << result.worst_z << " at (" << result.worst_x << ", " << result.worst_y
                             << "), mean difference " << metrics::measure(image, reference).signed_difference;
}

// test_surf_area_light differs by -0.16 % in the mean at 32,000 samples of ours, all of it in the diffuse part of its
// rough plastic sphere (-0.8 % in 335 pixels, 8 standard errors), and fails beyond 16,000 samples. The peer made that
// picture with an earlier transmittance of rough coats, 1 minus the singly reflected light: with it the sphere agrees
// (+0.2 %, 1.7 standard errors), while test_roughplastic_linear, made later, is off by up to 18 % and agrees to 0.05 %
// with the definition used here.
INSTANTIATE_TEST_SUITE_P(
    Scenes, ZTest,
    ::testing::Values(
        ZCase{"test_directional", "floating_sphere", "test_directional_direct.xml"},
        ZCase{"test_texture_interp", "texture_interp", "test_texture_interp_direct.xml"},
        ZCase{"test_textured_diffuse", "bsdf_spheres", "test_textured_diffuse_path.xml"},
        ZCase{"test_textured_roughconductor", "bsdf_spheres", "test_textured_roughconductor_path.xml"},
        ZCase{"test_roughplastic_linear", "bsdf_spheres", "test_roughplastic_linear_path.xml"},
        ZCase{"test_constant", "bsdf_spheres", "test_constant_path.xml"},
        ZCase{"test_arealight", "bsdf_spheres", "test_arealight_path.xml"},
        ZCase{"test_surf_area_light", "participating_media", "test_surf_area_light_volpath.xml"},
        ZCase{"test_homo_null_envmap", "participating_media", "test_homo_null_envmap_volpath.xml"},
        ZCase{"test_homo_dielectric_envmap", "participating_media", "test_homo_dielectric_envmap_volpath.xml"},
        ZCase{"test_hetero_sigmat", "participating_media", "test_hetero_sigmat_volpath.xml"},
        ZCase{"test_hetero_spectral_sigmat_no_scattering", "participating_media",
              "test_hetero_spectral_sigmat_no_scattering_volpath.xml"}),
    [](const auto& each) { return std::string(each.param.name); });

// The peer does not count light that goes straight through a thin dielectric as an edge, and draws lights through it: each
// of its pixels has far less noise than ours, whose spikes no z-test against its variance passes (138 and 167 of 6,912
// fail). The means agree: by 0.003 % and -0.06 % when last seen.
TEST_F(Reference, ThinPanesAroundMediaMeanWithinHalfAPercent) {
  for (const char* name : {"test_homo_area_light", "test_homo_obj_inside_medium"}) {
    const std::string base = "mitsuba-tests/tests/scenes/participating_media/";
    const Image<float> reference = image_io::read_image(folder() + "/" + base + "refs/" + name + "_ref_rgb.exr");
    const Image<float> image = render(base + name + "_volpath.xml", "-m path --straight-is-free --spp 868");
    EXPECT_NEAR(metrics::measure(image, reference).signed_difference, 0.0, 0.005) << name;
  }
}

TEST_F(Reference, CornellBoxMeanWithinHalfAPercent) {
  const Image<float> reference = shrink(image_io::read_image(folder() + "/cornell-box/TungstenRender.exr"), 4);
  const Image<float> image = render("cornell-box/scene.xml", "-m path --spp 64 --size 256x256");
  // 64 samples of 65,536 pixels: standard error of the mean about 0.1 %
  EXPECT_NEAR(metrics::measure(image, reference).signed_difference, 0.0, 0.005);
}

TEST_F(Reference, VeachMisMeanWithinHalfAPercent) {
  const Image<float> reference = shrink(image_io::read_image(folder() + "/veach-mis/TungstenRender.exr"), 4);
  const Image<float> image = render("veach-mis/scene.xml", "-m path --spp 512 --size 320x180 --max-depth 2");
  // standard error of the mean below 0.2 %
  EXPECT_NEAR(metrics::measure(image, reference).signed_difference, 0.0, 0.005);
}

/// Mean luminance of a window, given in pixels of an image `n` times as large.
double mean_of(const Image<float>& image, const Window& window, std::uint32_t n) {
  double sum = 0;
  for (std::uint32_t y = window.y0 / n; y < window.y1 / n; ++y) {
    for (std::uint32_t x = window.x0 / n; x < window.x1 / n; ++x) sum += static_cast<double>(luminance(image.at(x, y)));
  }
  return sum * n * n / static_cast<double>(window.pixel_count());
}

// The peer counts index-matched boundaries as vertices: its eight edges are six here, in and out of the smoke's box, and
// eight of ours are 8 % brighter. Both images have some 0.5 % of noise in the smoke.
TEST_F(Reference, SmokeMeansWithinTwoAndAHalfPercent) {
  const Image<float> reference = image_io::read_image(folder() + "/hetvol/hetvol.exr");
  const Image<float> image = render("hetvol/hetvol.xml", "-m path --spp 64 --size 384x288 --max-depth 6");
  const Window smoke{420, 50, 520, 170};
  const Window floor{0, 480, 600, 560};
  EXPECT_NEAR(mean_of(image, smoke, 2) / mean_of(reference, smoke, 1), 1.0, 0.025);
  EXPECT_NEAR(mean_of(image, floor, 2) / mean_of(reference, floor, 1), 1.0, 0.005);
}

// The same by blocks of 16 x 16. A path of six edges may cross the box up to six times and more where the floor is seen
// or lit through the smoke, which leaves the peer four edges or five: each block must lie between the means for five and
// six edges, 3 % on either side, or 1e-4 of radiance 1 in the near-black. Seen: 98 % inside, without the five edges 96 %.
TEST_F(Reference, SmokeBlocksWithinThreePercent) {
  Image<float> reference = image_io::read_image(folder() + "/hetvol/hetvol.exr");
  const Image<double> upper =
      metrics::block_means(render("hetvol/hetvol.xml", "-m path --spp 96 --size 384x288 --max-depth 6"), 8);
  const Image<double> lower =
      metrics::block_means(render("hetvol/hetvol.xml", "-m path --spp 96 --size 384x288 --max-depth 5 --seed 1"), 8);
  const Image<double> expected = metrics::block_means(reference, 16);
  ASSERT_EQ(expected.pixels.size(), upper.pixels.size());
  std::size_t compared = 0;
  std::size_t inside = 0;
  for (std::uint32_t y = 0; y < expected.height; ++y) {
    for (std::uint32_t x = 0; x < expected.width; ++x) {
      if (16 * x + 16 > 640 && 16 * y + 16 > 556) continue;  // the peer's banner
      const auto value = luminance(expected.at(x, y));
      ++compared;
      if (value >= 0.97 * luminance(lower.at(x, y)) - 1e-4 && value <= 1.03 * luminance(upper.at(x, y)) + 1e-4) ++inside;
    }
  }
  EXPECT_GE(static_cast<double>(inside), 0.95 * static_cast<double>(compared)) << "of " << compared << " blocks";
}

struct BlockCase {
  const char* name;
  const char* scene;
  const char* reference;
  const char* size;
};

class BlockTest : public Reference, public ::testing::WithParamInterface<BlockCase> {};

/// Path-traced by a peer, 12 edges, box filter, 4,096 samples: mean within 1 %, at most 1 % of the 8 x 8 blocks beyond 4
/// combined standard errors; ours from 16 independent runs, the peer's from its sample count relative to ours.
TEST_P(BlockTest, PathMatchesThePeerInMeanAndBlocks) {
  constexpr int k_runs = 16;
  constexpr double k_samples = 8;
  constexpr double k_limit = 5.5;  // Student t of 15 degrees of freedom at the level of 4 normal standard errors, 6e-5
  const Image<float> reference = image_io::read_image(folder() + "/" + GetParam().reference);
  const Image<double> expected = metrics::block_means(reference, 8);
  std::vector<Image<double>> runs;
  for (int run = 0; run < k_runs; ++run) {
    runs.push_back(metrics::block_means(
        render(GetParam().scene, std::string("-m path --sampler independent --max-depth 12 --filter box --spp 8 --size ") +
                                     GetParam().size + " --seed " + std::to_string(run)),
        8));
  }
  double ours = 0;
  double theirs = 0;
  std::size_t beyond = 0;
  for (std::size_t i = 0; i < expected.pixels.size(); ++i) {
    double mean = 0;
    for (const auto& run : runs) mean += luminance(run.pixels[i]) / k_runs;
    double variance = 0;  // of one run
    for (const auto& run : runs) variance += sqr(luminance(run.pixels[i]) - mean) / (k_runs - 1);
    const double reference_mean = luminance(expected.pixels[i]);
    ours += mean;
    theirs += reference_mean;
    const double error = std::sqrt(variance * (1.0 / k_runs + k_samples / 4096.0));
    if (std::abs(mean - reference_mean) > k_limit * error) ++beyond;
  }
  EXPECT_NEAR(ours / theirs, 1.0, 0.01);
  EXPECT_LE(beyond, expected.pixels.size() / 100) << "of " << expected.pixels.size() << " blocks";
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, BlockTest,
    ::testing::Values(BlockCase{"ModernHall", "modern-hall/scene.xml", "modern-hall/reference-path-256x256.exr", "256x256"},
                      BlockCase{"LivingRoom", "living-room/scene.xml", "living-room/reference-path-320x180.exr", "320x180"},
                      BlockCase{"Sponza", "sponza/sponza.xml", "sponza/reference-path-256x192.exr", "256x192"}),
    [](const auto& each) { return std::string(each.param.name); });

TEST_F(Reference, EverySceneRendersWithEveryMethod) {
  for (const char* scene : {"cornell-box/scene.xml", "veach-mis/scene.xml", "modern-hall/scene.xml",
                            "living-room/scene.xml", "sponza/sponza.xml",
                            "matpreview-roughplastic/docs/scenes/bsdf_roughplastic_ggx.xml", "hetvol/hetvol.xml",
                            "vol-cbox/vol_cbox.xml", "sss-bunny/docs/scenes/medium_homogeneous_sss.xml"}) {
    for (const char* method : {"path", "vpl", "bdlc"}) {
      const Image<float> image = render(scene, std::string("--size 32x20 --spp 4 --eye-paths 4 --vpls 2000 -m ") + method);
      double sum = 0;
      for (const Rgb<float>& pixel : image.pixels) {
        EXPECT_TRUE(is_valid_radiance(pixel)) << scene << ' ' << method;
        sum += static_cast<double>(luminance(pixel));
      }
      EXPECT_GT(sum, 0.0) << scene << ' ' << method;
    }
  }
}

}  // namespace
}  // namespace manylight::reference_slow_test
