// SPDX-License-Identifier: Apache-2.0
// Bidirectional path tracing on scenes that others made: against path tracing here, and against their images.
#include <algorithm>
#include <vector>

#include <gmock/gmock.h>

#include "manylight/integrator/film.hpp"
#include "metrics/t_test.hpp"
#include "programs/reference.hpp"

namespace manylight::reference_bdpt_slow_test {
namespace {

using test::Reference;
using test::shrink;

constexpr std::uint32_t k_block = 16;         // pixels
constexpr std::uint32_t k_everything = 4096;  // pixels: the whole image is one block

struct Case {
  const char* name;
  const char* folder;
  const char* reference;
  std::uint32_t shrunk;  ///< pixels of the reference along the side of one of ours
  const char* arguments;
  std::uint32_t runs;  ///< of each method
  double brightest;    ///< pixels above that many means of the reference are left out
  double path_blocks;  ///< differences allowed beyond the noise, relative: of blocks of path,
  double peer_blocks;  ///< of the reference,
  double peer_image;   ///< of the reference's mean,
  double median;       ///< and, noise included, of the median over blocks
};

class BidirectionalReference : public Reference, public ::testing::WithParamInterface<Case> {};

/// Black where the reference is above `most` of its means, whatever the image has there.
void leave_out(Image<float>& image, const Image<float>& reference, double most) {
  const double limit = most * luminance(metrics::block_means(reference, k_everything).pixels[0]);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    if (static_cast<double>(luminance(reference.pixels[i])) > limit) image.pixels[i] = Rgb<float>(0);
  }
}

Image<double> mean_blocks(const std::vector<Image<float>>& images) {
  Image<double> sum = metrics::block_means(images[0], k_block);
  for (std::size_t i = 1; i < images.size(); ++i) {
    const Image<double> blocks = metrics::block_means(images[i], k_block);
    for (std::size_t j = 0; j < sum.pixels.size(); ++j) sum.pixels[j] += blocks.pixels[j];
  }
  for (Rgb<double>& pixel : sum.pixels) pixel = pixel / static_cast<double>(images.size());
  return sum;
}

/// Median over blocks of a / b - 1, of luminances: no firefly moves it.
double median_difference(const std::vector<Image<float>>& a, const std::vector<Image<float>>& b) {
  const Image<double> left = mean_blocks(a);
  const Image<double> right = mean_blocks(b);
  std::vector<double> differences;
  for (std::size_t i = 0; i < left.pixels.size(); ++i) {
    const double truth = luminance(right.pixels[i]);
    if (truth > 0) differences.push_back(luminance(left.pixels[i]) / truth - 1);
  }
  std::sort(differences.begin(), differences.end());
  return differences[differences.size() / 2];
}

/// Student's t per channel: of blocks, and of the whole image as one of them; false alarms 1e-3 each, seeds fixed.
void expect_equal(const std::vector<Image<float>>& runs, const std::vector<Image<float>>& truth, double blocks,
                  double image, const char* of) {
  for (const std::uint32_t block : {k_block, k_everything}) {
    metrics::TTestConfig config;
    config.family_level = 1e-3;
    config.block = block;
    config.tolerance = block == k_block ? blocks : image;
    const auto result = metrics::t_test(runs, {truth, {}}, config);
    EXPECT_TRUE(result.passes) << "against " << of << ", blocks of " << block << ": p = " << result.worst_p
                               << ", t = " << result.worst_t << " at (" << result.worst_x << ", " << result.worst_y
                               << ")";
  }
}

// Single blocks have little power, as there are 6 to 12 runs and up to 192 tests; whole images and the median over
// blocks, a median of means which no firefly moves, see 1 % in the first three scenes and some 3 % in the living room.
// Planted bugs seen to fail: images of bdpt 1 % brighter, paths of 7 edges and more left out (in veach-mis, of 2); in
// the living room, where these are 0.3 % of the light, images 4 % brighter.
TEST_P(BidirectionalReference, AgreesWithPathTracingAndThePeer) {
  const Case& each = GetParam();
  const Image<float> full = image_io::read_image(folder() + "/" + each.folder + "/" + each.reference);
  Image<float> reference = shrink(full, each.shrunk);
  const auto runs = [&](const char* method, std::uint32_t first_seed) {
    std::vector<Image<float>> images;
    for (std::uint32_t i = 0; i < each.runs; ++i) {
      images.push_back(render(std::string(each.folder) + "/scene.xml",
                              std::string(each.arguments) + " --filter box -m " + method + " --size " +
                                  std::to_string(reference.width) + "x" + std::to_string(reference.height) +
                                  " --seed " + std::to_string(first_seed + i)));
      leave_out(images.back(), reference, each.brightest);
    }
    return images;
  };
  const std::vector<Image<float>> path_runs = runs("path", 100);
  const std::vector<Image<float>> bdpt_runs = runs("bdpt", 200);
  leave_out(reference, Image<float>(reference), each.brightest);
  expect_equal(bdpt_runs, path_runs, each.path_blocks, 0.0, "path");
  expect_equal(bdpt_runs, {reference}, each.peer_blocks, each.peer_image, "the peer");
  EXPECT_NEAR(median_difference(bdpt_runs, path_runs), 0.0, each.median);
  EXPECT_NEAR(median_difference(bdpt_runs, {reference}), 0.0, each.median);
}

// The peers' noise: unknown in the first two, where blocks are allowed half a percent; in the others 4,096 samples of
// four pixels against some 30 of one of ours. The hall is 0.1 to 0.3 % darker here than there, by both methods (path by
// 6 standard errors): that much is known to be missed. The picture of veach-mis holds two edges, and pixels that show a
// lamp, whose edges alone are 3 % of noise in the mean, are left out. In the living room single paths, through glass,
// bring fireflies. Nothing is clamped, and a t-test of so skewed means calls too dark what has met none (path in a
// block, t = -8 of seven degrees), so that its blocks are allowed a quarter: there the whole image and the median tell.
INSTANTIATE_TEST_SUITE_P(Scenes, BidirectionalReference,
                         ::testing::Values(Case{"CornellBox", "cornell-box", "TungstenRender.exr", 8, "--spp 8", 10,
                                                1e9, 0, 0.005, 0.002, 0.005},
                                           Case{"VeachMis", "veach-mis", "TungstenRender.exr", 8,
                                                "--spp 8 --max-depth 2", 12, 20, 0, 0.005, 0.002, 0.005},
                                           Case{"ModernHall", "modern-hall", "reference-path-256x256.exr", 2,
                                                "--spp 4 --max-depth 12", 8, 1e9, 0, 0, 0.004, 0.01},
                                           Case{"LivingRoom", "living-room", "reference-path-320x180.exr", 2,
                                                "--spp 4 --max-depth 12", 6, 1e9, 0.25, 0.25, 0.005, 0.025}),
                         [](const auto& each) { return std::string(each.param.name); });

}  // namespace
}  // namespace manylight::reference_bdpt_slow_test
