// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cmath>

#include "integrator/same_lights.hpp"

// Every integrator on every backend against scenes with closed solutions. Clamps are off unless a test is about them,
// so that each method's expectation is the exact radiance; the slack of 2e-5 in float, 1e-10 in double covers rounding.
//
// Planted bugs that these tests were seen to catch are named beside them.

namespace manylight::test {

template <class G>
class AnalyticSuite : public ::testing::Test {
 public:
  using Real = typename G::Scalar;
  using V = Vec3<Real>;
  using Diffuse = Lambertian<Real>;
  static constexpr double k_rounding = sizeof(Real) == 4 ? 2e-5 : 1e-10;
  static constexpr unsigned k_runs = 16;

  [[nodiscard]] static Diffuse diffuse(Real albedo) { return {Rgb<Real>(albedo)}; }
  [[nodiscard]] static V vec(double x, double y, double z) {
    return {static_cast<Real>(x), static_cast<Real>(y), static_cast<Real>(z)};
  }

  template <class SceneType, Camera C>
  static void expect_radiance(const SceneType& scene, const C& camera, const std::vector<double>& exact,
                              const Settings& settings, Method method, double slack = k_rounding) {
    const auto moments = repeat(method, scene, camera, settings, k_runs);
    for (std::size_t i = 0; i < exact.size(); ++i) {
      EXPECT_TRUE(agrees(moments[i], exact[i], slack))
          << name(method) << " probe " << i << ": " << moments[i].mean() << " +- " << moments[i].standard_error()
          << ", exact " << exact[i];
    }
  }
  template <class SceneType, Camera C>
  static void expect_all(const SceneType& scene, const C& camera, const std::vector<double>& exact,
                         const Settings& settings, double slack = k_rounding) {
    for (const Method method : k_methods) expect_radiance(scene, camera, exact, settings, method, slack);
  }

