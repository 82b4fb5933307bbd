// SPDX-License-Identifier: Apache-2.0
#include "metrics/t_test.hpp"

#include <algorithm>
#include <cmath>

namespace manylight::metrics {

namespace {

constexpr double k_no_noise_tolerance = 1e-6;  // relative: some roundings of float

/// The continued fraction of I_x(a, b) / (x^a (1 - x)^b / (a B(a, b))) by Lentz's method; quick for x < (a + 1) / (a +
/// b + 2).
double beta_fraction(double a, double b, double x) {
  constexpr double k_tiny = 1e-300;
  const auto away_from_zero = [](double v) { return std::abs(v) < k_tiny ? k_tiny : v; };
  double c = 1;
  double d = 1 / away_from_zero(1 - (a + b) * x / (a + 1));
  double fraction = d;
  for (int m = 1; m < 10'000; ++m) {
    const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
    const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
    double factor = 1;
    for (const double numerator : {even, odd}) {
      d = 1 / away_from_zero(1 + numerator * d);
      c = away_from_zero(1 + numerator / c);
      factor = d * c;
      fraction *= factor;
    }
    if (std::abs(factor - 1) < 1e-15) break;
  }
  return fraction;
}

/// I_x(a, b), given 1 - x apart, because it may be too small for a difference.
double regularised_beta(double a, double b, double x, double complement) {
  if (x <= 0) return 0;
  if (complement <= 0) return 1;
  const double scale =
      std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log(complement));
  if (x < (a + 1) / (a + b + 2)) return scale * beta_fraction(a, b, x) / a;
  return 1 - scale * beta_fraction(b, a, complement) / b;
}

struct Moments {
  double mean = 0.0;
  double variance_of_mean = 0.0;
  double freedom = k_infinity;
};

Moments moments_of(const std::vector<Image<double>>& images, std::size_t pixel, int channel) {
  const auto n = static_cast<double>(images.size());
  Moments m;
  for (const Image<double>& image : images) m.mean += image.pixels[pixel][channel] / n;
  if (images.size() < 2) return m;
  double squares = 0;
  for (const Image<double>& image : images) {
    squares += (image.pixels[pixel][channel] - m.mean) * (image.pixels[pixel][channel] - m.mean);
  }
  m.variance_of_mean = squares / (n * (n - 1));
  m.freedom = n - 1;
  return m;
}

/// [Welch 1947]
double welch_freedom(const Moments& a, const Moments& b) {
  const double sum = a.variance_of_mean + b.variance_of_mean;
  return sum * sum /
         (a.variance_of_mean * a.variance_of_mean / a.freedom + b.variance_of_mean * b.variance_of_mean / b.freedom);
}

struct Score {
  double t = 0.0;
  double p = 1.0;
};

Score score(const Moments& runs, const Moments& reference, const TTestConfig& config) {
  const double difference = runs.mean - reference.mean;
  const double excess = std::max(std::abs(difference) - config.tolerance * std::abs(reference.mean), 0.0);
  const double variance = runs.variance_of_mean + reference.variance_of_mean;
  if (!(variance > 0)) {
    if (excess <= k_no_noise_tolerance * std::abs(reference.mean)) return {};
    return {std::copysign(k_infinity, difference), 0.0};
  }
  const double t = excess / std::sqrt(variance);
  const double freedom = config.kind == PixelTest::normal ? k_infinity : welch_freedom(runs, reference);
  return {std::copysign(t, difference), student_two_sided(t, freedom)};
}

std::vector<Image<double>> blocks_of(const std::vector<Image<float>>& images, std::uint32_t block) {
  std::vector<Image<double>> result;
  result.reserve(images.size());
  for (const Image<float>& image : images) result.push_back(block_means(image, block));
  return result;
}

/// Variance of the means of the blocks of independent pixels.
Image<double> block_variances(const Image<float>& variance, std::uint32_t block) {
  Image<double> result = block_means(variance, block);
  for (std::uint32_t y = 0; y < result.height; ++y) {
    for (std::uint32_t x = 0; x < result.width; ++x) {
      const double count = static_cast<double>(std::min(block, variance.width - x * block)) *
                           static_cast<double>(std::min(block, variance.height - y * block));
      result.at(x, y) /= count;
    }
  }
  return result;
}

}  // namespace

double student_two_sided(double t, double degrees_of_freedom) {
  require(degrees_of_freedom > 0, "degrees of freedom", degrees_of_freedom, "above 0");
  const double square = t * t;
  // Beyond 1e8 degrees the two distributions agree to 1e-7 of their values.
  if (degrees_of_freedom > 1e8) return std::erfc(std::abs(t) / std::sqrt(2.0));
  if (std::isinf(square)) return 0.0;
  const double sum = degrees_of_freedom + square;
  return regularised_beta(0.5 * degrees_of_freedom, 0.5, degrees_of_freedom / sum, square / sum);
}

TTestResult t_test(const std::vector<Image<float>>& runs, const NoisyReference& reference, const TTestConfig& config) {
  require(config.family_level > 0 && config.family_level < 1, "family_level", config.family_level, "(0, 1)");
  require(config.block >= 1, "block", config.block, "at least 1 pixel");
  require(std::isfinite(config.tolerance) && config.tolerance >= 0, "tolerance", config.tolerance,
          "finite, at least 0");
  (void)checked_mean(reference);
  require_runs(runs, 2, reference.batches.front());
  const std::vector<Image<double>> run_blocks = blocks_of(runs, config.block);
  const std::vector<Image<double>> batch_blocks = blocks_of(reference.batches, config.block);
  Image<double> variances;
  if (!reference.variance.empty()) variances = block_variances(reference.variance, config.block);
  const Image<double>& shape = run_blocks.front();
  TTestResult result;
  result.tests = 3 * shape.pixels.size();
  result.level = -std::expm1(std::log1p(-config.family_level) / static_cast<double>(result.tests));
  for (std::size_t i = 0; i < shape.pixels.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      Moments truth = moments_of(batch_blocks, i, c);
      if (!variances.empty()) truth.variance_of_mean = variances.pixels[i][c];
      const Score s = score(moments_of(run_blocks, i, c), truth, config);
      if (s.p < result.level) ++result.failures;
      if (s.p > result.worst_p || (s.p == result.worst_p && std::abs(s.t) <= std::abs(result.worst_t))) continue;
      result.worst_p = s.p;
      result.worst_t = s.t;
      result.worst_x = static_cast<std::uint32_t>(i % shape.width) * config.block;
      result.worst_y = static_cast<std::uint32_t>(i / shape.width) * config.block;
      result.worst_channel = c;
    }
  }
  result.passes = result.failures == 0;
  return result;
}

}  // namespace manylight::metrics
