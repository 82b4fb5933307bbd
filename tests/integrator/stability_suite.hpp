// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cmath>

#include "integrator/same_lights.hpp"

// Scenes in which many-light renderers are known to fail: scale, distance from the origin, leaks, empty scenes,
// degenerate geometry. Every integrator on every backend.

namespace manylight::test {

template <class G>
class StabilitySuite : public ::testing::Test {
 public:
  using Real = typename G::Scalar;
  using V = Vec3<Real>;
  using Diffuse = Lambertian<Real>;
  using Builder = SceneBuilder<G, Diffuse>;

  [[nodiscard]] static Diffuse diffuse(double albedo) { return {Rgb<Real>(static_cast<Real>(albedo))}; }
  [[nodiscard]] static V vec(double x, double y, double z) {
    return {static_cast<Real>(x), static_cast<Real>(y), static_cast<Real>(z)};
  }

  /// Floor, wall, block and ball under a point light, `scale` times as large; intensity times scale^2.
  [[nodiscard]] static Builder still_life(double scale) {
    const auto at = [scale](double x, double y, double z) { return vec(x * scale, y * scale, z * scale); };
    Builder builder;
    builder.mesh(parallelogram<Real>(at(0, 0, 0), at(4, 0, 0), at(0, 4, 0)), diffuse(0.5));
    builder.mesh(parallelogram<Real>(at(0, 4, 2), at(4, 0, 0), at(0, 0, 2)), diffuse(0.7));
    builder.mesh(box_mesh<Real>(at(-1, 1, 0), at(0.5, 2, 1.5)), diffuse(0.6));
    builder.sphere({at(1.5, 0.5, 0.75), static_cast<Real>(0.75 * scale), false}, diffuse(0.8));
    builder.point_light(at(1, -1, 3), static_cast<Real>(10 * scale * scale));
    return builder;
  }
  [[nodiscard]] static Film still_life_image(Method method, double scale) {
    Settings settings;
    settings.samples = 4;
    settings.vpls = 100;
    settings.adaptation = 0;
    settings.clamp_scale = 1.0 / 800;
    const auto eye = vec(-2 * scale, -6 * scale, 3 * scale);
    return render(method, still_life(scale).build(), look_at<Real>(eye, vec(0, 0, 0.5 * scale), Real(40), 16),
                  settings);
  }

