// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <iosfwd>
#include <optional>
#include <vector>

#include "metrics/error_split.hpp"
#include "metrics/t_test.hpp"

namespace manylight::compare {

/// What many runs tell that one image cannot.
struct RunsReport {
  metrics::ErrorSplit split;
  std::optional<metrics::TTestResult> t_test;
};

/// Splits the error of `runs` and, with a family level above 0 in `test`, tests whether they have none but noise.
/// Throws as `metrics::split_error` and `metrics::t_test`.
[[nodiscard]] RunsReport compare_runs(const std::vector<Image<float>>& runs, const metrics::NoisyReference& reference,
                                      const metrics::TTestConfig& test);

void print_json(const RunsReport& report, std::ostream& out);
void print_text(const RunsReport& report, std::ostream& out);

}  // namespace manylight::compare
