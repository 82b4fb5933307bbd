// SPDX-License-Identifier: Apache-2.0
#pragma once

// Images by bidirectional path tracing. What eye walks find belongs to their pixel; what light walks find on the lens falls
// anywhere: tiles keep it in lists, which are added up in the order of tiles, so that threads do not matter.

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

#include "manylight/integrator/bidirectional_path.hpp"

namespace manylight {

/// Images of single strategies (s, t), for paths of 1 to `max_edges` segments.
struct StrategyImages {
  struct Strategy {
    std::vector<Rgb<double>> unweighted, weighted;  ///< sums per pixel of the window, W/m^2/sr
  };
  unsigned max_edges = 0;  ///< 0: none
  std::vector<Strategy> strategies;

  StrategyImages() = default;
  StrategyImages(unsigned longest, std::size_t pixels)
      : max_edges(longest), strategies(place(longest + 1, 0)) {
    for (Strategy& strategy : strategies) {
      strategy.unweighted.assign(pixels, Rgb<double>(0));
      strategy.weighted.assign(pixels, Rgb<double>(0));
    }
  }

  [[nodiscard]] bool has(unsigned s, unsigned t) const noexcept { return s + t >= 2 && s + t - 1 <= max_edges; }
  [[nodiscard]] Strategy& at(unsigned s, unsigned t) noexcept { return strategies[place(s + t - 1, s)]; }
  [[nodiscard]] const Strategy& at(unsigned s, unsigned t) const noexcept { return strategies[place(s + t - 1, s)]; }
  template <std::floating_point S>
  void add(unsigned s, unsigned t, std::size_t pixel, const PathContribution<S>& found, double filter) noexcept {
    if (!has(s, t)) return;
    at(s, t).unweighted[pixel] += Rgb<double>(found.value) * filter;
    at(s, t).weighted[pixel] += Rgb<double>(found.value) * (static_cast<double>(found.weight) * filter);
  }

 private:
  /// Paths of n segments have the strategies s = 0 ... n.
  [[nodiscard]] static std::size_t place(unsigned edges, unsigned s) noexcept {
    return std::size_t{edges} * (edges + 1) / 2 - 1 + s;
  }
};

/// Sums over samples, per pixel of a window, row by row, W/m^2/sr; divided by the samples per pixel, eye + light is the image.
struct BidirectionalSums {
  std::vector<Rgb<double>> eye;    ///< t >= 2
  std::vector<Rgb<double>> light;  ///< t = 1
  StrategyImages strategies;

  /// `strategy_edges`: longest paths of which every strategy gets images of its own, two of them, 0 for none.
  explicit BidirectionalSums(std::size_t pixels, unsigned strategy_edges = 0)
      : eye(pixels, Rgb<double>(0)), light(pixels, Rgb<double>(0)) {
    if (strategy_edges > 0) strategies = StrategyImages(strategy_edges, pixels);
  }
};

namespace detail {

/// What a light walk found, for a pixel of the window.
template <std::floating_point S>
struct Splat {
  std::uint32_t pixel;
  std::uint16_t s;
  S filter;  ///< filter's value, pixels^-2
  PathContribution<S> found;
};

/// What a tile's task hands back.
template <std::floating_point S>
struct TileSplats {
  std::vector<Splat<S>> splats;
  PathStatistics statistics;
};

/// Appends a splat for every pixel of the window whose filter reaches the place on the film.
template <std::floating_point S>
void splat(const LensContribution<S>& found, unsigned s, const ReconstructionFilter<S>& filter, const Window& window,
           std::vector<Splat<S>>& splats) {
  const S radius = filter.radius();
  const auto range = [&](S film, std::uint32_t low, std::uint32_t high, S& begin, S& end) {
    // In floating point: the place may be far outside of any integer. NaN gives an empty range.
    begin = std::max(static_cast<S>(low), std::ceil(film - radius - S(0.5)));
    end = std::min(static_cast<S>(high) - S(1), std::floor(film + radius - S(0.5)));
    return begin <= end;
  };
  S x0, x1, y0, y1;
  if (!range(found.film.x, window.x0, window.x1, x0, x1) || !range(found.film.y, window.y0, window.y1, y0, y1)) return;
  for (S y = y0; y <= y1; y += S(1)) {
    for (S x = x0; x <= x1; x += S(1)) {
      const S value = filter.eval(found.film - Vec2<S>(x + S(0.5), y + S(0.5)));
      if (!(value > S(0))) continue;
      const auto pixel = window.index(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y));
      splats.push_back({static_cast<std::uint32_t>(pixel), static_cast<std::uint16_t>(s), value, found});
    }
  }
}

/// Renders samples of tiles.
template <class Integrator, class Scene, Camera C, Sampler Random>
class BidirectionalTiles {
 public:
  using S = typename Scene::Scalar;

  BidirectionalTiles(const Integrator& integrator, const C& camera, const ReconstructionFilter<S>& filter,
                     const Window& window, const Random& sampler, BidirectionalSums& sums)
      : integrator_(integrator), camera_(camera), filter_(filter), window_(window), sampler_(sampler), sums_(sums) {}

  /// Sample `i` of every pixel of `tile`; what eye walks find goes to the pixels' own sums.
  void render(const Window& tile, std::uint32_t i, TileSplats<S>& out) {
    SubpathPair<Scene> walks;
    out.splats.clear();
    out.statistics = {};
    for (std::uint32_t y = tile.y0; y < tile.y1; ++y) {
      for (std::uint32_t x = tile.x0; x < tile.x1; ++x) render(x, y, i, walks, out);
    }
  }
  void add_splats(const TileSplats<S>& tile) {
    for (const Splat<S>& splat : tile.splats) {
      const double share = static_cast<double>(splat.found.weight) * static_cast<double>(splat.filter);
      sums_.light[splat.pixel] += Rgb<double>(splat.found.value) * share;
      sums_.strategies.add(splat.s, 1u, splat.pixel, splat.found, static_cast<double>(splat.filter));
    }
  }