  /// Largest channel of any pixel.
  template <class SceneType, Camera C>
  static double brightest(Method method, const SceneType& scene, const C& camera, const Settings& settings = {}) {
    const Film film = render(method, scene, camera, settings);
    EXPECT_EQ(film.invalid, 0u) << name(method);
    double result = 0;
    for (const auto& pixel : film.pixels) result = std::max(result, max_channel(pixel));
    return result;
  }
};

TYPED_TEST_SUITE_P(StabilitySuite);

/// Oracle O-31, stability case 5. A power of two scales every rounded number exactly, so that images must be equal to
/// the last bit: any absolute epsilon in walk, connection, weight, bound or tree breaks it. Caught: `+ 1e-6` to the
/// squared distance in connect; an origin offset of 1e-4.
TYPED_TEST_P(StabilitySuite, PowersOfTwoOfScaleGiveTheSameBits) {
  for (const Method method : k_methods) {
    const Film base = this->still_life_image(method, 1);
    EXPECT_GT(base.mean().x, 0.05);
    for (const double scale : {0x1p-10, 0x1p13}) {
      const Film scaled = this->still_life_image(method, scale);
      EXPECT_EQ(scaled.pixels, base.pixels) << name(method) << " scale " << scale;
    }
  }
}

/// Stability case 5 with scales that round: paths fork by rounding in few samples, so images agree in the mean.
TYPED_TEST_P(StabilitySuite, AnyScaleGivesTheSameImage) {
  for (const Method method : k_methods) {
    const Film base = this->still_life_image(method, 1);
    for (const double scale : {1e-3, 1e4}) {
      const Film scaled = this->still_life_image(method, scale);
      EXPECT_NEAR(scaled.mean().x, base.mean().x, 0.002 * base.mean().x) << name(method) << " scale " << scale;
      unsigned changed = 0;
      for (std::size_t i = 0; i < base.pixels.size(); ++i) {
        changed += std::abs(scaled.pixels[i].x - base.pixels[i].x) > 1e-3 * base.pixels[i].x ? 1 : 0;
      }
      EXPECT_LT(changed, base.pixels.size() / 10) << name(method) << " scale " << scale;
    }
  }
}

/// Stability case 6: a tilted floor 10,000 m from the origin, where a float steps by 1 mm. It does not see itself, so
/// each probe has a closed solution; acne would show as black pixels. Caught: rays that leave without an offset.
TYPED_TEST_P(StabilitySuite, NoAcneFarFromTheOrigin) {
  using S = typename TypeParam::Scalar;
  const auto shift = this->vec(1e4, 1e4, 1e4);
  const auto n = glm::normalize(this->vec(0.3, -0.2, 1));
  const auto u = glm::normalize(glm::cross(this->vec(0, 1, 0), n));
  const auto v = glm::cross(n, u);
  SceneBuilder<TypeParam, Lambertian<S>> builder;
  builder.mesh(parallelogram<S>(shift, u * S(8), v * S(8)), this->diffuse(0.5));
  const auto light = shift + n * S(4);
  builder.point_light(light, S(10));
  const auto scene = builder.build();
  ProbeCamera<S> camera;
  for (int i = 0; i < 40; ++i) {
    for (int k = 0; k < 20; ++k) {
      const auto target = shift + u * (S(0.37) * static_cast<S>(i - 20)) + v * (S(0.71) * static_cast<S>(k - 10));
      camera.add(target, shift + n * S(6) - u * S(3));
    }
  }
  for (const Method method : k_methods) {
    Settings settings;
    settings.samples = 1;
    const Film film = render(method, scene, camera, settings);
    for (std::size_t i = 0; i < film.pixels.size(); ++i) {
      const double squared = static_cast<double>(glm::dot(camera.targets[i] - shift, camera.targets[i] - shift)) + 16;
      const double exact = 0.5 / k_pi<double> * 10 * 4 / std::pow(squared, 1.5);
      EXPECT_NEAR(film.pixels[i].x, exact, 3e-3 * exact) << name(method) << ' ' << i;  // positions to 1e-3 of 4 m
    }
  }
}

/// Stability case 14: a one-sided emitter gives nothing behind itself, and is black when seen from there.
TYPED_TEST_P(StabilitySuite, OneSidedEmitterFromBehind) {
  using S = typename TypeParam::Scalar;
  SceneBuilder<TypeParam, Lambertian<S>> builder;
  const auto floor =
      builder.mesh(parallelogram<S>(Vec3<S>(0), this->vec(5, 0, 0), this->vec(0, 5, 0)), this->diffuse(0.5));
  (void)floor;
  builder.emit(
      builder.mesh(parallelogram<S>(this->vec(0, 0, 1), this->vec(1, 0, 0), this->vec(0, 1, 0)), this->diffuse(0.5)),
      Rgb<S>(3));
  ProbeCamera<S> camera;
  camera.add(this->vec(0, 0, 0), this->vec(0.01, 0, 0.02));
  camera.add(this->vec(2, 1, 0), this->vec(2, 1, 0.02));
  camera.add(this->vec(0, 0, 1), this->vec(0.01, 0, 0.5));  // the emitter's back
  for (const Method method : k_methods) {
    EXPECT_EQ(this->brightest(method, builder.build(), camera), 0) << name(method);
  }
}

/// Stability case 15, reference sheet 7.12: a closed box divided by a wall of 1e-4; the light is on one side, the other
/// side is exactly black, with the wall's shading normals bent by 60 degrees, too.
/// Caught: the rule of sides judged by the shading normal alone (detail::sides_agree without ng).
TYPED_TEST_P(StabilitySuite, ThinWallDoesNotLeak) {
  using S = typename TypeParam::Scalar;
  for (const bool bent : {false, true}) {
    SceneBuilder<TypeParam, Lambertian<S>> builder;
    auto room = box_mesh<S>(this->vec(-1, -1, -1), this->vec(1, 1, 1));
    room.flip_normals = true;
    builder.mesh(room, this->diffuse(0.8));
    auto wall = box_mesh<S>(this->vec(-5e-5, -1.5, -1.5), this->vec(5e-5, 1.5, 1.5));
    if (bent) {
      for (auto& n : wall.normals) n = glm::normalize(n + this->vec(0.1, 1.2, 1.2));
    }
    builder.mesh(wall, this->diffuse(0.8));
    builder.point_light(this->vec(-0.5, 0.1, 0.2), S(5));
    const auto scene = builder.build();
    ProbeCamera<S> dark;
    ProbeCamera<S> lit;
    for (int i = 0; i < 30; ++i) {
      const double y = -0.95 + 0.065 * i;
      dark.add(this->vec(5e-5, y, -y * y + 0.3), this->vec(0.8, 0.1, 0));
      dark.add(this->vec(0.001 * i, y, -1), this->vec(0.8, 0.1, 0));
      lit.add(this->vec(-5e-5, y, -y * y + 0.3), this->vec(-0.8, 0.1, 0));
    }
    Settings settings;
    settings.samples = 4;
    settings.vpls = 500;
    for (const Method method : k_methods) {
      EXPECT_EQ(this->brightest(method, scene, dark, settings), 0) << name(method) << " bent " << bent;
      EXPECT_GT(this->brightest(method, scene, lit, settings), 0.1) << name(method) << " bent " << bent;
    }
  }
}

/// Stability case 20, a small spherical light in a closed glass box. Direct light crosses the glass by refraction only:
/// path tracing finds it by hits of the emitter, both many-light methods lose all of it, as no connection passes glass.
/// What remains of them is pinned: exactly nothing here, since the floor sees no other surface.
TYPED_TEST_P(StabilitySuite, LightInsideAGlassBox) {
  using S = typename TypeParam::Scalar;
  using M = SmoothMaterial<S>;
  SceneBuilder<TypeParam, M> builder;
  builder.mesh(parallelogram<S>(Vec3<S>(0), this->vec(5, 0, 0), this->vec(0, 5, 0)), M(this->diffuse(0.5)));
  builder.mesh(box_mesh<S>(this->vec(-0.6, -0.6, 0.4), this->vec(0.6, 0.6, 1.6)), M(Dielectric<S>{S(1.5)}), false);
  builder.emit(builder.sphere({this->vec(0, 0, 1), S(0.3), false}, M(this->diffuse(0))), Rgb<S>(10));
  ProbeCamera<S> camera;
  camera.add(this->vec(0, 0, 0), this->vec(0.01, 0, 0.02));
  Settings settings;
  settings.samples = 500;
  EXPECT_GT(this->brightest(Method::path, builder.build(), camera, settings), 0.1);
  settings.samples = 16;
  EXPECT_EQ(this->brightest(Method::vpl, builder.build(), camera, settings), 0);
  EXPECT_EQ(this->brightest(Method::bdlc, builder.build(), camera, settings), 0);
}

/// Stability case 20, sun through a pane at normal incidence: nobody can connect to the sun through glass, so the lit
/// floor looks black to path tracing and only light paths know of it. A patch beside the window that looks at the floor
/// then shows what the floor reflects, as if the sun were weakened by T = (1 - R) / (1 + R) = 12/13 and no pane were
/// there.
TYPED_TEST_P(StabilitySuite, SunThroughAPane) {
  using S = typename TypeParam::Scalar;
  using M = SmoothMaterial<S>;
  const auto build = [&](bool pane) {
    SceneBuilder<TypeParam, M> builder;
    builder.mesh(parallelogram<S>(Vec3<S>(0), this->vec(1, 0, 0), this->vec(0, 1, 0)), M(this->diffuse(0.5)));
    builder.mesh(parallelogram<S>(this->vec(1.5, 0, 0.5), this->vec(0, 0, 0.4), this->vec(0, 0.5, 0)),
                 M(this->diffuse(0.5)));
    const double glass = pane ? 0 : 50;  // out of the way
    builder.mesh(box_mesh<S>(this->vec(-3 + glass, -3, 1), this->vec(3 + glass, 3, 1.1)), M(Dielectric<S>{S(1.5)}),
                 false);
    builder.lights.directionals.push_back({this->vec(0, 0, -1), Rgb<S>(static_cast<S>(pane ? 13.0 : 12.0))});
    return builder.build();
  };
  ProbeCamera<S> camera;
  camera.add(this->vec(0.2, 0, 0), this->vec(0.21, 0, 0.02));
  camera.add(this->vec(1.5, 0, 0.5), this->vec(1.4, 0, 0.6));
  Settings settings;
  settings.vpls = 400;
  settings.samples = 4;
  const auto with = this->brightest(Method::path, build(true), camera, settings);
  EXPECT_EQ(with, 0);
  for (const Method method : {Method::vpl, Method::lightcuts, Method::bdlc}) {
    const auto seen = repeat(method, build(true), camera, settings, 16);
    const auto bare = repeat(method, build(false), camera, settings, 16);
    // The floor's own direct light is lost: what stays there came back from the patch, some per cent.
    EXPECT_LT(seen[0].mean(), 0.2 * bare[0].mean()) << name(method);
    EXPECT_GT(bare[1].mean(), 0.05) << name(method);
    const double error = std::hypot(seen[1].standard_error(), bare[1].standard_error());
    EXPECT_NEAR(seen[1].mean(), bare[1].mean(), 5 * error + 1e-3 * bare[1].mean()) << name(method);  // see `agrees`
  }
}

/// Stability case 24: no lights at all is black; one to three give their sum.
TYPED_TEST_P(StabilitySuite, NoneToThreeLights) {
  using S = typename TypeParam::Scalar;
  ProbeCamera<S> camera;
  camera.add(this->vec(0, 0, 0), this->vec(0.01, 0, 0.02));
  for (unsigned lights = 0; lights <= 3; ++lights) {
    SceneBuilder<TypeParam, Lambertian<S>> builder;
    builder.mesh(parallelogram<S>(Vec3<S>(0), this->vec(5, 0, 0), this->vec(0, 5, 0)), this->diffuse(0.5));
    for (unsigned i = 0; i < lights; ++i) builder.point_light(this->vec(0, 0, 1 + i), S(1));
    double exact = 0;
    for (unsigned i = 0; i < lights; ++i) exact += 0.5 / k_pi<double> / sqr(1.0 + i);
    for (const Method method : k_methods) {
      Settings settings;
      settings.samples = method == Method::path ? 20000 : 4;
      settings.adaptation = 0;
      // path picks one light in three per sample: relative deviation of a sample below 1, 5 / sqrt(20000) = 3.5 %.
      const double tolerance = method == Method::path && lights > 1 ? 0.035 : 1e-3;
      EXPECT_NEAR(render(method, builder.build(), camera, settings).pixels[0].x, exact, tolerance * exact)
          << name(method) << ' ' << lights;
    }
  }
}

/// Stability case 24: a single triangle, a view of nothing, nothing but mirrors.
TYPED_TEST_P(StabilitySuite, SmallestScenes) {
  using S = typename TypeParam::Scalar;
  using M = SmoothMaterial<S>;
  TriangleMesh<S> triangle;
  triangle.positions = {this->vec(-1, -1, 0), this->vec(1, -1, 0), this->vec(0, 1, 0)};
  triangle.triangles = {{0, 1, 2}};
  SceneBuilder<TypeParam, M> single;
  single.mesh(triangle, M(this->diffuse(0.5)));
  single.point_light(this->vec(0, 0, 2), S(4));
  ProbeCamera<S> camera;
  camera.add(this->vec(0, 0, 0), this->vec(0.1, 0, 1));
  ProbeCamera<S> away;
  away.add(this->vec(0, 0, 9), this->vec(0.1, 0, 1));

  SceneBuilder<TypeParam, M> mirrors;
  auto room = box_mesh<S>(this->vec(-1, -1, -1), this->vec(1, 1, 1));
  mirrors.mesh(room, M(Mirror<S>{Rgb<S>(S(0.9))}));
  mirrors.point_light(this->vec(0.2, 0.1, 0.3), S(1));
  ProbeCamera<S> inside;
  inside.add(this->vec(1, 0.3, 0.2), Vec3<S>(0));
  for (const Method method : k_methods) {
    Settings settings;
    settings.adaptation = 0;
    EXPECT_NEAR(this->brightest(method, single.build(), camera, settings), 0.5 / k_pi<double>, 1e-5) << name(method);
    EXPECT_EQ(this->brightest(method, single.build(), away, settings), 0) << name(method);
    settings.max_edges = 50;
    EXPECT_EQ(this->brightest(method, mirrors.build(), inside, settings), 0) << name(method);
  }
}

/// Stability case 36: slivers, triangles of no area and zero vertex normals may stay in a mesh; the image is as without
/// them. The sliver is 1e-6 wide and hidden behind the floor's plane.
TYPED_TEST_P(StabilitySuite, DegenerateTrianglesAndZeroNormals) {
  using S = typename TypeParam::Scalar;
  auto floor = parallelogram<S>(Vec3<S>(0), this->vec(5, 0, 0), this->vec(0, 5, 0));
  for (auto& n : floor.normals) n = Vec3<S>(0);
  const auto first = static_cast<std::uint32_t>(floor.positions.size());
  for (const auto& p : {this->vec(1, 1, 1), this->vec(2, 1, 1), this->vec(3, 1, 1), this->vec(2, 1.000001, 1)}) {
    floor.positions.push_back(p);
    floor.normals.push_back(Vec3<S>(0));
    floor.uvs.push_back({0, 0});
  }
  floor.triangles.push_back({first, first + 1, first + 2});  // collinear
  floor.triangles.push_back({first, first, first});          // a point
  floor.triangles.push_back({first, first + 2, first + 3});  // sliver
  SceneBuilder<TypeParam, Lambertian<S>> builder;
  builder.mesh(floor, this->diffuse(0.5));
  builder.point_light(this->vec(0, 0, 1), S(1));
  ProbeCamera<S> camera;
  camera.add(this->vec(0, 0, 0), this->vec(0.01, 0, 0.02));
  camera.add(this->vec(2, 1.0000005, 1), this->vec(2, 1, 2));  // the sliver
  camera.add(this->vec(1, 1, 1), this->vec(1.5, 1.5, 3));      // degenerate corner
  for (const Method method : k_methods) {
    const Film film = render(method, builder.build(), camera, Settings{});
    EXPECT_EQ(film.invalid, 0u) << name(method);
    EXPECT_NEAR(film.pixels[0].x, 0.159155, 1e-4) << name(method);  // one VPL pair less than 1e-4 off by the sliver
    for (const auto& pixel : film.pixels) EXPECT_TRUE(is_valid_radiance(pixel)) << name(method);
  }
}

/// Stability case 36: light and view within 1e-6 of the tangent plane stay finite and within the clamp-free exact
/// value.
TYPED_TEST_P(StabilitySuite, GrazingLightAndView) {
  using S = typename TypeParam::Scalar;
  for (const double height : {1e-2, 1e-4, 1e-6}) {
    SceneBuilder<TypeParam, Lambertian<S>> builder;
    builder.mesh(parallelogram<S>(Vec3<S>(0), this->vec(5, 0, 0), this->vec(0, 5, 0)), this->diffuse(0.5));
    builder.point_light(this->vec(1, 0, height), S(1));
    ProbeCamera<S> camera;
    camera.add(this->vec(0, 0, 0), this->vec(-1, 0, height));
    const double exact = 0.5 / k_pi<double> * height / std::pow(1 + height * height, 1.5);
    for (const Method method : k_methods) {
      const Film film = render(method, builder.build(), camera, Settings{});
      EXPECT_EQ(film.invalid, 0u) << name(method);
      // In float a ray 1e-6 above the plane meets it where rounding says, up to the whole width away.
      const double tolerance = height < 1e-5 && sizeof(S) == 4 ? 10 : (sizeof(S) == 4 ? 0.05 : 1e-6);
      EXPECT_NEAR(film.pixels[0].x, exact, tolerance * exact) << name(method) << ' ' << height;
    }
  }
}

/// Stability case 3: VPLs placed by hand on the shading point and next to it, of every kind, under a clamp and without:
/// finite, and what lies far away still counts. Caught: S and I, or the room for sums, left out of the test for a
/// finite product (unoccluded_transfer), which makes the pixel infinite.
TYPED_TEST_P(StabilitySuite, LightsOnTheShadingPoint) {
  using S = typename TypeParam::Scalar;
  SceneBuilder<TypeParam, Lambertian<S>> builder;
  builder.mesh(parallelogram<S>(Vec3<S>(0), this->vec(1, 0, 0), this->vec(0, 1, 0)), this->diffuse(0.5));
  builder.point_light(this->vec(0, 0, 1), S(1));
  const auto scene = builder.build();
  using SceneType = std::remove_cv_t<decltype(scene)>;
  ProbeCamera<S> camera;
  camera.add(Vec3<S>(0), this->vec(0, 0, 1));
  for (const double clamp_scale : {1.0 / 800, std::numeric_limits<double>::infinity()}) {
    Settings settings;
    settings.clamp_scale = clamp_scale;
    SameLights lights(scene, camera, settings);
    LightSide<SceneType>& side = lights.side;
    side.lights.vpls.resize(1);  // the point light itself
    ASSERT_TRUE(side.lights.vpls[0].exact);
    if (clamp_scale < 1) side.weights.c_clamp = S(1);
    // Distances at which the square is 0, underflows, and at which M T D or S M T D I are beyond the largest number.
    for (const double distance : {0.0, 1e-25, 1.1e-19, 1e-18, 1e-160, 1e-154}) {
      for (const VertexKind kind : {VertexKind::surface, VertexKind::area_emitter, VertexKind::point_emitter}) {
        VertexOf<SceneType> light;
        light.kind = kind;
        light.exact = kind == VertexKind::point_emitter;
        light.position = this->vec(0, 0, distance);
        light.ng = this->vec(0, 0, -1);
        light.w = this->vec(0.6, 0, -0.8);
        light.shading = decltype(light.shading)(Frame<S>(light.ng));
        light.material = this->diffuse(0.5);
        light.alpha = S(0.5);
        light.strength = Rgb<S>(S(1000));
        side.lights.vpls.push_back(light);
      }
    }
    const ManyLightImage<S> images[] = {lights.all_pairs(), lights.lightcuts(), lights.bdlc()};
    for (const ManyLightImage<S>& image : images) {
      EXPECT_TRUE(is_valid_radiance(image.image.pixels[0])) << image.image.pixels[0].x;
      EXPECT_GE(static_cast<double>(image.image.pixels[0].x), 0.159) << "0.5 / pi of the light 1 m above";
    }
  }
}

REGISTER_TYPED_TEST_SUITE_P(StabilitySuite, PowersOfTwoOfScaleGiveTheSameBits, LightsOnTheShadingPoint,
                            AnyScaleGivesTheSameImage, NoAcneFarFromTheOrigin, OneSidedEmitterFromBehind,
                            ThinWallDoesNotLeak, LightInsideAGlassBox, SunThroughAPane, NoneToThreeLights,
                            SmallestScenes, DegenerateTrianglesAndZeroNormals, GrazingLightAndView);

}  // namespace manylight::test
