// SPDX-License-Identifier: Apache-2.0
#include "compare/compare.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <exception>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>
#include <string>

#include "image_io/image_io.hpp"
#include "manylight/core/config.hpp"
#include "metrics/metrics.hpp"
#include "metrics/z_test.hpp"

namespace manylight::compare {

namespace {

namespace fs = std::filesystem;

constexpr int k_z_test_failed = 1;
constexpr int k_bad_input = 2;

struct Options {
  fs::path image;
  fs::path reference;
  fs::path variance;    ///< empty: no z-test
  double samples = 0.0;
  fs::path difference;  ///< empty: not wanted
  double range = 0.5;
  bool json = false;
};

struct Report {
  metrics::Metrics metrics;
  std::optional<metrics::ZTestResult> z_test;
};

/// Nothing when help or the version was asked for and written to `out`.
std::optional<Options> parse(int argc, const char* const* argv, std::ostream& out, std::ostream& errors) {
  Options o;
  CLI::App app{"Measures how far an image is from a reference of the same size (EXR, PFM, PNG, JPEG).",
               "manylight-compare"};
  app.add_option("image", o.image, "Image to judge")->required();
  app.add_option("reference", o.reference, "Image taken for the truth")->required();
  auto* variance = app.add_option("--variance", o.variance,
                                  "Variance per sample of the reference's estimator, XYZ variances stored as linear "
                                  "RGB: adds a z-test; exit code 1 if it fails");
  auto* samples = app.add_option("--spp", o.samples, "Samples per pixel of IMAGE, for the z-test");
  variance->needs(samples);
  samples->needs(variance);
  auto* difference = app.add_option("--difference", o.difference,
                                    "Write the relative luminance difference in false colours, red above and blue "
                                    "below the reference: .exr, .pfm or .png");
  app.add_option("--difference-range", o.range, "Relative difference shown in full colour")
      ->needs(difference)->capture_default_str();
  app.add_flag("--json", o.json, "Print JSON; infinite values become null");
  app.set_version_flag("--version", fmt::format("manylight-compare {}.{}.{}", MANYLIGHT_VERSION_MAJOR,
                                                MANYLIGHT_VERSION_MINOR, MANYLIGHT_VERSION_PATCH));
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& request) {
    app.exit(request, out, errors);
    return std::nullopt;
  }
  return o;
}

Image<float> read(const fs::path& path, std::string_view name) {
  Image<float> image = image_io::read_image(path);
  try {
    metrics::require_measurable(image, name);
  } catch (const metrics::MetricError& error) {
    throw metrics::MetricError(fmt::format("{}: {}", path.string(), error.what()));
  }
  return image;
}

Report compare(const Options& o) {
  if (!o.difference.empty()) image_io::check_writable(o.difference);
  const Image<float> image = read(o.image, "image");
  const Image<float> reference = read(o.reference, "reference");
  Report report;
  report.metrics = metrics::measure(image, reference);
  if (!o.variance.empty()) {
    report.z_test = metrics::z_test(image, reference, read(o.variance, "variance image"), o.samples);
  }
  if (!o.difference.empty()) {
    image_io::write_image(o.difference, metrics::signed_difference_image(image, reference, o.range));
  }
  return report;
}

constexpr const char* k_channel_names[3] = {"X", "Y", "Z"};

void print_json(const Report& report, std::ostream& out) {
  const metrics::Metrics& m = report.metrics;
  nlohmann::ordered_json json{{"mean", m.mean},
                              {"reference_mean", m.reference_mean},
                              {"rmse", m.rmse},
                              {"rel_mse", m.rel_mse},
                              {"trimmed_rel_mse", m.trimmed_rel_mse},
                              {"mape", m.mape},
                              {"mean_signed_difference", m.signed_difference}};
  if (report.z_test) {
    const metrics::ZTestResult& z = *report.z_test;
    json["z_test"] = {{"passes", z.passes},
                      {"tests", z.tests},
                      {"failures", z.failures},
                      {"allowed_failures", z.allowed},
                      {"pixel_level", z.level},
                      {"worst_z", z.worst_z},
                      {"worst_pixel", {z.worst_x, z.worst_y}},
                      {"worst_channel", k_channel_names[z.worst_channel]}};
  }
  out << json.dump(2) << '\n';
}

void print_text(const Report& report, std::ostream& out) {
  const metrics::Metrics& m = report.metrics;
  out << fmt::format("mean                    {:.6g} (reference {:.6g})\n", m.mean, m.reference_mean)
      << fmt::format("RMSE                    {:.6g}\n", m.rmse)
      << fmt::format("relMSE                  {:.6g}\n", m.rel_mse)
      << fmt::format("relMSE, trimmed 0.1 %   {:.6g}\n", m.trimmed_rel_mse)
      << fmt::format("MAPE                    {:.6g}\n", m.mape)
      << fmt::format("mean signed difference  {:+.4f} %\n", 100.0 * m.signed_difference);
  if (!report.z_test) return;
  const metrics::ZTestResult& z = *report.z_test;
  out << fmt::format("z-test                  {}: {} of {} pixel-channels fail, {} may; ",
                     z.passes ? "passed" : "FAILED", z.failures, z.tests, z.allowed)
      << fmt::format("worst |z| {:.3g} at ({}, {}) {}\n", z.worst_z, z.worst_x, z.worst_y,
                     k_channel_names[z.worst_channel]);
}

}  // namespace

int run_compare(int argc, const char* const* argv, std::ostream& out, std::ostream& errors) {
  try {
    const std::optional<Options> options = parse(argc, argv, out, errors);
    if (!options) return 0;
    const Report report = compare(*options);
    if (options->json) {
      print_json(report, out);
    } else {
      print_text(report, out);
    }
    return report.z_test && !report.z_test->passes ? k_z_test_failed : 0;
  } catch (const std::exception& error) {  // also CLI11's, whose own exit codes are above 100
    errors << "manylight-compare: " << error.what() << '\n';
    return k_bad_input;
  }
}

}  // namespace manylight::compare
