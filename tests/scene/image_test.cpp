// SPDX-License-Identifier: Apache-2.0
#include "manylight/scene/image.hpp"

#include <gtest/gtest.h>

namespace manylight::image_test {
namespace {

TEST(Image, IsRowMajorFromTheTop) {
  Image<float> image(3u, 2u, Rgb<float>(1));
  EXPECT_EQ(image.pixels.size(), 6u);
  image.at(2, 1) = Rgb<float>(5);
  EXPECT_EQ(image.pixels[5].x, 5.0F);
  EXPECT_EQ(image.at(0, 1).x, 1.0F);
  EXPECT_FALSE(image.empty());
  EXPECT_TRUE(Image<float>().empty());
}

TEST(Image, RejectsImpossibleSizes) {
  EXPECT_THROW(Image<float>(0u, 4u), ParameterError);
  EXPECT_THROW(Image<float>(4u, 0u), ParameterError);
  EXPECT_THROW(Image<float>(std::size_t{1} << 40, 4u), ParameterError);
  EXPECT_THROW(Image<float>(2u, 2u, std::vector<Rgb<float>>(3)), ParameterError);
  EXPECT_NO_THROW(Image<float>(2u, 2u, std::vector<Rgb<float>>(4)));
}

}  // namespace
}  // namespace manylight::image_test
