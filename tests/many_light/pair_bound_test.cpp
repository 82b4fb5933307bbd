// SPDX-License-Identifier: Apache-2.0
// Bounds of cluster pairs in packs. Oracles: the members of the clusters, and the scalar definition on random nodes of
// every kind, made up field by field so that their flags meet in all combinations.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "manylight/many_light/pair_bound_pack.hpp"
#include "manylight/path/four_constraints.hpp"
#include "manylight/path/transfer.hpp"
#include "support/random_vertices.hpp"

namespace manylight::pair_bound_test {
namespace {

using test::Gloss;
using test::RandomVertices;

template <class S>
class PairBoundPacks : public ::testing::Test {
 public:
  /// A point, flat or full; small ones far from the others and large ones that overlap.
  Box<S> box() {
    Box<S> b;
    b.extend(random_.point(Vec3<S>(0), 1));
    const S size = random_.log_uniform(1e-3, 2);
    for (int axis = 0; axis < 3; ++axis) b.hi[axis] += random_.chance(0.3) ? S(0) : size * random_.uniform();
    return b;
  }
  DirectionCone<S> cone() {
    if (random_.chance(0.1)) return {};
    if (random_.chance(0.2)) {  // where frames and signs of zero change
      const S sign = random_.chance(0.5) ? S(1) : S(-1);
      return DirectionCone<S>::of(random_.chance(0.5) ? Vec3<S>(0, 0, sign) : Vec3<S>(sign, 0, -S(0)));
    }
    const S half = random_.chance(0.3) ? S(0) : random_.log_uniform(1e-3, 3);
    return {random_.direction(), std::cos(half), std::sin(half)};
  }
  GatherNode<S> gather() {
    GatherNode<S> node;
    node.box = box();
    node.normals = cone();
    node.lobes = cone();
    node.pattern.is_flat = random_.chance(0.4);
    node.pattern.has_both_sides = random_.chance(0.3);
    S eval = random_.uniform(1, 10);
    for (std::size_t i = 0; i < node.pattern.eval.size(); ++i) {
      node.pattern.eval[i] = node.pattern.eval_cos[i] = eval;
      if (!node.pattern.is_flat) eval *= S(0.6);
    }
    node.cap = random_.chance(0.5) ? k_infinity<S> : random_.uniform(0.1, 5);
    node.remaining = random_.chance(0.2) ? S(0) : random_.uniform();
    return node;
  }
  LightNode<S> light() {
    LightNode<S> node;
    node.box = box();
    node.normals = cone();
    node.peak = random_.chance(0.05) ? k_infinity<S> : random_.uniform(0.1, 3);
    node.is_infinite = random_.chance(0.2);
    node.is_exact = random_.chance(0.3);
    if (random_.chance(0.2)) {
      node.cos_cutoff = random_.uniform(-0.9, 1);
    } else {
      node.is_two_sided = random_.chance(0.3);
    }
    return node;
  }

