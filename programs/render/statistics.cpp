// SPDX-License-Identifier: Apache-2.0
#include "render/statistics.hpp"

#include <algorithm>
#include <numeric>

#include <nlohmann/json.hpp>

namespace manylight::render {

namespace {

/// Mean, median, 99th percentile and maximum.
[[nodiscard]] nlohmann::json distribution(std::vector<std::uint32_t> values) {
  if (values.empty()) return nullptr;
  std::sort(values.begin(), values.end());
  const double sum = std::accumulate(values.begin(), values.end(), 0.0);
  const auto at = [&](double p) {
    return values[static_cast<std::size_t>(p * static_cast<double>(values.size() - 1) + 0.5)];
  };
  return {{"mean", sum / static_cast<double>(values.size())},
          {"median", at(0.5)},
          {"percentile_99", at(0.99)},
          {"maximum", values.back()}};
}

}  // namespace

Statistics::Statistics()
    : json_(std::make_unique<nlohmann::json>(nlohmann::json{{"rays", {{"closest", 0}, {"shadow", 0}}}})) {}
Statistics::~Statistics() = default;
Statistics::Statistics(Statistics&&) noexcept = default;
Statistics& Statistics::operator=(Statistics&&) noexcept = default;

void Statistics::add_rays(const RayCounts& rays) {
  nlohmann::json& json = (*json_)["rays"];
  json["closest"] = json["closest"].get<std::uint64_t>() + rays.closest;
  json["shadow"] = json["shadow"].get<std::uint64_t>() + rays.shadow;
}

void Statistics::set_seconds(const char* of_what, double seconds) { (*json_)["seconds"][of_what] = seconds; }

void Statistics::set_interrupted(bool is_interrupted) { (*json_)["interrupted"] = is_interrupted; }

void Statistics::set_samples(std::uint32_t samples_per_pixel, std::uint64_t invalid) {
  (*json_)["samples_per_pixel"] = samples_per_pixel;
  (*json_)["invalid_samples"] = invalid;
}

void Statistics::set_lights(const LightReport& report) {
  nlohmann::json& json = *json_;
  const auto count = static_cast<double>(report.vpls);
  json["vpls"] = {{"count", report.vpls},
                  {"light_paths", report.light_paths},
                  {"bytes_per_vpl", report.vpls > 0 ? static_cast<double>(report.bytes) / count : 0.0},
                  {"mean_intensity_w", report.mean_intensity}};
  json["adaptation_luminance"] = report.adaptation_luminance;
  json["adaptation_is_fallback"] = report.is_adaptation_fallback;
  json["clamp"] = report.clamp < k_infinity<float> ? nlohmann::json(report.clamp) : nlohmann::json(nullptr);
}

void Statistics::set_pixels(const PixelReport& report, const ManyLightStatistics& sums) {
  nlohmann::json& json = *json_;
  add_rays(sums.eye_rays);
  add_rays(sums.pairs.rays);
  set_seconds("pixels", report.seconds);
  json["passes"] = report.passes;
  json["eye_paths_per_pixel"] = std::uint64_t{report.eye_paths} * report.passes;
  json["sensors"] = sums.sensors;
  json["pairs"] = sums.pairs.pairs;
  json["cut"] = report.has_cuts ? distribution(report.cut_sizes) : nlohmann::json(nullptr);
  json["capped_pixels"] = sums.capped_pixels;
  json["bound_violations"] = sums.pairs.bound_violations;
  json["invalid_samples"] = sums.invalid_samples;
}

void Statistics::set_ledger(const Ledger& ledger, std::uint32_t samples_per_pixel) {
  const auto entry = [&](const LedgerMean& mean) {
    const double truth = ledger.truth.luminance > 0 ? ledger.truth.luminance : 1;
    return nlohmann::json{{"luminance", mean.luminance},
                          {"standard_error", mean.luminance_error},
                          {"share", mean.luminance / truth}};
  };
  nlohmann::json& json = (*json_)["missing"];
  json = {{"samples_per_pixel", samples_per_pixel},
          {"invalid_samples", ledger.invalid},
          {"truth", entry(ledger.truth)},
          {"total", entry(ledger.total)}};
  for (std::size_t e = 0; e < k_ledger_entries; ++e) {
    std::string key(name(static_cast<LedgerEntry>(e)));
    std::replace(key.begin(), key.end(), ' ', '_');
    json["entries"][key] = entry(ledger.entries[e]);
  }
}

void Statistics::set_strategy(const std::string& strategy, double luminance) {
  (*json_)["strategies"][strategy] = luminance;
}

}  // namespace manylight::render
