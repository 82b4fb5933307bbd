// SPDX-License-Identifier: Apache-2.0
#include "metrics/ssim.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "metrics/compensated_sum.hpp"

namespace manylight::metrics {

namespace {

constexpr double k_sigma = 1.5;       // pixels
constexpr double k_c1 = 0.01 * 0.01;  // (K1 L)^2, L = 1
constexpr double k_c2 = 0.03 * 0.03;  // (K2 L)^2
constexpr double k_grey = 0.18;       // what the mean luminance is exposed to

std::array<double, k_ssim_window> window_weights() {
  std::array<double, k_ssim_window> weights{};
  double sum = 0;
  for (std::size_t i = 0; i < k_ssim_window; ++i) {
    const double x = (static_cast<double>(i) - static_cast<double>(k_ssim_window / 2)) / k_sigma;
    sum += weights[i] = std::exp(-0.5 * x * x);
  }
  for (double& weight : weights) weight /= sum;
  return weights;
}

/// Means under the window, where it fits: first along rows, then along columns.
std::vector<double> windowed(const std::vector<double>& values, std::size_t width, std::size_t height) {
  const auto weights = window_weights();
  const std::size_t columns = width - k_ssim_window + 1;
  const std::size_t rows = height - k_ssim_window + 1;
  std::vector<double> along(columns * height, 0.0);
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < columns; ++x) {
      for (std::size_t i = 0; i < k_ssim_window; ++i) along[y * columns + x] += weights[i] * values[y * width + x + i];
    }
  }
  std::vector<double> result(columns * rows, 0.0);
  for (std::size_t y = 0; y < rows; ++y) {
    for (std::size_t x = 0; x < columns; ++x) {
      for (std::size_t i = 0; i < k_ssim_window; ++i) {
        result[y * columns + x] += weights[i] * along[(y + i) * columns + x];
      }
    }
  }
  return result;
}

std::vector<double> products(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> result(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) result[i] = a[i] * b[i];
  return result;
}

std::vector<double> tone_mapped_luminance(const Image<float>& image, double exposure) {
  std::vector<double> values(image.pixels.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = tone_mapped(luminance(Rgb<double>(image.pixels[i])), exposure);
  }
  return values;
}

}  // namespace

double tone_mapped(double luminance, double exposure) {
  const double scaled = std::max(luminance * exposure, 0.0);
  const double v = scaled / (1 + scaled);
  return v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055;
}

double exposure_for(const Image<float>& reference) {
  CompensatedSum sum;
  for (const Rgb<float>& pixel : reference.pixels) sum.add(luminance(Rgb<double>(pixel)));
  const double mean = sum.value() / static_cast<double>(reference.pixels.size());
  return mean > 0 ? k_grey / mean : 0.0;
}

double ssim(const std::vector<double>& x, const std::vector<double>& y, std::size_t width, std::size_t height) {
  require(x.size() == width * height && y.size() == x.size(), "number of values", x.size(),
          "width * height, both equal");
  if (width < k_ssim_window || height < k_ssim_window) {
    throw MetricError(
        fmt::format("SSIM needs {0} x {0} pixels, the images have {1} x {2}", k_ssim_window, width, height));
  }
  const std::vector<double> mean_x = windowed(x, width, height);
  const std::vector<double> mean_y = windowed(y, width, height);
  const std::vector<double> square_x = windowed(products(x, x), width, height);
  const std::vector<double> square_y = windowed(products(y, y), width, height);
  const std::vector<double> crossed = windowed(products(x, y), width, height);
  CompensatedSum sum;
  for (std::size_t i = 0; i < mean_x.size(); ++i) {
    const double means = mean_x[i] * mean_y[i];
    const double squares = mean_x[i] * mean_x[i] + mean_y[i] * mean_y[i];
    const double variances = square_x[i] + square_y[i] - squares;
    sum.add((2 * means + k_c1) * (2 * (crossed[i] - means) + k_c2) / ((squares + k_c1) * (variances + k_c2)));
  }
  return sum.value() / static_cast<double>(mean_x.size());
}

double ssim(const Image<float>& image, const Image<float>& reference) {
  require_measurable(image, "image");
  require_measurable(reference, "reference");
  require_same_size(image, "image", reference, "reference");
  const double exposure = exposure_for(reference);
  return ssim(tone_mapped_luminance(image, exposure), tone_mapped_luminance(reference, exposure), image.width,
              image.height);
}

}  // namespace manylight::metrics
