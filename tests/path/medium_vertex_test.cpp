// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "manylight/path/connect.hpp"
#include "manylight/scattering/any_phase.hpp"
#include "manylight/scattering/falloff_profiles.hpp"
#include "manylight/scattering/gaussian_fiber.hpp"
#include "manylight/scattering/henyey_greenstein.hpp"
#include "manylight/scattering/lambertian.hpp"
#include "manylight/scattering/subsurface.hpp"

// Vertices off surfaces: in media and below surfaces.

namespace manylight::medium_vertex_test {
namespace {

using S = double;
using V = Vec3<S>;
using M = Lambertian<S>;

static_assert(sizeof(Vertex<float, Lambertian<float>>) == sizeof(Vertex<float, Lambertian<float>, NoPhase, NoSubsurface>));
static_assert(sizeof(Vertex<float, Lambertian<float>, HenyeyGreenstein<float>>) ==
                  sizeof(Vertex<float, Lambertian<float>>) + 8,
              "a phase function of one number and two media");

template <class Phase>
Vertex<S, M, Phase> in_medium(const Phase& phase, const V& position, const V& w) {
  Vertex<S, M, Phase> v;
  v.kind = VertexKind::medium;
  v.phase = phase;
  v.position = position;
  v.w = glm::normalize(w);
  v.alpha = 1;
  return v;
}

/// Light goes straight on: from behind the sensor as seen from the eye, and out of the light opposite to where it came
/// from. Caught: the light's turned round.
TEST(MediumVertex, ForwardScatteringGoesStraightOn) {
  const HenyeyGreenstein<S> phase{0.8};
  const S peak = phase.eval({0, 0, 1}, {0, 0, -1});
  ASSERT_NEAR(peak, 1.8 / (4 * k_pi<S> * 0.04), 1e-9);  // rounding of 0.04 = (1 - g)^2, here and below
  // Eye at -z, sensor at 0, light at z = 2 which was lit from z = 5.
  const auto pair = connect(in_medium(phase, {0, 0, 0}, {0, 0, -1}), in_medium(phase, {0, 0, 2}, {0, 0, 1}), S(1));
  EXPECT_NEAR(pair.m.x, peak, 1e-9);
  EXPECT_NEAR(pair.d.x, peak, 1e-9);
  EXPECT_NEAR(pair.sensor_d, peak, 1e-9);
  EXPECT_NEAR(pair.t, 0.25, 1e-12);  // a few roundings, here and below
}

/// sigma_s(wo) M = sigma_s(wi) D of one event: s is what both subpaths see [theory 1.4, 2.1]. Caught: the
/// sensor's patterns exchanged.
TEST(MediumVertex, FibersScatterTheSameBothWays) {
  const GaussianFiberTable<S> table(0.3);
  const GaussianFiber<S> phase(table, glm::normalize(V(0.2, 0.5, 0.8)));
  const V wi = glm::normalize(V(0.7, -0.2, 0.4));
  const V wo = glm::normalize(V(-0.1, 0.9, -0.3));
  Vertex<S, M, AnyPhase<HenyeyGreenstein<S>, GaussianFiber<S>>> sensor;
  sensor.kind = VertexKind::medium;
  sensor.phase = phase;
  sensor.alpha = 1;
  auto light = sensor;
  sensor.w = wo;
  light.w = wi;
  const SensorPatterns<S> of_sensor = sensor_patterns(sensor, wi);
  const S of_light = light_pattern(light, wo).x;
  EXPECT_NEAR(phase.projected_area(wo) * of_sensor.m.x, phase.projected_area(wi) * of_light, 1e-12);
  EXPECT_NEAR(of_sensor.d, of_light, 1e-12);
  EXPECT_GT(std::abs(of_sensor.m.x - of_light), 1e-3) << "the test must tell them apart";
}

/// Inner vertices of one object see each other through it, T = pi g(d); of no other object, and no outer vertex.
/// Caught: one channel for all objects.
TEST(SubsurfaceVertex, ConnectsWithinItsObjectAlone) {
  Subsurface<ExponentialFalloff<S>> jade;
  jade.falloff = ExponentialFalloff<S>(Rgb<S>(0.5, 1, 2));
  using Vx = Vertex<S, M, NoPhase, Subsurface<ExponentialFalloff<S>>>;
  Vx sensor;
  sensor.kind = VertexKind::subsurface_inner;
  sensor.below = &jade;
  sensor.object = 3;
  sensor.w = V(0.6, 0, 0.8);
  Vx light = sensor;
  light.position = V(0.7, 0, 0);
  const auto pair = connect(sensor, light, S(1));
  const Rgb<S> g = jade.falloff.eval(0.7);
  for (int channel = 0; channel < 3; ++channel) {
    EXPECT_NEAR(pair.m[channel] * pair.t * pair.d[channel], g[channel] / k_pi<S>, 1e-12);
  }
  EXPECT_NEAR(max_channel(pair.m), 1 / k_pi<S>, 1e-12);
  EXPECT_NEAR(pair.sensor_d, 0.8 / k_pi<S>, 1e-12);
  light.object = 4;
  EXPECT_TRUE(connect(sensor, light, S(1)).is_zero());
  light.object = 3;
  light.kind = VertexKind::subsurface_outer;
  EXPECT_TRUE(connect(sensor, light, S(1)).is_zero());
}

}  // namespace
}  // namespace manylight::medium_vertex_test
