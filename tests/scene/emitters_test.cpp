// SPDX-License-Identifier: Apache-2.0
// Selection among many lights, special counts, bad input and memory.
#include "manylight/scene/emitters.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "scene/light_builders.hpp"
#include "support/chi_square.hpp"

namespace manylight::test::emitters_test {
namespace {

// Case 24: no lights, and lights of no power, give no samples; 1, 2, 3 lights give the sum.
TEST(Emitters, NoneOneTwoAndThreeLights) {
  LightRig<double> rig;
  const Vec3<double> up(0, 0, 1);
  EXPECT_TRUE(Emitters<double>().empty());
  EXPECT_TRUE(rig.build().empty());
  EXPECT_EQ(rig.build().count(), 0u);
  EXPECT_EQ(rig.build().environment(up), Rgb<double>(0));
  EXPECT_FALSE(rig.build().sample_direct(Vec3<double>(0), 0.5, {0.5, 0.5}));
  EXPECT_FALSE(rig.build().sample_emission(0.5, {0.5, 0.5}, {0.5, 0.5}));
  EXPECT_EQ(rig.build().pdf_direct_environment(up), 0);
  double expected = 0;
  for (int i = 1; i <= 3; ++i) {
    rig.list.points.push_back({{0, 0, static_cast<double>(i)}, Rgb<double>(i)});
    expected += 1.0 / i;                                                                            // I / h^2
    expect_mean(irradiance(rig.build(), Vec3<double>(0), up, 100'000), expected, 1e-12, "points");  // rounding
    EXPECT_EQ(rig.build().count(), static_cast<std::uint32_t>(i));
  }
}

// Case 22: a black light among others is never chosen, and alone makes the scene dark, of whatever kind it is.
TEST(Emitters, LightsOfNoPowerAreNeverChosen) {
  LightRig<double> rig;
  rig.shapes.meshes = {rectangle<double>({0, 0, 1}, {0, 1, 0}, {1, 0, 0})};
  rig.shapes.meshes[0].triangles.push_back({0, 1, 1});  // degenerate
  rig.shapes.spheres = {{{0, 0, 3}, 1}};
  rig.emit(1, Rgb<double>(0));
  rig.list.points = {{{0, 0, 1}, Rgb<double>(0)}};
  rig.list.directionals = {{{0, 0, -1}, Rgb<double>(0)}};
  auto black = std::make_shared<Image<double>>(4u, 3u);
  rig.list.environments = {{Rgb<double>(0)}, {Rgb<double>(1), black}};
  EXPECT_TRUE(rig.build().empty());
  rig.emit(0, Rgb<double>(1));
  const auto lights = rig.build();
  IndependentStream<double> stream(1, Stage::test, 0, 0);
  for (int i = 0; i < 20'000; ++i) {
    const double select = stream.next();
    const Vec2<double> u = stream.next_2d();
    const auto sample = lights.sample_emission(select, u, stream.next_2d());
    ASSERT_TRUE(sample && sample->shape == 0 && sample->primitive < 2 && is_valid_radiance(sample->beta));
  }
  EXPECT_EQ(lights.selection_probability(2), 0) << "degenerate triangle";
}

// Case 21: 0, 1 and 2 environments beside area lights and the rest: every selection probability is
// its share of the flux, and draws follow them. Chi-square, 200,000 draws, false alarm 1e-4 each.
// Planted bugs seen: environments by their radiance instead of flux; triangles by count instead of area.
TEST(Emitters, SelectByFlux) {
  for (int environments = 0; environments <= 2; ++environments) {
    LightRig<double> rig;
    auto mesh = rectangle<double>({0, 0, 1}, {0, 1, 0}, {1, 0, 0});
    mesh.positions.push_back({3, 3, 3});
    mesh.triangles.push_back({0, 1, 4});
    rig.shapes.meshes = {mesh};
    rig.shapes.spheres = {{{0, 0, 3}, 0.5}};
    rig.shapes.disks = {disk<double>({0, 0, -3}, {0, 0, 1}, 0.7)};
    rig.emit(1, Rgb<double>(3));
    rig.emit(0, Rgb<double>(10));
    rig.emit(2, Rgb<double>(2), true);
    rig.list.points = {{{9, 0, 1}, Rgb<double>(1)}, {{8, 0, 1}, Rgb<double>(2)}};
    rig.list.directionals = {{{0, 0, -1}, Rgb<double>(1)}};
    for (int i = 0; i < environments; ++i) rig.list.environments.push_back({Rgb<double>(0.3 + i)});
    const auto lights = rig.build();
    const double pi = k_pi<double>, section = pi * 3 * 1.0001 * 1.0001;  // half diagonal of a box of side 2
    const double skew =
        glm::length(glm::cross(mesh.positions[1] - mesh.positions[0], mesh.positions[4] - mesh.positions[0]));
    std::vector<double> flux = {
        10 * pi / 2, 10 * pi / 2, 10 * pi * skew / 2, 3 * pi * pi, 2 * 2 * pi * pi * 0.49, 4 * pi, 8 * pi, section};
    for (int i = 0; i < environments; ++i) flux.push_back(section * 4 * pi * (0.3 + i));
    ASSERT_EQ(lights.count(), flux.size());
    double total = 0;
    for (const double f : flux) total += f;
    EXPECT_NEAR(lights.total_flux().x / total, 1, 1e-12);  // rounding
    constexpr int k_count = 200'000;
    std::vector<ExpectedCount> cells(flux.size());
    for (std::size_t i = 0; i < flux.size(); ++i) {
      EXPECT_NEAR(lights.selection_probability(static_cast<std::uint32_t>(i)), flux[i] / total, 1e-7);  // float table
      cells[i] = {flux[i] / total * k_count, 0, "light " + std::to_string(i)};
    }
    if (environments == 2) {  // the sample does not tell which of two constants drew it
      cells[8].expected += cells[9].expected;
      cells.pop_back();
    }
    IndependentStream<double> stream(2, Stage::test, 0, 0);
    for (int i = 0; i < k_count; ++i) {
      const double select = stream.next();
      const Vec2<double> u = stream.next_2d();
      const auto s = lights.sample_emission(select, u, stream.next_2d());
      ASSERT_TRUE(s);
      std::size_t cell = 8;
      if (s->kind == EmitterKind::area) cell = s->shape == 0 ? s->primitive : s->shape + 2;
      if (s->kind == EmitterKind::point) cell = s->position.x > 8.5 ? 5 : 6;
      if (s->kind == EmitterKind::directional) cell = 7;
      ASSERT_LT(cell, cells.size());
      cells[cell].observed += 1;
    }
    const auto result = chi_square(cells);
    EXPECT_TRUE(result.passes(1e-4)) << result.describe();
  }
}

// Environments add up, for rays that escape and for samples; the density is that of the mixture.
// Planted bug seen: radiance of the drawn environment alone.
TEST(Emitters, EnvironmentsAddUp) {
  LightRig<double> rig;
  auto image = std::make_shared<Image<double>>(4u, 3u, Rgb<double>(0));
  image->at(1, 1) = Rgb<double>(8);
  rig.list.environments = {{Rgb<double>(1)}, {Rgb<double>(1), image}};
  const auto both = rig.build();
  rig.list.environments.pop_back();
  const auto constant = rig.build();
  rig.list.environments = {{Rgb<double>(1), image}};
  const auto mapped = rig.build();
  const Vec3<double> n = glm::normalize(Vec3<double>(1, 0.3, 0.2));
  const auto a = irradiance(constant, Vec3<double>(0), n, 200'000, 1),
             b = irradiance(mapped, Vec3<double>(0), n, 200'000, 2);
  const auto sum = irradiance(both, Vec3<double>(0), n, 200'000, 3);
  const double error =
      std::sqrt(std::pow(a.standard_error(), 2) + std::pow(b.standard_error(), 2) + std::pow(sum.standard_error(), 2));
  EXPECT_LE(std::abs(sum.mean() - a.mean() - b.mean()), k_z_limit * error);
  EXPECT_LT(error, 0.02 * sum.mean());
  EXPECT_NEAR(both.environment(n).x, constant.environment(n).x + mapped.environment(n).x, 1e-12);
}

// Case 22: the sum of 100,000 weak lights beside a strong one is not lost, in float. The strong one lies below the
// horizon of the receiver; the weak ones in one point 1 m above have 1e-5 W/sr each, in total 1 W/sr of 101.
TEST(Emitters, WeakLightsSurviveAStrongOne) {
  LightRig<float> rig;
  rig.list.points.assign(100'000, {{0, 0, 1}, Rgb<float>(1e-5F)});
  rig.list.points.push_back({{0, 0, -1}, Rgb<float>(100)});
  // 1e-5: float probabilities of 1e-8
  const auto weak = irradiance(rig.build(), Vec3<float>(0), Vec3<float>(0, 0, 1), 2'500'000);
  expect_mean(weak, 1, 1e-5, "weak lights");
}

template <class Spoil>
void expect_rejected(const std::string& element, const Spoil& spoil) {
  LightRig<float> rig;
  rig.shapes.spheres = {{{0, 0, 3}, 1}};
  rig.emit(0, Rgb<float>(1));
  rig.list.points = {{{0, 0, 1}, Rgb<float>(1)}, {{0, 0, 1}, Rgb<float>(1)}};
  rig.list.directionals = {{{0, 0, -1}, Rgb<float>(1)}};
  rig.list.environments = {{Rgb<float>(1)}};
  EXPECT_NO_THROW((void)rig.build());
  spoil(rig);
  try {
    (void)rig.build();
    FAIL() << element;
  } catch (const ParameterError& error) {
    EXPECT_NE(std::string(error.what()).find(element), std::string::npos) << error.what();
  }
}

// Case 22: the bad value is rejected with a message that names the emitter.
TEST(Emitters, RejectBadInputByName) {
  using Rig = LightRig<float>;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const float bad : {-1.0F, nan, k_infinity<float>}) {
    expect_rejected("area emitter on shape 0",
                    [=](Rig& r) { r.list.areas[0].radiance = Texture<float>(Rgb<float>(1, bad, 1)); });
    expect_rejected("point light 1", [=](Rig& r) { r.list.points[1].intensity.z = bad; });
    expect_rejected("directional light 0", [=](Rig& r) { r.list.directionals[0].irradiance.x = bad; });
    expect_rejected("environment radiance", [=](Rig& r) { r.list.environments[0].radiance.y = bad; });
  }
  expect_rejected("position of point light 0", [=](Rig& r) { r.list.points[0].position.x = nan; });
  expect_rejected("direction of directional light 0",
                  [](Rig& r) { r.list.directionals[0].direction = Vec3<float>(0); });
  expect_rejected("shape of an area emitter", [](Rig& r) { r.list.areas[0].shape = 7; });
  expect_rejected("area emitter on shape 0", [](Rig& r) { r.list.areas.push_back(r.list.areas[0]); });
  expect_rejected("scene bounds", [](Rig& r) { r.bounds.hi.x = k_infinity<float>; });
}

TEST(Emitters, SceneSphereIsPositiveForFlatAndPointScenes) {
  LightRig<float> rig;
  rig.bounds = Box<float>();
  EXPECT_GT(rig.build().scene_radius(), 0.0F);
  rig.bounds.extend(Vec3<float>(3));
  EXPECT_GT(rig.build().scene_radius(), 0.0F);
  EXPECT_EQ(rig.build().scene_center(), Vec3<float>(3));
  rig.bounds.extend(Vec3<float>(5, 3, 3));
  EXPECT_GE(rig.build().scene_radius(), 1.0F);
}

// Case 37 and published figures of others (800 bytes per triangle): at most 64 bytes, 88 with a texture.
TEST(Emitters, CostFewBytesPerTriangle) {
  for (const bool textured : {false, true}) {
    LightRig<float> rig;
    TriangleMesh<float> mesh;
    for (int i = 0; i < 100'000; ++i) {
      const auto base = static_cast<std::uint32_t>(mesh.positions.size());
      const float x = static_cast<float>(i);
      for (const Vec3<float>& p : {Vec3<float>(x, 0, 0), Vec3<float>(x, 1, 0), Vec3<float>(x, 0, 1)}) {
        mesh.positions.push_back(p);
        mesh.uvs.push_back({p.y, p.z});
      }
      mesh.triangles.push_back({base, base + 1, base + 2});
    }
    rig.shapes.meshes = {mesh};
    rig.list.areas = {
        {0, textured ? Texture<float>::checkerboard(Rgb<float>(1), Rgb<float>(0)) : Texture<float>(Rgb<float>(1))}};
    const auto lights = rig.build();
    EXPECT_EQ(lights.count(), 100'000u);
    EXPECT_LE(lights.bytes_per_primitive(), textured ? 88 : 64);
    EXPECT_GE(lights.bytes_per_primitive(), 48);  // three corners and a table entry: the figure is not made up
  }
}

}  // namespace
}  // namespace manylight::test::emitters_test
