// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "metrics/estimate.hpp"

namespace manylight::metrics {

/// Mean square error of one run against the truth, split in two: MSE = variance + bias^2. Means run over pixels and
/// channels; the relative ones divide each term by r^2 + (0.05 mean r)^2, r from the reference alone.
///
/// All are free of bias, as the variance of the mean of the runs and that of the reference are subtracted. A bias^2 of
/// nothing, or hidden by noise, is therefore estimated below zero half of the time: judge it by its standard error.
struct ErrorSplit {
  Estimate mse;
  Estimate variance;      ///< of one run
  Estimate bias_squared;  ///< may be negative
  Estimate rel_mse;       ///< infinite, like the next two, for a reference that is black everywhere
  Estimate rel_variance;
  Estimate rel_bias_squared;            ///< may be negative
  Estimate signed_difference;           ///< mean of x - r, relative to the mean of r
  double reference_variance = 0.0;      ///< of the reference, mean of s_r^2
  double rel_reference_variance = 0.0;  ///< the same, relative as above
};

/// Splits the error of independent runs of equal cost; the reference must be independent of them. With the runs x_i and
/// the reference's batches r_b as vectors over pixels and channels, bias^2 is the U-statistic
///
///     mean of x_i x_j, i != j,  -  2 mean of x_i r_b  +  mean of r_b r_c, b != c,
///
/// which equals mean((mean x - r)^2 - s^2 / K - s_r^2). Standard errors are jackknifed over whole runs and over whole
/// batches, so that noise shared by many pixels, as that of virtual lights, counts in full; where there is no bias they
/// come out too large, by up to sqrt(2 (n - 1) / (n - 2)) for n runs or batches, whichever are fewer
/// [Efron and Stein 1981]. They are infinite for two runs or two batches. For a single reference of known variance, its
/// noise is taken as normal and independent between pixels, not channels.
/// Throws MetricError for fewer than two runs and as `require_runs` and `checked_mean`.
[[nodiscard]] ErrorSplit split_error(const std::vector<Image<float>>& runs, const NoisyReference& reference);

}  // namespace manylight::metrics