  /// Sphere of radius 1 around the origin seen from inside.
  [[nodiscard]] static SceneBuilder<G, Diffuse> cavity(Real albedo) {
    SceneBuilder<G, Diffuse> builder;
    builder.sphere({V(0), Real(1), true}, diffuse(albedo));
    return builder;
  }
  [[nodiscard]] static ProbeCamera<Real> cavity_probes() {
    ProbeCamera<Real> camera;
    const V eye = vec(0.3, 0.2, 0.1);
    camera.add(vec(1, 0, 0), eye);
    camera.add(vec(0, 1, 0), eye);
    camera.add(vec(-1, 0, 0), eye);
    camera.add(glm::normalize(vec(0.3, -0.5, -0.8)), eye);
    return camera;
  }
  /// Large floor z = 0 of the given albedo, normal +z.
  static void add_floor(SceneBuilder<G, Diffuse>& builder, Real albedo, Real half = Real(50)) {
    builder.mesh(parallelogram<Real>(V(0), V(half, 0, 0), V(0, half, 0)), diffuse(albedo));
  }
  /// Probes on the floor at x, seen from just above: nothing comes between.
  [[nodiscard]] static ProbeCamera<Real> floor_probes(const std::vector<double>& xs) {
    ProbeCamera<Real> camera;
    for (const double x : xs) camera.add(vec(x, 0, 0), vec(x + 0.01, 0.005, 0.02));
    return camera;
  }
};

TYPED_TEST_SUITE_P(AnalyticSuite);

/// Reference sheet 7.6: E_direct = I = pi, E = pi / (1 - 1/2), L = E / 2 pi = 1 everywhere.
/// Caught: pi missing in the point light's VPL strength; roulette without dividing by its probability.
TYPED_TEST_P(AnalyticSuite, CavityWithAPointLightAtItsCentre) {
  using S = typename TypeParam::Scalar;
  auto builder = this->cavity(S(0.5));
  builder.point_light(Vec3<S>(0), k_pi<S>);
  this->expect_all(builder.build(), this->cavity_probes(), {1, 1, 1, 1}, Settings{});
}

/// Reference sheet 7.4: L = Le / (1 - albedo) = 1. Caught: MIS weight of hits 1 instead of pB / (pB + pL).
TYPED_TEST_P(AnalyticSuite, CavityWithEmittingWalls) {
  using S = typename TypeParam::Scalar;
  SceneBuilder<TypeParam, Lambertian<S>> builder;
  builder.emit(builder.sphere({Vec3<S>(0), S(1), true}, this->diffuse(S(0.5))), Rgb<S>(S(0.5)));
  this->expect_all(builder.build(), this->cavity_probes(), {1, 1, 1, 1}, Settings{});
}

/// The clamp of Eq. 6, with the pilot's L_a, is C_clamp = L_a N / (800 flux) > 1 / (4 pi^2 R^2) from N = 800 VPLs on:
/// it must not bind any more, so that the image is the unclamped one up to rounding of sums in another order.
TYPED_TEST_P(AnalyticSuite, EnoughVplsSwitchTheClampOff) {
  using S = typename TypeParam::Scalar;
  auto builder = this->cavity(S(0.5));
  builder.point_light(Vec3<S>(0), k_pi<S>);
  const auto scene = builder.build();
  Settings settings;
  settings.samples = 4;
  settings.vpls = 1200;
  for (const Method method : {Method::vpl, Method::lightcuts, Method::bdlc}) {
    settings.clamp_scale = std::numeric_limits<double>::infinity();
    const Film unclamped = render(method, scene, this->cavity_probes(), settings);
    settings.adaptation = 0;
    settings.clamp_scale = 1.0 / 800;
    const Film clamped = render(method, scene, this->cavity_probes(), settings);
    for (std::size_t i = 0; i < clamped.pixels.size(); ++i) {
      EXPECT_NEAR(clamped.pixels[i].x, unclamped.pixels[i].x, 10 * this->k_rounding) << name(method);
    }
    settings.clamp_scale = 1e-3 / 800;  // what a clamp that binds takes; bdlc's further sensors get it back
    if (method == Method::vpl) {
      EXPECT_LT(render(method, scene, this->cavity_probes(), settings).pixels[0].x, 0.6);
    }
  }
}

/// Oracle O-30: with standard weights the part that virtual point lights reflect scales by 4 pi^2 R^2 C_clamp, while
/// the exact light is never clamped: L = 0.5 + 0.5 scale, on average over the VPLs' count.
TYPED_TEST_P(AnalyticSuite, ClampScalesTheReflectedPartOfTheCavity) {
  using S = typename TypeParam::Scalar;
  auto builder = this->cavity(S(0.5));
  builder.point_light(Vec3<S>(0), k_pi<S>);
  const auto scene = builder.build();
  const auto camera = this->cavity_probes();
  const double pair = 1 / (4 * sqr(k_pi<double>));
  for (const double scale : {0.25, 0.5, 1.0, 2.0}) {
    Settings settings;
    settings.adaptation = 1;
    settings.seed = 7;
    SameLights lights(scene, camera, settings);
    lights.side.weights.c_clamp = static_cast<S>(scale * pair);
    const auto film = lights.all_pairs();
    double intensity = 0;
    for (const auto& v : lights.side.lights.vpls) intensity += v.exact ? 0.0 : static_cast<double>(v.strength.x);
    const double expected = 0.5 + std::min(1.0, scale) * pair * intensity * 0.5;
    EXPECT_NEAR(static_cast<double>(film.image.pixels[0].x), expected, 20 * this->k_rounding)  // 1000 roundings
        << "scale " << scale;
  }
}

/// Oracle O-36: every connection inside the sphere has M T D = 1 / (4 pi^2 R^2), wherever its ends lie.
TYPED_TEST_P(AnalyticSuite, EveryPairOfTheCavityTransfersTheSame) {
  using S = typename TypeParam::Scalar;
  auto builder = this->cavity(S(0.5));
  builder.point_light(Vec3<S>(0), k_pi<S>);
  const auto scene = builder.build();
  const IndependentSampler<S> sampler{3};
  RayCounts rays;
  const auto set = trace_vpls(scene, VplConfig{300, 100}, sampler, SerialExecutor{}, rays);
  const S exact = S(1) / (S(4) * sqr(k_pi<S>));
  // Rounding: positions are off by eps R, so cosines of a chord of length d by eps R / d; both enter twice.
  const S tolerance = sizeof(S) == 4 ? S(1e-4) : S(1e-12);
  unsigned compared = 0;
  for (std::size_t i = 1; i + 1 < set.vpls.size(); i += 2) {
    const auto pair = connect(set.vpls[i], set.vpls[i + 1], S(1));
    if (glm::distance(set.vpls[i].position, set.vpls[i + 1].position) < S(0.3)) continue;
    EXPECT_NEAR(pair.m.x * pair.t * pair.d.x, exact, exact * tolerance);
    ++compared;
  }
  EXPECT_GT(compared, 100u);
}

/// Oracle O-6 and the meaning of max_edges: 1 sees emitters only, 2 adds direct light, each further one a bounce:
/// L_k = Le (1 - rho^(k+1)) / (1 - rho). Caught: one bounce too many in unoccluded_transfer's edge count.
TYPED_TEST_P(AnalyticSuite, FurnaceTruncatedAfterEachBounce) {
  using S = typename TypeParam::Scalar;
  SceneBuilder<TypeParam, Lambertian<S>> builder;
  builder.emit(builder.sphere({Vec3<S>(0), S(1), true}, this->diffuse(S(0.8))), Rgb<S>(1));
  const auto scene = builder.build();
  const std::array<double, 4> exact{1, 1.8, 2.44, 2.952};
  for (unsigned bounces = 0; bounces < exact.size(); ++bounces) {
    Settings settings;
    settings.max_edges = bounces + 1;
    settings.vpls = 500;
    const std::vector<double> everywhere(4, exact[bounces]);
    this->expect_all(scene, this->cavity_probes(), everywhere, settings);
    // The clamp hands paths on from sensor to sensor and to emitter hits: none may become too long or count twice.
    settings.vpls = 50;
    settings.clamp_scale = 1.0 / 100;  // w about 0.5 for the first two sensors
    this->expect_radiance(scene, this->cavity_probes(), everywhere, settings, Method::bdlc);
  }
}

/// A point light cannot be seen: 1 edge gives nothing, 2 edges its direct light alone.
TYPED_TEST_P(AnalyticSuite, DepthsOfThePointLitCavity) {
  using S = typename TypeParam::Scalar;
  auto builder = this->cavity(S(0.5));
  builder.point_light(Vec3<S>(0), k_pi<S>);
  const auto scene = builder.build();
  const std::array<double, 3> exact{0, 0.5, 0.75};
  for (unsigned edges = 1; edges <= 3; ++edges) {
    Settings settings;
    settings.max_edges = edges;
    settings.vpls = 500;
    this->expect_all(scene, this->cavity_probes(), std::vector<double>(4, exact[edges - 1]), settings);
  }
}

/// Reference sheet 7.6: indirect irradiance is uniform wherever the light is. Values of the sheet to 6 digits.
/// Caught: VPL strengths without alpha.
TYPED_TEST_P(AnalyticSuite, CavityWithAPointLightOffItsCentre) {
  using S = typename TypeParam::Scalar;
  auto builder = this->cavity(S(0.6));
  builder.point_light(this->vec(0.5, 0, 0), S(1));
  auto camera = this->cavity_probes();
  camera.targets.pop_back();
  camera.from.pop_back();
  this->expect_all(builder.build(), camera, {1.050423, 0.423137, 0.371362}, Settings{}, this->k_rounding + 2e-6);
}

/// Reference sheet 7.1: L = rho I / pi H / (H^2 + d^2)^(3/2); the floor does not see itself, so nothing is random.
TYPED_TEST_P(AnalyticSuite, PointLightOverAPlane) {
  using S = typename TypeParam::Scalar;
  SceneBuilder<TypeParam, Lambertian<S>> builder;
  this->add_floor(builder, S(0.5));
  builder.point_light(Vec3<S>(0, 0, 1), S(1));
  const auto camera = this->floor_probes({0, 1, 2});
  for (const Method method : k_methods) {
    const Film film = render(method, builder.build(), camera, Settings{});
    EXPECT_NEAR(film.pixels[0].x, 0.159155, 5e-6) << name(method);  // digits of the sheet, float rounding
    EXPECT_NEAR(film.pixels[1].x, 0.0562698, 5e-6) << name(method);
    EXPECT_NEAR(film.pixels[2].x, 0.0142353, 5e-6) << name(method);
  }
}

/// Oracle O-2: Phi = 100 W, rho = 0.8, height 2.
TYPED_TEST_P(AnalyticSuite, HundredWattsOverAPlane) {
  using S = typename TypeParam::Scalar;
  SceneBuilder<TypeParam, Lambertian<S>> builder;
  this->add_floor(builder, S(0.8));
  builder.point_light(Vec3<S>(0, 0, 2), static_cast<S>(100 / (4 * k_pi<double>)));
  for (const Method method : k_methods) {
    const Film film = render(method, builder.build(), this->floor_probes({0, 1.5}), Settings{});
    EXPECT_NEAR(film.pixels[0].x, 0.506606, 1e-5) << name(method);
    EXPECT_NEAR(film.pixels[1].x, 0.259382, 1e-5) << name(method);
  }
}

/// Reference sheet 7.13: L = rho / pi E cos, wherever the point lies and whatever the scene's size.
TYPED_TEST_P(AnalyticSuite, DirectionalLightOnAPlane) {
  using S = typename TypeParam::Scalar;
  for (const double half : {1.0, 1000.0}) {
    SceneBuilder<TypeParam, Lambertian<S>> builder;
    this->add_floor(builder, S(0.5), static_cast<S>(half));
    builder.lights.directionals.push_back({this->vec(1, 0, -1), Rgb<S>(3)});
    const double exact = 0.5 / k_pi<double> * 3 * std::sqrt(0.5);
    for (const Method method : k_methods) {
      const Film film = render(method, builder.build(), this->floor_probes({0, 0.5, -0.7}), Settings{});
      for (const auto& pixel : film.pixels) EXPECT_NEAR(pixel.x, exact, 4 * this->k_rounding) << name(method);
    }
  }
}

/// Oracle O-3: disc light R = 1, L = 10 on the axis: E = pi L R^2 / (R^2 + h^2); receiver albedo 0.5.
/// The clamp of Eq. 6 is on for bdlc in the second pass: emitter hits must give back what it takes.
TYPED_TEST_P(AnalyticSuite, DiscLightOnItsAxis) {
  using S = typename TypeParam::Scalar;
  for (const double h : {1.0, 2.0}) {
    SceneBuilder<TypeParam, Lambertian<S>> builder;
    this->add_floor(builder, S(0.5));
    builder.emit(builder.disk({this->vec(0, 0, h), this->vec(0, 0, -1), this->vec(1, 0, 0), S(1)}, this->diffuse(S(0))),
                 Rgb<S>(10));
    const auto scene = builder.build();
    const double exact = 0.5 * 10 / (1 + h * h);
    Settings settings;
    settings.samples = 32;
    this->expect_all(scene, this->floor_probes({0}), {exact}, settings);
    settings.clamp_scale = 1.0 / 800;
    settings.vpls = 20;
    settings.adaptation = 2;  // C_clamp = 5e-4, far below M T D of about 0.05
    this->expect_radiance(scene, this->floor_probes({0}), {exact}, settings, Method::bdlc);
  }
}

/// Oracle O-5: 2 x 2 rectangle at height 1, centred: form factor 0.554126.
TYPED_TEST_P(AnalyticSuite, RectangleLight) {
  using S = typename TypeParam::Scalar;
  SceneBuilder<TypeParam, Lambertian<S>> builder;
  this->add_floor(builder, S(0.5));
  builder.emit(
      builder.mesh(parallelogram<S>(Vec3<S>(0, 0, 1), Vec3<S>(0, 1, 0), Vec3<S>(1, 0, 0)), this->diffuse(S(0))),
      Rgb<S>(2));
  Settings settings;
  settings.samples = 32;
  this->expect_all(builder.build(), this->floor_probes({0}), {0.5 * 2 * 0.554126}, settings);
}

/// Oracle O-4: mean irradiance of a coaxial disc is pi L F_21; discs (r1, r2, distance) -> F_12, F_21 = F_12 A_1 / A_2.
TYPED_TEST_P(AnalyticSuite, CoaxialDiscs) {
  using S = typename TypeParam::Scalar;
  struct Case {
    double r1, r2, distance, f12;
  };
  for (const Case& c : {Case{1, 1, 1, 0.381966}, Case{0.5, 1, 2, 0.192236}}) {
    SceneBuilder<TypeParam, Lambertian<S>> builder;
    builder.disk({Vec3<S>(0), Vec3<S>(0, 0, 1), Vec3<S>(1, 0, 0), static_cast<S>(c.r2)}, this->diffuse(S(0.5)));
    builder.emit(
        builder.disk({this->vec(0, 0, c.distance), this->vec(0, 0, -1), this->vec(1, 0, 0), static_cast<S>(c.r1)},
                     this->diffuse(S(0))),
        Rgb<S>(4));
    const auto r2 = static_cast<S>(c.r2 * 0.9999);  // off the rim, where a float ray may pass
    const AreaProbe<S> camera{Vec3<S>(0), Vec3<S>(r2, 0, 0), Vec3<S>(0, r2, 0), this->vec(0, 0, 0.01), true};
    Settings settings;
    settings.samples = 64;
    settings.vpls = 100;
    const double exact = 0.5 * 4 * c.f12 * sqr(c.r1 / c.r2);
    this->expect_all(builder.build(), camera, {exact}, settings, 1e-4);  // the rim left out: 2e-4 of the area
  }
}

/// Oracle O-7: a convex Lambertian body in a uniform environment shows exactly its albedo, at any scale of the scene.
/// Caught: scene radius in the VPLs' flux but 1 in T; a scene radius of 1 everywhere.
TYPED_TEST_P(AnalyticSuite, ConvexBodyInAUniformEnvironment) {
  using S = typename TypeParam::Scalar;
  for (const double scale : {1e-3, 1.0, 1e3}) {
    SceneBuilder<TypeParam, Lambertian<S>> builder;
    builder.sphere({Vec3<S>(0), static_cast<S>(scale), false}, this->diffuse(S(0.7)));
    builder.lights.environments.push_back({Rgb<S>(1), nullptr});
    ProbeCamera<S> camera;
    camera.add(Vec3<S>(0), this->vec(3 * scale, 0, 0));
    camera.add(Vec3<S>(0), this->vec(scale, -2 * scale, scale));
    Settings settings;
    settings.samples = 32;
    settings.vpls = 500;
    this->expect_all(builder.build(), camera, {0.7, 0.7}, settings);
  }
}

/// Oracle O-7 with an image: irradiance of an upward plane by quadrature of Environment::eval. One texel in the upper
/// half is 1000 times the rest.
TYPED_TEST_P(AnalyticSuite, PlaneUnderAnHdrEnvironment) {
  using S = typename TypeParam::Scalar;
  auto image = std::make_shared<Image<S>>(16, 9);
  for (auto& texel : image->pixels) texel = Rgb<S>(S(0.1));
  image->at(5, 2) = Rgb<S>(100);
  const EnvironmentEmitter<S> emitter{Rgb<S>(1), image};
  const Environment<S> environment(emitter);
  double irradiance = 0;  // midpoint rule over the hemisphere y > 0
  const int n = 512;
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < 2 * n; ++k) {
      const double theta = (i + 0.5) * k_pi<double> / 2 / n;
      const double phi = (k + 0.5) * k_pi<double> / n;
      const Rgb<S> radiance = environment.eval(
          this->vec(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi)));
      irradiance +=
          static_cast<double>(radiance.x) * std::cos(theta) * std::sin(theta) * k_pi<double> / 2 / n * k_pi<double> / n;
    }
  }
  SceneBuilder<TypeParam, Lambertian<S>> builder;
  builder.mesh(parallelogram<S>(Vec3<S>(0), this->vec(0, 0, 1), this->vec(1, 0, 0)), this->diffuse(S(0.5)));
  builder.lights.environments.push_back(emitter);
  ProbeCamera<S> camera;
  camera.add(Vec3<S>(0), this->vec(0.1, 0.2, 0.1));
  Settings settings;
  settings.samples = 64;
  this->expect_all(builder.build(), camera, {0.5 / k_pi<double> * irradiance}, settings, 1e-4);  // quadrature
}

