// SPDX-License-Identifier: Apache-2.0
#include "compare/runs.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <ostream>

namespace manylight::compare {

namespace {

constexpr const char* k_rgb_names[3] = {"R", "G", "B"};

nlohmann::ordered_json to_json(const metrics::Estimate& e) {
  return {{"value", e.value}, {"standard_error", e.standard_error}};
}

void print(std::ostream& out, const char* name, const metrics::Estimate& e, double unit = 1.0) {
  out << fmt::format("{:<24}{:+.6g} +- {:.2g}{}\n", name, unit * e.value, unit * e.standard_error,
                     unit == 1.0 ? "" : " %");
}

}  // namespace

RunsReport compare_runs(const std::vector<Image<float>>& runs, const metrics::NoisyReference& reference,
                        const metrics::TTestConfig& test) {
  RunsReport report;
  report.split = metrics::split_error(runs, reference);
  if (test.family_level > 0) report.t_test = metrics::t_test(runs, reference, test);
  return report;
}

void print_json(const RunsReport& report, std::ostream& out) {
  const metrics::ErrorSplit& s = report.split;
  nlohmann::ordered_json json{{"mse", to_json(s.mse)},
                              {"variance", to_json(s.variance)},
                              {"bias_squared", to_json(s.bias_squared)},
                              {"reference_variance", s.reference_variance},
                              {"rel_mse", to_json(s.rel_mse)},
                              {"rel_variance", to_json(s.rel_variance)},
                              {"rel_bias_squared", to_json(s.rel_bias_squared)},
                              {"rel_reference_variance", s.rel_reference_variance},
                              {"mean_signed_difference", to_json(s.signed_difference)}};
  if (report.t_test) {
    const metrics::TTestResult& t = *report.t_test;
    json["t_test"] = {{"passes", t.passes},
                      {"tests", t.tests},
                      {"failures", t.failures},
                      {"level", t.level},
                      {"worst_p", t.worst_p},
                      {"worst_t", t.worst_t},
                      {"worst_pixel", {t.worst_x, t.worst_y}},
                      {"worst_channel", k_rgb_names[t.worst_channel]}};
  }
  out << json.dump(2) << '\n';
}

void print_text(const RunsReport& report, std::ostream& out) {
  const metrics::ErrorSplit& s = report.split;
  print(out, "MSE of one run", s.mse);
  print(out, "  variance", s.variance);
  print(out, "  bias^2", s.bias_squared);
  print(out, "relMSE of one run", s.rel_mse);
  print(out, "  variance", s.rel_variance);
  print(out, "  bias^2", s.rel_bias_squared);
  print(out, "mean signed difference", s.signed_difference, 100.0);
  out << fmt::format("{:<24}{:.6g}, relative {:.6g}; subtracted above\n", "reference's variance", s.reference_variance,
                     s.rel_reference_variance);
  if (!report.t_test) return;
  const metrics::TTestResult& t = *report.t_test;
  out << fmt::format("{:<24}{}: {} of {} block-channels fail at level {:.3g}; ", "t-test",
                     t.passes ? "passed" : "FAILED", t.failures, t.tests, t.level)
      << fmt::format("worst t {:+.3g}, p {:.2g} at ({}, {}) {}\n", t.worst_t, t.worst_p, t.worst_x, t.worst_y,
                     k_rgb_names[t.worst_channel]);
}

}  // namespace manylight::compare
