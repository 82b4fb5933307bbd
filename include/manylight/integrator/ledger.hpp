// SPDX-License-Identifier: Apache-2.0
#pragma once

// The ledger of missing energy: how much radiance a weighting leaves out of its image, where, and why (theory sheet,
// section 4). A path tracer draws whole paths f/p, emitter hits and next event estimation by MIS as in PathIntegrator,
// and asks for each what its generators would take of it:
//
//   image of the weighting + missing = truth,    missing = E[(1 - sum w) f/p] >= 0, per pixel and exact in expectation
//
// It is noisy where the weighting chose bias over noise. Paths that a path tracer cannot draw (point and directional
// lights through mirrors or smooth glass) stand on neither side, though virtual point lights may have brought some of
// them into the image. Random numbers are those of Stage::ledger: independent of any image.

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "manylight/integrator/ledger_sample.hpp"

namespace manylight {

/// A mean over the window with its standard error, from samples taken as independent, W/m^2/sr; of a stratified sampler
/// the true error is smaller.
struct LedgerMean {
  Rgb<double> rgb{0};
  Rgb<double> rgb_error{0};
  double luminance = 0;
  double luminance_error = 0;
};

/// What is missing of an image.
struct Ledger {
  std::vector<Rgb<double>> missing;  ///< per pixel of the window, row by row, W/m^2/sr: add it to the image
  LedgerMean truth;
  LedgerMean total;                                  ///< missing, over all entries
  std::array<LedgerMean, k_ledger_entries> entries;  ///< by LedgerEntry
  RayCounts rays;
  std::uint64_t samples = 0;
  std::uint64_t invalid = 0;  ///< samples that were not finite or negative: dropped and counted

  [[nodiscard]] const LedgerMean& entry(LedgerEntry e) const noexcept { return entries[static_cast<std::size_t>(e)]; }
  /// Part of the window's luminance that is missing for the reason `e`, [0, 1]; 0 where all is dark.
  [[nodiscard]] double share(LedgerEntry e) const noexcept {
    return truth.luminance > 0 ? entry(e).luminance / truth.luminance : 0.0;
  }
  /// Part of the window's luminance that is missing, [0, 1].
  [[nodiscard]] double share() const noexcept { return truth.luminance > 0 ? total.luminance / truth.luminance : 0.0; }
};

namespace detail {

/// Red, green, blue and luminance of one quantity: sums over a pixel's samples.
struct LedgerPixelSum {
  std::array<double, 4> sum{};
  std::array<double, 4> squares{};

  void add(const Rgb<double>& c) noexcept {
    const std::array<double, 4> x{c.x, c.y, c.z, luminance(c)};
    for (std::size_t i = 0; i < x.size(); ++i) {
      sum[i] += x[i];
      squares[i] += x[i] * x[i];
    }
  }
};

/// Sums over pixels of pixel means and of their variances.
struct LedgerWindowSum {
  std::array<double, 4> mean{};
  std::array<double, 4> variance{};

