// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

namespace manylight::metrics {

/// A sum whose rounding error does not grow with the number of terms: Neumaier's variant of Kahan's summation. Infinite
/// terms give what a plain sum gives.
class CompensatedSum {
 public:
  void add(double term) noexcept {
    const double next = sum_ + term;
    lost_ += std::abs(sum_) >= std::abs(term) ? (sum_ - next) + term : (term - next) + sum_;
    sum_ = next;
  }
  [[nodiscard]] double value() const noexcept { return std::isfinite(sum_) ? sum_ + lost_ : sum_; }

 private:
  double sum_ = 0.0;
  double lost_ = 0.0;
};

}  // namespace manylight::metrics
