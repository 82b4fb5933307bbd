// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "integrator/same_lights.hpp"
#include "manylight/core/sobol.hpp"
#include "manylight/scene/instants.hpp"

// Scenes in motion, as the mean over their instants. False alarms: `agrees` 2e-4 per comparison.

namespace manylight::test::motion_test {
namespace {

using S = double;
using V = Vec3<S>;
using Snapshot = Scene<Bvh<S>, UniformShader<Lambertian<S>>, NoMedia, Moving>;
using MovingScene = Instants<Snapshot>;

static_assert(sizeof(VertexOf<DiffuseScene<Bvh<float>>>) == 84, "what stands still has no instant");

/// A grey floor; `light(time)` and `wall(time)` for time in [0, 1).
template <class Light, class Wall>
MovingScene moving_scene(std::uint32_t instants, const Light& light, const Wall& wall) {
  std::vector<Snapshot> scenes;
  for (std::uint32_t i = 0; i < instants; ++i) {
    const double time = (i + 0.5) / instants;
    Shapes<S> shapes;
    shapes.meshes.push_back(parallelogram<S>({0, 0, 0}, {4, 0, 0}, {0, 4, 0}));
    shapes.meshes.push_back(parallelogram<S>(wall(time), {0.5, 0, 0}, {0, 0.5, 0}));
    EmitterList<S> lights;
    light(time, lights);
    const std::vector<UniformShader<Lambertian<S>>> shaders{{{Rgb<S>(0.5)}, true}};
    scenes.emplace_back(Bvh<S>(shapes), shaders, std::vector<std::uint32_t>{0, 0}, lights, NoMedia{},
                        Box<S>{V(-5), V(5)});
  }
  return MovingScene(std::move(scenes));
}
const auto no_wall = [](double) { return V(0, 0, -3); };

/// Stability case 30: a point light that moves along x, 256 instants, through a lens. L is the mean of the instants'
/// rho I cos / (pi r^2). Caught: sensors and lights of different instants connected.
TEST(Motion, MovingPointLight) {
  constexpr std::uint32_t k_instants = 256;
  const auto at = [](double time) { return V(-1 + 2 * time, 0.3, 1); };
  const MovingScene scene = moving_scene(
      k_instants, [&](double time, EmitterList<S>& lights) { lights.points.push_back({at(time), Rgb<S>(2)}); }, no_wall);
  PerspectiveConfig<S> lens;
  lens.to_world[0] = {-1, 0, 0, 0};
  lens.to_world[1] = {0, 1, 0, 0};
  lens.to_world[2] = {0, 0, -1, 0};
  lens.to_world[3] = {0, 0, 3, 1};
  lens.horizontal_fov = 1e-3;
  lens.width = lens.height = 1;
  lens.aperture_radius = 0.2;
  lens.focus_distance = 3;
  double exact = 0;
  for (std::uint32_t i = 0; i < k_instants; ++i) {
    const V light = at((i + 0.5) / k_instants);
    exact += 0.5 / k_pi<S> * 2 * light.z / std::pow(glm::dot(light, light), 1.5) / k_instants;
  }
  for (const Method method : k_methods) {
    Settings settings;
    settings.samples = k_instants;
    settings.max_edges = 2;
    settings.threshold = 0.001;
    const double seen = render(method, scene, PerspectiveCamera<S>(lens), settings).mean().x;
    EXPECT_NEAR(seen, exact, 1e-4 * exact) << name(method);
  }
}

/// An area light and an occluder that both move, with interreflection: all methods have the same mean, and cuts stay
/// within their threshold of the sum over all pairs. Caught: lights divided by all paths instead of their instant's;
/// shadow rays of the first instant.
TEST(Motion, MethodsAgreeOnMovingLightAndOccluder) {
  std::vector<Snapshot> scenes;
  constexpr std::uint32_t k_instants = 8;
  for (std::uint32_t i = 0; i < k_instants; ++i) {
    const double time = (i + 0.5) / k_instants;
    Shapes<S> shapes;
    shapes.meshes.push_back(parallelogram<S>({0, 0, 0}, {4, 0, 0}, {0, 4, 0}));
    shapes.meshes.push_back(parallelogram<S>({-0.5 + time, 0, 0.6}, {0.3, 0, 0}, {0, 0.3, 0}));
    shapes.meshes.push_back(parallelogram<S>({0, 1 - 2 * time, 2}, {0, 0.3, 0}, {0.3, 0, 0}));
    shapes.meshes.push_back(parallelogram<S>({0, 1.5, 1}, {1, 0, 0}, {0, 0, 1}));
    EmitterList<S> lights;
    lights.areas.push_back({2, Texture<S>(Rgb<S>(10)), false});
    const std::vector<UniformShader<Lambertian<S>>> shaders{{{Rgb<S>(0.6)}, true}};
    scenes.emplace_back(Bvh<S>(shapes), shaders, std::vector<std::uint32_t>{0, 0, 0, 0}, lights, NoMedia{},
                        Box<S>{V(-5), V(5)});
  }
  const MovingScene scene(std::move(scenes));
  const auto camera = look_at<S>({0.2, -2, 1.5}, {0, 0, 0.3}, 50, 4);
  Settings settings;
  settings.samples = 16;
  const auto means = [&](Method method, std::uint32_t samples) {
    RunningMoments moments;
    Settings many = settings;
    many.samples = samples;
    for (unsigned run = 0; run < 16; ++run) {
      ++many.seed;
      moments.add(render(method, scene, camera, many).mean().x);
    }
    return moments;
  };
  const RunningMoments path = means(Method::path, 400);
  for (const Method method : {Method::vpl, Method::lightcuts, Method::bdlc}) {
    const RunningMoments seen = means(method, 16);
    EXPECT_LT(std::abs(z_score(path.mean(), path.standard_error(), seen.mean(), seen.standard_error())),
              student_limit(1e-3, 15))
        << name(method) << ": " << seen.mean() << " +- " << seen.standard_error() << ", path " << path.mean();
  }
  SameLights lights(scene, camera, settings);
  for (const Method method : k_cut_methods) {
    const auto cut = lights.cut(method);
    const auto brute = lights.brute(method);
    EXPECT_EQ(cut.statistics.pairs.bound_violations, 0u);
    for (std::size_t i = 0; i < cut.image.pixels.size(); ++i) {
      EXPECT_NEAR(cut.image.pixels[i].x, brute.image.pixels[i].x, 0.06 * brute.image.pixels[i].x) << name(method);
    }
  }
}

/// What stands still while the shutter is open has the clamp of the single instant, though each of its lights is n times
/// as strong in its own: I_avg is what a pixel gets. Caught: I_avg without the division by n, which clamped 32 times as
/// hard at 32 instants.
TEST(Motion, MeanIntensityDoesNotDependOnInstants) {
  const auto mean_intensity = [](std::uint32_t instants) {
    const MovingScene scene = moving_scene(
        instants, [](double, EmitterList<S>& lights) { lights.areas.push_back({1, Texture<S>(Rgb<S>(3)), true}); },
        [](double) { return V(0, 0, 1); });
    RayCounts rays;
    return trace_vpls(scene, VplConfig{65'536, 6}, IndependentSampler<S>{1}, SerialExecutor{}, rays).mean_intensity;
  };
  const S one = mean_intensity(1);
  EXPECT_GT(one, 0);
  // Each holds the flux by roulette, 1.4 / sqrt(65,536) of it uncertain: 0.8 % between the two, of which 4.5 times.
  EXPECT_NEAR(mean_intensity(32), one, 0.035 * one);
}

/// Two lamps of one flux: of the light paths of every instant exactly half start at each if their numbers fill the unit
/// interval evenly. Caught: a stream per path, as for independent numbers; instants dealt among the points of one set, of
/// which each gets a slice.
TEST(Motion, LightPathsOfAnInstantAreStratified) {
  constexpr std::size_t k_paths = 64;
  for (const std::uint32_t instants : {1u, 4u}) {
    const MovingScene scene = moving_scene(
        instants,
        [](double, EmitterList<S>& lights) {
          lights.areas.push_back({0, Texture<S>(Rgb<S>(1)), false});
          lights.areas.push_back({1, Texture<S>(Rgb<S>(64)), false});  // of 1/64 of the area
        },
        [](double) { return V(0, 0, 1); });
    RayCounts rays;
    const auto set = trace_vpls(scene, VplConfig{instants * k_paths, 2}, SobolSampler<S>{1}, SerialExecutor{}, rays);
    ASSERT_EQ(set.vpls.size(), instants * k_paths) << "emissions alone";
    for (std::uint32_t i = 0; i < instants; ++i) {
      const auto below = std::count_if(set.vpls.begin(), set.vpls.end(),
                                       [i](const auto& v) { return v.instant == i && v.position.z < 0.5; });
      EXPECT_EQ(below, k_paths / 2) << "instant " << i << " of " << instants;
    }
  }
}

/// As many samples as there are instants meet each once; a quarter of them leave no gap of half the interval; the first
/// sample's is any, by the seed. Caught: strides of 1, which see the interval's parts one after the other; of a divisor of
/// the count; a start by the index alone, which passes of few samples would share.
TEST(Motion, SamplesSpreadOverInstants) {
  for (const std::uint32_t count : {2u, 3u, 6u, 8u, 32u, 100u, 255u, 1000u}) {
    for (const std::uint64_t index : {0u, 7u, 123'456u}) {
      std::vector<bool> is_met(count, false);
      for (std::uint64_t i = 5; i < 5 + count; ++i) is_met[sample_instant(count, IndependentSampler<S>{1}, index, i)] = true;
      EXPECT_EQ(std::count(is_met.begin(), is_met.end(), true), count) << count;
      if (count < 8) continue;
      std::vector<std::uint32_t> met;
      for (std::uint64_t i = 0; i < count / 4; ++i) met.push_back(sample_instant(count, IndependentSampler<S>{1}, index, i));
      std::sort(met.begin(), met.end());
      std::uint32_t gap = met.front() + count - met.back();
      for (std::size_t i = 1; i < met.size(); ++i) gap = std::max(gap, met[i] - met[i - 1]);
      EXPECT_LT(gap, count / 2 + 2) << count;
    }
  }
  std::vector<int> first(8, 0);
  for (std::uint64_t seed = 0; seed < 800; ++seed) ++first[sample_instant(8, IndependentSampler<S>{seed}, 5, 0)];
  for (const int met : first) EXPECT_NEAR(met, 100, 45);  // binomial, 4.8 standard deviations: 1e-5
}

/// A camera that moves sideways by the width of what it sees: the mean of the instants' views.
TEST(Motion, MovingCamera) {
  const MovingScene scene = moving_scene(
      4, [](double, EmitterList<S>& lights) { lights.points.push_back({V(0, 0, 2), Rgb<S>(1)}); }, no_wall);
  std::vector<ProbeCamera<S>> cameras(4);
  double exact = 0;
  for (int i = 0; i < 4; ++i) {
    cameras[static_cast<std::size_t>(i)].add({0.5 * i, 0, 0}, {0.5 * i, 0.1, 1});
    exact += 0.5 / k_pi<S> * 2 / std::pow(4 + 0.25 * i * i, 1.5) / 4;
  }
  const PathIntegrator<MovingScene> integrator(scene, PathConfig{2});
  const MovingCamera<ProbeCamera<S>> camera(cameras);
  std::vector<Rgb<double>> sums(1, Rgb<double>(0));
  (void)accumulate_path_samples(integrator, camera, ReconstructionFilter<S>::box(), Window::of(camera),
                                IndependentSampler<S>{1}, 0, 8, sums, SerialExecutor{});
  EXPECT_NEAR(sums[0].x / 8, exact, 1e-9);
}

TEST(Motion, RejectsInstantsThatDoNotFit) {
  EXPECT_THROW(MovingScene(std::vector<Snapshot>{}), SceneError);
  EXPECT_THROW(MovingCamera<ProbeCamera<S>>(std::vector<ProbeCamera<S>>{}), ParameterError);
  const auto snapshot = [](double size) {
    Shapes<S> shapes;
    shapes.meshes.push_back(parallelogram<S>({0, 0, 0}, {size, 0, 0}, {0, size, 0}));
    EmitterList<S> lights;
    lights.points.push_back({V(0, 0, 1), Rgb<S>(1)});
    return Snapshot(Bvh<S>(shapes), {{{Rgb<S>(0.5)}, true}}, {0}, lights);
  };
  EXPECT_THROW(MovingScene({snapshot(1), snapshot(2)}), SceneError);
}

}  // namespace
}  // namespace manylight::test::motion_test
