// SPDX-License-Identifier: Apache-2.0
#include "metrics/error_split.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "metrics/compensated_sum.hpp"

namespace manylight::metrics {

namespace {

constexpr std::size_t k_none = std::numeric_limits<std::size_t>::max();

/// Inner products of runs and batches after the reference's mean is taken off, which keeps them small.
struct Gram {
  Gram(std::size_t run_count, std::size_t batch_count)
      : runs(run_count), batches(batch_count), rows(run_count + batch_count), sums(rows * rows) {}
  /// Adds the outer product of `values`, one per run and batch, times `weight`.
  void add(const std::vector<double>& values, double weight) {
    for (std::size_t i = 0; i < rows; ++i) {
      for (std::size_t j = 0; j <= i; ++j) sums[i * rows + j].add(weight * values[i] * values[j]);
    }
  }
  [[nodiscard]] double product(std::size_t i, std::size_t j) const {
    return sums[std::max(i, j) * rows + std::min(i, j)].value();
  }
  std::size_t runs, batches, rows;
  std::vector<CompensatedSum> sums;
  double given_variance = 0.0;  ///< sum of s_r^2 of a single reference
  double given_square = 0.0;    ///< variance of bias^2 by it, times the square of the number of terms
};

struct Parts {
  double mse = 0.0, variance = 0.0, bias_squared = 0.0;
};

/// The estimates without run or batch `left_out`, times the number of terms.
Parts parts_without(const Gram& g, std::size_t left_out) {
  double squares = 0, run_pairs = 0, crossed = 0, batch_pairs = 0;
  for (std::size_t i = 0; i < g.rows; ++i) {
    for (std::size_t j = 0; j < g.rows; ++j) {
      if (i == left_out || j == left_out) continue;
      const double product = g.product(i, j);
      if (i < g.runs && j < g.runs) (i == j ? squares : run_pairs) += product;
      if (i < g.runs && j >= g.runs) crossed += product;
      if (i >= g.runs && j >= g.runs && i != j) batch_pairs += product;
    }
  }
  const double k = static_cast<double>(g.runs) - (left_out < g.runs ? 1 : 0);
  const double b = static_cast<double>(g.batches) - (left_out != k_none && left_out >= g.runs ? 1 : 0);
  const double own = squares / k;
  const double pairs = run_pairs / (k * (k - 1));
  // One batch is at its own mean: its square is nothing but the variance that may be known.
  const double truth = g.batches > 1 ? batch_pairs / (b * (b - 1)) : -g.given_variance;
  const double shift = truth - 2 * crossed / (k * b);
  return {own + shift, own - pairs, pairs + shift};
}

/// Adds the jackknife's variance over `count` items from `first` on to `variances`.
void add_jackknife(const Gram& g, std::size_t first, std::size_t count, Parts& variances) {
  if (count < 2) return;
  if (count == 2) {
    variances = {k_infinity, k_infinity, k_infinity};
    return;
  }
  std::vector<Parts> parts(count);
  for (std::size_t i = 0; i < count; ++i) parts[i] = parts_without(g, first + i);
  const auto n = static_cast<double>(count);
  for (double Parts::*member : {&Parts::mse, &Parts::variance, &Parts::bias_squared}) {
    double mean = 0, squares = 0;
    for (const Parts& p : parts) mean += p.*member / n;
    for (const Parts& p : parts) squares += (p.*member - mean) * (p.*member - mean);
    variances.*member += squares * (n - 1) / n;
  }
}

std::array<Estimate, 3> estimates(const Gram& g, double terms) {
  const Parts values = parts_without(g, k_none);
  Parts variances;
  variances.mse = variances.bias_squared = g.given_square;
  add_jackknife(g, 0, g.runs, variances);
  add_jackknife(g, g.runs, g.batches, variances);
  const auto scaled = [&](double value, double variance) {
    return Estimate{value / terms, std::sqrt(variance) / terms};
  };
  return {scaled(values.mse, variances.mse), scaled(values.variance, variances.variance),
          scaled(values.bias_squared, variances.bias_squared)};
}

/// Mean of s_r^2, that of the mean of all batches.
double reference_variance(const Gram& g, double terms) {
  if (g.batches < 2) return g.given_variance / terms;
  double squares = 0;
  for (std::size_t b = g.runs; b < g.rows; ++b) squares += g.product(b, b);
  const auto n = static_cast<double>(g.batches);
  return squares / (n * (n - 1)) / terms;
}

/// Variance of (mean x - r)^2 by the noise of r, of variance v, normal: 4 bias^2 v + 2 v^2.
double square_noise(const std::vector<double>& values, std::size_t runs, double v) {
  double mean = 0, squares = 0;
  const auto k = static_cast<double>(runs);
  for (std::size_t i = 0; i < runs; ++i) mean += values[i] / k;
  for (std::size_t i = 0; i < runs; ++i) squares += (values[i] - mean) * (values[i] - mean);
  const double bias_squared = mean * mean - squares / (k * (k - 1)) - v;
  return 4 * std::max(bias_squared, 0.0) * v + 2 * v * v;
}

/// Mean over all pixels and channels.
template <class S>
double grand_mean(const Image<S>& image) {
  CompensatedSum sum;
  for (const Rgb<S>& p : image.pixels)
    sum.add(static_cast<double>(p.x) + static_cast<double>(p.y) + static_cast<double>(p.z));
  return sum.value() / (3.0 * static_cast<double>(image.pixels.size()));
}

/// Variance of the mean of the images' grand means; infinite for fewer than two.
double variance_of_mean(const std::vector<Image<float>>& images) {
  if (images.size() < 2) return k_infinity;
  const auto n = static_cast<double>(images.size());
  double mean = 0, squares = 0;
  for (const Image<float>& image : images) mean += grand_mean(image) / n;
  for (const Image<float>& image : images) squares += (grand_mean(image) - mean) * (grand_mean(image) - mean);
  return squares / (n * (n - 1));
}

/// By the delta method for the quotient of two means.
Estimate signed_difference(const std::vector<Image<float>>& runs, const NoisyReference& reference, double truth) {
  double mean = 0;
  for (const Image<float>& run : runs) mean += grand_mean(run) / static_cast<double>(runs.size());
  double reference_noise = 0;
  if (reference.batches.size() > 1) {
    reference_noise = variance_of_mean(reference.batches);
  } else if (!reference.variance.empty()) {
    for (const Rgb<float>& v : reference.variance.pixels) {
      const double error = std::sqrt(double{v.x}) + std::sqrt(double{v.y}) + std::sqrt(double{v.z});
      reference_noise += error * error;
    }
    const double terms = 3.0 * static_cast<double>(reference.variance.pixels.size());
    reference_noise /= terms * terms;
  }
  if (truth == 0.0) return mean == 0.0 ? Estimate{} : Estimate{std::copysign(k_infinity, mean), k_infinity};
  const double ratio = mean / truth;
  return {ratio - 1, std::sqrt(variance_of_mean(runs) + ratio * ratio * reference_noise) / std::abs(truth)};
}

}  // namespace

ErrorSplit split_error(const std::vector<Image<float>>& runs, const NoisyReference& reference) {
  const Image<double> truth = checked_mean(reference);
  require_runs(runs, 2, reference.batches.front());
  const double mean = grand_mean(truth);
  Gram plain(runs.size(), reference.batches.size());
  Gram relative = plain;
  std::vector<double> values(plain.rows);
  for (std::size_t p = 0; p < truth.pixels.size(); ++p) {
    double plain_error = 0, relative_error = 0;
    for (int c = 0; c < 3; ++c) {
      const double r = truth.pixels[p][c];
      const double floored = r * r + 0.05 * mean * 0.05 * mean;
      const double weight = floored > 0 ? 1 / floored : 0.0;
      for (std::size_t i = 0; i < plain.rows; ++i) {
        const Image<float>& image = i < plain.runs ? runs[i] : reference.batches[i - plain.runs];
        values[i] = static_cast<double>(image.pixels[p][c]) - r;
      }
      plain.add(values, 1.0);
      relative.add(values, weight);
      if (reference.variance.empty()) continue;
      const double v = static_cast<double>(reference.variance.pixels[p][c]);
      const double noise = std::sqrt(square_noise(values, plain.runs, v));
      plain.given_variance += v;
      relative.given_variance += weight * v;
      plain_error += noise;
      relative_error += weight * noise;
    }
    plain.given_square += plain_error * plain_error;
    relative.given_square += relative_error * relative_error;
  }
  const double terms = 3.0 * static_cast<double>(truth.pixels.size());
  ErrorSplit split;
  const auto plain_parts = estimates(plain, terms);
  split.mse = plain_parts[0], split.variance = plain_parts[1], split.bias_squared = plain_parts[2];
  split.reference_variance = reference_variance(plain, terms);
  split.signed_difference = signed_difference(runs, reference, mean);
  if (mean == 0.0) {
    split.rel_mse = split.rel_variance = split.rel_bias_squared = {k_infinity, k_infinity};
    return split;
  }
  const auto relative_parts = estimates(relative, terms);
  split.rel_mse = relative_parts[0], split.rel_variance = relative_parts[1], split.rel_bias_squared = relative_parts[2];
  split.rel_reference_variance = reference_variance(relative, terms);
  return split;
}

}  // namespace manylight::metrics
