// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "integrator/builders.hpp"
#include "manylight/integrator/ledger.hpp"

// The image of any weighting and the ledger of what it misses, estimated independently of each other, in double.

namespace manylight::test {

/// How much work the estimates are; the means of `runs` independent images give their error.
struct Numbers {
  unsigned max_edges = k_unlimited_edges;
  std::size_t vpls = 500;
  std::uint32_t eye_paths = 2;
  std::uint32_t ledger_samples = 200;
  unsigned runs = 12;
};

template <class SceneType, class W, Camera C>
Ledger ledger_of(const SceneType& scene, const W& weighting, const C& camera, const LedgerConfig& config,
                 std::uint32_t samples) {
  const LedgerIntegrator<SceneType, W> integrator(scene, weighting, config);
  return estimate_ledger(integrator, camera, ReconstructionFilter<double>::box(), Window::of(camera),
                         IndependentSampler<double>{77}, 0, samples, SerialExecutor{});
}

/// Film means of images by all pairs or by cuts, red channel, over independent sets of virtual point lights.
template <class SceneType, class W, Camera C>
[[nodiscard]] RunningMoments image_means(const SceneType& scene, const W& weighting, const C& camera,
                                         const Numbers& numbers, bool by_cuts) {
  const auto filter = ReconstructionFilter<double>::box();
  Settings settings;
  settings.vpls = numbers.vpls;
  settings.samples = numbers.eye_paths;
  settings.max_edges = numbers.max_edges;
  const ManyLightConfig config = many_light_config(settings);
  RunningMoments moments;
  for (unsigned run = 0; run < numbers.runs; ++run) {
    const IndependentSampler<double> sampler{1000 + run};
    const auto lights = prepare_lights(scene, camera, filter, config, sampler, SerialExecutor{});
    ManyLightImage<double> image;
    if (by_cuts) {
      const LightTree<SceneType> tree(lights.lights.vpls, SerialExecutor{});
      image = render_by_cuts(scene, camera, filter, config, weighting, lights, tree, sampler, SerialExecutor{});
      EXPECT_EQ(image.statistics.pairs.bound_violations, 0u);
    } else {
      image = render_all_pairs(scene, camera, filter, config, weighting, lights, sampler, SerialExecutor{});
    }
    EXPECT_EQ(image.statistics.invalid_samples, 0u);
    double sum = 0;
    for (const Rgb<double>& p : image.image.pixels) sum += p.x;
    moments.add(sum / static_cast<double>(image.image.pixels.size()));
  }
  return moments;
}

template <class SceneType, Camera C>
[[nodiscard]] RunningMoments path_means(const SceneType& scene, const C& camera, std::uint32_t samples, unsigned runs) {
  Settings settings;
  settings.samples = samples;
  RunningMoments moments;
  for (unsigned run = 0; run < runs; ++run) {
    ++settings.seed;
    moments.add(render_paths(scene, camera, settings).mean().x);
  }
  return moments;
}

/// O-21. The three estimates are independent; `least` states how much must be missing for the test to mean something.
template <class SceneType, class W, Camera C>
void expect_closed(const SceneType& scene, const W& weighting, const C& camera, const RunningMoments& path,
                   const Numbers& numbers, bool by_cuts, double least) {
  const Ledger ledger = ledger_of(scene, weighting, camera, {numbers.max_edges}, numbers.ledger_samples);
  const RunningMoments image = image_means(scene, weighting, camera, numbers, by_cuts);
  const double missing = ledger.total.rgb.x;
  const double error = std::hypot(image.standard_error(), ledger.total.rgb_error.x);
  const double z = z_score(image.mean() + missing, error, path.mean(), path.standard_error());
  const auto numbers_text = [&] {
    return "image " + std::to_string(image.mean()) + " +- " + std::to_string(image.standard_error()) + ", missing " +
           std::to_string(missing) + " +- " + std::to_string(ledger.total.rgb_error.x) + ", path " +
           std::to_string(path.mean()) + " +- " + std::to_string(path.standard_error());
  }();
  EXPECT_LT(std::abs(z), student_limit(1e-3, numbers.runs - 1)) << numbers_text;
  EXPECT_LT(std::hypot(error, path.standard_error()), 0.02 * path.mean()) << numbers_text;
  EXPECT_GT(missing, least * path.mean()) << numbers_text;
  EXPECT_EQ(ledger.invalid, 0u);
}

}  // namespace manylight::test
