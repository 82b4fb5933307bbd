// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "support/chi_square.hpp"

namespace manylight::test {

/// Mean and variance of a stream of numbers, by Welford's recurrence.
class RunningMoments {
 public:
  void add(double x) {
    ++count_;
    const double delta = x - mean_;
    mean_ += delta / static_cast<double>(count_);
    squares_ += delta * (x - mean_);
  }
  [[nodiscard]] std::uint64_t count() const { return count_; }
  [[nodiscard]] double mean() const { return mean_; }
  /// Unbiased; 0 for fewer than two numbers.
  [[nodiscard]] double variance() const { return count_ > 1 ? squares_ / static_cast<double>(count_ - 1) : 0.0; }
  /// Of the mean.
  [[nodiscard]] double standard_error() const {
    return count_ > 0 ? std::sqrt(variance() / static_cast<double>(count_)) : 0.0;
  }

 private:
  std::uint64_t count_ = 0;
  double mean_ = 0.0;
  double squares_ = 0.0;
};

/// Probability that a standard normal variable lies farther from 0 than `z`.
[[nodiscard]] inline double normal_two_sided(double z) { return std::erfc(std::abs(z) / std::sqrt(2.0)); }

/// Regularised incomplete beta function I_x(a, b) by its continued fraction.
[[nodiscard]] inline double regularised_beta(double a, double b, double x) {
  if (x <= 0.0) return 0.0;
  if (x >= 1.0) return 1.0;
  if (x > (a + 1.0) / (a + b + 2.0)) return 1.0 - regularised_beta(b, a, 1.0 - x);
  const double front =
      std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log1p(-x)) / a;
  constexpr double k_tiny = 1e-300;
  double f = 1.0;
  double c = 1.0;
  double d = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const int m = i / 2;
    double numerator = 1.0;
    if (i > 0 && i % 2 == 0) numerator = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
    if (i % 2 == 1) numerator = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
    d = 1.0 + numerator * d;
    if (std::abs(d) < k_tiny) d = k_tiny;
    d = 1.0 / d;
    c = 1.0 + numerator / c;
    if (std::abs(c) < k_tiny) c = k_tiny;
    f *= c * d;
    if (std::abs(1.0 - c * d) < 1e-15) break;
  }
  return front * (f - 1.0);
}

/// Probability that Student's t of that many degrees of freedom lies farther from 0 than `t`.
[[nodiscard]] inline double student_two_sided(double t, double degrees_of_freedom) {
  return regularised_beta(0.5 * degrees_of_freedom, 0.5, degrees_of_freedom / (degrees_of_freedom + t * t));
}

/// The limit that a monotone two-sided tail probability crosses at `level`, by bisection.
template <class Tail>
[[nodiscard]] double two_sided_limit(const Tail& tail, double level) {
  double low = 0.0;
  double high = 1e6;
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    (tail(middle) > level ? low : high) = middle;
  }
  return 0.5 * (low + high);
}
[[nodiscard]] inline double normal_limit(double level) { return two_sided_limit(normal_two_sided, level); }
[[nodiscard]] inline double student_limit(double level, double degrees_of_freedom) {
  return two_sided_limit([=](double t) { return student_two_sided(t, degrees_of_freedom); }, level);
}

/// (estimate - reference) in standard errors; a difference without any error is infinitely many, none is 0.
[[nodiscard]] inline double z_score(double estimate, double error, double reference, double reference_error = 0.0) {
  const double both = std::sqrt(error * error + reference_error * reference_error);
  const double difference = estimate - reference;
  if (both > 0.0) return difference / both;
  return difference == 0.0 ? 0.0 : std::copysign(std::numeric_limits<double>::infinity(), difference);
}

struct ZTestResult {
  std::size_t tests = 0;
  std::size_t failures = 0;  ///< beyond the limit
  double limit = 0.0;
  double worst = 0.0;           ///< largest |z|
  std::size_t worst_index = 0;  ///< where
  [[nodiscard]] double failed_share() const {
    return tests > 0 ? static_cast<double>(failures) / static_cast<double>(tests) : 0.0;
  }
};

/// Compares values with references, all spans of one length; the limit is Sidak's for `family_level` and normal errors.
/// A NaN on either side counts as a failure.
[[nodiscard]] inline ZTestResult z_test(std::span<const double> value, std::span<const double> error,
                                        std::span<const double> reference, std::span<const double> reference_error,
                                        double family_level) {
  ZTestResult result;
  result.tests = value.size();
  result.limit = normal_limit(sidak_level(family_level, static_cast<double>(value.size())));
  for (std::size_t i = 0; i < value.size(); ++i) {
    const double z = std::abs(z_score(value[i], error[i], reference[i], reference_error[i]));
    if (!(z <= result.limit)) ++result.failures;
    if (!(z <= result.worst)) {
      result.worst = z;
      result.worst_index = i;
    }
  }
  return result;
}

}  // namespace manylight::test