 private:
  void render(std::uint32_t x, std::uint32_t y, std::uint32_t i, SubpathPair<Scene>& walks, TileSplats<S>& out) {
    const std::uint64_t index = film_index(camera_, x, y);
    const std::uint32_t instant = sample_instant(instant_count(integrator_), sampler_, index, i);
    const auto& camera = at_instant(camera_, instant);
    const auto& integrator = at_instant(integrator_, instant);
    const bool is_seen = x >= window_.x0 && x < window_.x1 && y >= window_.y0 && y < window_.y1;
    if (!is_seen && !integrator.template uses_lens<std::remove_cvref_t<decltype(camera)>>()) return;
    const S light_paths = static_cast<S>(camera_.width()) * static_cast<S>(camera_.height());
    PathStatistics& statistics = out.statistics;

    auto light_stream = sampler_.stream(Stage::light, index, i);
    integrator.trace_light(camera, light_paths, light_stream, statistics.rays, walks.light,
                           [&](unsigned s, const LensContribution<S>& found) {
                             if (is_valid_radiance(found.value * filter_peak_)) {
                               splat(found, s, filter_, window_, out.splats);
                             } else {
                               ++statistics.invalid;
                             }
                           });
    if (!is_seen) return;
    auto stream = sampler_.stream(Stage::eye, index, i);
    const Ray<S> ray = camera_ray(camera, filter_, x, y, stream);
    const std::size_t pixel = window_.index(x, y);
    Rgb<S> sum(0);
    integrator.trace_eye(camera, ray, light_paths, stream, statistics.rays, walks,
                         [&](unsigned s, unsigned t, const PathContribution<S>& found) {
                           // A share of 0 of a value that is not finite is nothing.
                           if (found.weight > S(0)) sum += found.value * found.weight;
                           if (is_valid_radiance(found.value)) sums_.strategies.add(s, t, pixel, found, 1.0);
                         });
    ++statistics.samples;
    if (is_valid_radiance(sum)) {
      sums_.eye[pixel] += Rgb<double>(sum);
    } else {
      ++statistics.invalid;
    }
  }

  const Integrator& integrator_;
  const C& camera_;
  const ReconstructionFilter<S>& filter_;
  Window window_;
  const Random& sampler_;
  BidirectionalSums& sums_;
  S filter_peak_ = filter_.eval(Vec2<S>(0));
};

}  // namespace detail

/// Adds samples [first, first + count) of every pixel of `window` to `sums`: call it with consecutive ranges to refine an
/// image; neither the split into ranges nor the executor changes a bit of it. Light walks belong to the pixels of the whole
/// film, one per sample of each: with a LensCamera a window costs the light walks of all, and has the bits of the same pixels
/// of the whole image. Besides `sums` it takes memory for what the light walks of 32768 samples find. Throws ParameterError
/// unless the window lies in the film and the sums have a place for each of its pixels.
template <class Scene, Camera C, Sampler Random, Executor Exec, class Progress = NoProgress>
PathStatistics accumulate_bidirectional_samples(const BidirectionalPathIntegrator<Scene>& integrator, const C& camera,
                                                const ReconstructionFilter<typename Scene::Scalar>& filter,
                                                const Window& window, const Random& sampler, std::uint32_t first,
                                                std::uint32_t count, BidirectionalSums& sums, const Exec& executor,
                                                const Progress& progress = {}) {
  using SceneNow = std::remove_cvref_t<decltype(at_instant(integrator, 0).scene())>;
  using S = typename Scene::Scalar;
  window.validate(camera.width(), camera.height());
  require(sums.eye.size() == window.pixel_count() && sums.light.size() == window.pixel_count(), "number of sums",
          sums.eye.size(), "one per pixel of the window: " + std::to_string(window.pixel_count()));
  detail::BidirectionalTiles<BidirectionalPathIntegrator<Scene>, SceneNow, C, Random> tiles(integrator, camera, filter,
                                                                                            window, sampler, sums);
  constexpr std::size_t k_batch = 128;
  const std::uint32_t tiles_x = (camera.width() + k_tile_size - 1) / k_tile_size;
  const std::size_t tile_count = std::size_t{tiles_x} * ((camera.height() + k_tile_size - 1) / k_tile_size);
  std::vector<detail::TileSplats<S>> results(std::min(k_batch, tile_count));
  std::atomic<std::size_t> done{0};
  PathStatistics total;
  for (std::uint32_t i = first; i < first + count; ++i) {
    for (std::size_t begin = 0; begin < tile_count; begin += k_batch) {
      const std::size_t size = std::min(k_batch, tile_count - begin);
      executor.for_each_index(size, [&](std::size_t k) {
        const auto x = static_cast<std::uint32_t>((begin + k) % tiles_x) * k_tile_size;
        const auto y = static_cast<std::uint32_t>((begin + k) / tiles_x) * k_tile_size;
        tiles.render({x, y, std::min(x + k_tile_size, camera.width()), std::min(y + k_tile_size, camera.height())}, i,
                     results[k]);
        progress(++done, tile_count * count);
      });
      for (std::size_t k = 0; k < size; ++k) {
        tiles.add_splats(results[k]);
        total += results[k].statistics;
      }
    }
  }
  return total;
}

}  // namespace manylight
