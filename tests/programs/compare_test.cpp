// SPDX-License-Identifier: Apache-2.0
#include "compare/compare.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "image_io/image_io.hpp"

namespace manylight::compare::compare_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

struct Outcome {
  int code = 0;
  std::string out;
  std::string errors;
};

Outcome run(const std::vector<std::string>& arguments) {
  std::vector<const char*> argv{"manylight-compare"};
  for (const std::string& argument : arguments) argv.push_back(argument.c_str());
  std::ostringstream out;
  std::ostringstream errors;
  const int code = run_compare(static_cast<int>(argv.size()), argv.data(), out, errors);
  return {code, out.str(), errors.str()};
}

/// Writes a grey 2 x 2 reference of 1 and images that differ from it into a folder of the test's own.
class Compare : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(MANYLIGHT_SCRATCH_DIR) / testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    write("reference.exr", 1.0F);
    write("brighter.pfm", 1.5F);
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] std::string path(const std::string& name) const { return (folder_ / name).string(); }
  void write(const std::string& name, float value) const {
    image_io::write_image(path(name), Image<float>(2, 2, Rgb<float>(value)));
  }
  /// Every error is one line on the error stream, exit code 2 and nothing printed.
  void expect_error(const std::vector<std::string>& arguments, const std::string& part) const {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.code, 2) << outcome.out;
    EXPECT_EQ(outcome.out, "");
    EXPECT_THAT(outcome.errors, HasSubstr(part));
    EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1) << outcome.errors;
  }

  fs::path folder_;
};

