// SPDX-License-Identifier: Apache-2.0
#pragma once

// What all many-light methods share: light subpaths first, then per pixel eye subpaths, whose sensors a PairSum connects
// with the lights. A method is a choice of weighting and pair sum.

#include <cstdint>
#include <optional>
#include <vector>

#include "manylight/integrator/adaptation.hpp"
#include "manylight/many_light/cut.hpp"
#include "manylight/many_light/pair_sum.hpp"

namespace manylight {

/// Parameters of the many-light methods.
struct ManyLightConfig {
  std::size_t vpls = 1'000'000;            ///< virtual point lights left by light paths, see VplConfig
  unsigned eye_paths = 64;                 ///< eye samples per pixel, >= 1
  unsigned max_edges = k_unlimited_edges;  ///< longest path, segments
  double threshold = 0.02;                 ///< lightcuts: relative error bound of a cluster, [0, 1]
  std::uint32_t max_cut = 20000;           ///< lightcuts: most clusters per pixel
  double adaptation_luminance = 0;         ///< L_a, W/m^2/sr; 0: estimated by a pilot
  double clamp_scale = 1.0 / 800;          ///< C_clamp = clamp_scale L_a / I_avg; infinity: no clamp
  double c_d = 1, c_v = 1, c_m = 100;      ///< see WeightingConfig, sr^-1
  EmitterHits emitter_hits = EmitterHits::all;
  std::optional<Window> window = std::nullopt;  ///< pixels to render; none: the whole film

  /// Throws ParameterError.
  void validate() const {
    require(vpls >= 1, "number of virtual point lights", vpls, "at least 1");
    require(eye_paths >= 1 && eye_paths <= 65536, "eye paths per pixel", eye_paths, "1 to 65536");
    require(max_edges >= 1, "maximum path length", max_edges, "at least 1 segment");
    require(threshold >= 0 && threshold <= 1, "cut threshold", threshold, "[0, 1]");
    require(max_cut >= 1, "maximum cut", max_cut, "at least 1");
    require(adaptation_luminance >= 0 && std::isfinite(adaptation_luminance), "adaptation luminance",
            adaptation_luminance, "finite, at least 0 (0: estimated)");
    require(clamp_scale > 0, "clamp scale", clamp_scale, "above 0");
    require(c_d > 0 && c_v > 0 && c_m > 0, "directionality limit", std::min(c_d, std::min(c_v, c_m)), "above 0");
    require(c_v <= c_d, "limit C_V", c_v, "at most C_D");
  }
};

/// The light side of a view: VPLs and the constants of its weights.
template <class Scene>
struct LightSide {
  VplSet<Scene> lights;
  double adaptation_luminance = 1;     ///< L_a, W/m^2/sr
  bool is_adaptation_fallback = false; ///< nothing was lit: L_a is 1 by convention
  WeightingConfig<typename Scene::Scalar> weights;
  RayCounts rays;
};

/// Traces the VPLs and fixes C_clamp = L_a / (800 I_avg) [Walter 2012, Eq. 6].
template <class Scene, Camera C, Sampler Random, Executor Exec>
[[nodiscard]] LightSide<Scene> prepare_lights(const Scene& scene, const C& camera,
                                              const ReconstructionFilter<typename Scene::Scalar>& filter,
                                              const ManyLightConfig& config, const Random& sampler,
                                              const Exec& executor) {
  using S = typename Scene::Scalar;
  config.validate();
  LightSide<Scene> side;
  side.lights = trace_vpls(scene, VplConfig{config.vpls, config.max_edges}, sampler, executor, side.rays);
  side.adaptation_luminance = config.adaptation_luminance > 0
                                  ? config.adaptation_luminance
                                  : adaptation_luminance(scene, camera, filter, side.lights.vpls, config.max_edges,
                                                         sampler, executor, side.rays);
  if (!(side.adaptation_luminance > 0)) {
    side.adaptation_luminance = 1;
    side.is_adaptation_fallback = true;
  }
  const double mean = static_cast<double>(side.lights.mean_intensity);
  const double clamp = mean > 0 ? config.clamp_scale * side.adaptation_luminance / mean : 1.0;
  side.weights = {static_cast<S>(std::min(clamp, static_cast<double>(k_infinity<S>))), static_cast<S>(config.c_d),
                  static_cast<S>(config.c_v), static_cast<S>(config.c_m), config.emitter_hits};
  return side;
}

/// What an image cost, besides its light side.
struct ManyLightStatistics {
  PairStatistics pairs;              ///< summed over pixels; `cut_size` is their sum
  RayCounts eye_rays;
  std::uint64_t sensors = 0;         ///< VPSs
  std::uint64_t capped_pixels = 0;
  std::uint64_t invalid_samples = 0; ///< dropped: not finite or negative
  std::vector<std::uint32_t> cut_sizes;  ///< per pixel of the window, row by row

