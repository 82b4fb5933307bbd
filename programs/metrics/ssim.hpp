// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "metrics/metrics.hpp"

namespace manylight::metrics {

inline constexpr std::size_t k_ssim_window = 11;  ///< side of the window, pixels

/// The tone curve before SSIM: luminance Y times 0.18 / mean Y of the reference, v = Y / (1 + Y) [Reinhard 2002, Eq.
/// 3], then sRGB's transfer function: 0 to 1 for display. Negative luminance counts as 0, an `exposure` of 0 makes
/// black.
[[nodiscard]] double tone_mapped(double luminance, double exposure);

/// 0.18 / mean luminance of the reference; 0 if that is not positive.
[[nodiscard]] double exposure_for(const Image<float>& reference);

/// Structural similarity of two grey images of values 0 to 1, row by row: Gaussian window of 11 x 11 pixels, standard
/// deviation 1.5, K1 = 0.01, K2 = 0.03, mean over the places where the window fits [Wang 2004, Section III-C]. 1 for
/// equal images, at least -1. Throws MetricError for a side below 11 pixels.
[[nodiscard]] double ssim(const std::vector<double>& x, const std::vector<double>& y, std::size_t width,
                          std::size_t height);

/// The same of two linear images behind the tone curve. Not a measure of convergence: noise in the dark counts much,
/// missing light little. Throws MetricError as `measure` and for a side below 11 pixels.
[[nodiscard]] double ssim(const Image<float>& image, const Image<float>& reference);

}  // namespace manylight::metrics
