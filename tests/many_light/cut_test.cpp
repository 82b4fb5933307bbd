// SPDX-License-Identifier: Apache-2.0
// Oracle of the cut: the sum over all pairs by brute force, with the same weighting. Scenes are random sensors and
// lights in a box with a few blockers, so that every kind of bound and visibility occurs.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "manylight/many_light/cut.hpp"
#include "manylight/path/four_constraints.hpp"
#include "support/analytic_scenes.hpp"
#include "support/random_vertices.hpp"
#include "support/z_test.hpp"

namespace manylight::cut_test {
namespace {

using test::Gloss;
using test::RandomVertices;
using S = double;
using TestScene = test::MixedScene<S>;
using Weights = FourConstraints<S>;
using Light = VertexOf<TestScene>;
using Vps = Sensor<TestScene, Weights>;

/// Blockers only; lights and sensors are made up. `blockers`: number of random rectangles in [-2, 2]^3.
TestScene blockers(RandomVertices<S>& random, int count) {
  test::PartsBuilder<S> b;
  b.rectangle({0, 0, -20}, {1, 0, 0}, {0, 1, 0});  // out of the way: a scene needs a shape
  for (int i = 0; i < count; ++i) {
    b.rectangle(random.point(Vec3<S>(0), 2), random.direction() * 0.6, random.direction() * 0.6);
  }
  return test::compose_bvh<test::MixedMaterial<S>>(b.parts, {test::MixedMaterial<S>(Lambertian<S>{})});
}

struct Problem {
  std::vector<Light> lights;
  std::vector<Vps> sensors;
};

Problem problem(RandomVertices<S>& random, const Weights& weighting, Gloss gloss, std::size_t sensors,
                std::size_t lights, const std::vector<VertexKind>& kinds) {
  Problem p;
  const Vec3<S> center = random.point(Vec3<S>(0), 1.5);
  const double size = random.log_uniform(0.01, 1);
  const Vec3<S> facing = random.direction();
  for (std::size_t i = 0; i < sensors; ++i) {
    const Vec3<S> ng = glm::normalize(facing + random.direction() * random.uniform());
    p.sensors.push_back(random.sensor(weighting, random.point(center, size), ng, gloss));
  }
  for (std::size_t i = 0; i < lights; ++i) {
    p.lights.push_back(random.light(random.point(Vec3<S>(0), 2), random.direction(), gloss, kinds));
  }
  return p;
}

WeightingConfig<S> random_config(RandomVertices<S>& random) {
  WeightingConfig<S> c;
  c.c_clamp = random.chance(0.1) ? k_infinity<S> : random.log_uniform(1e-3, 10);
  c.c_v = random.chance(0.5) ? 1.0 : 0.4;
  return c;
}

const std::vector<VertexKind> k_all_kinds{VertexKind::surface,         VertexKind::surface,
                                          VertexKind::area_emitter,    VertexKind::two_sided_area_emitter,
                                          VertexKind::point_emitter,   VertexKind::spot_emitter,
                                          VertexKind::infinite_emitter};

struct Difference {
  double relative;   ///< largest over the channels, relative to the luminance
  double luminance;  ///< of luminances
  double absolute;   ///< of luminances, not relative
  PairStatistics cut;
  PairStatistics all;
};

Difference compare(const TestScene& scene, const Weights& weighting, const Problem& p, const CutConfig& config,
                   std::uint64_t key) {
  const LightTree<TestScene> tree(p.lights, SerialExecutor{});
  CutSum<TestScene, Weights> cut(scene, weighting, tree, k_unlimited_edges, config);
  const BruteForceSum<TestScene, Weights> all(scene, weighting, p.lights, k_unlimited_edges);
  const PairSumResult a = cut(p.sensors, Rgb<double>(0), key);
  const PairSumResult b = all(p.sensors, Rgb<double>(0), key);
  double relative = 0;
  const double scale = std::max(1e-300, luminance(b.radiance));
  for (int c = 0; c < 3; ++c) relative = std::max(relative, std::abs(a.radiance[c] - b.radiance[c]) / scale);
  const double absolute = std::abs(luminance(a.radiance) - luminance(b.radiance));
  return {relative, absolute / scale, absolute, a.statistics, b.statistics};
}

constexpr std::uint32_t k_no_cap = 1u << 30;

// O-24, O-26, O-29. Planted bugs seen to fail: T bound by the distance of the boxes' centres; no unclamped bound of
// exact lights; gloss looked up at the angle to the normal; `remaining` multiplied into C_D; one child not pushed.
TEST(CutSum, ThresholdZeroEqualsBruteForce) {
  RandomVertices<S> random(6);
  std::uint64_t lit = 0;
  for (int n = 0; n < 200; ++n) {
    const Weights weighting(random_config(random));
    const TestScene scene = blockers(random, n % 3 == 0 ? 0 : 6);
    const Problem p =
        problem(random, weighting, n % 4 == 0 ? Gloss::none : Gloss::some, 1 + static_cast<std::size_t>(n % 40),
                1 + static_cast<std::size_t>(n * 7 % 90), k_all_kinds);
    const Difference d = compare(scene, weighting, p, {0.0, k_no_cap, 0.0}, static_cast<std::uint64_t>(n));
    // The orders of summation and of products differ, nothing else.
    ASSERT_LE(d.relative, 1e-11) << "scene " << n << ": " << p.sensors.size() << " x " << p.lights.size();
    ASSERT_EQ(d.cut.bound_violations, 0u) << n;
    ASSERT_EQ(d.cut.invalid, 0u);
    ASSERT_FALSE(d.cut.capped);
    lit += d.all.rays.shadow;
  }
  EXPECT_GT(lit, 10000u);
}

// The luminance of a cut differs from that of all pairs by at most the sum of its bounds, wherever refinement ended.
// Sensors and lights face each other from a distance, so that bounds are nearly sharp, in colours as saturated as they get:
// a red pair may stand for red, green and blue ones. Planted bug seen to fail: the error without the clusters' saturation.
TEST(CutSum, BoundsHoldForSaturatedColours) {
  RandomVertices<S> random(16);
  const std::array<Rgb<S>, 3> primaries{Rgb<S>(1, 0, 0), Rgb<S>(0, 1, 0), Rgb<S>(0, 0, 1)};
  const TestScene scene = blockers(random, 0);
  const Weights weighting{};
  int tight = 0;
  for (int n = 0; n < 400; ++n) {
    Problem p;
    for (std::size_t i = 0; i < 1 + static_cast<std::size_t>(n % 7); ++i) {
      p.sensors.push_back(random.sensor(weighting, random.point(Vec3<S>(0), 0.01), Vec3<S>(0, 0, 1), Gloss::none));
      p.sensors.back().vertex.strength *= primaries[i % 3];
    }
    for (std::size_t i = 0; i < 9; ++i) {
      p.lights.push_back(random.light(random.point(Vec3<S>(0, 0, 1), 0.01), Vec3<S>(0, 0, -1), Gloss::none,
                                      {VertexKind::area_emitter}));
      p.lights.back().strength *= primaries[(i + static_cast<std::size_t>(n)) % 3];
    }
    const CutConfig config{0.0, static_cast<std::uint32_t>(1 + n % 20), 0.0};
    const Difference d = compare(scene, weighting, p, config, static_cast<std::uint64_t>(n));
    ASSERT_LE(d.absolute, d.cut.error_bound * (1 + 1e-12) + 1e-15) << n;  // rounding of sums, also of settled ones
    tight += d.absolute > 0.5 * d.cut.error_bound ? 1 : 0;
  }
  EXPECT_GT(tight, 10) << "bounds so far off that the test shows nothing";
}

// The criterion bounds single clusters, not the sum; the test fixes what it gives in practice: over 300 random pixels
// of the worst kind (normals and colours of neighbours unrelated) half of the errors of luminance stay below the
// threshold of 2 %, 90 % below 5 % and all below 15 %.
TEST(CutSum, ErrorsAtTwoPercentStaySmall) {
  RandomVertices<S> random(7);
  std::vector<double> errors;
  std::uint64_t pairs = 0;
  std::uint64_t all = 0;
  for (int n = 0; n < 300; ++n) {
    WeightingConfig<S> config;
    config.c_clamp = 0.05;
    const Weights weighting(config);
    const TestScene scene = blockers(random, 4);
    const Problem p = problem(random, weighting, n % 2 == 0 ? Gloss::none : Gloss::some, 30, 200, k_all_kinds);
    const Difference d = compare(scene, weighting, p, {0.02, k_no_cap, 0.0}, static_cast<std::uint64_t>(n));
    ASSERT_EQ(d.cut.bound_violations, 0u) << n;
    if (d.all.rays.shadow == 0) continue;
    errors.push_back(d.luminance);
    pairs += d.cut.pairs;
    all += d.all.pairs;
  }
  std::sort(errors.begin(), errors.end());
  const auto quantile = [&](double q) {
    return errors[static_cast<std::size_t>(q * static_cast<double>(errors.size() - 1))];
  };
  std::string report = "relative error, median " + std::to_string(quantile(0.5)) + ", 90 % " +
                       std::to_string(quantile(0.9)) + ", 99 % " + std::to_string(quantile(0.99)) + ", largest " +
                       std::to_string(errors.back()) + "; pairs evaluated " +
                       std::to_string(static_cast<double>(pairs) / static_cast<double>(all));
  RecordProperty("errors", report);
  EXPECT_LE(quantile(0.5), 0.02) << report;
  EXPECT_LE(quantile(0.9), 0.05) << report;
  EXPECT_LE(errors.back(), 0.15) << report;
}

// Every estimate is S_C I_L w M T D(rep) with P(rep) = S I / (S_C I_L): for a fixed cut its mean is the sum of all
// pairs. A cut of one pair is fixed. 4e4 keys; false alarm rate 1e-4 over all channels and rounds. Planted bugs seen to
// fail: representatives by equal probability (both trees); colours not divided by luminance.
TEST(CutSum, RepresentativesAreUnbiased) {
  RandomVertices<S> random(8);
  std::vector<double> mean, error, reference, none;
  for (int n = 0; n < 4; ++n) {
    WeightingConfig<S> config;
    config.c_clamp = 1;
    const Weights weighting(config);
    const TestScene scene = blockers(random, 3);
    Problem p = problem(random, weighting, Gloss::none, 12, 30, {VertexKind::surface, VertexKind::area_emitter});
    for (std::size_t i = 0; i < p.lights.size(); ++i) {
      p.lights[i].strength *= i % 10 == 0 ? Rgb<S>(0.05, 0.05, 4) : Rgb<S>(2, 0.1, 0.1);  // nine reds to one blue
    }
    const LightTree<TestScene> tree(p.lights, SerialExecutor{});
    CutSum<TestScene, Weights> cut(scene, weighting, tree, k_unlimited_edges, {0.0, n < 2 ? 1u : 5u, 0.0});
    const BruteForceSum<TestScene, Weights> all(scene, weighting, p.lights, k_unlimited_edges);
    const PairSumResult truth = all(p.sensors, Rgb<double>(0), 0);
    std::array<test::RunningMoments, 3> moments;
    for (std::uint64_t key = 0; key < 40000; ++key) {
      const PairSumResult one = cut(p.sensors, Rgb<double>(0), key);
      for (std::size_t c = 0; c < 3; ++c) moments[c].add(one.radiance[static_cast<int>(c)]);
    }
    for (std::size_t c = 0; c < 3; ++c) {
      mean.push_back(moments[c].mean());
      error.push_back(moments[c].standard_error());
      reference.push_back(truth.radiance[static_cast<int>(c)]);
      none.push_back(0);
    }
  }
  const test::ZTestResult z = test::z_test(mean, error, reference, none, 1e-4);
  EXPECT_EQ(z.failures, 0u) << "worst z " << z.worst << " at " << z.worst_index << ", mean " << mean[z.worst_index]
                            << " for " << reference[z.worst_index];
}

TEST(CutSum, CapEndsRefinementAndIsReported) {
  RandomVertices<S> random(9);
  const Weights weighting(WeightingConfig<S>{});
  const TestScene scene = blockers(random, 0);
  const Problem p = problem(random, weighting, Gloss::none, 30, 100, {VertexKind::area_emitter});
  const Difference capped = compare(scene, weighting, p, {0.0, 50, 0.0}, 1);
  EXPECT_TRUE(capped.cut.capped);
  EXPECT_EQ(capped.cut.cut_size, 50u);
  EXPECT_LE(capped.cut.pairs, 51u) << "one evaluation per split";
  const Difference free = compare(scene, weighting, p, {0.0, k_no_cap, 0.0}, 1);
  EXPECT_FALSE(free.cut.capped);
  EXPECT_LE(free.cut.cut_size, free.all.pairs);
}

TEST(CutSum, FloorAndKnownRadianceEndRefinementEarly) {
  RandomVertices<S> random(10);
  const Weights weighting(WeightingConfig<S>{});
  const TestScene scene = blockers(random, 0);
  const Problem p = problem(random, weighting, Gloss::none, 30, 100, {VertexKind::area_emitter});
  const LightTree<TestScene> tree(p.lights, SerialExecutor{});
  const auto size = [&](double floor, double known) {
    CutSum<TestScene, Weights> cut(scene, weighting, tree, k_unlimited_edges, {0.02, k_no_cap, floor});
    return cut(p.sensors, Rgb<double>(known), 1).statistics.cut_size;
  };
  const std::uint64_t plain = size(0, 0);
  const double total = luminance(
      BruteForceSum<TestScene, Weights>(scene, weighting, p.lights, k_unlimited_edges)(p.sensors, Rgb<double>(0), 0)
          .radiance);
  EXPECT_GT(plain, 20u);
  EXPECT_LT(size(100 * total, 0), plain / 2);
  EXPECT_LT(size(0, 100 * total), plain / 2);
  EXPECT_EQ(size(0.01 * total, 0), plain) << "a floor far below the pixel changes nothing";
}

// Known radiance is part of the total that errors refer to, not of the result.
TEST(CutSum, KnownRadianceIsNotAdded) {
  RandomVertices<S> random(11);
  const Weights weighting(WeightingConfig<S>{});
  const TestScene scene = blockers(random, 0);
  const Problem p = problem(random, weighting, Gloss::none, 5, 10, {VertexKind::area_emitter});
  const LightTree<TestScene> tree(p.lights, SerialExecutor{});
  CutSum<TestScene, Weights> cut(scene, weighting, tree, k_unlimited_edges, {0.0, k_no_cap, 0.0});
  const Rgb<double> without = cut(p.sensors, Rgb<double>(0), 1).radiance;
  const Rgb<double> with = cut(p.sensors, Rgb<double>(1e3), 1).radiance;
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(without[c], with[c], 1e-12 * luminance(without));  // other order of sums
}

TEST(CutSum, EmptySidesGiveZero) {
  RandomVertices<S> random(12);
  const Weights weighting(WeightingConfig<S>{});
  const TestScene scene = blockers(random, 0);
  const Problem p = problem(random, weighting, Gloss::none, 3, 3, {VertexKind::area_emitter});
  const Difference no_lights = compare(scene, weighting, Problem{{}, p.sensors}, {}, 1);
  EXPECT_EQ(no_lights.cut.cut_size, 0u);
  EXPECT_EQ(no_lights.relative, 0.0);
  const Difference no_sensors = compare(scene, weighting, Problem{p.lights, {}}, {}, 1);
  EXPECT_EQ(no_sensors.cut.pairs, 0u);
}

TEST(CutSum, PathsBeyondTheLimitCarryNothing) {
  RandomVertices<S> random(13);
  const Weights weighting(WeightingConfig<S>{});
  const TestScene scene = blockers(random, 0);
  const Problem p = problem(random, weighting, Gloss::none, 5, 10, {VertexKind::surface});  // 1 + 1 + 1 segments
  const LightTree<TestScene> tree(p.lights, SerialExecutor{});
  EXPECT_EQ(
      luminance((CutSum<TestScene, Weights>(scene, weighting, tree, 2, {}))(p.sensors, Rgb<double>(0), 1).radiance),
      0.0);
  EXPECT_GT(
      luminance((CutSum<TestScene, Weights>(scene, weighting, tree, 3, {}))(p.sensors, Rgb<double>(0), 1).radiance),
      0.0);
}

TEST(CutConfig, RejectsWhatIsOutOfRange) {
  EXPECT_THROW((CutConfig{-0.1, 1, 0}).validate(), ParameterError);
  EXPECT_THROW((CutConfig{1.1, 1, 0}).validate(), ParameterError);
  EXPECT_THROW((CutConfig{0.02, 0, 0}).validate(), ParameterError);
  EXPECT_THROW((CutConfig{0.02, 1, -1}).validate(), ParameterError);
  EXPECT_NO_THROW((CutConfig{0, 1, 0}).validate());
}

}  // namespace
}  // namespace manylight::cut_test