  void add(const LedgerPixelSum& pixel, double n) noexcept {
    for (std::size_t i = 0; i < mean.size(); ++i) {
      mean[i] += pixel.sum[i] / n;
      variance[i] += std::max(0.0, pixel.squares[i] - pixel.sum[i] * pixel.sum[i] / n) / ((n - 1) * n);
    }
  }
  void add(const LedgerWindowSum& other) noexcept {
    for (std::size_t i = 0; i < mean.size(); ++i) {
      mean[i] += other.mean[i];
      variance[i] += other.variance[i];
    }
  }
  [[nodiscard]] LedgerMean result(double pixels) const noexcept {
    const auto error = [&](std::size_t i) { return std::sqrt(variance[i]) / pixels; };
    return {
        Rgb<double>(mean[0], mean[1], mean[2]) / pixels, {error(0), error(1), error(2)}, mean[3] / pixels, error(3)};
  }
};

/// A tile's share of a ledger: truth, total, then the entries.
struct LedgerTile {
  std::array<LedgerWindowSum, k_ledger_entries + 2> sums{};
  RayCounts rays;
  std::uint64_t invalid = 0;
};

/// Samples [first, first + count) of one pixel into `tile`; returns the pixel's mean of what is missing.
template <class Scene, class W, Sampler Random, class MakeRay>
[[nodiscard]] Rgb<double> ledger_pixel(const LedgerIntegrator<Scene, W>& integrator, const Random& sampler,
                                       const MakeRay& make_ray, std::uint64_t index, std::uint32_t first,
                                       std::uint32_t count, LedgerTile& tile) {
  std::array<LedgerPixelSum, k_ledger_entries + 2> sums{};
  for (std::uint32_t i = first; i < first + count; ++i) {
    auto stream = sampler.stream(Stage::ledger, index, i);
    const std::uint32_t instant = sample_instant(instant_count(integrator), sampler, index, i);
    const auto ray = make_ray(stream, instant);
    const LedgerSample sample = at_instant(integrator, instant).sample(ray, stream, tile.rays);
    if (!sample.is_valid()) {
      ++tile.invalid;
      continue;
    }
    sums[0].add(sample.truth);
    sums[1].add(sample.missing);
    for (std::size_t e = 0; e < k_ledger_entries; ++e) sums[2 + e].add(sample.entries[e]);
  }
  const double n = count;
  for (std::size_t i = 0; i < sums.size(); ++i) tile.sums[i].add(sums[i], n);
  return {sums[1].sum[0] / n, sums[1].sum[1] / n, sums[1].sum[2] / n};
}

}  // namespace detail

/// Estimates the ledger of `window` by samples [first, first + count) of every pixel, at least two; different ranges
/// are independent estimates if the sampler's numbers are. Throws ParameterError.
template <class Scene, class W, Camera C, Sampler Random, Executor Exec, class Progress = NoProgress>
[[nodiscard]] Ledger estimate_ledger(const LedgerIntegrator<Scene, W>& integrator, const C& camera,
                                     const ReconstructionFilter<typename Scene::Scalar>& filter, const Window& window,
                                     const Random& sampler, std::uint32_t first, std::uint32_t count,
                                     const Exec& executor, const Progress& progress = {}) {
  require(count >= 2, "samples per pixel of the ledger", count, "at least 2: one has no error");
  window.validate(camera.width(), camera.height());
  Ledger ledger;
  ledger.missing.assign(window.pixel_count(), Rgb<double>(0));
  const auto render_tile = [&](const Window& tile) {
    detail::LedgerTile result;
    for (std::uint32_t y = tile.y0; y < tile.y1; ++y) {
      for (std::uint32_t x = tile.x0; x < tile.x1; ++x) {
        ledger.missing[window.index(x, y)] = detail::ledger_pixel(
            integrator, sampler,
            [&](auto& stream, std::uint32_t instant) {
              return camera_ray(at_instant(camera, instant), filter, x, y, stream);
            },
            film_index(camera, x, y), first, count, result);
      }
    }
    return result;
  };
  detail::LedgerTile all;
  for (const detail::LedgerTile& tile : for_each_tile(window, executor, render_tile, progress)) {
    for (std::size_t i = 0; i < all.sums.size(); ++i) all.sums[i].add(tile.sums[i]);
    ledger.rays += tile.rays;
    ledger.invalid += tile.invalid;
  }
  const auto pixels = static_cast<double>(window.pixel_count());
  ledger.samples = window.pixel_count() * std::uint64_t{count};
  ledger.truth = all.sums[0].result(pixels);
  ledger.total = all.sums[1].result(pixels);
  for (std::size_t e = 0; e < k_ledger_entries; ++e) ledger.entries[e] = all.sums[2 + e].result(pixels);
  return ledger;
}

}  // namespace manylight