  /// Adds the counts of a tile; `cut_sizes` belongs to the whole image.
  ManyLightStatistics& operator+=(const ManyLightStatistics& tile) noexcept {
    pairs += tile.pairs;
    eye_rays += tile.eye_rays;
    sensors += tile.sensors;
    capped_pixels += tile.capped_pixels;
    invalid_samples += tile.invalid_samples;
    return *this;
  }
};

/// An image of the window, W/m^2/sr, and what it cost.
template <std::floating_point S>
struct ManyLightImage {
  Image<S> image;
  ManyLightStatistics statistics;
};

namespace detail {

/// Collects what one pixel's eye subpaths find.
template <class Scene, class W>
struct PixelCollector {
  using S = typename Scene::Scalar;
  std::vector<Sensor<Scene, W>> sensors;
  Rgb<double> emitted{0};
  std::uint64_t invalid = 0;
  std::uint32_t instant = 0;  ///< of the eye subpath that is traced

  void clear() {
    sensors.clear();
    emitted = Rgb<double>(0);
  }
  void emission(const Rgb<S>& radiance) {
    if (is_valid_radiance(radiance)) {
      emitted += Rgb<double>(radiance);
    } else {
      ++invalid;
    }
  }
  void sensor(const Sensor<Scene, W>& vps) {
    if (!is_valid_radiance(vps.vertex.strength)) {
      ++invalid;
    } else if (max_channel(vps.vertex.strength) > S(0)) {
      sensors.push_back(vps);
      if constexpr (Scene::k_moves) sensors.back().vertex.instant = static_cast<InstantId>(instant);
    }
  }
};

/// Traces the eye subpaths of pixel (x, y) into `collector`.
template <class Scene, Camera C, Weighting W, Sampler Random>
void trace_pixel(const Scene& scene, const C& camera, const ReconstructionFilter<typename Scene::Scalar>& filter,
                 const ManyLightConfig& config, const W& weighting, const Random& sampler, std::uint32_t x,
                 std::uint32_t y, RayCounts& rays, PixelCollector<Scene, W>& collector) {
  using S = typename Scene::Scalar;
  collector.clear();
  for (std::uint32_t i = 0; i < config.eye_paths; ++i) {
    auto stream = sampler.stream(Stage::eye, film_index(camera, x, y), i);
    collector.instant = sample_instant(instant_count(scene), sampler, film_index(camera, x, y), i);
    const auto& now = at_instant(scene, collector.instant);
    const Ray<S> ray = camera_ray(at_instant(camera, collector.instant), filter, x, y, stream);
    EyeSubpath<std::remove_cvref_t<decltype(now)>, W, decltype(stream), PixelCollector<Scene, W>>(
        now, weighting, config.max_edges, stream, rays, collector)
        .trace(ray, S(1) / static_cast<S>(config.eye_paths));
  }
}

}  // namespace detail

/// Renders by eye subpaths of `weighting` and pair sums made by `make_sum()` (a PairSum per tile: callable with the
/// pixel's sensors, its known radiance and its key).
template <class Scene, Camera C, Weighting W, Sampler Random, Executor Exec, class MakeSum, class Progress = NoProgress>
[[nodiscard]] ManyLightImage<typename Scene::Scalar> render_many_light(
    const Scene& scene, const C& camera, const ReconstructionFilter<typename Scene::Scalar>& filter,
    const ManyLightConfig& config, const W& weighting, const MakeSum& make_sum, const Random& sampler,
    const Exec& executor, const Progress& progress = {}) {
  using S = typename Scene::Scalar;
  const Window window = config.window.value_or(Window::of(camera));
  window.validate(camera.width(), camera.height());
  ManyLightImage<S> result;
  result.image = Image<S>(window.width(), window.height());
  result.statistics.cut_sizes.resize(window.pixel_count());
  const auto render_tile = [&](const Window& tile) {
    detail::PixelCollector<Scene, W> collector;
    auto sum = make_sum();
    ManyLightStatistics statistics;
    for (std::uint32_t y = tile.y0; y < tile.y1; ++y) {
      for (std::uint32_t x = tile.x0; x < tile.x1; ++x) {
        detail::trace_pixel(scene, camera, filter, config, weighting, sampler, x, y, statistics.eye_rays, collector);
        auto key = sampler.stream(Stage::representative, film_index(camera, x, y), 0);
        const PairSumResult pairs = sum(collector.sensors, collector.emitted, random_bits(key));
        statistics.sensors += collector.sensors.size();
        statistics.pairs += pairs.statistics;
        statistics.capped_pixels += pairs.statistics.capped ? 1 : 0;
        result.statistics.cut_sizes[window.index(x, y)] = static_cast<std::uint32_t>(pairs.statistics.cut_size);
        result.image.pixels[window.index(x, y)] = Rgb<S>(collector.emitted + pairs.radiance);
      }
    }
    statistics.invalid_samples = collector.invalid + statistics.pairs.invalid;
    return statistics;
  };
  for (const ManyLightStatistics& tile : for_each_tile(window, executor, render_tile, progress)) {
    result.statistics += tile;
  }
  return result;
}

}  // namespace manylight
