// SPDX-License-Identifier: Apache-2.0
// Spot lights as emitters: falloff, flux, both kinds of sampling, what set-up refuses.
#include <cmath>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "manylight/core/sampler.hpp"
#include "scene/light_builders.hpp"
#include "support/z_test.hpp"

namespace manylight::test::spot_lights_test {
namespace {

constexpr double k_pi_d = k_pi<double>;

PointEmitter<double> spot(double cutoff, double beam_width, const Vec3<double>& axis = {0, 0, -2}) {
  return {{0.3, 0.2, 1.5}, Rgb<double>(2, 4, 1), axis, cutoff, beam_width};
}

TEST(SpotLights, FallOffLinearlyInTheAngle) {
  const Vec3<double> axis = glm::normalize(Vec3<double>(1, 2, -2));
  const Frame<double> frame(axis);
  const auto at = [&](double angle) {
    return spot_falloff(frame.to_world({std::sin(angle), 0, std::cos(angle)}), axis, 0.2, 0.5);
  };
  EXPECT_EQ(at(0), 1);
  EXPECT_EQ(at(0.199), 1);
  EXPECT_NEAR(at(0.35), 0.5, 1e-14);  // some ulp
  EXPECT_NEAR(at(0.49), 0.1 / 3, 1e-14);  // the same
  EXPECT_EQ(at(0.501), 0);
  EXPECT_EQ(at(3), 0);
  EXPECT_EQ(spot_falloff(axis, axis, 0.2, 0.2), 1);  // a hard edge
  EXPECT_EQ(spot_falloff(-axis, axis, 0.2, 0.2), 0);
}

// Oracle: the midpoint rule on 1e5 rings, error 1e-10 of the integral; the cap 2 pi (1 - cos) without a penumbra.
// Planted bug seen to fail: the integral without its second term.
TEST(SpotLights, FluxIsTheIntegralOfTheFalloff) {
  for (const auto& [cutoff, beam] : {std::pair{0.5, 0.2}, {3.0, 1.0}, {k_pi_d, 0.0}, {0.01, 0.0}, {1e-3, 0.9e-3}}) {
    double sum = 0;
    constexpr int k_steps = 100'000;
    for (int i = 0; i < k_steps; ++i) {
      const double angle = cutoff * (i + 0.5) / k_steps;
      const double part = angle <= beam ? 1 : (cutoff - angle) / (cutoff - beam);
      sum += 2 * k_pi_d * part * std::sin(angle) * cutoff / k_steps;
    }
    EXPECT_NEAR(spot(cutoff, beam).effective_solid_angle() / sum, 1, 1e-8) << cutoff;  // of the midpoint rule
    const auto single = PointEmitter<float>{
        Vec3<float>(0), Rgb<float>(1), {0, 0, 1}, static_cast<float>(cutoff), static_cast<float>(beam)};
    EXPECT_NEAR(double(single.effective_solid_angle()) / sum, 1, 2e-6) << cutoff;  // float, and its rounded angles
  }
  EXPECT_NEAR(spot(0.4, 0.4).effective_solid_angle(), 2 * k_pi_d * (1 - std::cos(0.4)), 1e-14);  // some ulp
  EXPECT_NEAR(PointEmitter<double>{}.effective_solid_angle(), 4 * k_pi_d, 1e-14);  // the same
}

// Light paths carry the flux in the mean (z-test, false-alarm rate 1e-4) and leave within the cone with the density
// that the sample states. Planted bug seen to fail: the density of the whole sphere.
TEST(SpotLights, EmissionCarriesTheFlux) {
  for (const auto& [cutoff, beam] : {std::pair{0.5, 0.2}, {2.5, 0.4}, {0.01, 0.005}}) {
    LightRig<double> rig;
    rig.bounds = {Vec3<double>(-2, -2, 0), Vec3<double>(2, 2, 3)};
    rig.list.points = {spot(cutoff, beam)};
    const auto lights = rig.build();
    IndependentStream<double> stream(5, Stage::test, 0, 0);
    RunningMoments moments;
    for (int k = 0; k < 40'000; ++k) {
      const double select = stream.next();
      const Vec2<double> position = stream.next_2d();
      const auto s = lights.sample_emission(select, position, stream.next_2d());
      ASSERT_TRUE(s.has_value());
      ASSERT_LE(std::acos(std::min(1.0, -s->wo.z)), cutoff * (1 + 1e-5));
      ASSERT_NEAR(s->pdf_direction * 2 * k_pi_d * 2 * sqr(std::sin(cutoff / 2)), 1, 1e-12);  // some ulp
      ASSERT_NEAR(s->beta.y, s->radiance.y / (s->pdf_position * s->pdf_direction), 1e-12 * s->intensity.y);
      moments.add(s->beta.y);
    }
    const double flux = lights.total_flux().y;
    EXPECT_NEAR(flux, 4 * spot(cutoff, beam).effective_solid_angle(), 1e-12 * flux);
    EXPECT_NEAR(moments.mean(), flux, normal_limit(1e-4 / 3) * moments.standard_error());
  }
}

// I falloff / d^2 within the cone; none outside of it, behind, and at the light itself.
TEST(SpotLights, DirectSamplesAreExact) {
  LightRig<double> rig;
  rig.bounds = {Vec3<double>(-2, -2, 0), Vec3<double>(2, 2, 3)};
  rig.list.points = {spot(0.5, 0.2)};
  const auto lights = rig.build();
  const Vec3<double> at = rig.list.points[0].position;
  const auto sample = [&](const Vec3<double>& reference) { return lights.sample_direct(reference, 0.5, {0.5, 0.5}); };
  const auto below = sample(at - Vec3<double>(0, 0, 1.5));
  ASSERT_TRUE(below && below->is_delta);
  EXPECT_NEAR(below->radiance.y, 4 / 2.25, 1e-14);
  EXPECT_EQ(below->pdf, 1);
  const auto aside = sample(at + 2.0 * Vec3<double>(std::sin(0.35), 0, -std::cos(0.35)));
  ASSERT_TRUE(aside.has_value());
  EXPECT_NEAR(aside->radiance.x, 2 * 0.5 / 4, 1e-14);
  EXPECT_FALSE(sample(at + Vec3<double>(std::sin(0.51), 0, -std::cos(0.51))).has_value());
  EXPECT_FALSE(sample(at + Vec3<double>(0, 0, 1)).has_value());
  EXPECT_FALSE(sample(at).has_value());
}

TEST(SpotLights, BadParametersAreNamed) {
  const auto message = [](const PointEmitter<double>& light) -> std::string {
    LightRig<double> rig;
    rig.list.points = {light};
    try {
      static_cast<void>(rig.build());
    } catch (const ParameterError& error) {
      return error.what();
    }
    return "accepted";
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(message(spot(0.5, 0.5)), "accepted");
  const auto names = [&](const PointEmitter<double>& light, const char* what) {
    return message(light).find(what) != std::string::npos;
  };
  for (const double bad : {nan, -1.0, 0.0, 4.0}) EXPECT_TRUE(names(spot(bad, 0), "cutoff of point light 0")) << bad;
  for (const double bad : {nan, -1.0, 0.6}) EXPECT_TRUE(names(spot(0.5, bad), "beam width of point light 0")) << bad;
  EXPECT_TRUE(names(spot(0.5, 0.2, Vec3<double>(0)), "axis of point light 0"));
  EXPECT_TRUE(names(spot(0.5, 0.2, Vec3<double>(nan)), "axis of point light 0"));
}

}  // namespace
}  // namespace manylight::test::spot_lights_test
