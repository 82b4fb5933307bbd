// SPDX-License-Identifier: Apache-2.0
#include "metrics/metrics.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include "metrics/compensated_sum.hpp"
#include "metrics/z_test.hpp"

namespace manylight::metrics::metrics_test {
namespace {

// Values of the images are exact in float; what is left is the rounding of a few operations in double.
constexpr double k_rounding = 1e-14;
constexpr double k_infinity = std::numeric_limits<double>::infinity();

Image<float> grey(std::size_t width, std::size_t height, float value) {
  return Image<float>(width, height, Rgb<float>(value));
}

template <class Exception, class Function>
std::string message_of(const Function& function) {
  try {
    function();
  } catch (const Exception& error) {
    return error.what();
  }
  return "nothing thrown";
}

// Oracle: 1 + 1e100 + 1 - 1e100 = 2, where a plain sum gives 0.
TEST(CompensatedSum, KeepsWhatAPlainSumLoses) {
  CompensatedSum sum;
  for (const double term : {1.0, 1e100, 1.0, -1e100}) sum.add(term);
  EXPECT_EQ(sum.value(), 2.0);
}

TEST(CompensatedSum, InfiniteTermsStayInfinite) {
  CompensatedSum sum;
  sum.add(k_infinity);
  sum.add(1.0);
  EXPECT_EQ(sum.value(), k_infinity);
}

// Oracle: all worked by hand. r = (2, 4, 6), (0, 0, 0): mean 2; x = (4, 4, 2), (1, 0, 0): mean 11 / 6.
// Planted bugs seen to fail here: the mean of x in place of r, 0.05^2 without the mean, MAPE divided by x.
TEST(Metrics, TwoPixelsByHand) {
  const Image<float> reference(2, 1, {Rgb<float>(2, 4, 6), Rgb<float>(0, 0, 0)});
  const Image<float> image(2, 1, {Rgb<float>(4, 4, 2), Rgb<float>(1, 0, 0)});
  const Metrics m = measure(image, reference);
  const double dark = 0.1 * 0.1;
  EXPECT_NEAR(m.mean, 11.0 / 6, k_rounding);
  EXPECT_NEAR(m.reference_mean, 2.0, k_rounding);
  EXPECT_NEAR(m.rmse, std::sqrt((4 + 16 + 1) / 6.0), k_rounding);
  const double relative = (4 / (4 + dark) + 16 / (36 + dark) + 1 / dark) / 6;
  EXPECT_NEAR(m.rel_mse, relative, 1e-12);          // relative rounding times a value of 17
  EXPECT_NEAR(m.trimmed_rel_mse, relative, 1e-12);  // fewer than 1000 pixels: none is dropped
  EXPECT_NEAR(m.mape, (2 / 2.01 + 4 / 6.01 + 1 / 0.01) / 6, 1e-12);  // rounding times 17
  EXPECT_NEAR(m.signed_difference, -1.0 / 12, k_rounding);
}

// Oracle: 2000 pixels, so the 2 worst go. Three are wrong, by 1, 2 and 4 on a reference of 1; the smallest stays.
// Planted bugs seen to fail here: the best pixels dropped, division by all pixels, one pixel too many dropped.
TEST(Metrics, TrimmingDropsTheWorstThousandth) {
  const Image<float> reference = grey(100, 20, 1.0F);
  Image<float> image = reference;
  image.at(3, 0) = Rgb<float>(2.0F);
  image.at(50, 10) = Rgb<float>(5.0F);
  image.at(99, 19) = Rgb<float>(3.0F);
  const Metrics m = measure(image, reference);
  EXPECT_NEAR(m.rel_mse, (1.0 + 4.0 + 16.0) / 1.0025 / 2000, k_rounding);
  EXPECT_NEAR(m.trimmed_rel_mse, 1.0 / 1.0025 / 1998, k_rounding);
}

TEST(Metrics, EqualImagesHaveNoError) {
  const Image<float> image(2, 2, {Rgb<float>(0.1F), Rgb<float>(7.0F), Rgb<float>(0.0F), Rgb<float>(1e30F)});
  const Metrics m = measure(image, image);
  for (const double error : {m.rmse, m.rel_mse, m.trimmed_rel_mse, m.mape, m.signed_difference}) EXPECT_EQ(error, 0.0);
}

TEST(Metrics, BlackReference) {
  const Image<float> black = grey(2, 2, 0.0F);
  const Metrics same = measure(black, black);
  EXPECT_EQ(same.rel_mse, 0.0);
  EXPECT_EQ(same.signed_difference, 0.0);
  const Metrics other = measure(grey(2, 2, 1.0F), black);
  EXPECT_EQ(other.rel_mse, k_infinity);
  EXPECT_EQ(other.trimmed_rel_mse, k_infinity);
  EXPECT_EQ(other.signed_difference, k_infinity);
  EXPECT_NEAR(other.mape, 100.0, 1e-12);  // 1 / 0.01
}

TEST(Metrics, UnusableImagesAreErrors) {
  const Image<float> one = grey(2, 1, 1.0F);
  Image<float> broken = grey(3, 2, 1.0F);
  broken.at(2, 1).y = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(message_of<MetricError>([&] { (void)measure(one, grey(1, 2, 1.0F)); }),
            "the image has 2 x 1 pixels, the reference 1 x 2");
  EXPECT_EQ(message_of<MetricError>([&] { (void)measure(Image<float>(), one); }), "the image has no pixels");
  EXPECT_EQ(message_of<MetricError>([&] { (void)measure(one, Image<float>()); }), "the reference has no pixels");
  EXPECT_EQ(message_of<MetricError>([&] { (void)measure(broken, grey(3, 2, 1.0F)); }),
            "the image has a value that is not finite at pixel (2, 1)");
}

// Oracle: 3 x 3 pixels of values 0 to 8 in blocks of 2: the last column and row are narrower.
TEST(BlockMeans, IncompleteBlocksAverageWhatTheyHave) {
  Image<float> image(3, 3);
  for (std::size_t i = 0; i < 9; ++i) image.pixels[i] = Rgb<float>(static_cast<float>(i));
  const Image<double> means = block_means(image, 2);
  ASSERT_EQ(means.width, 2U);
  ASSERT_EQ(means.height, 2U);
  EXPECT_EQ(means.at(0, 0).x, 2.0);  // 0 1 3 4
  EXPECT_EQ(means.at(1, 0).y, 3.5);  // 2 5
  EXPECT_EQ(means.at(0, 1).z, 6.5);  // 6 7
  EXPECT_EQ(means.at(1, 1).x, 8.0);
  const Image<double> whole = block_means(image, std::numeric_limits<std::uint32_t>::max());
  ASSERT_EQ(whole.pixels.size(), 1U);
  EXPECT_EQ(whole.pixels[0].x, 4.0);
  EXPECT_THROW((void)block_means(image, 0), ParameterError);
  EXPECT_THROW((void)block_means(Image<float>(), 2), MetricError);
}

// Oracle: grey 1, +50 % and -25 %: divided by sqrt(1 + 0.05^2) and the range 0.5.
TEST(SignedDifferenceImage, RedAboveBlueBelow) {
  const Image<float> reference = grey(3, 1, 1.0F);
  Image<float> image = reference;
  image.at(0, 0) = Rgb<float>(1.5F);
  image.at(1, 0) = Rgb<float>(0.75F);
  const Image<float> shown = signed_difference_image(image, reference, 0.5);
  const double scale = 1.0 / std::sqrt(1.0025) / 0.5;
  EXPECT_NEAR(static_cast<double>(shown.at(0, 0).x), 0.5 * scale, 1e-6);  // rounded to float
  EXPECT_NEAR(static_cast<double>(shown.at(1, 0).z), 0.25 * scale, 1e-6);
  EXPECT_EQ(shown.at(0, 0).z, 0.0F);
  EXPECT_EQ(shown.at(1, 0).x, 0.0F);
  EXPECT_TRUE(is_black(shown.at(2, 0)));
  EXPECT_THROW((void)signed_difference_image(image, reference, 0.0), ParameterError);
}

// Oracle: Y of grey is its value, as the Y row of the matrix sums to 1. A variance of grey 0.04 and 4 samples give a
// standard error of 0.1 in Y, so that 0.3 more is z = 3.
TEST(ZTest, ScoreInStandardErrorsByHand) {
  // X and Z rows sum to 0.950456 and 1.088754: z = 3 sqrt(row sum), largest in Z.
  const ZTestResult z = z_test(grey(1, 1, 1.3F), grey(1, 1, 1.0F), grey(1, 1, 0.04F), 4);
  EXPECT_EQ(z.tests, 3U);
  EXPECT_EQ(z.worst_channel, 2);
  EXPECT_NEAR(z.worst_z, 3 * std::sqrt(1.088754), 1e-5);  // 1.3 and 0.04 are rounded to float
  EXPECT_NEAR(z.level, 0.01, k_rounding);                 // one pixel: no correction
  // p(3.13) = 0.0017, p(3) = 0.0027, p(2.92) = 0.0035: all below 0.01.
  EXPECT_EQ(z.failures, 3U);
  EXPECT_FALSE(z.passes);
}

// Oracle: |z| = 2.5758 is the 1 % limit of the normal distribution; for 2304 pixels Sidak's level is 1 - 0.99^(1/2304)
// = 4.362e-6, limit 4.593. Only Y is judged: the shift is (0, d, 0) in XYZ, turned to RGB.
// Planted bugs seen to fail here: one-sided p-value, Bonferroni over pixel-channels.
TEST(ZTest, LimitIsSidaks) {
  const Rgb<float> y_only(-1.537150F, 1.875992F, -0.204043F);  // second column of XYZ to RGB
  const auto failures = [&](std::size_t side, double z) {
    const Image<float> reference = grey(side, side, 0.0F);
    Image<float> image = reference;
    image.at(0, 0) = y_only * static_cast<float>(z);
    return z_test(image, reference, grey(side, side, 1.0F), 1).failures;
  };
  EXPECT_EQ(failures(1, 2.570), 0U);
  EXPECT_EQ(failures(1, 2.581), 1U);
  EXPECT_EQ(failures(48, 4.585), 0U);
  EXPECT_EQ(failures(48, 4.600), 1U);
}

// Oracle: a variance of (0, 1, 0) in XYZ is negative in red and blue as RGB. Read as RGB, red would be floored to 1e-4
// and fail; converted first, Y has the variance 1 and X and Z the floor. Planted bug seen to fail here: variance
// clamped before the conversion.
TEST(ZTest, VarianceIsConvertedBeforeItIsFloored) {
  const Rgb<float> y_only(-1.537150F, 1.875992F, -0.204043F);
  const Image<float> zero = grey(1, 1, 0.0F);
  const Image<float> variance(1, 1, y_only);
  const ZTestResult y = z_test(Image<float>(1, 1, y_only), zero, variance, 4);
  // |1 - 0| sqrt(4 / 1); the inverse matrix has 6 decimals, which the floor in X and Z magnifies.
  EXPECT_NEAR(y.worst_z, 2.0, 1e-3);
  EXPECT_TRUE(y.passes);
}

// Oracle: variance 0 is floored to 1e-4, so a difference of 0.02 in Y of one sample is z = 2.
TEST(ZTest, ZeroVarianceIsFloored) {
  const ZTestResult z = z_test(grey(1, 1, 0.02F), grey(1, 1, 0.0F), grey(1, 1, 0.0F), 1);
  EXPECT_NEAR(z.worst_z, 2 * 1.088754, 1e-5);  // Z, as above, 0.02 rounded to float
}

// Oracle: of 20 x 20 x 3 tests 0.25 % are 3 failures. A pixel with all of X, Y, Z far off makes 3, two make 6.
TEST(ZTest, QuotaOfFailures) {
  const Image<float> reference = grey(20, 20, 1.0F);
  Image<float> image = reference;
  image.at(7, 3) = Rgb<float>(100.0F);
  const ZTestResult one = z_test(image, reference, reference, 16);
  EXPECT_EQ(one.allowed, 3U);
  EXPECT_EQ(one.failures, 3U);
  EXPECT_TRUE(one.passes);
  EXPECT_EQ(one.worst_x, 7U);
  EXPECT_EQ(one.worst_y, 3U);
  image.at(8, 3) = Rgb<float>(90.0F);
  const ZTestResult two = z_test(image, reference, reference, 16);
  EXPECT_EQ(two.failures, 6U);
  EXPECT_FALSE(two.passes);
}

TEST(ZTest, UnusableInputIsAnError) {
  const Image<float> one = grey(1, 1, 1.0F);
  EXPECT_THROW((void)z_test(one, one, grey(2, 1, 1.0F), 1), MetricError);
  EXPECT_THROW((void)z_test(one, one, Image<float>(), 1), MetricError);
  EXPECT_THROW((void)z_test(one, one, one, 0), ParameterError);
  EXPECT_THROW((void)z_test(one, one, one, k_infinity), ParameterError);
  EXPECT_THROW((void)z_test(one, one, one, 1, {.family_level = 1.0}), ParameterError);
}

}  // namespace
}  // namespace manylight::metrics::metrics_test
