// SPDX-License-Identifier: Apache-2.0
#include "metrics/t_test.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "programs/noisy_images.hpp"

namespace manylight::metrics::t_test_test {
namespace {

using test::noisy_images;
using test::smooth_image;

constexpr double k_infinity = std::numeric_limits<double>::infinity();

Image<float> grey(float value) { return Image<float>(1, 1, Rgb<float>(value)); }

// Oracle: closed forms for 1, 2 and 4 degrees of freedom, far into the tails.
TEST(Student, ClosedForms) {
  for (const double t : {0.0, 0.01, 0.5, 1.0, 3.0, 20.0, 1000.0}) {
    const double one = 2 / std::acos(-1.0) * std::atan2(1.0, t);
    // 1 - t / sqrt(2 + t^2) without cancellation.
    const double root = std::sqrt(2 + t * t);
    const double two = 2 / (root * (root + t));
    EXPECT_NEAR(student_two_sided(t, 1), one, 1e-12 * one) << t;
    EXPECT_NEAR(student_two_sided(t, 2), two, 1e-12 * two) << t;
    EXPECT_EQ(student_two_sided(-t, 2), student_two_sided(t, 2));
  }
  const double s = 3 / std::sqrt(4 + 9.0);
  EXPECT_NEAR(student_two_sided(3, 4), 1 - s * (1.5 - 0.5 * s * s), 1e-14);
  EXPECT_NEAR(student_two_sided(1.959963985, k_infinity), 0.05, 1e-9);
  EXPECT_NEAR(student_two_sided(1.959963985, 1e6), 0.05, 1e-6);  // nearly normal
  EXPECT_EQ(student_two_sided(k_infinity, 3), 0.0);
  EXPECT_THROW((void)student_two_sided(1, 0), ParameterError);
}

// Oracle: limits for Sidak's level of n tests, from tables: 3 decimals each.
TEST(Student, LimitsOfManyTests) {
  struct Row {
    double n, family, freedom, limit;
  };
  for (const Row& row : {Row{4096, 0.01, k_infinity, 4.712}, Row{4096, 0.01, 15, 7.338}, Row{4096, 0.01, 63, 5.183},
                         Row{65536, 0.01, 15, 9.174}, Row{65536, 0.01, 63, 5.906}, Row{262144, 0.05, 15, 9.002}}) {
    const double level = -std::expm1(std::log1p(-row.family) / row.n);
    EXPECT_GT(student_two_sided(row.limit - 0.002, row.freedom), level);
    EXPECT_LT(student_two_sided(row.limit + 0.002, row.freedom), level);
  }
}

// Oracle: by hand. Runs 1, 3 against 0: mean 2, standard error 1, t = 2 with 1 degree of freedom: p = 0.2952. With
// batches -1, 1 the variance is 2, t = sqrt(2), by Welch 2 degrees of freedom: p = 1 - sqrt(2) / 2.
// Planted bugs seen to fail here: K degrees of freedom, K^2 in place of K (K - 1), the reference's noise left out.
TEST(TTest, ScoresByHand) {
  const TTestResult exact = t_test({grey(1), grey(3)}, {.batches = {grey(0)}, .variance = {}});
  EXPECT_EQ(exact.tests, 3U);
  EXPECT_NEAR(exact.worst_t, 2.0, 1e-14);
  EXPECT_NEAR(exact.worst_p, 2 / std::acos(-1.0) * std::atan2(1.0, 2.0), 1e-13);
  EXPECT_TRUE(exact.passes);
  const TTestResult batches = t_test({grey(1), grey(3)}, {.batches = {grey(-1), grey(1)}, .variance = {}});
  EXPECT_NEAR(batches.worst_t, std::sqrt(2.0), 1e-14);
  EXPECT_NEAR(batches.worst_p, 1 - std::sqrt(0.5), 1e-13);
  // Known variance 1: the same t, (1 + 1)^2 / 1 = 4 degrees of freedom; s = t / sqrt(4 + t^2), as above.
  const TTestResult known = t_test({grey(1), grey(3)}, {.batches = {grey(0)}, .variance = grey(1)});
  const double s = std::sqrt(2.0 / 6);
  EXPECT_NEAR(known.worst_p, 1 - s * (1.5 - 0.5 * s * s), 1e-13);
  const TTestResult normal =
      t_test({grey(1), grey(3)}, {.batches = {grey(0)}, .variance = {}}, {.kind = PixelTest::normal});
  EXPECT_NEAR(normal.worst_p, std::erfc(std::sqrt(2.0)), 1e-13);
}

// Oracle: a family level of 0.1 and 400 families of 8 x 6 x 3 tests: 40 alarms, standard deviation 6; 4.5 of them are
// a false-alarm rate of 7e-6. Planted bugs seen to fail here: no correction for many tests, K degrees of freedom.
// Normal noise, 5 runs: the z test would fail nearly always, which is seen too.
TEST(TTest, KeepsItsLevel) {
  const Image<float> truth = smooth_image(8, 6);
  int alarms = 0, normal_alarms = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    const auto runs = noisy_images(truth, 0, {.own = 0.3}, seed, 5);
    alarms += t_test(runs, {.batches = {truth}, .variance = {}}, {.family_level = 0.1}).passes ? 0 : 1;
    normal_alarms +=
        t_test(runs, {.batches = {truth}, .variance = {}}, {.kind = PixelTest::normal, .family_level = 0.1}).passes ? 0
                                                                                                                    : 1;
  }
  EXPECT_NEAR(alarms, 40, 27);
  EXPECT_GT(normal_alarms, 200);
}

// Oracle: planted, 1 % of a picture with 5 % noise. A pixel with 16 runs has a standard error of 1.25 %: hidden. A
// block of 16 x 16 has 0.08 %: 12 standard errors. A tolerance of 1 % takes it for granted, one of 0.5 % does not.
TEST(TTest, OnePercentShowsInBlocks) {
  const Image<float> truth = smooth_image(32, 32);
  const auto runs = noisy_images(truth, 0.01, {.own = 0.05}, 21, 16);
  const NoisyReference reference{.batches = {truth}, .variance = {}};
  EXPECT_TRUE(t_test(runs, reference).passes);
  const TTestResult blocks = t_test(runs, reference, {.block = 16});
  EXPECT_FALSE(blocks.passes);
  EXPECT_EQ(blocks.tests, 12U);
  EXPECT_GT(blocks.failures, 9U);
  EXPECT_GT(blocks.worst_t, 0);
  EXPECT_TRUE(t_test(runs, reference, {.block = 16, .tolerance = 0.01}).passes);
  EXPECT_FALSE(t_test(runs, reference, {.block = 16, .tolerance = 0.005}).passes);
}

// Oracle: without noise only roundings pass; the worst place is the planted one.
TEST(TTest, WithoutNoise) {
  const Image<float> truth = smooth_image(6, 4);
  Image<float> image = truth;
  for (Rgb<float>& p : image.pixels) p *= 1.0F + 2e-7F;
  EXPECT_TRUE(t_test({image, image}, {.batches = {truth}, .variance = {}}).passes);
  image.at(5, 2).y *= 0.999F;
  const TTestResult result = t_test({image, image}, {.batches = {truth}, .variance = {}});
  EXPECT_FALSE(result.passes);
  EXPECT_EQ(result.failures, 1U);
  EXPECT_EQ(result.worst_t, -k_infinity);
  EXPECT_EQ(result.worst_x, 5U);
  EXPECT_EQ(result.worst_y, 2U);
  EXPECT_EQ(result.worst_channel, 1);
}

TEST(TTest, UnusableInputIsAnError) {
  const NoisyReference one{.batches = {grey(1)}, .variance = {}};
  EXPECT_THROW((void)t_test({grey(1)}, one), MetricError);
  EXPECT_THROW((void)t_test({grey(1), grey(1)}, {}), MetricError);
  EXPECT_THROW((void)t_test({grey(1), grey(1)}, one, {.family_level = 0}), ParameterError);
  EXPECT_THROW((void)t_test({grey(1), grey(1)}, one, {.block = 0}), ParameterError);
  EXPECT_THROW((void)t_test({grey(1), grey(1)}, one, {.tolerance = -1}), ParameterError);
}

}  // namespace
}  // namespace manylight::metrics::t_test_test