/// Reference sheet 7.11, rho = 0.5, r = 0.9 at x = 1: L = 0.190326. A spherical light of radius a and radiance
/// 1 / (pi a^2) stands for the point light exactly (7.2) and path tracing finds it in the mirrors. Light that reaches
/// a diffuse surface over mirrors only is out of reach of virtual point lights: there the direct part 0.5 / pi remains.
TYPED_TEST_P(AnalyticSuite, MirrorCorridor) {
  using S = typename TypeParam::Scalar;
  using M = SmoothMaterial<S>;
  SceneBuilder<TypeParam, M> builder;
  builder.mesh(parallelogram<S>(Vec3<S>(1, 0, 0), Vec3<S>(1, 0, 0), Vec3<S>(0, 200, 0)), M(this->diffuse(S(0.5))));
  builder.mesh(parallelogram<S>(Vec3<S>(0, 0, 100), Vec3<S>(0, 200, 0), Vec3<S>(0, 0, 100)),
               M(Mirror<S>{Rgb<S>(S(0.9))}));
  builder.mesh(parallelogram<S>(Vec3<S>(2, 0, 100), Vec3<S>(0, 0, 100), Vec3<S>(0, 200, 0)),
               M(Mirror<S>{Rgb<S>(S(0.9))}));
  const S a = S(0.4);
  builder.emit(builder.sphere({this->vec(1, 0, 1), a, false}, M(this->diffuse(S(0)))), Rgb<S>(k_inv_pi<S> / sqr(a)));
  const auto scene = builder.build();
  ProbeCamera<S> camera;
  camera.add(this->vec(1, 0, 0), this->vec(1.01, 0, 0.02));
  Settings settings;
  settings.samples = 500;
  this->expect_radiance(scene, camera, {0.190326}, settings, Method::path);
  settings.samples = 16;
  this->expect_radiance(scene, camera, {0.159155}, settings, Method::vpl);
  this->expect_radiance(scene, camera, {0.159155}, settings, Method::bdlc);
}

