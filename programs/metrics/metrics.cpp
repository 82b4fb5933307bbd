// SPDX-License-Identifier: Apache-2.0
#include "metrics/metrics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "metrics/compensated_sum.hpp"

namespace manylight::metrics {

namespace {

constexpr double k_dark_part = 0.05;    // of the mean: keeps black pixels from ruling a relative error
constexpr double k_mape_offset = 0.01;  // in the unit of the images
constexpr std::size_t k_trimmed_one_in = 1000;

/// 0 / 0 is no error, x / 0 an infinite one.
double ratio(double numerator, double denominator) {
  if (denominator != 0.0) return numerator / denominator;
  return numerator == 0.0 ? 0.0 : std::copysign(std::numeric_limits<double>::infinity(), numerator);
}

double mean_of(const Image<float>& image) {
  CompensatedSum sum;
  for (const Rgb<float>& pixel : image.pixels) {
    for (int c = 0; c < 3; ++c) sum.add(static_cast<double>(pixel[c]));
  }
  return sum.value() / (3.0 * static_cast<double>(image.pixels.size()));
}

double sum_of(const std::vector<double>& values, std::size_t first) {
  CompensatedSum sum;
  for (std::size_t i = first; i < values.size(); ++i) sum.add(values[i]);
  return sum.value();
}

double dark_term(double mean) { return k_dark_part * mean * k_dark_part * mean; }

/// Per pixel the sum over channels of the terms of relMSE.
std::vector<double> relative_squares(const Image<float>& image, const Image<float>& reference, double mean) {
  std::vector<double> errors(image.pixels.size(), 0.0);
  for (std::size_t i = 0; i < errors.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      const double r = static_cast<double>(reference.pixels[i][c]);
      const double difference = static_cast<double>(image.pixels[i][c]) - r;
      errors[i] += ratio(difference * difference, r * r + dark_term(mean));
    }
  }
  return errors;
}

void require_comparable(const Image<float>& image, const Image<float>& reference) {
  require_measurable(image, "image");
  require_measurable(reference, "reference");
  require_same_size(image, "image", reference, "reference");
}

}  // namespace

void require_measurable(const Image<float>& image, std::string_view name) {
  if (image.empty()) throw MetricError(fmt::format("the {} has no pixels", name));
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    if (is_finite(image.pixels[i])) continue;
    throw MetricError(fmt::format("the {} has a value that is not finite at pixel ({}, {})", name, i % image.width,
                                  i / image.width));
  }
}

void require_same_size(const Image<float>& image, std::string_view name, const Image<float>& reference,
                       std::string_view reference_name) {
  if (image.width == reference.width && image.height == reference.height) return;
  throw MetricError(fmt::format("the {} has {} x {} pixels, the {} {} x {}", name, image.width, image.height,
                                reference_name, reference.width, reference.height));
}

Metrics measure(const Image<float>& image, const Image<float>& reference) {
  require_comparable(image, reference);
  Metrics result;
  result.mean = mean_of(image);
  result.reference_mean = mean_of(reference);
  CompensatedSum squares;
  CompensatedSum signed_sum;
  CompensatedSum relative;
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      const double r = static_cast<double>(reference.pixels[i][c]);
      const double difference = static_cast<double>(image.pixels[i][c]) - r;
      squares.add(difference * difference);
      signed_sum.add(difference);
      relative.add(std::abs(difference) / (std::abs(r) + k_mape_offset));
    }
  }
  std::vector<double> errors = relative_squares(image, reference, result.reference_mean);
  const std::size_t trimmed = errors.size() / k_trimmed_one_in;
  const double terms = 3.0 * static_cast<double>(errors.size());
  result.rmse = std::sqrt(squares.value() / terms);
  result.mape = relative.value() / terms;
  result.signed_difference = ratio(signed_sum.value() / terms, result.reference_mean);
  result.rel_mse = sum_of(errors, 0) / terms;
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(trimmed), errors.end(),
                   std::greater<>{});
  result.trimmed_rel_mse = sum_of(errors, trimmed) / (3.0 * static_cast<double>(errors.size() - trimmed));
  return result;
}

Image<double> block_means(const Image<float>& image, std::uint32_t block) {
  require(block >= 1, "block", block, "at least 1 pixel");
  require_measurable(image, "image");
  // Not (width + block - 1) / block, which would overflow for the largest blocks.
  Image<double> means((image.width - 1) / block + std::size_t{1}, (image.height - 1) / block + std::size_t{1});
  for (std::uint32_t by = 0; by < means.height; ++by) {
    for (std::uint32_t bx = 0; bx < means.width; ++bx) {
      const std::uint32_t x_end = bx * block + std::min(block, image.width - bx * block);
      const std::uint32_t y_end = by * block + std::min(block, image.height - by * block);
      CompensatedSum sums[3];
      for (std::uint32_t y = by * block; y < y_end; ++y) {
        for (std::uint32_t x = bx * block; x < x_end; ++x) {
          for (int c = 0; c < 3; ++c) sums[c].add(static_cast<double>(image.at(x, y)[c]));
        }
      }
      const double count = static_cast<double>(x_end - bx * block) * static_cast<double>(y_end - by * block);
      means.at(bx, by) = Rgb<double>(sums[0].value(), sums[1].value(), sums[2].value()) / count;
    }
  }
  return means;
}

Image<float> signed_difference_image(const Image<float>& image, const Image<float>& reference, double range) {
  require(std::isfinite(range) && range > 0.0, "range of the difference image", range, "finite, above 0");
  require_comparable(image, reference);
  CompensatedSum sum;
  for (const Rgb<float>& pixel : reference.pixels) sum.add(luminance(Rgb<double>(pixel)));
  const double mean = sum.value() / static_cast<double>(reference.pixels.size());
  Image<float> result(image.width, image.height);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    const double r = luminance(Rgb<double>(reference.pixels[i]));
    const double difference = luminance(Rgb<double>(image.pixels[i])) - r;
    const double value = ratio(difference, std::sqrt(r * r + dark_term(mean)) * range);
    // A finite stand-in for an infinite ratio: image files should stay measurable.
    const float shown = static_cast<float>(std::min(std::abs(value), double{std::numeric_limits<float>::max()}));
    result.pixels[i] = value > 0.0 ? Rgb<float>(shown, 0.0F, 0.0F) : Rgb<float>(0.0F, 0.0F, shown);
  }
  return result;
}

}  // namespace manylight::metrics
