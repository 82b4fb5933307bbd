// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <memory>

#include "integrator/common_scenes.hpp"
#include "integrator/room.hpp"
#include "manylight/path/four_constraints.hpp"
#include "manylight/scattering/any_of.hpp"
#include "manylight/scattering/conductor.hpp"
#include "manylight/scattering/dielectric.hpp"
#include "manylight/scattering/phong.hpp"
#include "manylight/scattering/ward.hpp"

// Integrators against each other where no closed solution exists, and against what is known of their bias. The cores
// are the same in float; double keeps rounding out of the comparisons.

namespace manylight::test::consistency_test {
namespace {

using S = double;
using Real3 = Vec3<S>;
using Diffuse = Lambertian<S>;
using DiffuseScene = Scene<Bvh<S>, UniformShader<Diffuse>>;

// A Lambertian scene pays for nothing else: its vertex stores a normal, no tangent, and one colour as material.
static_assert(k_is_isotropic<Lambertian<float>> && !k_is_isotropic<Ward<float>>);
static_assert(sizeof(Lambertian<float>) == 12);
static_assert(sizeof(detail::ShadingFrame<float, true>) == 12 && sizeof(detail::ShadingFrame<float, false>) == 24);
static_assert(sizeof(Vertex<float, Lambertian<float>>) == 84,
              "position 12, error 4, ng 12, w 12, ns 12, albedo 12, alpha 4, strength 12, edges, kind and exact 4");
static_assert(sizeof(Vertex<float, Ward<float>>) > sizeof(Vertex<float, Lambertian<float>>));
static_assert(!UniformShader<Lambertian<float>>::k_may_be_transparent &&
              !UniformShader<Lambertian<float>>::k_may_absorb);

/// Means of a film over independent renderings, red channel.
template <class SceneType, Camera C>
RunningMoments film_means(Method method, const SceneType& scene, const C& camera, Settings settings, unsigned runs) {
  RunningMoments moments;
  for (unsigned run = 0; run < runs; ++run) {
    ++settings.seed;
    const Film film = render(method, scene, camera, settings);
    EXPECT_EQ(film.invalid, 0u) << name(method);
    EXPECT_EQ(film.bound_violations, 0u) << name(method);
    moments.add(film.mean().x);
  }
  return moments;
}

/// Without clamp virtual point lights are unbiased: on the wall opposite the camera, away from corners, every probe
/// agrees with path tracing. z-test, family level 1e-3 by Sidak over 9 probes of 12 runs: see the normal limit widened
/// to t.
TEST(Consistency, UnclampedVplsEqualPathTracingAwayFromCorners) {
  const auto scene = cornell<Diffuse>(grey(0.8)).build();
  ProbeCamera<S> camera;
  for (const double x : {-0.5, 0.0, 0.5}) {
    for (const double z : {-0.5, 0.0, 0.5}) camera.add({x, 1, z}, {0, -0.5, 0.1});
  }
  Settings settings;
  settings.vpls = 600;
  settings.samples = 1;  // the probe is one point: a sensor more would be the same one
  const auto vpl = repeat(Method::vpl, scene, camera, settings, 24);
  settings.samples = 400;
  const auto path = repeat(Method::path, scene, camera, settings, 24);
  const double limit = student_limit(sidak_level(1e-3, 9), 23);
  for (std::size_t i = 0; i < vpl.size(); ++i) {
    const double z = z_score(vpl[i].mean(), vpl[i].standard_error(), path[i].mean(), path[i].standard_error());
    EXPECT_LT(std::abs(z), limit) << "probe " << i << ": " << vpl[i].mean() << ' ' << path[i].mean();
    EXPECT_LT(vpl[i].standard_error(), 0.05 * vpl[i].mean());
  }
}

/// The four constraints only ever remove energy: the mean is not above path tracing's by more than errors (5 sigma,
/// 2e-5 one-sided at 15 degrees of freedom), and not below by more than the stated share. Caught: the VPL pattern D
/// without its cosine; a root of the light tree pushed twice.
template <Material M>
void expect_slightly_darker(const M& ball, double clamp_scale, double largest_loss) {
  const auto scene = cornell<M>(ball).build();
  Settings settings;
  settings.samples = 2;
  settings.vpls = 4000;
  settings.adaptation = 0;
  settings.clamp_scale = clamp_scale;
  const RunningMoments bdlc = film_means(Method::bdlc, scene, room_camera(), settings, 8);
  settings.samples = 200;
  const RunningMoments path = film_means(Method::path, scene, room_camera(), settings, 8);
  const double error = std::hypot(bdlc.standard_error(), path.standard_error());
  ::testing::Test::RecordProperty("bdlc_over_path", std::to_string(bdlc.mean() / path.mean()));
  EXPECT_LT(bdlc.mean(), path.mean() + 5 * error);
  EXPECT_GT(bdlc.mean(), path.mean() * (1 - largest_loss) - 5 * error);
  EXPECT_LT(error, 0.02 * path.mean());
}

TEST(Consistency, LightcutsOfADiffuseRoom) { expect_slightly_darker<Diffuse>(grey(0.8), 1.0 / 800, 0.02); }

TEST(Consistency, LightcutsOfAGlossyBallInARoom) {
  using M = AnyOf<Diffuse, Phong<S>>;
  const M ball(Phong<S>{Rgb<S>(0.8), 60});
  expect_slightly_darker<M>(ball, 1.0, 0.03);
  // With the paper's clamp and only 4000 VPLs the lobe (M up to 10 sr^-1, so not "narrow") loses what the clamp takes:
  // measured 0.87 of the mean, 0.95 at 40 times, 0.99 at 800 times the clamp. Pinned so that it cannot grow.
  expect_slightly_darker<M>(ball, 1.0 / 800, 0.16);
}

/// The weights of bidirectional lightcuts, and no eye path ended that could not contribute.
struct Unpruned : FourConstraints<S> {
  using FourConstraints<S>::FourConstraints;
  [[nodiscard]] bool prune(const Record& /*record*/, S /*d_sup*/) const noexcept { return false; }
  [[nodiscard]] bool prune_delta(const Record& /*record*/) const noexcept { return false; }
};
static_assert(Weighting<Unpruned>);

/// Oracle O-19 as an image: pruning ends paths whose weights are all 0 from there on, so that without it the same
/// random numbers make the same image from more sensors; on a ball of sharp gloss, of dull gloss and a mirror. Caught:
/// pruning by C_D alone, without the clamp.
TEST(Consistency, PruningChangesNothing) {
  using M = AnyOf<Diffuse, Ward<S>, Mirror<S>>;
  for (const M& ball : {M(Ward<S>{Rgb<S>(0.7), 0.02, 0.02}), M(Ward<S>{Rgb<S>(0.7), 0.3, 0.3}), M(Mirror<S>{})}) {
    const auto scene = cornell<M>(ball).build();
    const auto camera = look_at<S>({0, -0.95, 0}, {0.2, 0.1, -0.4}, 60, 16);
    const auto filter = ReconstructionFilter<S>::box();
    Settings settings;
    settings.vpls = 100;
    settings.samples = 16;
    const ManyLightConfig config = many_light_config(settings);
    const IndependentSampler<S> sampler{9};
    const auto lights = prepare_lights(scene, camera, filter, config, sampler, SerialExecutor{});
    const WeightingConfig<S> weights{0.04};
    const auto image = [&](const auto& weighting) {
      return render_all_pairs(scene, camera, filter, config, weighting, lights, sampler, SerialExecutor{});
    };
    const auto pruned = image(FourConstraints<S>(weights));
    const auto whole = image(Unpruned(weights));
    EXPECT_GT(whole.statistics.sensors, pruned.statistics.sensors + pruned.statistics.sensors / 10);
    for (std::size_t i = 0; i < pruned.image.pixels.size(); ++i) {
      const Rgb<S> difference = pruned.image.pixels[i] - whole.image.pixels[i];
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(difference[c], 0, 1e-12) << i;  // rounding of weights that are 0
    }
  }
}

/// Oracle O-23: power that light paths bring to the floor equals what eye paths see leave it, over its albedo. The
/// light passes a glass slab; the wall beside the floor has shading normals bent by 30 degrees, which light walks must
/// count with |wi.ns wo.ng| / |wi.ng wo.ns| and eye walks not at all. The emitter is large, so that eye paths find it.
/// Caught: the factor of shading normals left out of light walks. (A slab cannot tell eta^2 on light walks: it
/// cancels.)
TEST(Consistency, LightTracingEqualsEyeTracing) {
  using M = AnyOf<Diffuse, Dielectric<S>>;
  SceneBuilder<Bvh<S>, M> builder;
  builder.mesh(parallelogram<S>({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), M(grey(0.5)));
  auto wall = parallelogram<S>({1.1, 0, 1}, {0, 0, 0.9}, {0, 1, 0});
  for (auto& n : wall.normals) n = glm::normalize(n + Real3(0, 0.5, 0.3));
  builder.mesh(wall, M(grey(0.9)));
  builder.mesh(box_mesh<S>({-2, -2, 2.0}, {2, 2, 2.3}), M(Dielectric<S>{1.5}), false);
  builder.emit(builder.disk({{0.2, 0.1, 2.5}, {0, 0, -1}, {1, 0, 0}, 1.5}, M(grey(0.0))), Rgb<S>(5));
  const auto scene = builder.build();
  using SceneType = std::decay_t<decltype(scene)>;

  RunningMoments light;
  for (unsigned run = 0; run < 16; ++run) {
    RayCounts rays;
    const auto set = trace_vpls(scene, VplConfig{20000, 100}, IndependentSampler<S>{run}, SerialExecutor{}, rays);
    double power = 0;
    for (const VertexOf<SceneType>& v : set.vpls) {
      const bool on_floor = v.kind == VertexKind::surface && std::abs(v.position.z) < 1e-9;
      if (on_floor) power += v.strength.x / v.alpha;
    }
    light.add(power / 4);  // irradiance over 2 x 2
  }
  const AreaProbe<S> camera{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0.01}};
  Settings settings;
  settings.samples = 20000;
  RunningMoments eye;
  for (const RunningMoments& m : repeat(Method::path, scene, camera, settings, 16)) eye = m;
  const double irradiance = eye.mean() * k_pi<S> / 0.5;
  const double error = std::hypot(light.standard_error(), eye.standard_error() * k_pi<S> / 0.5);
  EXPECT_NEAR(light.mean(), irradiance, 5 * error);  // see `agrees`
  EXPECT_LT(error, 0.014 * irradiance);
}

/// Stability case 36: a value that is not a number is refused when the scene is made, naming what it is.
TEST(Consistency, NotANumberIsRejected) {
  const S nan = std::numeric_limits<S>::quiet_NaN();
  SceneBuilder<Bvh<S>, Diffuse> builder;
  const auto floor = builder.mesh(parallelogram<S>({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), grey(0.5));
  auto point = builder;
  point.point_light({0, 0, 1}, nan);
  EXPECT_THROW((void)point.build(), Error);
  auto area = builder;
  area.emit(floor, Rgb<S>(nan));
  EXPECT_THROW((void)area.build(), Error);
  auto far = builder;
  far.point_light({0, 0, nan}, 1);
  EXPECT_THROW((void)far.build(), Error);
  auto sun = builder;
  sun.lights.directionals.push_back({{0, 0, 0}, Rgb<S>(1)});
  EXPECT_THROW((void)sun.build(), Error);
}

/// A material that is not a number at run time costs its samples, which are counted; the film stays finite.
TEST(Consistency, NotANumberInAMaterialIsCountedOrDropped) {
  const S nan = std::numeric_limits<S>::quiet_NaN();
  SceneBuilder<Bvh<S>, Diffuse> builder;
  builder.mesh(parallelogram<S>({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), Diffuse{{0.5, nan, 0.5}});
  builder.mesh(parallelogram<S>({0, 0, -1}, {3, 0, 0}, {0, 3, 0}), grey(0.5));
  builder.point_light({0, 0, 2}, 4);
  const auto scene = builder.build();
  ProbeCamera<S> camera;
  camera.add({0, 0, 0}, {0.1, 0, 0.3});
  camera.add({2.5, 0, -1}, {2, 0, 0.3});
  for (const Method method : k_methods) {
    const Film film = render(method, scene, camera, Settings{});
    for (const auto& pixel : film.pixels) EXPECT_TRUE(is_valid_radiance(pixel)) << name(method);
    EXPECT_GT(film.invalid, 0u) << name(method);
    EXPECT_GT(film.pixels[1].x, 0.0) << name(method);
  }
}

/// Stability case 23: lights at one point or on one line. Quick size; the million is in the slow tests.
TEST(Consistency, DuplicateAndCollinearLights) {
  for (const bool on_a_line : {false, true}) {
    SceneBuilder<Bvh<S>, Diffuse> builder;
    builder.mesh(parallelogram<S>({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), grey(0.5));
    const unsigned n = 20000;
    for (unsigned i = 0; i < n; ++i) builder.point_light({on_a_line ? 1e-9 * i : 0.0, 0, 1}, 1.0 / n);
    ProbeCamera<S> camera;
    camera.add({0, 0, 0}, {0.1, 0, 0.3});
    Settings settings;
    settings.samples = 1;
    EXPECT_NEAR(render(Method::bdlc, builder.build(), camera, settings).pixels[0].x, 0.5 / k_pi<S>, 1e-6)
        << "on a line " << on_a_line;  // all lights within 2e-5 of one point
  }
}

}  // namespace
}  // namespace manylight::test::consistency_test