/// Looking along the corridor at a panel over mirrors: radiance r^m Le, exact for every method; the panel is met after
/// m + 1 segments and must be gone when paths are shorter.
TYPED_TEST_P(AnalyticSuite, EmitterSeenThroughAChainOfMirrors) {
  using S = typename TypeParam::Scalar;
  using M = SmoothMaterial<S>;
  SceneBuilder<TypeParam, M> builder;
  const M mirror(Mirror<S>{Rgb<S>(S(0.9))});
  builder.mesh(parallelogram<S>(Vec3<S>(0, 0, 0), Vec3<S>(0, 5, 0), Vec3<S>(0, 0, 5)), mirror);
  builder.mesh(parallelogram<S>(Vec3<S>(2, 0, 0), Vec3<S>(0, 0, 5), Vec3<S>(0, 5, 0)), mirror);
  builder.emit(
      builder.mesh(parallelogram<S>(Vec3<S>(1, 0, 4), Vec3<S>(0, 5, 0), Vec3<S>(1, 0, 0)), M(this->diffuse(S(0)))),
      Rgb<S>(2));
  const auto scene = builder.build();
  ProbeCamera<S> camera;
  camera.add(this->vec(2, 0, 0.5), this->vec(1, 0, 0));  // rises 0.5 per metre of x: mirrors at z = 0.5, 1.5, 2.5, 3.5
  for (const Method method : k_methods) {
    Settings settings;
    settings.samples = 4000;  // roulette of the path tracer: weight 1 / 0.9 with probability 0.9
    const Film film = render(method, scene, camera, settings);
    EXPECT_NEAR(film.pixels[0].x, 2 * std::pow(0.9, 4), 0.05) << name(method);  // 4 sigma of the roulette
    settings.max_edges = 5;
    settings.samples = 4000;
    EXPECT_NEAR(render(method, scene, camera, settings).pixels[0].x, 2 * std::pow(0.9, 4), 0.05) << name(method);
    settings.max_edges = 4;
    EXPECT_EQ(render(method, scene, camera, settings).pixels[0].x, 0) << name(method);
  }
}

