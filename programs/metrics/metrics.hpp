// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

#include "manylight/core/error.hpp"
#include "manylight/scene/image.hpp"

/// How far an image x is from a reference r. All sums are compensated and in double.
namespace manylight::metrics {

/// Images that cannot be compared: empty, of different sizes, or with a value that is not finite.
class MetricError : public Error {
 public:
  using Error::Error;
};

/// Throws MetricError if `image` has no pixels or a value that is not finite; `name` is what the message calls it.
void require_measurable(const Image<float>& image, std::string_view name);

/// Throws MetricError unless the two images have the same size.
void require_same_size(const Image<float>& image, std::string_view name, const Image<float>& reference,
                       std::string_view reference_name);

/// Means run over pixels and channels. Where a reference is black everywhere, the relative errors of equal images are
/// 0, of others infinite.
struct Metrics {
  double mean = 0.0;              ///< of x
  double reference_mean = 0.0;    ///< of r
  double rmse = 0.0;              ///< root of the mean of (x - r)^2, in the unit of the images
  double rel_mse = 0.0;           ///< mean of (x - r)^2 / (r^2 + (0.05 mean r)^2)
  double trimmed_rel_mse = 0.0;   ///< the same without the worst 0.1 % of the pixels, rounded down
  double mape = 0.0;              ///< mean of |x - r| / (|r| + 0.01)
  double signed_difference = 0.0;  ///< mean of x - r, relative to the mean of r: negative where energy is missing
};

/// Throws MetricError for images that are empty, differ in size or hold values that are not finite.
[[nodiscard]] Metrics measure(const Image<float>& image, const Image<float>& reference);

/// Means of `block` x `block` pixels; blocks at the right and lower edge are averaged over the pixels that they have.
/// Throws ParameterError for a block of 0 pixels, MetricError as `require_measurable`.
[[nodiscard]] Image<double> block_means(const Image<float>& image, std::uint32_t block);

/// False colours: red where the luminance lies above the reference, blue where below, black where equal. The value is
/// the difference relative to sqrt(Y_r^2 + (0.05 mean Y_r)^2), divided by `range`: 1 is the full colour, not clamped.
/// Throws ParameterError unless `range` is finite and positive, MetricError as `measure`.
[[nodiscard]] Image<float> signed_difference_image(const Image<float>& image, const Image<float>& reference,
                                                   double range);

}  // namespace manylight::metrics
