// SPDX-License-Identifier: Apache-2.0
#include "metrics/z_test.hpp"

#include <algorithm>
#include <cmath>

namespace manylight::metrics {

namespace {

/// Linear sRGB (Rec. 709 primaries, white D65) to CIE 1931 XYZ. In double: variances cancel in it.
Rgb<double> to_xyz(const Rgb<float>& colour) {
  const Rgb<double> c(colour);
  return {0.412453 * c.x + 0.357580 * c.y + 0.180423 * c.z, 0.212671 * c.x + 0.715160 * c.y + 0.072169 * c.z,
          0.019334 * c.x + 0.119193 * c.y + 0.950227 * c.z};
}

/// Chance that a standard normal variable lies farther from 0.
double two_sided(double z) { return std::erfc(z / std::sqrt(2.0)); }

void check(const ZTestConfig& config, double samples) {
  require(std::isfinite(samples) && samples >= 1.0, "samples per pixel", samples, "finite, at least 1");
  require(config.family_level > 0.0 && config.family_level < 1.0, "family_level", config.family_level, "(0, 1)");
  require(config.failed_share >= 0.0 && config.failed_share <= 1.0, "failed_share", config.failed_share, "[0, 1]");
  require(std::isfinite(config.least_variance) && config.least_variance > 0.0, "least_variance",
          config.least_variance, "finite, above 0");
}

}  // namespace

ZTestResult z_test(const Image<float>& image, const Image<float>& reference, const Image<float>& variance,
                   double samples, const ZTestConfig& config) {
  check(config, samples);
  require_measurable(image, "image");
  require_measurable(reference, "reference");
  require_measurable(variance, "variance image");
  require_same_size(image, "image", reference, "reference");
  require_same_size(variance, "variance image", reference, "reference");
  ZTestResult result;
  const auto pixels = static_cast<double>(image.pixels.size());
  result.tests = 3 * image.pixels.size();
  result.allowed = static_cast<std::size_t>(config.failed_share * static_cast<double>(result.tests));
  result.level = -std::expm1(std::log1p(-config.family_level) / pixels);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    const Rgb<double> difference = to_xyz(image.pixels[i]) - to_xyz(reference.pixels[i]);
    const Rgb<double> spread = to_xyz(variance.pixels[i]);
    for (int c = 0; c < 3; ++c) {
      const double z = std::abs(difference[c]) * std::sqrt(samples / std::max(spread[c], config.least_variance));
      if (two_sided(z) <= result.level) ++result.failures;
      if (z <= result.worst_z) continue;
      result.worst_z = z;
      result.worst_x = static_cast<std::uint32_t>(i % image.width);
      result.worst_y = static_cast<std::uint32_t>(i / image.width);
      result.worst_channel = c;
    }
  }
  result.passes = result.failures <= result.allowed;
  return result;
}

}  // namespace manylight::metrics
