// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <gtest/gtest.h>

#include "image_io/image_io.hpp"
#include "metrics/metrics.hpp"
#include "programs/program_run.hpp"

namespace manylight::test {

/// A test on scenes and images that others made; skipped, or failed for that, without them.
class Reference : public ScratchTest {
 protected:
  void SetUp() override {
    if (folder().empty()) GTEST_SKIP() << "MANYLIGHT_REFERENCE_SCENES is not set: no reference images to compare with";
    ScratchTest::SetUp();
  }
  [[nodiscard]] static std::string folder() { return MANYLIGHT_REFERENCE_SCENES; }
  [[nodiscard]] Image<float> render(const std::string& scene, const std::string& arguments) const {
    const std::string out = path("image.pfm").string();
    const ProgramRun run = run_program(std::string(MANYLIGHT_RENDER_PROGRAM) + " " + folder() + "/" + scene +
                                       " -q -o " + out + " " + arguments);
    EXPECT_EQ(run.exit_code, 0) << run.output;
    return image_io::read_image(out);
  }
};

/// Means of n x n pixels, which turn a large reference into the size of a quick rendering.
[[nodiscard]] inline Image<float> shrink(const Image<float>& image, std::uint32_t n) {
  const Image<double> blocks = metrics::block_means(image, n);
  Image<float> result(blocks.width, blocks.height);
  for (std::size_t i = 0; i < blocks.pixels.size(); ++i) result.pixels[i] = Rgb<float>(blocks.pixels[i]);
  return result;
}

}  // namespace manylight::test
