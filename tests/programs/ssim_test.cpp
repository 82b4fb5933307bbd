// SPDX-License-Identifier: Apache-2.0
#include "metrics/ssim.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "programs/noisy_images.hpp"

namespace manylight::metrics::ssim_test {
namespace {

using test::noisy_image;
using test::smooth_image;

/// SSIM as [Wang 2004] writes it: the 121 weights of each window, deviations from the window's mean.
double direct_ssim(const std::vector<double>& x, const std::vector<double>& y, int width, int height) {
  double weights[11][11], total = 0, sum = 0;
  for (int j = 0; j < 11; ++j) {
    for (int i = 0; i < 11; ++i) {
      total += weights[j][i] = std::exp(-((i - 5) * (i - 5) + (j - 5) * (j - 5)) / (2 * 1.5 * 1.5));
    }
  }
  int count = 0;
  for (int top = 0; top + 11 <= height; ++top) {
    for (int left = 0; left + 11 <= width; ++left) {
      const auto mean = [&](const auto& value) {
        double m = 0;
        for (int j = 0; j < 11; ++j) {
          for (int i = 0; i < 11; ++i) {
            m += weights[j][i] / total * value(static_cast<std::size_t>((top + j) * width + left + i));
          }
        }
        return m;
      };
      const double mx = mean([&](std::size_t k) { return x[k]; });
      const double my = mean([&](std::size_t k) { return y[k]; });
      const double vx = mean([&](std::size_t k) { return (x[k] - mx) * (x[k] - mx); });
      const double vy = mean([&](std::size_t k) { return (y[k] - my) * (y[k] - my); });
      const double vxy = mean([&](std::size_t k) { return (x[k] - mx) * (y[k] - my); });
      sum += (2 * mx * my + 1e-4) * (2 * vxy + 9e-4) / ((mx * mx + my * my + 1e-4) * (vx + vy + 9e-4));
      ++count;
    }
  }
  return sum / count;
}

// Oracle: the definition, window by window. Planted bugs seen to fail here: sigma 1.6, C2 = C1.
TEST(Ssim, EqualsTheDefinition) {
  std::vector<double> x, y;
  for (int i = 0; i < 17 * 13; ++i) {
    x.push_back(0.5 + 0.4 * std::sin(0.7 * i));
    y.push_back(0.5 + 0.3 * std::sin(0.7 * i + 0.4) + 0.1 * std::cos(2.1 * i));
  }
  EXPECT_NEAR(ssim(x, y, 17, 13), direct_ssim(x, y, 17, 13), 1e-13);  // rounding, variances by difference
}

// Oracle: closed forms. Equal images 1; constants a, b: (2ab + C1) / (a^2 + b^2 + C1).
TEST(Ssim, KnownCases) {
  const std::vector<double> a(12 * 11, 0.5), b(12 * 11, 0.25);
  EXPECT_NEAR(ssim(a, a, 12, 11), 1.0, 1e-13);
  EXPECT_NEAR(ssim(a, b, 12, 11), (0.25 + 1e-4) / (0.25 + 0.0625 + 1e-4), 1e-12);
  const Image<float> image = smooth_image(16, 16);
  EXPECT_NEAR(ssim(image, image), 1.0, 1e-13);
  const Image<float> black(16, 16);
  EXPECT_NEAR(ssim(black, black), 1.0, 1e-13);
}

// Oracle: opposite stripes, whose windows have opposite deviations: near (-v + C2) / (v + C2), negative.
TEST(Ssim, OppositeStructureIsNegative) {
  std::vector<double> x, y;
  for (int i = 0; i < 16 * 16; ++i) {
    x.push_back(i % 2 == 0 ? 0.7 : 0.3);
    y.push_back(i % 2 == 0 ? 0.3 : 0.7);
  }
  const double v = 2 * 0.2 * 0.2;
  EXPECT_NEAR(ssim(x, y, 16, 16), (-v + 9e-4) / (v + 9e-4), 1e-3);  // stripes of one pixel average out to 1e-4
}

// Oracle: by hand. Mean luminance to 0.18: v = 0.18 / 1.18 = 0.152542, sRGB 1.055 v^(1/2.4) - 0.055 = 0.427554.
TEST(Ssim, ToneCurve) {
  EXPECT_NEAR(exposure_for(Image<float>(4, 4, Rgb<float>(2.0F))), 0.09, 1e-7);  // float luminance weights
  EXPECT_NEAR(tone_mapped(2.0, 0.09), 1.055 * std::pow(0.18 / 1.18, 1 / 2.4) - 0.055, 1e-14);
  EXPECT_NEAR(tone_mapped(0.001, 1.0), 12.92 * 0.001 / 1.001, 1e-14);  // the linear part
  EXPECT_EQ(tone_mapped(-1.0, 1.0), 0.0);
  EXPECT_LT(tone_mapped(1e30, 1.0), 1.0 + 1e-12);
  EXPECT_EQ(exposure_for(Image<float>(4, 4)), 0.0);
}

TEST(Ssim, FallsWithNoiseAndIgnoresExposure) {
  const Image<float> truth = smooth_image(32, 32);
  double last = 1.0;
  for (const double noise : {0.02, 0.1, 0.5}) {
    const Image<float> image = noisy_image(truth, 0, {.own = noise}, 3, 0);
    const double value = ssim(image, truth);
    EXPECT_LT(value, last);
    last = value;
    Image<float> brighter_image = image, brighter_truth = truth;
    for (auto* both : {&brighter_image, &brighter_truth}) {
      for (Rgb<float>& p : both->pixels) p *= 8.0F;
    }
    EXPECT_NEAR(ssim(brighter_image, brighter_truth), value, 1e-12);
  }
}

TEST(Ssim, UnusableInputIsAnError) {
  EXPECT_THROW((void)ssim(Image<float>(10, 11), Image<float>(10, 11)), MetricError);
  EXPECT_THROW((void)ssim(Image<float>(11, 11), Image<float>(11, 12)), MetricError);
  EXPECT_THROW((void)ssim({1.0}, {1.0}, 11, 11), ParameterError);
}

}  // namespace
}  // namespace manylight::metrics::ssim_test
