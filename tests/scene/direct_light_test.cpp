// SPDX-License-Identifier: Apache-2.0
// Next event estimation against closed forms of irradiance, and the agreement of its samples with their densities.
#include <gtest/gtest.h>

#include <cmath>

#include "manylight/scene/emitters.hpp"
#include "scene/light_builders.hpp"

namespace manylight::test::direct_light_test {
namespace {

constexpr double k_round = 1e-9;  // double: rounding of some hundred operations, far below the noise of all estimates
const Vec3<double> k_up(0, 0, 1), k_down(0, 0, -1), k_origin(0);

// O-1 and O-2: radiance of a Lambertian surface under a point light. One sample is exact.
// Planted bug seen: the 4 pi of the flux in the intensity.
TEST(DirectLight, PointLightFollowsTheInverseSquareAndCosine) {
  LightRig<double> rig;
  rig.list.points = {{{0, 0, 2}, Rgb<double>(1)}};
  EXPECT_NEAR(irradiance(rig.build(), k_origin, k_up, 1).mean() * 0.5 / k_pi<double>, 0.0397887, 5e-8);  // digits given
  rig.list.points = {{{0, 0, 2}, Rgb<double>(100 / (4 * k_pi<double>))}};
  const auto lights = rig.build();
  EXPECT_NEAR(irradiance(lights, k_origin, k_up, 1).mean() * 0.8 / k_pi<double>, 0.506606, 5e-7);
  EXPECT_NEAR(irradiance(lights, {1.5, 0, 0}, k_up, 1).mean() * 0.8 / k_pi<double>, 0.259382, 5e-7);
}

// Planted bug seen: wi along the direction of travel.
TEST(DirectLight, DirectionalLightGivesItsPerpendicularIrradianceTimesTheCosine) {
  for (const double scale : {1e-3, 1.0, 1e4}) {
    LightRig<double> rig;
    rig.bounds = {Vec3<double>(-scale), Vec3<double>(scale)};
    rig.list.directionals = {{{3, 0, -4}, Rgb<double>(2)}};
    EXPECT_NEAR(irradiance(rig.build(), k_origin, k_up, 1).mean(), 2 * 0.8, k_round);
    EXPECT_EQ(irradiance(rig.build(), k_origin, k_down, 1).mean(), 0);
  }
}

// O-3. Planted bug seen: the cosine at the light left out of the density.
TEST(DirectLight, DiskOnAxis) {
  LightRig<double> rig;
  rig.emit(0, Rgb<double>(10));
  for (const auto& [height, exact] : {std::pair{1.0, 15.70796}, std::pair{2.0, 6.283185}}) {
    rig.shapes.disks = {disk<double>({0, 0, height}, k_down, 1)};
    expect_mean(irradiance(rig.build(), k_origin, k_up, 200'000), exact, 1e-6, "disk");  // digits given
  }
}

// O-4: mean irradiance of a disk from a coaxial one is pi L times the form factor receiver -> light.
TEST(DirectLight, CoaxialDisks) {
  struct Case {
    double receiver, light, distance, factor;
  };
  for (const Case& c : {Case{1, 1, 1, 0.381966}, Case{0.5, 1, 2, 0.192236}}) {
    LightRig<double> rig;
    rig.emit(0, Rgb<double>(1));
    rig.shapes.disks = {disk<double>({0, 0, c.distance}, k_down, c.light)};
    const auto lights = rig.build();
    RunningMoments mean;
    IndependentStream<double> stream(2, Stage::test, 0, 0);
    for (int i = 0; i < 200'000; ++i) {
      const Vec2<double> p = warp::square_to_disk(stream.next_2d()) * c.receiver;
      const double select = stream.next();
      const auto s = lights.sample_direct({p.x, p.y, 0}, select, stream.next_2d());
      mean.add(s ? s->radiance.x * s->wi.z / s->pdf : 0);
    }
    expect_mean(mean, k_pi<double> * c.factor, 3e-6, "coaxial");  // digits given
  }
}

// O-5, and published form factors of the unit square. The mesh's two triangles also test the table.
TEST(DirectLight, Rectangles) {
  LightRig<double> rig;
  rig.emit(0, Rgb<double>(1));
  rig.shapes.meshes = {rectangle<double>({0, 0, 1}, {0, 2, 0}, {2, 0, 0})};
  expect_mean(irradiance(rig.build(), k_origin, k_up, 200'000), k_pi<double> * 0.554126, 2e-6, "2 x 2");
  rig.shapes.meshes = {rectangle<double>({0, 0, 1}, {0, 1, 0}, {1, 0, 0})};
  expect_mean(irradiance(rig.build(), k_origin, k_up, 200'000), 0.752274, 2e-6, "unit square");
  expect_mean(irradiance(rig.build(), {0.5, 0.5, 0}, k_up, 200'000), k_pi<double> * 0.1385316, 2e-6, "corner");
}

// Closed form of a sphere over a plane, both scalars, three scales: fully above the horizon and cut by it.
// Planted bugs seen: half-angle from atan(a / D); the squared sine used for 1 - cos.
struct SphereCase {
  double sigma, omega, exact;
};
constexpr SphereCase k_spheres[] = {{0.3, 0.0, 0.274362},   {0.3, 1.0, 0.148239},   {0.3, 1.4, 0.0489923},
                                    {0.3, 1.57, 0.0177882}, {0.3, 1.7, 0.00463996}, {0.8, 1.2, 0.660260}};
template <class S>
void expect_spheres(double rounding) {
  for (const SphereCase& c : k_spheres) {
    for (const double scale : {1e-3, 1.0, 1e4}) {
      LightRig<S> rig;
      rig.emit(0, Rgb<S>(1));
      const Vec3<double> center(std::sin(c.omega) * scale, 0, std::cos(c.omega) * scale);
      rig.shapes.spheres = {{Vec3<S>(center), static_cast<S>(std::sin(c.sigma) * scale)}};
      expect_mean(irradiance(rig.build(), Vec3<S>(0), Vec3<S>(0, 0, 1), 100'000), c.exact, rounding, "sphere");
    }
  }
}
TEST(DirectLight, SpheresInDouble) { expect_spheres<double>(1e-5); }  // digits given
TEST(DirectLight, SpheresInFloat) { expect_spheres<float>(3e-5); }  // digits given and float cosines at grazing angles

// A tiny or distant sphere must not lose its solid angle to cancellation: E = pi (a / D)^2 to float precision.
// Planted bug seen: 1 - sqrt(1 - sin^2), which is 0 here.
TEST(DirectLight, TinyAndFarSpheresInFloat) {
  for (const float ratio : {1e-2F, 1e-4F, 1e-6F}) {
    LightRig<float> rig;
    rig.emit(0, Rgb<float>(1));
    rig.shapes.spheres = {{{0, 0, 1000}, 1000 * ratio}};
    const double exact = k_pi<double> * static_cast<double>(ratio) * static_cast<double>(ratio);
    // 1e-5: a hundred float roundings in mean and factors.
    expect_mean(irradiance(rig.build(), Vec3<float>(0), Vec3<float>(0, 0, 1), 5000), exact, 1e-5, "far sphere");
  }
}

// Just outside a sphere it fills the hemisphere: E = pi L.
TEST(DirectLight, ReferenceNextToASphere) {
  LightRig<float> rig;
  rig.emit(0, Rgb<float>(1));
  rig.shapes.spheres = {{{0, 0, 1}, 1 - 1e-6F}};
  // (a / D)^2 = 1 - 2e-6; 1e-3 because float leaves D - a one digit.
  expect_mean(irradiance(rig.build(), Vec3<float>(0), Vec3<float>(0, 0, 1), 100'000), k_pi<double>, 1e-3, "touching");
}

// A sphere that emits inwards gives E = pi L at every inner point and for every normal.
TEST(DirectLight, InsideAnInwardSphere) {
  LightRig<double> rig;
  rig.emit(0, Rgb<double>(1));
  rig.shapes.spheres = {{{1, 2, 3}, 2, true}};
  const auto lights = rig.build();
  for (const Vec3<double>& p : {Vec3<double>(1, 2, 3), Vec3<double>(2, 2, 3), Vec3<double>(1, 3, 2)}) {
    for (const Vec3<double>& n : {k_up, k_down, Vec3<double>(1, 0, 0)}) {
      expect_mean(irradiance(lights, p, n, 400'000), k_pi<double>, k_round, "inside");
    }
  }
}

// Case 14: one-sided emitters seen from behind give exactly nothing; two-sided ones the same on both sides.
// Planted bug seen: std::abs around the cosine of emits_towards.
TEST(DirectLight, OneSidedEmittersAreBlackFromBehind) {
  for (const bool two_sided : {false, true}) {
    LightRig<double> rig;
    rig.shapes.meshes = {rectangle<double>({0, 0, 1}, {0, 1, 0}, {1, 0, 0})};
    rig.shapes.spheres = {{{0, 0, 0}, 5, false}};
    rig.shapes.disks = {disk<double>({0.5, 0, 1}, k_down, 1)};
    for (std::uint32_t shape = 0; shape < 3; ++shape) {
      rig.list.areas.clear();
      rig.emit(shape, Rgb<double>(1), two_sided);
      const auto lights = rig.build();
      const double behind = irradiance(lights, {0, 0, 2}, k_down, 1000).mean();
      if (two_sided) {
        EXPECT_GT(behind, 0);
      } else {
        EXPECT_EQ(behind, 0);
      }
      SurfacePoint<double> point{};
      point.shape = shape;
      point.ng = k_down;
      EXPECT_EQ(lights.emitted(point, k_up).x, two_sided ? 1.0 : 0.0);
      EXPECT_EQ(lights.emitted(point, k_down).x, 1.0);
    }
  }
}

// `flip_normals`, and vertex normals against the winding, turn the emitting side as they turn surface_point's normal.
TEST(DirectLight, TheEmittingSideIsThatOfTheSurfacePoint) {
  for (const bool flip : {false, true}) {
    for (const double normal : {0.0, 1.0, -1.0}) {
      LightRig<double> rig;
      auto mesh = rectangle<double>({0, 0, 1}, {0, 1, 0}, {1, 0, 0});  // winding: down
      mesh.flip_normals = flip;
      if (normal != 0) mesh.normals.assign(4, Vec3<double>(0, 0, normal));
      rig.shapes.meshes = {mesh};
      rig.emit(0, Rgb<double>(1));
      const Ray<double> ray{k_origin, k_up};
      const double ng = surface_point(rig.shapes, ray, Hit<double>{1, 0, 0, 0.2, 0.2}).ng.z;
      const auto lights = rig.build();
      EXPECT_EQ(irradiance(lights, k_origin, k_up, 100).mean() > 0, ng < 0) << flip << normal;
      EXPECT_EQ(irradiance(lights, {0, 0, 2}, k_down, 100).mean() > 0, ng > 0) << flip << normal;
    }
  }
}

/// All kinds of light at once.
template <class S>
LightRig<S> mixed_rig() {
  LightRig<S> rig;
  rig.shapes.meshes = {rectangle<S>({0, 0, 3}, {0, 1, 0}, {1, 0, 0}), rectangle<S>({2, 0, 1}, {0, 0, 1}, {0, 1, 0})};
  rig.shapes.spheres = {{{-2, 0, 1}, S(0.5)}, {{0, 0, 0}, 20, true}};
  rig.shapes.disks = {disk<S>({0, 2, 1}, Vec3<S>(0, -1, 0), S(0.3))};
  for (const std::uint32_t shape : {0u, 2u, 3u, 4u}) {
    rig.emit(shape, Rgb<S>(S(1) + static_cast<S>(shape)), shape == 4);
  }
  rig.list.points = {{{1, 1, 1}, Rgb<S>(500)}};
  rig.list.directionals = {{{0, 0, -1}, Rgb<S>(300)}};
  auto image = std::make_shared<Image<S>>(8u, 5u);
  for (std::size_t i = 0; i < image->pixels.size(); ++i) image->pixels[i] = Rgb<S>(static_cast<S>(i % 7) * S(0.3));
  rig.list.environments = {{Rgb<S>(S(0.2))}, {Rgb<S>(1), image}};
  return rig;
}

// Sample and density agree to rounding, for every kind, and every value is usable. References lie everywhere, in float
// also on the lights themselves. Planted bugs seen: the selection probability left out of pdf_direct;
// the squared sine used for 1 - cos in the density of spheres.
template <class S>
void expect_agreement(double tolerance) {
  const auto rig = mixed_rig<S>();
  const auto lights = rig.build();
  IndependentStream<S> stream(5, Stage::test, 0, 0);
  int kinds[4] = {};
  for (int i = 0; i < 50'000; ++i) {
    const Vec3<S> reference = (Vec3<S>(stream.next(), stream.next(), stream.next()) - S(0.5)) * S(6);
    const S select = stream.next();
    const auto sample = lights.sample_direct(reference, select, stream.next_2d());
    if (!sample) continue;
    ++kinds[static_cast<int>(sample->kind)];
    ASSERT_TRUE(is_valid_radiance(sample->radiance) && sample->pdf > 0 && std::isfinite(sample->pdf));
    ASSERT_NEAR(glm::length(sample->wi), S(1), S(1e-5));  // float rounding of a normalisation
    double expected = static_cast<double>(sample->pdf);
    if (sample->kind == EmitterKind::environment) expected = lights.pdf_direct_environment(sample->wi);
    if (sample->kind == EmitterKind::area) {
      SurfacePoint<S> point{};
      point.position = sample->position;
      point.ng = sample->ng;
      point.shape = sample->shape;
      point.primitive = sample->primitive;
      expected = static_cast<double>(lights.pdf_direct(reference, point, sample->wi));
      // Position, direction and distance tell the same story, within the position's error.
      const S off = glm::length(reference + sample->wi * sample->distance - sample->position);
      ASSERT_LT(static_cast<double>(off), tolerance * 30) << "scene diameter 40";
    }
    ASSERT_NEAR(static_cast<double>(sample->pdf) / expected, 1, tolerance);
  }
  for (const int n : kinds) EXPECT_GT(n, 50);
}
TEST(DirectLight, SampleAndDensityAgreeInDouble) { expect_agreement<double>(1e-12); }  // thousands of ulp
TEST(DirectLight, SampleAndDensityAgreeInFloat) { expect_agreement<float>(1e-5); }     // a hundred ulp

// MIS needs the density of points found by other means: for a disk and a mesh that do not hide each other it integrates
// over all directions to the probability of selecting one of them, 1. Taken over the areas of the lights:
// pdf_direct d omega = pdf_direct cos / d^2 dA.
TEST(DirectLight, DensitiesIntegrateToTheSelectionProbability) {
  LightRig<double> rig;
  rig.shapes.meshes = {rectangle<double>({0, 0, 3}, {0, 1, 0}, {1, 0, 0})};
  rig.shapes.disks = {disk<double>({0, 2, 1}, {0, -1, 0}, 0.3)};
  rig.emit(0, Rgb<double>(1));
  rig.emit(1, Rgb<double>(4));
  const auto lights = rig.build();
  const Vec3<double> reference(0.3, -0.2, 0.1);
  IndependentStream<double> stream(9, Stage::test, 0, 0);
  RunningMoments integral;
  for (int i = 0; i < 200'000; ++i) {
    const bool on_disk = i % 2 == 1;
    SurfacePoint<double> p{};
    const Vec2<double> u = stream.next_2d();
    if (on_disk) {
      const Vec2<double> q = warp::square_to_disk(u) * 0.3;
      p.position = {q.x, 2, 1 + q.y};
      p.ng = {0, -1, 0};
      p.shape = 1;
    } else {
      p.position = {u.x - 0.5, u.y - 0.5, 3};
      p.ng = k_down;
      p.primitive = (u.y > u.x) ? 0 : 1;  // positions (a, a + x, a + x + y): x of the mesh is world y
    }
    const Vec3<double> segment = p.position - reference;
    const double d2 = glm::dot(segment, segment);
    const Vec3<double> wi = segment / std::sqrt(d2);
    const double area = on_disk ? k_pi<double> * 0.09 : 1.0;
    integral.add(2 * area * lights.pdf_direct(reference, p, wi) * -glm::dot(wi, p.ng) / d2);
  }
  expect_mean(integral, 1, k_round, "density");
}

}  // namespace
}  // namespace manylight::test::direct_light_test
