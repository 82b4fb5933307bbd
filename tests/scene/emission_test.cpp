// SPDX-License-Identifier: Apache-2.0
// The start of light subpaths: flux, the irradiance that rays carry, and the virtual lights they leave at the emitters.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "manylight/scene/emitters.hpp"
#include "scene/light_builders.hpp"

namespace manylight::test::emission_test {
namespace {

constexpr double k_round = 1e-9;  // double: rounding of some hundred operations
const Vec3<double> k_up(0, 0, 1);

template <class S>
EmissionSample<S> emit(const Emitters<S>& lights, IndependentStream<S>& stream) {
  for (;;) {
    const S select = stream.next();
    const Vec2<S> position = stream.next_2d();
    if (const auto sample = lights.sample_emission(select, position, stream.next_2d())) return *sample;
  }
}

/// One light of each kind above the floor patch, one rig each.
std::vector<LightRig<double>> single_rigs(double scale) {
  std::vector<LightRig<double>> rigs(9);
  for (auto& rig : rigs) rig.bounds = {Vec3<double>(-2, -2, 0) * scale, Vec3<double>(2, 2, 3) * scale};
  rigs[0].shapes.meshes = {rectangle<double>(Vec3<double>(0, 0, 2) * scale, {0, scale, 0}, {scale, 0, 0})};
  rigs[1].shapes.spheres = {{Vec3<double>(0.5, 0, 2) * scale, 0.4 * scale}};
  rigs[2].shapes.disks = {
      disk<double>(Vec3<double>(0, 0.3, 1) * scale, glm::normalize(Vec3<double>(0.5, 0, -1)), scale)};
  rigs[3].shapes = rigs[2].shapes;
  for (int i = 0; i < 4; ++i) rigs[static_cast<std::size_t>(i)].emit(0, Rgb<double>(7), i == 3);
  rigs[4].list.points = {{Vec3<double>(0.2, 0.1, 1) * scale, Rgb<double>(3)}};
  rigs[5].list.directionals = {{{0.3, 0, -1}, Rgb<double>(2)}};
  rigs[6].list.environments = {{Rgb<double>(1.5)}};
  auto image = std::make_shared<Image<double>>(8u, 5u);
  for (std::size_t i = 0; i < image->pixels.size(); ++i)
    image->pixels[i] = Rgb<double>(0.1 + static_cast<double>(i % 7));
  rigs[7].list.environments = {{Rgb<double>(1), image}};
  // A sphere seen from inside, which emits inwards.
  rigs[8].shapes.spheres = {{Vec3<double>(0, 0, 1) * scale, 2.5 * scale, true}};
  rigs[8].emit(0, Rgb<double>(1));
  return rigs;
}
const char* const k_names[] = {"rectangle",   "sphere",   "disk",      "two-sided disk", "point",
                               "directional", "constant", "image map", "inner sphere"};

// The density of light subpaths, asked for at the start that was drawn for a subpath, at the same point of a shape and at a
// light drawn for a point, is one and the same, and gives the power that subpaths carry: beta = radiance / projected pdf.
// Planted bugs seen: both sides of a lamp counted as one; the selection left out for point lights.
TEST(Emission, ProjectedDensityIsTheSameHoweverTheLightIsFound) {
  auto rigs = single_rigs(1.5);
  rigs.resize(10);
  for (std::size_t i = 0; i < 9; ++i) {  // of all kinds together, for their selection
    LightRig<double>& all = rigs[9];
    all.bounds = rigs[i].bounds;
    for (const auto& light : rigs[i].list.points) all.list.points.push_back(light);
    for (const auto& light : rigs[i].list.directionals) all.list.directionals.push_back(light);
    for (const auto& light : rigs[i].list.environments) all.list.environments.push_back(light);
  }
  rigs[9].list.points.push_back({{0, 1, 1}, Rgb<double>(2), {0, 0, -1}, 0.7, 0.4});
  rigs[9].shapes.disks = rigs[3].shapes.disks;
  rigs[9].emit(0, Rgb<double>(7), true);
  std::size_t points = 0;
  for (const auto& rig : rigs) {
    const auto lights = rig.build();
    IndependentStream<double> stream(3, Stage::test, 0, 0);
    for (int i = 0; i < 400; ++i) {
      const auto start = emit(lights, stream);
      const double pdf = start.projected_pdf();
      EXPECT_NEAR(start.beta.x, start.radiance.x / pdf, k_round * start.beta.x);
      if (start.kind == EmitterKind::area) {
        SurfacePoint<double> point{};
        point.shape = start.shape;
        point.primitive = start.primitive;
        EXPECT_NEAR(lights.projected_pdf_emission(point) / pdf, 1, k_round);
      }
      if (start.kind == EmitterKind::environment) {
        EXPECT_NEAR(lights.projected_pdf_emission_environment(-start.wo) / pdf, 1, k_round);
      }
      const double select = stream.next();
      const auto drawn = lights.sample_direct({0.1, 0.2, 0.3}, select, stream.next_2d());
      if (!drawn) continue;
      const double found = lights.projected_pdf_emission(*drawn);
      if (drawn->kind == EmitterKind::area) {
        SurfacePoint<double> point{};
        point.shape = drawn->shape;
        point.primitive = drawn->primitive;
        EXPECT_NEAR(found / lights.projected_pdf_emission(point), 1, k_round);
      } else if (drawn->kind == EmitterKind::environment) {
        EXPECT_NEAR(found / lights.projected_pdf_emission_environment(drawn->wi), 1, k_round);
      } else if (drawn->kind == EmitterKind::directional) {
        EXPECT_NEAR(found, drawn->pdf * k_inv_pi<double> / sqr(lights.scene_radius()), k_round * found);
      } else {
        ++points;
        const bool is_spot = drawn->position == Vec3<double>(0, 1, 1);
        const double solid_angle = 2 * k_pi<double> * (1 - std::cos(is_spot ? 0.7 : k_pi<double>));
        EXPECT_NEAR(found, drawn->pdf / solid_angle, k_round * found);
      }
    }
  }
  EXPECT_GT(points, 400U);  // those of the rig of a point light alone, and more
}

// What an emission sample carries on average is the total flux; without texture and colour it is so for every sample.
// Closed forms: pi A L, both sides, 4 pi I, pi R^2 E, 4 pi^2 R^2 L.
// Planted bugs seen: one pi missing for areas; R for R^2; the factor for two sides left out of beta.
TEST(Emission, CarriesTheTotalFlux) {
  for (const double scale : {1e-3, 1.0, 1e4}) {
    const auto rigs = single_rigs(scale);
    const double pi = k_pi<double>, r2 = 41.0 / 4 * 1.0001 * 1.0001, s2 = scale * scale;  // half diagonal of 4 x 4 x 3
    const double exact[] = {7 * pi * s2,
                            7 * pi * 4 * pi * 0.16 * s2,
                            7 * pi * pi * s2,
                            2 * 7 * pi * pi * s2,
                            12 * pi,
                            2 * pi * r2 * s2,
                            1.5 * 4 * pi * pi * r2 * s2,
                            0,
                            pi * 4 * pi * 6.25 * s2};
    for (std::size_t i = 0; i < rigs.size(); ++i) {
      const auto lights = rigs[i].build();
      IndependentStream<double> stream(1, Stage::test, i, 0);
      RunningMoments beta;
      for (int k = 0; k < 20'000; ++k) beta.add(emit(lights, stream).beta.y);
      if (i == 7) {
        // Corner means of cells 45 degrees high against the bilinear image: second order, measured 1 %.
        EXPECT_NEAR(beta.mean() / lights.total_flux().y, 1, 0.03);
        continue;
      }
      EXPECT_NEAR(beta.mean() / exact[i], 1, k_round) << k_names[i];
      EXPECT_NEAR(lights.total_flux().y / exact[i], 1, k_round) << k_names[i];
    }
  }
}

// Rays from the emitters bring to a patch of the floor what next event estimation finds there: position, direction,
// weight and side of every kind of light at once. The z-test is of the difference; 1e-5 each.
// Planted bugs seen: uniform instead of cosine-weighted directions; travel direction of the environment not turned
// round; the disk of infinite lights half as large; the inner side's frame on the outer side.
TEST(Emission, BringsTheIrradianceOfNextEventEstimation) {
  const auto rigs = single_rigs(1);
  for (std::size_t i = 0; i < rigs.size(); ++i) {
    const auto lights = rigs[i].build();
    IndependentStream<double> stream(2, Stage::test, i, 0);
    RunningMoments by_rays, by_points;
    for (int k = 0; k < 200'000; ++k) {
      const auto ray = emit(lights, stream);
      const double t = -ray.position.z / ray.wo.z;
      const Vec3<double> hit = ray.position + ray.wo * t;
      const bool on_patch = t > 0 && ray.wo.z < 0 && std::abs(hit.x) < 0.5 && std::abs(hit.y) < 0.5;
      by_rays.add(on_patch ? ray.beta.x : 0);  // area 1
      const Vec2<double> p = stream.next_2d() - 0.5;
      const double select = stream.next();
      const auto light = lights.sample_direct({p.x, p.y, 0}, select, stream.next_2d());
      by_points.add(light && light->wi.z > 0 ? light->radiance.x * light->wi.z / light->pdf : 0);
    }
    const double error = std::hypot(by_rays.standard_error(), by_points.standard_error());
    EXPECT_LE(std::abs(by_rays.mean() - by_points.mean()), k_z_limit * error)
        << k_names[i] << ": " << by_rays.mean() << " against " << by_points.mean();
    EXPECT_LT(error, 0.03 * by_points.mean()) << k_names[i];
  }
}

// As virtual lights: the mean of intensity D T cos over emission samples is the irradiance, with D = |wo . ng| / pi
// (point: 1 / (4 pi)) and T = 1 / d^2, or D = 1 / pi and T = 1 / R^2 at infinity. Planted bugs seen: intensity doubled
// for two-sided lights; one pi missing for areas.
TEST(Emission, VirtualLightsGiveTheSameIrradiance) {
  for (const double scale : {1e-3, 1.0, 1e4}) {
    const auto rigs = single_rigs(scale);
    for (std::size_t i = 0; i < rigs.size(); ++i) {
      const auto lights = rigs[i].build();
      IndependentStream<double> stream(3, Stage::test, i, 0);
      const Vec3<double> p = Vec3<double>(0.1, 0.2, 0) * scale;
      const RunningMoments expected = irradiance(lights, p, k_up, 200'000, 7);
      RunningMoments sum;
      for (int k = 0; k < 200'000; ++k) {
        const auto vpl = emit(lights, stream);
        if (is_infinite(vpl.kind)) {
          sum.add(vpl.intensity.x * k_inv_pi<double> * std::max(-vpl.wo.z, 0.0) /
                  (lights.scene_radius() * lights.scene_radius()));
          continue;
        }
        const Vec3<double> segment = p - vpl.position;
        const double d2 = glm::dot(segment, segment), cosine = -segment.z / std::sqrt(d2);
        double pattern = 1 / (4 * k_pi<double>);
        if (vpl.kind == EmitterKind::area) {
          const double c = glm::dot(segment, vpl.ng) / std::sqrt(d2);
          pattern = (vpl.two_sided ? std::abs(c) : std::max(c, 0.0)) * k_inv_pi<double>;
        }
        sum.add(vpl.intensity.x * pattern * std::max(cosine, 0.0) / d2);
      }
      const double error = std::hypot(sum.standard_error(), expected.standard_error());
      EXPECT_LE(std::abs(sum.mean() - expected.mean()), k_z_limit * error + k_round * expected.mean())
          << k_names[i] << ": " << sum.mean() << " against " << expected.mean();
      EXPECT_LT(error, 0.02 * expected.mean()) << k_names[i];
    }
  }
}

// O-7: a Lambertian point in a constant environment of radiance 1 has radiance rho whatever the scale of the scene.
TEST(Emission, EnvironmentIsIndependentOfTheScale) {
  for (const double scale : {1e-3, 1.0, 1e4}) {
    const auto lights = single_rigs(scale)[6].build();
    IndependentStream<double> stream(4, Stage::test, 0, 0);
    RunningMoments radiance;
    const double t = 1 / (lights.scene_radius() * lights.scene_radius()), rho = 0.5;
    for (int i = 0; i < 100'000; ++i) {
      const auto vpl = emit(lights, stream);
      radiance.add(rho * k_inv_pi<double> * std::max(-vpl.wo.z, 0.0) * t * k_inv_pi<double> * vpl.intensity.x / 1.5);
    }
    expect_mean(radiance, rho, k_round, "environment");
  }
}

TEST(Emission, LeavesOnTheEmittingSideAndFromOutsideTheScene) {
  const auto rigs = single_rigs(1);
  for (std::size_t i = 0; i < rigs.size(); ++i) {
    const auto lights = rigs[i].build();
    IndependentStream<double> stream(5, Stage::test, i, 0);
    int inner = 0;
    for (int k = 0; k < 2000; ++k) {
      const auto s = emit(lights, stream);
      ASSERT_NEAR(glm::length(s.wo), 1, 1e-12);  // rounding
      ASSERT_TRUE(is_valid_radiance(s.beta) && is_valid_radiance(s.intensity) && s.pdf_position > 0 &&
                  s.pdf_direction > 0);
      if (s.kind == EmitterKind::area) {
        if (glm::dot(s.wo, s.ng) < 0) ++inner;
        // e_l / (p(v_l) p(wo)) from the stated parts
        ASSERT_NEAR(s.radiance.x * std::abs(glm::dot(s.wo, s.ng)) / (s.pdf_position * s.pdf_direction) / s.beta.x, 1,
                    1e-6)
            << "the sampled cosine has a floor of 1e-7";
      } else if (s.kind == EmitterKind::point) {
        ASSERT_NEAR(s.radiance.x / (s.pdf_position * s.pdf_direction) / s.beta.x, 1, k_round);
      } else {
        const Vec3<double> from_center = s.position - lights.scene_center();
        ASSERT_NEAR(glm::dot(from_center, s.wo), -lights.scene_radius(), 1e-9);
        ASSERT_LE(glm::length(from_center + s.wo * lights.scene_radius()), lights.scene_radius() * (1 + 1e-12));
        ASSERT_NEAR(s.radiance.x / (s.pdf_position * s.pdf_direction) / s.beta.x, 1, k_round);
      }
    }
    if (i == 3) {
      EXPECT_NEAR(inner, 1000, 4.42 * std::sqrt(500));  // binomial, false alarm 1e-5
    } else {
      EXPECT_EQ(inner, 0);
    }
  }
}

// A textured light: samples are valued at their own texel, so the mean of beta is the exact integral over the square.
// Planted bug seen: corners' uv not turned with a flipped winding.
TEST(Emission, TexturedLightsAreValuedTexelByTexel) {
  for (const bool flip : {false, true}) {
    LightRig<double> rig;
    auto mesh = rectangle<double>({0, 0, 1}, {0, 1, 0}, {1, 0, 0});
    mesh.flip_normals = flip;
    rig.shapes.meshes = {mesh};
    auto texels = std::make_shared<Texels<double>>();
    *texels = {2, 2, {Rgb<double>(1), Rgb<double>(0), Rgb<double>(10), Rgb<double>(5)}};
    rig.list.areas = {{0, Texture<double>::bitmap(texels, TextureFilter::nearest)}};
    const auto lights = rig.build();
    IndependentStream<double> stream(6, Stage::test, 0, 0);
    RunningMoments beta;
    for (int i = 0; i < 100'000; ++i) {
      const auto s = emit(lights, stream);
      // uv runs along the mesh's first edge (world y) and second edge (world x)
      ASSERT_NEAR(s.uv.x, s.position.y + 0.5, 1e-12);
      ASSERT_NEAR(s.uv.y, s.position.x + 0.5, 1e-12);
      beta.add(s.beta.x);
    }
    expect_mean(beta, k_pi<double> * 4, k_round, "texture");
  }
}

}  // namespace
}  // namespace manylight::test::emission_test
