// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "manylight/integrator/film.hpp"

namespace manylight::render {

enum class Method { path, bdpt, pppm, photonmap, vpl, ir, lightcuts, bdlc };
enum class Weights { standard, four, residual, kollig_keller, full };
enum class BoundsKind { automatic, analytic, cube_map };
enum class Backend { bvh, embree };
enum class SamplerKind { independent, sobol };

/// What the command line asks for; absent values are left to the scene file or to the method's default.
struct Options {
  std::string scene;
  Method method = Method::bdlc;
  std::vector<std::string> outputs;
  std::optional<std::uint32_t> width, height;
  std::optional<Window> window;  ///< pixels to render; none: all
  std::uint32_t spp = 64;                 ///< at most
  std::uint32_t passes = 1;               ///< at most; whole images of the many-light methods
  std::uint32_t eye_paths = 64;
  std::uint64_t vpls = 1'000'000;
  std::uint64_t photon_paths = 200'000;  ///< light paths of photons: of a pass of pppm, of the map of photonmap
  std::uint32_t gather_rays = 2;         ///< of photonmap, per sample
  std::uint32_t light_samples = 4;       ///< of photonmap, per sample
  std::uint32_t instants = 32;  ///< of the shutter interval, where something moves
  double threshold = 0.02;
  std::uint32_t max_cut = 20'000;
  std::optional<int> max_depth;  ///< edges; -1 unlimited
  bool straight_is_free = false;  ///< light straight through a thin pane costs no edge; path only
  Backend backend = Backend::bvh;
  SamplerKind sampler = SamplerKind::sobol;
  std::string filter;  ///< box, tent or gaussian; empty: from the file
  std::uint64_t seed = 0;
  std::uint32_t threads = 0;
  std::optional<double> time_limit;       ///< s
  std::optional<double> progress_images;  ///< s between them; none: no images before the last one
  Weights weights = Weights::four;
  BoundsKind bounds = BoundsKind::automatic;  ///< of materials, in cuts
  double clamp_scale = 1.0 / 800;    ///< 0: no clamp
  double adaptation_luminance = 0;   ///< 0: estimated
  bool hits_after_dirac_only = false;
  bool compensates = false;          ///< ir gives back what its clamp takes
  std::optional<std::uint32_t> ledger_spp;  ///< samples of the ledger of missing energy; none: no ledger
  std::string stats;
  std::string strategy_images;  ///< folder; empty: none
  std::map<std::string, std::string> aovs;  ///< name -> file
  std::map<std::string, std::string> defines;
  float exposure = 0;  ///< stops
  bool lenient = false;
  bool quiet = false;
};

/// Samples or passes where only the time limits them.
inline constexpr std::uint32_t k_max_samples = 1U << 24U;

[[nodiscard]] constexpr bool is_many_light(Method method) noexcept {
  return method == Method::vpl || method == Method::ir || method == Method::lightcuts || method == Method::bdlc;
}
[[nodiscard]] constexpr bool has_cuts(Method method) noexcept {
  return method == Method::lightcuts || method == Method::bdlc;
}

/// As on the command line.
[[nodiscard]] const char* method_name(Method method);

/// Names of the auxiliary images that `--aov` knows.
[[nodiscard]] const std::vector<std::string>& aov_names();

/// Parses the command line. Prints help or the version and returns nothing if asked for; throws ParameterError.
[[nodiscard]] std::optional<Options> parse_options(int argc, const char* const* argv);

}  // namespace manylight::render
