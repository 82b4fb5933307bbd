// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "metrics/metrics.hpp"

namespace manylight::metrics {

inline constexpr double k_infinity = std::numeric_limits<double>::infinity();

/// A value with its standard error, which is infinite where the data are too few to tell.
struct Estimate {
  double value = 0.0;
  double standard_error = 0.0;
};

/// What is taken for the truth: the mean of independent images of equal cost, or one image, exact unless the variance
/// of its pixels is known.
struct NoisyReference {
  std::vector<Image<float>> batches;
  Image<float> variance;  ///< of one image's pixels, per channel; empty: none. Only with one batch
};

/// Mean of the batches, summed in double. Throws MetricError without batches, for images that `require_measurable`
/// refuses, of different sizes, and for a variance beside several batches or with a negative value.
[[nodiscard]] Image<double> checked_mean(const NoisyReference& reference);

/// Throws MetricError for fewer than `least` runs, unmeasurable ones, or sizes that differ from the reference's.
void require_runs(const std::vector<Image<float>>& runs, std::size_t least, const Image<float>& reference);

}  // namespace manylight::metrics
