// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "manylight/integrator/bidirectional_image.hpp"
#include "manylight/integrator/ledger.hpp"
#include "manylight/integrator/many_light.hpp"

namespace manylight::render {

/// The light side of the first pass.
struct LightReport {
  std::size_t vpls = 0;
  std::size_t bytes = 0;  ///< of the VPLs and their tree
  std::size_t light_paths = 0;
  double mean_intensity = 0;  ///< W
  double adaptation_luminance = 0;
  bool is_adaptation_fallback = false;
  float clamp = 0;  ///< infinite: none
};

/// What the passes of a many-light method summed up to.
struct PixelReport {
  std::uint32_t passes = 1;
  std::uint32_t eye_paths = 1;  ///< per pixel and pass
  double seconds = 0;
  bool has_cuts = false;
  std::vector<std::uint32_t> cut_sizes;  ///< per pixel, means over passes
};

/// What `--stats` writes, docs/program.md; names are those of the document. JSON is hidden in here, since it takes long to
/// compile.
class Statistics {
 public:
  Statistics();
  ~Statistics();
  Statistics(Statistics&&) noexcept;
  Statistics& operator=(Statistics&&) noexcept;

  [[nodiscard]] nlohmann::json& json() noexcept { return *json_; }

  void add_rays(const RayCounts& rays);
  void set_seconds(const char* of_what, double seconds);
  void set_interrupted(bool is_interrupted);
  void set_samples(std::uint32_t samples_per_pixel, std::uint64_t invalid);
  void set_lights(const LightReport& report);
  void set_pixels(const PixelReport& report, const ManyLightStatistics& sums);
  void set_ledger(const Ledger& ledger, std::uint32_t samples_per_pixel);
  /// Mean luminance that a strategy of bidirectional path tracing contributes, W/m^2/sr.
  void set_strategy(const std::string& strategy, double luminance);

 private:
  std::unique_ptr<nlohmann::json> json_;
};

}  // namespace manylight::render
