// SPDX-License-Identifier: Apache-2.0
#include "compare/compare.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <CLI/CLI.hpp>
#include <exception>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "compare/runs.hpp"
#include "image_io/image_io.hpp"
#include "manylight/core/config.hpp"
#include "metrics/metrics.hpp"
#include "metrics/ssim.hpp"
#include "metrics/z_test.hpp"

namespace manylight::compare {

namespace {

namespace fs = std::filesystem;

constexpr int k_test_failed = 1;
constexpr int k_bad_input = 2;

struct Options {
  fs::path image;
  fs::path reference;
  fs::path variance;    ///< empty: no z-test
  double samples = 0.0;
  fs::path difference;  ///< empty: not wanted
  double range = 0.5;
  std::vector<fs::path> runs;  ///< not empty: split their error instead
  std::vector<fs::path> references;
  fs::path reference_variance;  ///< empty: unknown
  metrics::TTestConfig t_test{.family_level = 0.0};
  bool json = false;
};

struct Report {
  metrics::Metrics metrics;
  std::optional<double> ssim;  ///< none for images smaller than its window
  std::optional<metrics::ZTestResult> z_test;
};

void add_run_options(CLI::App& app, Options& o, const std::vector<CLI::Option*>& not_with_runs) {
  auto* runs = app.add_option("--runs", o.runs, "Instead of IMAGE and REFERENCE: two or more independent images of "
                                                "equal cost, whose error is split into variance and bias^2");
  auto* references = app.add_option("--reference", o.references,
                                    "Taken for the truth, independent of the runs; several: independent images whose "
                                    "mean is the truth and whose spread its noise");
  auto* variance = app.add_option("--reference-variance", o.reference_variance,
                                  "Variance of a single reference's pixels, linear RGB; it counts as exact otherwise");
  auto* level = app.add_option("--test-level", o.t_test.family_level,
                               "Adds a t-test of all pixels: chance that runs without bias fail it, 0 to 1; exit code "
                               "1 if they do");
  auto* block = app.add_option("--test-block", o.t_test.block, "Side of the blocks averaged for the test, pixels");
  auto* tolerance = app.add_option("--test-tolerance", o.t_test.tolerance, "Relative difference that the test allows");
  level->check(CLI::Range(1e-12, 0.5));
  block->needs(level)->capture_default_str();
  tolerance->needs(level)->capture_default_str();
  runs->needs(references);
  for (auto* option : {references, variance, level}) option->needs(runs);
  for (auto* option : not_with_runs) runs->excludes(option);
}

/// Nothing when help or the version was asked for and written to `out`.
std::optional<Options> parse(int argc, const char* const* argv, std::ostream& out, std::ostream& errors) {
  Options o;
  CLI::App app{"Measures how far an image is from a reference of the same size (EXR, PFM, PNG, JPEG), or splits the "
               "error of independent runs into variance and bias.",
               "manylight-compare"};
  auto* image = app.add_option("image", o.image, "Image to judge");
  auto* reference = app.add_option("reference", o.reference, "Image taken for the truth");
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
  add_run_options(app, o, {image, reference, variance, difference});
  app.add_flag("--json", o.json, "Print JSON; infinite values become null");
  app.set_version_flag("--version", fmt::format("manylight-compare {}.{}.{}", MANYLIGHT_VERSION_MAJOR,
                                                MANYLIGHT_VERSION_MINOR, MANYLIGHT_VERSION_PATCH));
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& request) {
    app.exit(request, out, errors);
    return std::nullopt;
  }
  if (o.runs.empty() && o.image.empty()) throw CLI::RequiredError("image");
  if (o.runs.empty() && o.reference.empty()) throw CLI::RequiredError("reference");
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

std::vector<Image<float>> read_all(const std::vector<fs::path>& paths, std::string_view name) {
  std::vector<Image<float>> images;
  for (const fs::path& path : paths) images.push_back(read(path, name));
  return images;
}

RunsReport read_and_compare_runs(const Options& o) {
  metrics::NoisyReference reference{read_all(o.references, "reference"), {}};
  if (!o.reference_variance.empty()) reference.variance = read(o.reference_variance, "reference's variance");
  return compare_runs(read_all(o.runs, "run"), reference, o.t_test);
}

Report compare(const Options& o) {
  if (!o.difference.empty()) image_io::check_writable(o.difference);
  const Image<float> image = read(o.image, "image");
  const Image<float> reference = read(o.reference, "reference");
  Report report;
  report.metrics = metrics::measure(image, reference);
  if (std::min(image.width, image.height) >= metrics::k_ssim_window) report.ssim = metrics::ssim(image, reference);
  if (!o.variance.empty()) {
    report.z_test = metrics::z_test(image, reference, read(o.variance, "variance image"), o.samples);
  }
  if (!o.difference.empty()) {
    image_io::write_image(o.difference, metrics::signed_difference_image(image, reference, o.range));
  }
  return report;
}

constexpr const char* k_xyz_names[3] = {"X", "Y", "Z"};

void print_json(const Report& report, std::ostream& out) {
  const metrics::Metrics& m = report.metrics;
  nlohmann::ordered_json json{{"mean", m.mean},
                              {"reference_mean", m.reference_mean},
                              {"rmse", m.rmse},
                              {"rel_mse", m.rel_mse},
                              {"trimmed_rel_mse", m.trimmed_rel_mse},
                              {"mape", m.mape},
                              {"mean_signed_difference", m.signed_difference}};
  if (report.ssim) json["ssim"] = *report.ssim;
  if (report.z_test) {
    const metrics::ZTestResult& z = *report.z_test;
    json["z_test"] = {{"passes", z.passes},
                      {"tests", z.tests},
                      {"failures", z.failures},
                      {"allowed_failures", z.allowed},
                      {"pixel_level", z.level},
                      {"worst_z", z.worst_z},
                      {"worst_pixel", {z.worst_x, z.worst_y}},
                      {"worst_channel", k_xyz_names[z.worst_channel]}};
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
  if (report.ssim) out << fmt::format("SSIM, tone-mapped       {:.6g}\n", *report.ssim);
  if (!report.z_test) return;
  const metrics::ZTestResult& z = *report.z_test;
  out << fmt::format("z-test                  {}: {} of {} pixel-channels fail, {} may; ",
                     z.passes ? "passed" : "FAILED", z.failures, z.tests, z.allowed)
      << fmt::format("worst |z| {:.3g} at ({}, {}) {}\n", z.worst_z, z.worst_x, z.worst_y,
                     k_xyz_names[z.worst_channel]);
}

}  // namespace

int run_compare(int argc, const char* const* argv, std::ostream& out, std::ostream& errors) {
  try {
    const std::optional<Options> options = parse(argc, argv, out, errors);
    if (!options) return 0;
    const auto print = [&](const auto& report) {
      if (options->json) {
        print_json(report, out);
      } else {
        print_text(report, out);
      }
    };
    if (!options->runs.empty()) {
      const RunsReport report = read_and_compare_runs(*options);
      print(report);
      return report.t_test && !report.t_test->passes ? k_test_failed : 0;
    }
    const Report report = compare(*options);
    print(report);
    return report.z_test && !report.z_test->passes ? k_test_failed : 0;
  } catch (const std::exception& error) {  // also CLI11's, whose own exit codes are above 100
    errors << "manylight-compare: " << error.what() << '\n';
    return k_bad_input;
  }
}

}  // namespace manylight::compare
