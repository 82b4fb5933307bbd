// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "metrics/estimate.hpp"

namespace manylight::metrics {

/// Chance that Student's t with that many degrees of freedom (above 0, may be infinite: the normal distribution) lies
/// farther from 0 than `t`, by the regularised incomplete beta function
/// [Abramowitz and Stegun 1964, Eqs. 26.5.8, 26.5.27].
[[nodiscard]] double student_two_sided(double t, double degrees_of_freedom);

enum class PixelTest { student, normal };  ///< normal: the z test, for many runs only

struct TTestConfig {
  PixelTest kind = PixelTest::student;
  double family_level = 0.01;  ///< chance that runs without bias fail, in (0, 1)
  std::uint32_t block = 1;     ///< side of the blocks that are averaged first, pixels, at least 1
  double tolerance = 0.0;      ///< difference that is allowed, relative to the reference's block: for biased methods
};

struct TTestResult {
  std::size_t tests = 0;      ///< three per block
  std::size_t failures = 0;   ///< tests whose p-value is below `level`
  double level = 0.0;         ///< of one test: Sidak's 1 - (1 - family_level)^(1 / tests)
  double worst_p = 1.0;       ///< smallest p-value
  double worst_t = 0.0;       ///< its t, positive where the runs are too bright; infinite without any noise
  std::uint32_t worst_x = 0;  ///< its block's first pixel
  std::uint32_t worst_y = 0;
  int worst_channel = 0;  ///< 0 to 2: R, G, B
  bool passes = false;    ///< no failure
};

/// Tests block by block and channel by channel whether the mean of independent runs of equal cost is the reference:
/// t = (mean - r) / sqrt(s^2 / K + s_r^2) with the degrees of freedom of [Welch 1947]. Three channels of one lamp are
/// hardly independent, which makes the family's level smaller than asked for, never larger [Sidak 1967]. Block means
/// must be near normal: average enough samples per run and block, or the level is not kept. Where nothing varies,
/// differences up to 1e-6 of the reference pass. Throws MetricError for fewer than two runs and as `require_runs` and
/// `checked_mean`, ParameterError for levels, blocks and tolerances out of range.
[[nodiscard]] TTestResult t_test(const std::vector<Image<float>>& runs, const NoisyReference& reference,
                                 const TTestConfig& config = {});

}  // namespace manylight::metrics