/// Oracle O-34: a mirror of reflectance 1 in front of the camera shows the mirrored scene.
TYPED_TEST_P(AnalyticSuite, MirrorBeforeTheCameraShowsTheMirroredScene) {
  using S = typename TypeParam::Scalar;
  using M = SmoothMaterial<S>;
  // A corner of two walls and a point light at x > 1, the mirror in the plane x = 0 right before the camera.
  SceneBuilder<TypeParam, M> plain;
  plain.mesh(parallelogram<S>(Vec3<S>(3, 0, 0), Vec3<S>(2, 0, 0), Vec3<S>(0, 2, 0)), M(this->diffuse(S(0.7))));
  plain.mesh(parallelogram<S>(Vec3<S>(5, 0, 2), Vec3<S>(0, 2, 0), Vec3<S>(0, 0, 2)), M(this->diffuse(S(0.4))));
  plain.point_light(this->vec(3.2, 0.4, 1.5), S(10));
  SceneBuilder<TypeParam, M> mirrored = plain;
  mirrored.mesh(parallelogram<S>(this->vec(0, 0, 0), this->vec(0, 0.02, 0), this->vec(0, 0, 0.02)),
                M(Mirror<S>{Rgb<S>(1)}));
  plain.mesh(parallelogram<S>(this->vec(0, 0, 0), this->vec(0, 0.02, 0), this->vec(0, 0, 0.02)),
             M(this->diffuse(S(0))));  // the same occluder, behind the camera
  ProbeCamera<S> direct;
  ProbeCamera<S> reflected;
  for (const auto& target : {this->vec(3, 0.2, 0), this->vec(4, -0.3, 0), this->vec(5, 0.1, 1)}) {
    const Vec3<S> through = this->vec(0, 0.001, 0.003);
    const Vec3<S> w = glm::normalize(target - through);
    direct.add(target, through + w * S(0.005));
    // As far before the mirror, on the scene's side.
    reflected.add(through, through + Vec3<S>(w.x, -w.y, -w.z) * S(0.005));
  }
  for (const Method method : k_methods) {
    Settings settings;
    settings.samples = 64;
    settings.vpls = 400;
    const auto a = repeat(method, plain.build(), direct, settings, this->k_runs);
    const auto b = repeat(method, mirrored.build(), reflected, settings, this->k_runs);
    for (std::size_t i = 0; i < a.size(); ++i) {
      EXPECT_GT(a[i].mean(), 0.05);
      const double error = std::hypot(a[i].standard_error(), b[i].standard_error());
      EXPECT_NEAR(a[i].mean(), b[i].mean(), 5 * error + this->k_rounding)  // as `agrees`
          << name(method) << " probe " << i;
    }
  }
}

REGISTER_TYPED_TEST_SUITE_P(AnalyticSuite, CavityWithAPointLightAtItsCentre, CavityWithEmittingWalls,
                            EnoughVplsSwitchTheClampOff, ClampScalesTheReflectedPartOfTheCavity,
                            EveryPairOfTheCavityTransfersTheSame, FurnaceTruncatedAfterEachBounce,
                            DepthsOfThePointLitCavity, CavityWithAPointLightOffItsCentre, PointLightOverAPlane,
                            HundredWattsOverAPlane, DirectionalLightOnAPlane, DiscLightOnItsAxis, RectangleLight,
                            CoaxialDiscs, ConvexBodyInAUniformEnvironment, PlaneUnderAnHdrEnvironment, MirrorCorridor,
                            EmitterSeenThroughAChainOfMirrors, MirrorBeforeTheCameraShowsTheMirroredScene);

}  // namespace manylight::test