 private:
  RandomVertices<S> random_{31};
};
using Scalars = ::testing::Types<float, double>;
TYPED_TEST_SUITE(PairBoundPacks, Scalars);

// Lists of all lengths by one object, so that lanes keep what longer lists left there. Rounding may move a cosine over
// a ring of the profile or the edge of a spot light: allowed in 1 of 2000 pairs for float, in none for double.
// Planted bugs seen to fail: the mask of two-sided lights, or that of patterns with both sides, inverted; the normals'
// cosine taken for the lobes'; the flags of the last lane for all; lights at infinity seen from the sensors' box; their
// sides compared by distance; an incomplete last pack left out.
TYPED_TEST(PairBoundPacks, EqualTheScalarDefinition) {
  using S = TypeParam;
  const double tolerance = sizeof(S) == 4 ? 1e-4 : 1e-9;  // of a bound at cosines 1: sines are steep next to -1
  RandomVertices<S> random(33);
  PairBounds<S> bounds;
  int positive = 0, unequal = 0, infinite = 0, on_gather = 0, pairs = 0;
  for (int n = 0; n < 2000; ++n) {
    const PairLimits<S> limits{n % 2 == 0 ? k_infinity<S> : S(1), n % 3 == 0 ? k_infinity<S> : S(4), S(2)};
    std::vector<GatherNode<S>> gathers(static_cast<std::size_t>(1 + n % 37));
    std::vector<LightNode<S>> lights(gathers.size());
    bounds.clear();
    for (std::size_t i = 0; i < gathers.size(); ++i) {
      gathers[i] = this->gather();
      lights[i] = this->light();
      if (random.chance(0.1)) lights[i].box = gathers[i].box;
      bounds.add(gathers[i], lights[i]);
    }
    bounds.evaluate(limits);
    ASSERT_EQ(bounds.size(), gathers.size());
    for (std::size_t i = 0; i < gathers.size(); ++i, ++pairs) {
      const S scalar = pair_bound(gathers[i], lights[i], limits);
      const S packed = bounds.bound(i);
      ASSERT_FALSE(std::isnan(packed));
      ASSERT_TRUE(packed >= S(0));
      positive += packed > S(0) ? 1 : 0;
      infinite += packed == k_infinity<S> ? 1 : 0;
      if (scalar != packed) {
        const Box<S> vectors = difference(gathers[i].box, lights[i].box);
        const S squared = lights[i].is_infinite ? sqr(limits.scene_radius) : min_squared_length(vectors);
        const double scale = 30.0 / static_cast<double>(squared);
        const double off = std::abs(static_cast<double>(scalar) - static_cast<double>(packed));
        unequal += off <= tolerance * scale ? 0 : 1;
      }
      const bool by_scalar = splits_gather(gathers[i], lights[i]);
      on_gather += by_scalar ? 1 : 0;
      unequal += by_scalar == bounds.splits_gather(i) ? 0 : 1;
    }
  }
  EXPECT_LE(unequal, sizeof(S) == 4 ? pairs / 2000 : 0);
  EXPECT_GT(positive, pairs / 3);
  EXPECT_GT(pairs - positive, pairs / 10);
  EXPECT_GT(infinite, pairs / 100);
  EXPECT_GT(on_gather, pairs / 10);
  EXPECT_LT(on_gather, pairs * 9 / 10);
}

// Planted bugs seen to fail: those above, but for the mask of patterns with both sides, which no material here has, and
// the sides.
TYPED_TEST(PairBoundPacks, HoldForEveryPairOfMembers) {
  using S = TypeParam;
  using Scene = test::MixedScene<S>;
  using Weights = FourConstraints<S>;
  RandomVertices<S> random(32);
  constexpr S k_radius = 3;
  int positive = 0, finite = 0;
  for (int n = 0; n < 60; ++n) {
    WeightingConfig<S> config;
    config.c_clamp = n % 3 == 0 ? k_infinity<S> : random.log_uniform(1e-2, 10);
    const Weights weighting(config);
    const Gloss gloss = n % 2 == 0 ? Gloss::none : Gloss::some;
    std::vector<Sensor<Scene, Weights>> sensors;
    std::vector<VertexOf<Scene>> vpls;
    const Vec3<S> facing = random.direction();
    for (int i = 0; i < 12; ++i) {
      const Vec3<S> ng = glm::normalize(facing + random.direction() * S(0.3));
      sensors.push_back(random.sensor(weighting, random.point(Vec3<S>(0), 0.3), ng, gloss));
    }
    for (int i = 0; i < 40; ++i) {
      vpls.push_back(random.light(random.point(Vec3<S>(0), 1), random.direction(), gloss,
                                  {VertexKind::surface, VertexKind::area_emitter, VertexKind::two_sided_area_emitter,
                                   VertexKind::point_emitter, VertexKind::spot_emitter, VertexKind::infinite_emitter}));
    }
    GatherTree<Scene, Weights> gather;
    if (n % 4 == 3) {
      gather.build(sensors, weighting, CubeMapBounds<>{});
    } else {
      gather.build(sensors, weighting);
    }
    const LightTree<Scene> tree(vpls, SerialExecutor{});
    std::vector<LightNode<S>> lights;
    for (std::vector<std::uint32_t> open = tree.roots(); !open.empty();) {
      lights.push_back(tree.node(open.back()));
      open.pop_back();
      if (!lights.back().is_leaf) open.insert(open.end(), lights.back().children.begin(), lights.back().children.end());
    }
    PairBounds<S> bounds;
    for (std::uint32_t g = 0; g < gather.size(); ++g) {
      for (std::size_t l = g % 3; l < lights.size(); l += 3) bounds.add(gather.node(g), lights[l]);
    }
    bounds.evaluate({weighting.light_limit(), weighting.clamp(), k_radius});
    for (std::size_t i = 0; i < bounds.size(); ++i) {
      finite += bounds.bound(i) < k_infinity<S> ? 1 : 0;
      const LeafRange& of_sensors = bounds.gather(i).leaves;
      const LeafRange& of_lights = bounds.light(i).leaves;
      for (int k = 0; k < 3; ++k) {
        const auto u = static_cast<double>(random.uniform(0, 0.9999));
        const auto v = static_cast<double>(random.uniform(0, 0.9999));
        const auto s = of_sensors.begin + static_cast<std::uint32_t>(u * (of_sensors.end - of_sensors.begin));
        const auto l = of_lights.begin + static_cast<std::uint32_t>(v * (of_lights.end - of_lights.begin));
        const Transfer<S> transfer = unoccluded_transfer<Scene>(weighting, gather.sensor_of_leaf(s), tree.vpls()[l],
                                                                k_radius, k_unlimited_edges);
        const S value = max_channel(transfer.value);
        positive += value > S(0) ? 1 : 0;
        ASSERT_LE(value, bounds.bound(i) * S(1.00001));  // rounding of products, as in the cut
      }
    }
  }
  EXPECT_GT(positive, 5000);
  EXPECT_GT(finite, 10000);
}

}  // namespace
}  // namespace manylight::pair_bound_test
