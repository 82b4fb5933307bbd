// SPDX-License-Identifier: Apache-2.0
// Clusters that bounds of lightcuts are known to fail on, against the sum of all pairs.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "manylight/bounds/analytic.hpp"
#include "manylight/many_light/cut.hpp"
#include "manylight/path/four_constraints.hpp"
#include "support/analytic_scenes.hpp"
#include "support/random_vertices.hpp"

namespace manylight::hard_clusters_test {
namespace {

using S = double;
using TestScene = test::MixedScene<S>;
using Weights = FourConstraints<S>;
using Vps = Sensor<TestScene, Weights>;
using Light = VertexOf<TestScene>;

TestScene empty_scene() {
  test::PartsBuilder<S> b;
  b.rectangle({0, 0, -20}, {1, 0, 0}, {0, 1, 0});  // out of the way: a scene needs a shape
  return test::compose_bvh<test::MixedMaterial<S>>(b.parts, {test::MixedMaterial<S>(Lambertian<S>{})});
}

Vps sensor(const Weights& weighting, const Vec3<S>& position, const Frame<S>& frame, const Vec3<S>& wo,
           const test::MixedMaterial<S>& material) {
  Vps s{{}, weighting.start()};
  Light& v = s.vertex;
  v.position = position;
  v.error = 1e-9;
  v.ng = frame.n;
  v.w = wo;
  v.shading = detail::ShadingFrame<S, false>(frame);
  v.material = material;
  v.alpha = max_channel(v.material.albedo());
  v.strength = Rgb<S>(1);
  v.edges = 1;
  return s;
}
Light lamp(const Vec3<S>& position, const Vec3<S>& ng, VertexKind kind) {
  Light v;
  v.position = position;
  v.error = 1e-9;
  v.ng = ng;
  v.kind = kind;
  v.exact = kind == VertexKind::point_emitter;
  v.strength = Rgb<S>(1, 0.5, 0.25);
  return v;
}

struct Sums {
  PairSumResult cut, all;
  [[nodiscard]] double error() const { return std::abs(luminance(cut.radiance) / luminance(all.radiance) - 1); }
};
template <class B = AutomaticBounds>
Sums sums(const TestScene& scene, const Weights& weighting, const std::vector<Vps>& sensors,
          const std::vector<Light>& lights, double threshold, const B& bounds = {}) {
  const LightTree<TestScene> tree(lights, SerialExecutor{}, bounds);
  CutSum<TestScene, Weights, B> cut(scene, weighting, tree, k_unlimited_edges, {threshold, 1U << 30, 0.0}, bounds);
  const BruteForceSum<TestScene, Weights> all(scene, weighting, lights, k_unlimited_edges);
  return {cut(sensors, Rgb<double>(0), 1), all(sensors, Rgb<double>(0), 1)};
}

// Case 4: 8 lights at the corners of a cube around the shading point, which lies in the box of the cluster: no bound of
// distance or direction holds anything back until the boxes part. Refinement must end, and with nothing left out.
// Planted bug seen to fail: distance 1e-3 of the box's diagonal in place of 0 (clamped lamps are one cluster then).
TEST(HardClusters, ShadingPointInsideTheBoxOfItsLights) {
  const TestScene scene = empty_scene();
  const Frame<S> up(Vec3<S>(0, 0, 1));
  for (const double clamp : {1e-4, 1e-2, 1.0, k_infinity<S>}) {
    for (const VertexKind kind : {VertexKind::area_emitter, VertexKind::point_emitter}) {
      const Weights weighting(WeightingConfig<S>{clamp, 1, 1, 100, EmitterHits::all});
      std::vector<Light> lights;
      for (int corner = 0; corner < 8; ++corner) {
        const Vec3<S> p(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
        lights.push_back(lamp(p, glm::normalize(-p), kind));
      }
      std::vector<Vps> sensors{
          sensor(weighting, Vec3<S>(0), up, glm::normalize(Vec3<S>(0.3, 0, 1)), Lambertian<S>{Rgb<S>(0.5)})};
      const Sums at_zero = sums(scene, weighting, sensors, lights, 0.0);
      EXPECT_LT(at_zero.error(), 1e-12) << clamp;
      EXPECT_FALSE(at_zero.cut.statistics.capped);
      EXPECT_LE(at_zero.cut.statistics.cut_size, 8U);
      const Sums sum = sums(scene, weighting, sensors, lights, 0.02);
      EXPECT_EQ(sum.cut.statistics.bound_violations, 0U);
      EXPECT_LT(std::abs(luminance(sum.cut.radiance) - luminance(sum.all.radiance)),
                sum.cut.statistics.error_bound + 1e-12);
      EXPECT_LE(sum.cut.statistics.error_bound, 8 * 0.02 * luminance(sum.cut.radiance) * 1.001) << clamp;
    }
  }
}

/// Sensors of a patch of a ball, and 1000 lamps around it of which a few stand in mirror directions.
struct Highlight {
  std::vector<Vps> sensors;
  std::vector<Light> lights;
  Highlight(test::RandomVertices<S>& random, const Weights& weighting, double alpha_u, double alpha_v) {
    const test::MixedMaterial<S> lobe = test::DiffuseWard<S>({Lambertian<S>{Rgb<S>(0.05)}, 1},
                                                             {Ward<S>{Rgb<S>(0.8), alpha_u, alpha_v}, 1});
    const Vec3<S> top = random.direction();
    for (int i = 0; i < 16; ++i) {
      const Vec3<S> n = glm::normalize(top + 0.05 * random.direction());
      const Vec3<S> wo = glm::normalize(top + random.direction() * 0.8);
      const Frame<S> frame(n);
      if (!(glm::dot(wo, n) > 0.05)) continue;
      sensors.push_back(sensor(weighting, n, frame, wo, lobe));
    }
    for (int i = 0; i < 1000; ++i) {
      const Vps& s = sensors[static_cast<std::size_t>(i) % sensors.size()];
      const Vec3<S> mirrored = glm::normalize(2 * glm::dot(s.vertex.w, s.vertex.ng) * s.vertex.ng - s.vertex.w);
      const Vec3<S> to = i < 4 ? mirrored : glm::normalize(top * 0.3 + random.direction());
      const Vec3<S> p = s.vertex.position + to * random.uniform(2, 4);
      lights.push_back(lamp(p, -to, VertexKind::area_emitter));
    }
  }
};

// A bound that misses a lobe settles its cluster before the highlight is found: the error is then above the sum of the
// bounds. Errors of clusters have random signs and mostly cancel: 5 % is far more than the root mean square found.
// Planted bugs seen to fail: the profile looked up two rings too far out; rings as if the inner angle were the outer one.
template <class B>
void lobe_is_found(const B& bounds, double alpha_u, double alpha_v, double least_share) {
  test::RandomVertices<S> random(41);
  const TestScene scene = empty_scene();
  const Weights weighting(WeightingConfig<S>{k_infinity<S>, 1, 1, 100, EmitterHits::all});
  double with_highlight = 0, without = 0, squares = 0;
  constexpr int k_rounds = 6;
  for (int n = 0; n < k_rounds; ++n) {
    const Highlight h(random, weighting, alpha_u, alpha_v);
    const Sums sum = sums(scene, weighting, h.sensors, h.lights, 0.02, bounds);
    EXPECT_EQ(sum.cut.statistics.bound_violations, 0U) << n;
    EXPECT_LE(std::abs(luminance(sum.cut.radiance) - luminance(sum.all.radiance)), sum.cut.statistics.error_bound) << n;
    EXPECT_LT(sum.cut.statistics.cut_size, 0.5 * static_cast<double>(h.sensors.size() * h.lights.size())) << n;
    squares += sqr(sum.error()) / k_rounds;
    with_highlight += luminance(sum.all.radiance);
    const std::vector<Light> others(h.lights.begin() + 4, h.lights.end());
    without += luminance(sums(scene, weighting, h.sensors, others, 1.0, bounds).all.radiance);
  }
  EXPECT_LT(std::sqrt(squares), 0.05);
  EXPECT_GT(with_highlight, least_share * without) << "there is a highlight to be missed";
}
// Case 11: Ward's lobe of alpha 0.015 under 1000 lamps, four of them in mirror directions.
TEST(HardClusters, HighlightOfASharpLobe) {
  lobe_is_found(AutomaticBounds{}, 0.015, 0.015, 1.5);
  lobe_is_found(AnalyticBounds{}, 0.015, 0.015, 1.5);
  lobe_is_found(CubeMapBounds<>{}, 0.015, 0.015, 1.5);
}
// Case 12's share of cuts: a lobe seven times as long as wide.
TEST(HardClusters, AnisotropicLobe) { lobe_is_found(AutomaticBounds{}, 0.03, 0.22, 0.0); }

}  // namespace
}  // namespace manylight::hard_clusters_test