// Oracle: 1.5 against 1 is RMSE 0.5, relMSE 0.25 / 1.0025, MAPE 0.5 / 1.01, +50 %.
TEST_F(Compare, JsonHoldsTheMetrics) {
  const Outcome outcome = run({path("brighter.pfm"), path("reference.exr"), "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_NEAR(json.at("rmse").get<double>(), 0.5, 1e-14);  // exact in float; double rounding
  EXPECT_NEAR(json.at("rel_mse").get<double>(), 0.25 / 1.0025, 1e-14);
  EXPECT_NEAR(json.at("trimmed_rel_mse").get<double>(), 0.25 / 1.0025, 1e-14);
  EXPECT_NEAR(json.at("mape").get<double>(), 0.5 / 1.01, 1e-14);
  EXPECT_NEAR(json.at("mean_signed_difference").get<double>(), 0.5, 1e-14);
  EXPECT_FALSE(json.contains("z_test"));
}

TEST_F(Compare, TextNamesEveryMetric) {
  const Outcome outcome = run({path("brighter.pfm"), path("reference.exr")});
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  for (const char* line : {"RMSE                    0.5\n", "relMSE                  0.249377\n",
                           "relMSE, trimmed 0.1 %   0.249377\n", "MAPE                    0.49505\n",
                           "mean signed difference  +50.0000 %\n"}) {
    EXPECT_THAT(outcome.out, HasSubstr(line));
  }
}

TEST_F(Compare, InfiniteErrorsAreNullInJson) {
  write("black.pfm", 0.0F);
  const Outcome outcome = run({path("reference.exr"), path("black.pfm"), "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_TRUE(nlohmann::json::parse(outcome.out).at("rel_mse").is_null());
}

// Oracle: a variance of 1 and 4 samples make 0.5 a difference of about one standard error; 10,000 samples of fifty.
TEST_F(Compare, ZTestDecidesTheExitCode) {
  const std::vector<std::string> files{path("brighter.pfm"), path("reference.exr"), "--variance",
                                       path("reference.exr"), "--json", "--spp"};
  std::vector<std::string> few = files;
  few.emplace_back("4");
  std::vector<std::string> many = files;
  many.emplace_back("10000");
  const Outcome passed = run(few);
  EXPECT_EQ(passed.code, 0) << passed.errors;
  EXPECT_TRUE(nlohmann::json::parse(passed.out).at("z_test").at("passes").get<bool>());
  const Outcome failed = run(many);
  EXPECT_EQ(failed.code, 1) << failed.errors;
  const auto z = nlohmann::json::parse(failed.out).at("z_test");
  EXPECT_FALSE(z.at("passes").get<bool>());
  EXPECT_EQ(z.at("failures").get<int>(), 12);
}

// Oracle: +50 % at a range of 1 is 0.5 / sqrt(1.0025) in red.
TEST_F(Compare, DifferenceImage) {
  const std::string file = path("difference.exr");
  const Outcome outcome = run({path("brighter.pfm"), path("reference.exr"), "--difference", file,
                               "--difference-range", "1"});
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const Image<float> image = image_io::read_image(file);
  ASSERT_EQ(image.pixels.size(), 4U);
  EXPECT_NEAR(image.at(1, 1).x, 0.499376F, 1e-6F);  // float and the six digits given
  EXPECT_EQ(image.at(1, 1).z, 0.0F);
}

// Oracle: by hand. Runs 1 and 3 of a reference 1: MSE 2, variance 2, bias^2 0; relative 1.0025 below. The mean is 2 with
// an error of 1, +100 %.
TEST_F(Compare, RunsAreSplitIntoVarianceAndBias) {
  write("three.pfm", 3.0F);
  const Outcome outcome =
      run({"--runs", path("reference.exr"), path("three.pfm"), "--reference", path("reference.exr"), "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const auto json = nlohmann::json::parse(outcome.out);
  const auto value = [&](const char* name) { return json.at(name).at("value").get<double>(); };
  EXPECT_NEAR(value("mse"), 2.0, 1e-14);  // small integers
  EXPECT_NEAR(value("variance"), 2.0, 1e-14);
  EXPECT_NEAR(value("bias_squared"), 0.0, 1e-14);
  EXPECT_NEAR(value("rel_mse"), 2.0 / 1.0025, 1e-14);
  EXPECT_NEAR(value("mean_signed_difference"), 1.0, 1e-14);
  EXPECT_NEAR(json.at("mean_signed_difference").at("standard_error").get<double>(), 1.0, 1e-14);
  EXPECT_TRUE(json.at("bias_squared").at("standard_error").is_null());  // two runs do not tell
  EXPECT_FALSE(json.contains("t_test"));
}

// Oracle: two references of 0.5 and 1.5 have a variance of 0.25, as one of that variance.
TEST_F(Compare, SeveralReferencesOrAVariance) {
  write("low.pfm", 0.5F);
  write("quarter.pfm", 0.25F);
  const std::vector<std::string> runs{"--runs", path("reference.exr"), path("brighter.pfm"), "--json", "--reference"};
  std::vector<std::string> several = runs, known = runs;
  several.insert(several.end(), {path("low.pfm"), path("brighter.pfm")});
  known.insert(known.end(), {path("reference.exr"), "--reference-variance", path("quarter.pfm")});
  for (const auto& arguments : {several, known}) {
    const Outcome outcome = run(arguments);
    ASSERT_EQ(outcome.code, 0) << outcome.errors;
    const auto json = nlohmann::json::parse(outcome.out);
    EXPECT_NEAR(json.at("reference_variance").get<double>(), 0.25, 1e-14);
    EXPECT_NEAR(json.at("bias_squared").at("value").get<double>(), -0.25, 1e-14);  // 0.25^2 - 0.125 / 2 - 0.25
  }
}

// Oracle: equal runs above an exact reference have no noise: any difference fails; equal to it, they pass.
TEST_F(Compare, TTestDecidesTheExitCode) {
  const auto test = [&](const std::string& image, const std::string& tolerance) {
    return run({"--runs", path(image), path(image), "--reference", path("reference.exr"), "--test-level", "0.01",
                "--test-block", "2", "--test-tolerance", tolerance});
  };
  EXPECT_EQ(test("reference.exr", "0").code, 0);
  EXPECT_EQ(test("brighter.pfm", "0").code, 1);
  EXPECT_EQ(test("brighter.pfm", "0.5").code, 0);
  EXPECT_THAT(test("brighter.pfm", "0").out, HasSubstr("3 of 3 block-channels fail"));
}

// Oracle: 1 of equal images; left out where the window does not fit.
TEST_F(Compare, SsimNeedsElevenPixels) {
  image_io::write_image(path("large.pfm"), Image<float>(11, 11, Rgb<float>(1.0F)));
  const auto ssim = [&](const std::string& name) {
    return nlohmann::json::parse(run({path(name), path(name), "--json"}).out).value("ssim", -1.0);
  };
  EXPECT_NEAR(ssim("large.pfm"), 1.0, 1e-13);  // rounding
  EXPECT_EQ(ssim("reference.exr"), -1.0);
}

TEST_F(Compare, HelpAndVersionSucceed) {
  const Outcome help = run({"--help"});
  EXPECT_EQ(help.code, 0);
  EXPECT_THAT(help.out, HasSubstr("--variance"));
  EXPECT_EQ(help.errors, "");
  EXPECT_EQ(run({"--version"}).code, 0);
}

TEST_F(Compare, BadCommandLines) {
  expect_error({}, "image");
  expect_error({path("reference.exr")}, "reference");
  expect_error({path("reference.exr"), path("reference.exr"), "--sharpen"}, "--sharpen");
  expect_error({path("reference.exr"), path("reference.exr"), "--spp", "many"}, "--spp");
  expect_error({path("reference.exr"), path("reference.exr"), "--spp", "4"}, "--variance");
  expect_error({path("reference.exr"), path("reference.exr"), "--variance", path("reference.exr")}, "--spp");
  expect_error({path("reference.exr"), path("reference.exr"), "--variance", path("reference.exr"), "--spp", "0"},
               "samples per pixel is 0");
  expect_error({path("reference.exr"), path("reference.exr"), "--difference", path("d.exr"), "--difference-range",
                "0"}, "range");
  EXPECT_FALSE(fs::exists(path("d.exr")));
  const std::string image = path("reference.exr");
  expect_error({"--runs", image, image}, "--reference");
  expect_error({"--runs", image, "--reference", image}, "1 runs given, at least 2");
  expect_error({image, image, "--runs", image, "--reference", image}, "--runs");
  expect_error({image, image, "--test-level", "0.1"}, "--runs");
  expect_error({"--runs", image, image, "--reference", image, "--test-level", "2"}, "--test-level");
  expect_error({"--runs", image, image, "--reference", image, "--test-level", "0.1", "--test-block", "0"}, "block");
  expect_error({"--runs", image, path("missing.exr"), "--reference", image}, "missing.exr: no such file");
  expect_error({"--runs", image, image, "--reference", image, image, "--reference-variance", image}, "variance");
}

TEST_F(Compare, BadFiles) {
  image_io::write_image(path("wide.exr"), Image<float>(3, 2));
  write("nan.exr", std::numeric_limits<float>::quiet_NaN());
  std::ofstream(path("text.exr")) << "not an image";
  expect_error({path("missing.exr"), path("reference.exr")}, "missing.exr: no such file");
  expect_error({path("wide.exr"), path("reference.exr")}, "the image has 3 x 2 pixels, the reference 2 x 2");
  expect_error({path("nan.exr"), path("reference.exr")}, "not finite at pixel (0, 0)");
  expect_error({path("text.exr"), path("reference.exr")}, "text.exr");
  expect_error({path("reference.exr"), path("reference.exr"), "--difference", path("d.gif")}, "'.gif'");
  expect_error({path("reference.exr"), path("reference.exr"), "--difference", path("nowhere/d.png")}, "folder");
}

}  // namespace
}  // namespace manylight::compare::compare_test
