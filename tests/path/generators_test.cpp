// SPDX-License-Identifier: Apache-2.0
// O-16: the value f of a path is a property of the path, not of the generator. A path of fixed points, eye to light, is
// split at each of its segments into an eye part with strength S, a pair M T D and a light part with intensity I, all
// densities set to one; the products must agree with each other and with f written out as the product of s / d^2.

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <vector>

#include "manylight/path/four_constraints.hpp"
#include "manylight/path/light_subpath.hpp"
#include "manylight/path/transfer.hpp"
#include "support/analytic_scenes.hpp"
#include "support/random_vertices.hpp"
#include "support/z_test.hpp"

namespace manylight::generators_test {
namespace {

using S = double;
using test::Gloss;
using test::MixedMaterial;
using TestScene = test::MixedScene<S>;
using V = VertexOf<TestScene>;

/// A surface point with what it is made of; `ng` and `ns` on the side of both its neighbours.
struct Node {
  Vec3<S> position{0}, ng{0, 0, 1}, ns{0, 0, 1}, tangent{1, 0, 0};
  MixedMaterial<S> material{};
};

Interaction<S, MixedMaterial<S>> interaction_of(const Node& node) {
  Interaction<S, MixedMaterial<S>> hit{};
  hit.point.position = node.position;
  hit.point.ng = node.ng;
  hit.point.ns = node.ns;
  hit.ng = node.ng;
  hit.frame = Frame<S>(node.ns, node.tangent);
  hit.material = node.material;
  return hit;
}

/// s = |wi . ns| f |wo . ng| written out [theory 1.1].
Rgb<S> scatter_term(const Node& node, const Vec3<S>& wi, const Vec3<S>& wo) {
  const Frame<S> frame(node.ns, node.tangent);
  return std::abs(glm::dot(wi, node.ns)) * node.material.eval(frame.to_local(wi), frame.to_local(wo)) *
         std::abs(glm::dot(wo, node.ng));
}

// O-17: alpha only normalises the patterns that weights see. Without limits a pair's contribution is the same for any
// alpha, as S and I carry it too. Planted bugs seen to fail: alpha left out of D; alpha left out of M.
TEST(Generators, AlphaCancelsWhereNothingIsLimited) {
  test::RandomVertices<S> random(18);
  const FullWeighting<S> weighting;
  const std::vector<VertexKind> kinds{VertexKind::surface, VertexKind::area_emitter, VertexKind::point_emitter,
                                      VertexKind::infinite_emitter};
  int lit = 0;
  for (int n = 0; n < 4000; ++n) {
    Sensor<TestScene, FullWeighting<S>> sensor{random.surface({0, 0, 0}, random.direction(), Gloss::some), {}};
    V light = random.light(random.point({0, 0, 0}, 2), random.direction(), Gloss::some, kinds);
    sensor.vertex.strength = random.color(0.1, 1);
    const auto contribution = [&] {
      return sensor.vertex.strength * light.strength *
             unoccluded_transfer<TestScene>(weighting, sensor, light, 3.0, k_unlimited_edges).value;
    };
    const Rgb<S> before = contribution();
    for (V* v : {&sensor.vertex, &light}) {
      if (v->kind != VertexKind::surface) continue;
      const S factor = random.log_uniform(0.01, 100);
      v->alpha *= factor;
      v->strength *= factor;
    }
    const Rgb<S> after = contribution();
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(after[c], before[c], 1e-12 * before[c]) << "pair " << n;  // rounding
    lit += is_black(before) ? 0 : 1;
  }
  EXPECT_GT(lit, 800);
}

// Planted bugs seen to fail: |wo.ns| in D; |wi.ng| in M.
TEST(Generators, AllSplitsOfAPathGiveTheSameValue) {
  test::RandomVertices<S> random(17);
  int paths = 0;
  int bent = 0;
  while (paths < 2000) {
    const int inner = 2 + paths % 4;  // surface vertices between the eye and the light
    const Vec3<S> eye = random.point(Vec3<S>(0), 1);
    std::vector<Node> nodes(static_cast<std::size_t>(inner));
    for (Node& n : nodes) n.position = random.point(Vec3<S>(0), 1);
    const Vec3<S> light = random.point(Vec3<S>(0), 1);
    const Vec3<S> light_ng = random.direction();
    const auto at = [&](int j) {
      return j == 0 ? eye : j > inner ? light : nodes[static_cast<std::size_t>(j - 1)].position;
    };
    for (int j = 1; j <= inner; ++j) {
      Node& n = nodes[static_cast<std::size_t>(j - 1)];
      const Vec3<S> middle =
          glm::normalize(glm::normalize(at(j - 1) - n.position) + glm::normalize(at(j + 1) - n.position));
      n.ng = glm::normalize(middle + random.direction() * 0.3);
      n.ns = glm::normalize(n.ng + random.direction() * 0.4);
      n.tangent = random.direction();
      n.material = random.material(Gloss::some);
    }
    // f, straight from its definition: emitted radiance 1 times |omega . ng| at the light, s / d^2 on the way.
    const auto wi = [&](int j) { return glm::normalize(at(j + 1) - at(j)); };
    const auto squared = [&](int j) { return glm::dot(at(j + 1) - at(j), at(j + 1) - at(j)); };
    Rgb<S> f(glm::dot(-wi(inner), light_ng) / squared(inner));
    bool usable = f.x > 0;
    for (int j = 1; j <= inner && usable; ++j) {
      const Node& n = nodes[static_cast<std::size_t>(j - 1)];
      usable = glm::dot(wi(j), n.ng) > 0.01 && glm::dot(-wi(j - 1), n.ng) > 0.01 && glm::dot(wi(j), n.ns) > 0.01 &&
               glm::dot(-wi(j - 1), n.ns) > 0.01;
      if (!usable) break;
      f *= scatter_term(n, wi(j), -wi(j - 1));
      if (j > 1) f /= squared(j - 1);
    }
    if (!usable || !(max_channel(f) > 1e-200)) continue;
    // The first segment's cosine belongs to the camera's measure: S_1 starts at beta = 1 without it.
    f /= std::abs(glm::dot(-wi(0), nodes[0].ng));
    ++paths;
    bent += glm::dot(nodes[0].ns, nodes[0].ng) < 0.999 ? 1 : 0;

    for (int k = 1; k <= inner; ++k) {
      // Eye part up to v_k: the cosine-free throughput; sampling by area cancels d^2 against the density.
      Rgb<S> beta(1);
      for (int j = 1; j < k; ++j) {
        const Node& n = nodes[static_cast<std::size_t>(j - 1)];
        const V v = surface_vertex<V>(interaction_of(n), -wi(j - 1));
        // p(psi) = p_area d^2 / |omega . ng| of the next vertex, with p_area = 1.
        const Vec3<S> arriving = -wi(j);
        const S pdf = squared(j) / std::abs(glm::dot(arriving, nodes[static_cast<std::size_t>(j)].ng));
        beta *= sensor_patterns(v, wi(j)).m * v.alpha / pdf;
      }
      const Node& sensor_node = nodes[static_cast<std::size_t>(k - 1)];
      V sensor = surface_vertex<V>(interaction_of(sensor_node), -wi(k - 1));
      sensor.strength = beta * sensor.alpha;

      // Light part down to v_{k+1}.
      V vpl;
      if (k == inner) {
        vpl.kind = VertexKind::area_emitter;
        vpl.position = light;
        vpl.ng = light_ng;
        vpl.strength = Rgb<S>(k_pi<S>);  // pi L_e / p with area density 1
      } else {
        // Power that arrives at v_inner from the light, then at each vertex towards the eye.
        Rgb<S> power(glm::dot(-wi(inner), light_ng) * std::abs(glm::dot(wi(inner), nodes.back().ng)) / squared(inner));
        for (int j = inner; j > k + 1; --j) {
          const Node& n = nodes[static_cast<std::size_t>(j - 1)];
          const V v = surface_vertex<V>(interaction_of(n), wi(j));
          const Node& next = nodes[static_cast<std::size_t>(j - 2)];
          const Vec3<S> wo = -wi(j - 1);
          const S pdf = squared(j - 1) / std::abs(glm::dot(wi(j - 1), next.ng));
          // I of v_j times its D is the intensity towards the next vertex.
          const Rgb<S> intensity =
              power * (v.alpha * std::abs(glm::dot(wi(j), n.ns)) / std::abs(glm::dot(wi(j), n.ng)));
          power = intensity * light_pattern(v, wo) / pdf;
        }
        const Node& n = nodes[static_cast<std::size_t>(k)];
        vpl = surface_vertex<V>(interaction_of(n), wi(k + 1));
        vpl.strength = power * (vpl.alpha * std::abs(glm::dot(wi(k + 1), n.ns)) / std::abs(glm::dot(wi(k + 1), n.ng)));
      }
      const Pair<S> pair = connect(sensor, vpl, S(1));
      const Rgb<S> value = sensor.strength * pair.m * pair.t * pair.d * vpl.strength;
      for (int c = 0; c < 3; ++c) {
        // Rounding, except that sharp lobes (roughness 0.02, exponent 2000) amplify that of their directions.
        ASSERT_NEAR(value[c] / f[c], 1, 1e-10) << "path " << paths << " generator " << k << " of " << inner;
      }
    }
  }
  EXPECT_GT(bent, 1000);
}

/// Variates from a list.
struct FixedStream {
  using Scalar = S;
  std::vector<S> values;
  std::size_t next_index = 0;
  S next() { return values[next_index++ % values.size()]; }
  Vec2<S> next_2d() {
    const S x = next();
    return {x, next()};
  }
};

// The walk step against the same definition: factor * pdf = s (without the cosine that cancels).
// Planted bugs seen to fail: the light's |w.ns / w.ng| inverted; its |wo.ng| left out.
TEST(Generators, WalkFactorsMatchTheScatteringTerm) {
  test::RandomVertices<S> random(18);
  int drawn = 0;
  for (int n = 0; n < 5000; ++n) {
    Node node;
    node.ng = random.direction();
    node.ns = glm::normalize(node.ng + random.direction() * 0.4);
    node.tangent = random.direction();
    node.material = random.material(Gloss::some);
    const Vec3<S> known = random.above(node.ng, node.ns);
    FixedStream stream{{random.uniform(), random.uniform(), random.uniform()}};
    for (const Walk walk : {Walk::eye, Walk::light}) {
      stream.next_index = 0;
      const auto sample = sample_scatter<TestScene>(interaction_of(node), known, walk, stream);
      if (!sample) continue;
      ++drawn;
      const bool eye = walk == Walk::eye;
      const Rgb<S> s =
          eye ? scatter_term(node, sample->direction, known) : scatter_term(node, known, sample->direction);
      // Eye: s / |wo.ng| / p; light: s / |wi.ng| / p: both divide by the geometric cosine of the known direction.
      const Rgb<S> expected = s / (std::abs(glm::dot(known, node.ng)) * sample->pdf);
      // Turning a direction to world and back costs digits on sharp lobes.
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(sample->factor[c], expected[c], 1e-9 * expected[c] + 1e-30);
      const Frame<S> frame(node.ns, node.tangent);
      ASSERT_NEAR(sample->pdf, node.material.pdf(frame.to_local(known), frame.to_local(sample->direction), walk),
                  1e-9 * sample->pdf);
    }
  }
  EXPECT_GT(drawn, 5000);
}

/// Not reciprocal: f depends on the light side alone. Directions are drawn like a Lambertian's.
struct OneWay : Lambertian<S> {
  [[nodiscard]] Rgb<S> eval(const Vec3<S>& wi, const Vec3<S>& wo) const noexcept {
    return Lambertian<S>::eval(wi, wo) * (0.2 + wi.z * wi.z);
  }
};
static_assert(Material<OneWay>);

// Planted bug seen to fail: wi and wo of `eval` swapped in the walk.
TEST(Generators, RolesOfDirectionsNeverSwap) {
  using OneWayScene = Scene<Bvh<S>, UniformShader<OneWay>>;
  test::RandomVertices<S> random(22);
  const auto f = [](const Vec3<S>& wi) { return 0.5 * k_inv_pi<S> * (0.2 + wi.z * wi.z); };
  Interaction<S, OneWay> hit{};
  hit.ng = Vec3<S>(0, 0, 1);
  hit.frame = Frame<S>(Vec3<S>(0, 0, 1));
  for (int n = 0; n < 100; ++n) {
    const Vec3<S> known = random.above(hit.ng, hit.ng);
    const Vec3<S> other = random.above(hit.ng, hit.ng);
    const auto v = surface_vertex<Vertex<S, OneWay>>(hit, known);                       // alpha = 0.5
    EXPECT_NEAR(sensor_patterns(v, other).m.x, f(other) * other.z / 0.5, 1e-14);  // rounding, here and below
    EXPECT_NEAR(sensor_patterns(v, other).d, f(other) * known.z / 0.5, 1e-14);
    EXPECT_NEAR(light_pattern(v, other).x, f(known) * other.z / 0.5, 1e-14);
    IndependentStream<S> stream(1, Stage::test, static_cast<std::uint64_t>(n), 0);
    const auto eye = sample_scatter<OneWayScene>(hit, known, Walk::eye, stream);
    ASSERT_TRUE(eye.has_value());
    EXPECT_NEAR(eye->factor.x, f(eye->direction) * eye->direction.z / eye->pdf, 1e-12);
    const auto light = sample_scatter<OneWayScene>(hit, known, Walk::light, stream);
    ASSERT_TRUE(light.has_value());
    EXPECT_NEAR(light->factor.x, f(known) * light->direction.z / light->pdf, 1e-12);
  }
}

// Planted bug seen to fail: sides judged by one normal alone.
TEST(Generators, BentNormalsDoNotLeakLight) {
  test::RandomVertices<S> random(19);
  int excluded = 0;
  for (int n = 0; n < 20000; ++n) {
    const V v = random.surface(Vec3<S>(0), random.direction(), Gloss::some);
    const Vec3<S> w = random.direction();
    const bool agree = glm::dot(w, v.ng) * glm::dot(w, v.shading.normal()) > 0;
    if (agree) continue;
    ++excluded;
    ASSERT_EQ(max_channel(sensor_patterns(v, w).m), 0.0);
    ASSERT_EQ(max_channel(light_pattern(v, w)), 0.0);
  }
  EXPECT_GT(excluded, 200);
}

TEST(Generators, CoincidentVerticesCarryNothing) {
  test::RandomVertices<S> random(20);
  const V a = random.surface(Vec3<S>(1, 2, 3), random.direction(), Gloss::none);
  const Pair<S> pair = connect(a, a, S(1));
  EXPECT_TRUE(pair.is_zero());
  EXPECT_TRUE(is_finite(pair.m) && is_finite(pair.d));
}

// Lights at infinity: I D T = L / p whatever the scene's radius [theory 2.5].
TEST(Generators, InfiniteLightsDoNotDependOnTheSceneRadius) {
  test::RandomVertices<S> random(21);
  V light;
  light.kind = VertexKind::infinite_emitter;
  light.position = random.direction();
  const V sensor = random.surface(Vec3<S>(0), light.position, Gloss::none);
  for (const S radius : {0.1, 1.0, 50.0}) {
    light.strength = Rgb<S>(k_pi<S> * radius * radius * 3);  // irradiance 3
    const Pair<S> pair = connect(sensor, light, radius);
    EXPECT_NEAR((pair.t * pair.d * light.strength).x, 3, 1e-14);  // rounding
  }
}

struct Collect {
  std::vector<Sensor<Scene<Bvh<S>, UniformShader<Lambertian<S>>>, FourConstraints<S>>> sensors;
  Rgb<S> emitted{0};
  void emission(const Rgb<S>& radiance) { emitted += radiance; }
  template <class T>
  void sensor(const T& sensor) {
    sensors.push_back(sensor);
  }
};

// A pinhole pixel on a Lambertian wall: S_1 = rho / N_e, whatever the angle [theory 2.2].
TEST(EyeSubpath, FirstSensorOfALambertianWallHasStrengthOfItsAlbedo) {
  test::PartsBuilder<S> b;
  b.rectangle({0, 0, 0}, {10, 0, 0}, {0, 10, 0});
  const Rgb<S> albedo(0.2, 0.5, 0.7);
  const auto scene = test::compose_bvh<Lambertian<S>>(b.parts, {Lambertian<S>{albedo}});
  using TheScene = std::remove_cv_t<decltype(scene)>;
  const FourConstraints<S> weighting{};
  for (const Vec3<S>& direction : {Vec3<S>(0, 0, -1), Vec3<S>(3, 0, -1), Vec3<S>(0, 9, -1)}) {
    IndependentStream<S> stream(1, Stage::eye, 0, 0);
    RayCounts rays;
    Collect collect;
    EyeSubpath<TheScene, FourConstraints<S>, IndependentStream<S>, Collect> path(scene, weighting, 100, stream, rays,
                                                                                 collect);
    path.trace(Ray<S>{{0, 0, 1}, glm::normalize(direction)}, 1.0 / 64);
    ASSERT_EQ(collect.sensors.size(), 1u);
    const VertexOf<TheScene>& v = collect.sensors[0].vertex;
    // S carries the largest channel, M = albedo / alpha / pi at normal incidence the colour.
    const Rgb<S> reflected = v.strength * sensor_patterns(v, Vec3<S>(0, 0, 1)).m * k_pi<S>;
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(v.strength[c], 0.7 / 64, 1e-15);  // rounding
      EXPECT_NEAR(reflected[c], albedo[c] / 64, 1e-15);
    }
    EXPECT_EQ(collect.sensors[0].vertex.edges, 1);
    EXPECT_EQ(collect.sensors[0].vertex.alpha, 0.7);
    EXPECT_NEAR(glm::length(collect.sensors[0].vertex.position - Vec3<S>(direction.x, direction.y, 0)), 0, 1e-12);
  }
}

// Emission seen directly counts fully; without any clamp a diffuse scene needs no second sensor (theory 3.6 c).
TEST(EyeSubpath, SeesEmittersAndStopsWhereNothingIsClamped) {
  const auto parts = test::inside_of_sphere<S>(1, 0.5);
  const auto scene = test::compose_bvh<Lambertian<S>>(parts, {Lambertian<S>{Rgb<S>(0.8)}});
  using TheScene = std::remove_cv_t<decltype(scene)>;
  const auto run = [&](S c_clamp, unsigned max_edges) {
    const FourConstraints<S> weighting(WeightingConfig<S>{c_clamp, 1, 1, 100});
    IndependentStream<S> stream(1, Stage::eye, 0, 0);
    RayCounts rays;
    Collect collect;
    EyeSubpath<TheScene, FourConstraints<S>, IndependentStream<S>, Collect>(scene, weighting, max_edges, stream, rays,
                                                                            collect)
        .trace(Ray<S>{{0, 0, 0.3}, {0, 0, 1}}, 1.0);
    return collect;
  };
  // No weight is left for later vertices: at the hit of the second one either the rule ends the path, or it has 0.
  const Collect free = run(k_infinity<S>, 100);
  EXPECT_EQ(free.sensors.size(), 1u);
  EXPECT_NEAR(free.emitted.x, 0.5, 1e-15);
  // Pairs of the sphere have M T D = 1 / (4 pi^2): a smaller clamp leaves weight, and the path goes on.
  const Collect clamped = run(1e-4, 100);
  EXPECT_GE(clamped.sensors.size(), 2u);
  EXPECT_GT(clamped.emitted.x, 0.6);
  EXPECT_EQ(run(1e-4, 1).sensors.size(), 0u);
  EXPECT_EQ(run(1e-4, 2).sensors.size(), 1u);
}

// What the clamp takes from a floor under a small lamp comes back by hits: rho L (r / h)^2, found by drawn lights, where
// hits alone would find it once in (h / r)^2 = 400 paths, with a standard error of 63 % after 1000. Fixed seed;
// 5 standard errors: false alarm 6e-7. Caught: hits that are not weighted; no light drawn.
TEST(EyeSubpath, LightOfASmallLampIsDrawnWhereHitsWouldBeRare) {
  test::PartsBuilder<S> b;
  b.rectangle({0, 0, 0}, {10, 0, 0}, {0, 10, 0});
  b.parts.shapes.spheres.push_back({.center = {0, 0, 2}, .radius = 0.1});
  b.emit(1, Rgb<S>(100));
  const auto scene = test::compose_bvh<Lambertian<S>>(b.parts, {Lambertian<S>{Rgb<S>(0.5)}, Lambertian<S>{Rgb<S>(0.5)}});
  using TheScene = std::remove_cv_t<decltype(scene)>;
  const FourConstraints<S> weighting(WeightingConfig<S>{1e-9, 1, 1, 100});
  test::RunningMoments radiance;
  for (std::uint32_t i = 0; i < 1000; ++i) {
    IndependentStream<S> stream(1, Stage::eye, 0, i);
    RayCounts rays;
    Collect collect;
    EyeSubpath<TheScene, FourConstraints<S>, IndependentStream<S>, Collect>(scene, weighting, 2, stream, rays, collect)
        .trace(Ray<S>{{1, 0, 1}, glm::normalize(Vec3<S>(-1, 0, -1))}, 1.0);
    radiance.add(collect.emitted.x);
  }
  EXPECT_NEAR(radiance.mean(), 0.5 * 100 * sqr(0.1 / 2), 5 * radiance.standard_error());
  EXPECT_LT(radiance.standard_error(), 0.01 * radiance.mean());
}

}  // namespace
}  // namespace manylight::generators_test
