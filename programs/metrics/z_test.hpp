// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "metrics/metrics.hpp"

namespace manylight::metrics {

/// Levels of `z_test`.
struct ZTestConfig {
  double family_level = 0.01;      ///< chance that an image without any error has one failing pixel, in (0, 1)
  double failed_share = 0.0025;    ///< part of the pixel-channels that may fail, in [0, 1]
  double least_variance = 1e-4;    ///< smaller ones, and the negative ones of rounding, are raised to this; above 0
};

struct ZTestResult {
  std::size_t tests = 0;       ///< three per pixel
  std::size_t failures = 0;    ///< pixel-channels whose p-value is at most `level`
  std::size_t allowed = 0;     ///< most failures of an image that passes
  double level = 0.0;          ///< of one pixel: Sidak's 1 - (1 - family_level)^(1 / pixels)
  double worst_z = 0.0;        ///< largest |z|
  std::uint32_t worst_x = 0;   ///< its pixel
  std::uint32_t worst_y = 0;
  int worst_channel = 0;       ///< 0 to 2: X, Y, Z of CIE 1931
  bool passes = false;         ///< failures <= allowed
};

/// Tests whether `image` is an average of `samples` independent samples per pixel whose mean is `reference` and whose
/// variance per sample is `variance`: z = |mean - reference| sqrt(samples / max(variance, least_variance)) in XYZ.
/// `variance` holds the variances of X, Y and Z, passed like a colour through the matrix to linear sRGB; its RGB values
/// may therefore be negative. The noise of the reference itself is left out: it must have far more samples.
/// Throws MetricError as `measure`, also for `variance`; ParameterError for 0 samples and levels out of range.
[[nodiscard]] ZTestResult z_test(const Image<float>& image, const Image<float>& reference,
                                 const Image<float>& variance, double samples, const ZTestConfig& config = {});

}  // namespace manylight::metrics
