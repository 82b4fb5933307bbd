// SPDX-License-Identifier: Apache-2.0
// Scenes in which methods of many lights are known to fail: spikes next to virtual lights, pixels that no light
// reaches, weak lights beside a strong one, fewer lights than a cut pays for, and what one cut per pixel is for.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>

#include "integrator/same_lights.hpp"

namespace manylight::test::known_failures_test {
namespace {

template <class S>
Lambertian<S> grey(double albedo) {
  return {Rgb<S>(static_cast<S>(albedo))};
}

/// Form factor from a point at height `c` of a wall to the floor rectangle that meets it: `depth` wide, `half` to
/// either side of the point [configuration factor of a perpendicular rectangle with a common edge].
double corner_form_factor(double c, double depth, double half) {
  const double slant = std::hypot(depth, c);
  return k_inv_pi<double> * (std::atan(half / c) - c / slant * std::atan(half / slant));
}

/// Stability case 1, the singularity of virtual point lights: the sun on a floor that meets a wall at 90 degrees. What
/// the wall reflects of the floor is the form factor. Asserted: without the clamp virtual lights make spikes, so that
/// the scene does show the failure; with it no pixel of any method in any run is above k times the reference;
/// lightcuts and brute force lose the edge, which is pinned; bidirectional lightcuts and path tracing agree with the
/// form factor at every probe (16 runs, see `agrees`: 2e-4 per comparison, 12 comparisons; fixed seeds). Caught:
/// C_clamp a hundred times too large; the second sensor not given what the clamp took from the first.
TEST(KnownFailures, SunlitFloorBesideAWall) {
  using S = double;
  SceneBuilder<Bvh<S>, Lambertian<S>> builder;
  builder.mesh(parallelogram<S>({0.5, 0, 0}, {0.5, 0, 0}, {0, 1, 0}), grey<S>(0.8));
  builder.mesh(parallelogram<S>({0, 0, 0.5}, {0, 1, 0}, {0, 0, 0.5}), grey<S>(0.5));
  builder.lights.directionals.push_back({{0, 0, -1}, Rgb<S>(3)});
  const auto scene = builder.build();
  const std::array<double, 6> heights{1e-4, 1e-3, 1e-2, 0.03, 0.1, 0.5};
  ProbeCamera<S> camera;
  std::vector<double> exact;
  for (const double c : heights) {
    camera.add({0, 0, c}, {0.3, 0.2, c + 0.3});
    exact.push_back(0.5 * 0.8 * 3 * k_inv_pi<double> * corner_form_factor(c, 1, 1));
  }
  Settings settings;
  settings.max_edges = 3;
  settings.adaptation = 0.1;
  settings.samples = 1;  // a probe is one point: a sensor more would be the same one
  settings.vpls = 200;
  double spike = 0;
  for (settings.seed = 1; settings.seed <= 16; ++settings.seed) {
    const Film film = render(Method::lightcuts, scene, camera, settings);
    for (std::size_t i = 0; i < exact.size(); ++i) spike = std::max(spike, film.pixels[i].x / exact[i]);
  }
  EXPECT_GT(spike, 4.0) << "without the clamp";
  settings.vpls = 2000;
  settings.clamp_scale = 1.0 / 800;
  for (const Method method : k_methods) {
    const bool is_complete = method == Method::path || method == Method::bdlc;
    settings.samples = is_complete ? 256 : 1;
    std::vector<RunningMoments> moments(exact.size());
    for (settings.seed = 1; settings.seed <= 16; ++settings.seed) {
      const Film film = render(method, scene, camera, settings);
      for (std::size_t i = 0; i < exact.size(); ++i) {
        moments[i].add(film.pixels[i].x);
        // The second vertex of an eye path meets the floor or not: 6 % noise of 256 samples, so 1.5 is 8 sigma.
        EXPECT_LT(film.pixels[i].x, 1.5 * exact[i]) << name(method) << " probe " << i;
      }
    }
    for (std::size_t i = 0; i < exact.size(); ++i) {
      if (is_complete) {
        EXPECT_TRUE(agrees(moments[i], exact[i], 0)) << name(method) << " probe " << i << ": " << moments[i].mean()
                                                     << " +- " << moments[i].standard_error() << ", exact " << exact[i];
      } else {
        EXPECT_LT(moments[i].mean(), exact[i] + 5 * moments[i].standard_error()) << name(method) << " probe " << i;
      }
    }
    if (!is_complete) {  // the clamp's loss: everything at the edge, a fifth half a metre away (measured 0.80)
      EXPECT_LT(moments.front().mean(), 0.01 * exact.front()) << name(method);
      EXPECT_NEAR(moments.back().mean(), 0.8 * exact.back(), 0.03 * exact.back()) << name(method);
    }
  }
}

/// Stability case 7: a floor beside a closed box that hides 10,000 lights. Asserted: every pixel is exactly black; the
/// cut ends at its cap and says so; work is bounded by the cap, in pairs and in rays. The pilot finds nothing lit, so
/// that the floor under the error threshold is that of L_a = 1. Caught: the capped pixel not
/// counted; shadow rays of the cut left out.
TEST(KnownFailures, PitchDarkPixels) {
  using S = double;
  SceneBuilder<Bvh<S>, Lambertian<S>> builder;
  builder.mesh(parallelogram<S>({0, 0, 0}, {9, 0, 0}, {0, 9, 0}), grey<S>(0.5));
  builder.mesh(box_mesh<S>({-1, -1, 0.5}, {1, 1, 2.5}), grey<S>(0.5));
  for (int i = 0; i < 10000; ++i) {
    builder.point_light({-0.9 + 0.08 * (i % 22), -0.9 + 0.08 * (i / 22 % 22), 0.6 + 0.08 * (i / 484)}, 1);
  }
  const auto scene = builder.build();
  ProbeCamera<S> camera;
  for (const double x : {0.0, 2.0, 4.0}) camera.add({x, 0, 0}, {x + 0.01, 0.02, 0.1});
  Settings settings;
  settings.adaptation = 0;
  settings.clamp_scale = 1.0 / 800;
  settings.samples = 4;
  settings.max_cut = 1000;
  SameLights lights(scene, camera, settings);
  EXPECT_TRUE(lights.side.is_adaptation_fallback);
  EXPECT_GE(lights.side.lights.vpls.size(), 10000u);
  for (const Method method : k_methods) {
    for (const auto& pixel : render(method, scene, camera, settings).pixels)
      EXPECT_EQ(max_channel(pixel), 0) << name(method);
  }
  for (const Method method : k_cut_methods) {
    const ManyLightStatistics cost = lights.cut(method).statistics;
    EXPECT_EQ(cost.capped_pixels, 3u) << name(method);
    for (const std::uint32_t size : cost.cut_sizes) EXPECT_EQ(size, 1000u) << name(method);
    EXPECT_LE(cost.pairs.pairs, 3 * 1000u) << name(method);  // one evaluation per cluster
    EXPECT_LE(cost.pairs.rays.shadow, cost.pairs.pairs) << name(method);
  }
}

/// Stability case 22, in float: 100,000 lights of 1e-5 W/sr (a rounding error of the strong one each, 1 W/sr together)
/// beside one of 1000 W/sr that a screen hides from the first probe, and one of no power. Asserted: the hidden probe
/// shows the weak ones' sum as brute force has it, within a cut's error; the other probe shows both; the light of no
/// power is no VPL. (Negative and NaN powers: see Emitters.RejectBadInputByName.) Caught: totals of light clusters
/// taken from the stronger child alone.
TEST(KnownFailures, WeakLightsBesideAStrongOne) {
  using S = float;
  SceneBuilder<Bvh<S>, Lambertian<S>> builder;
  builder.mesh(parallelogram<S>({0, 0, 0}, {30, 0, 0}, {0, 30, 0}), grey<S>(0.5));
  builder.mesh(parallelogram<S>({6, 0, 3}, {0, 2, 0}, {0, 0, 2}), grey<S>(0));
  for (int i = 0; i < 100'000; ++i) {
    const auto x = static_cast<S>(i % 400);
    const auto y = static_cast<S>(i / 400);
    builder.point_light({S(-2) + S(0.01) * x, S(-1.25) + S(0.01) * y, 1}, S(1e-5));
  }
  builder.point_light({10, 0, 5}, S(1000));
  builder.point_light({0, 0, S(0.1)}, S(0));
  const auto scene = builder.build();
  ProbeCamera<S> camera;
  camera.add({0, 0, 0}, {S(0.1), S(0.1), S(0.2)});
  camera.add({10, 5, 0}, {S(10.1), S(5.1), S(0.2)});
  Settings settings;
  settings.samples = 1;
  settings.vpls = 1;
  SameLights lights(scene, camera, settings);
  const auto& vpls = lights.side.lights.vpls;
  EXPECT_EQ(std::count_if(vpls.begin(), vpls.end(), [](const auto& v) { return v.exact; }), 100'001);
  const auto exact = lights.all_pairs();
  const auto visible = static_cast<double>(exact.image.pixels[1].x);
  EXPECT_NEAR(visible, 0.5 * 1000 / k_pi<double> * 5 / std::pow(50, 1.5), 0.01 * visible);  // the weak ones' part
  EXPECT_GT(exact.image.pixels[0].x, S(0.03));
  for (const Method method : k_cut_methods) {
    const auto cut = lights.cut(method);
    std::cout << name(method) << ": hidden " << cut.image.pixels[0].x / exact.image.pixels[0].x << " of the sum, cuts "
              << cut.statistics.cut_sizes[0] << " and " << cut.statistics.cut_sizes[1] << '\n';
    EXPECT_EQ(cut.statistics.capped_pixels, 0u) << name(method);
    for (int i = 0; i < 2; ++i) {  // 2 % per cluster, of random signs: measured 1.4 %
      const auto at = static_cast<std::size_t>(i);
      EXPECT_NEAR(cut.image.pixels[at].x, exact.image.pixels[at].x, S(0.03) * exact.image.pixels[at].x) << name(method);
    }
  }
}

/// Stability case 35: with few lights a cut must not cost more than the sum over all pairs, whatever the threshold.
/// Asserted in pairs evaluated and in shadow rays, which no machine's load can blur: at most 1.1 times brute force's at
/// 50 to 1000 lights, at the usual threshold and at 0, where the cut ends at single pairs. Caught: both children of a
/// split evaluated afresh.
TEST(KnownFailures, FewLightsCostNoMoreThanBruteForce) {
  const auto scene = diffuse_room().build();
  const auto camera = diffuse_room_camera(3);
  for (const std::size_t count : {50u, 100u, 200u, 500u, 1000u}) {
    Settings settings;
    settings.vpls = count;
    settings.samples = 4;
    settings.adaptation = 1;
    settings.clamp_scale = 1.0 / 800;
    settings.max_cut = 1'000'000;
    SameLights lights(scene, camera, settings);
    for (const Method method : k_cut_methods) {
      const ManyLightStatistics brute = lights.brute(method).statistics;
      for (const double threshold : {0.02, 0.0}) {
        lights.config.threshold = threshold;
        const ManyLightStatistics cut = lights.cut(method).statistics;
        const double pairs = static_cast<double>(cut.pairs.pairs) / static_cast<double>(brute.pairs.pairs);
        const double rays = static_cast<double>(cut.pairs.rays.shadow) / static_cast<double>(brute.pairs.rays.shadow);
        std::cout << name(method) << ", " << count << " lights, threshold " << threshold << ": " << pairs
                  << " of all pairs, " << rays << " of all shadow rays\n";
        EXPECT_LE(pairs, 1.1) << name(method) << ' ' << count;
        EXPECT_LE(rays, 1.1) << name(method) << ' ' << count;
      }
    }
  }
}

/// One cut per pixel over all its sensors, the point of multidimensional lightcuts: with four times as many eye paths
/// the cut must grow by less than two, the square root, at each step from 4 to 256 eye paths in a room of 2000 VPLs.
/// It hardly grows at all: 272, 336, 360, 386 clusters, and 303, 379, 436, 472 of bidirectional lightcuts. Pinned: less
/// than twice as large at 256 eye paths as at 4, where the root is 8.
/// Caught: the error allowed divided by the number of sensors.
TEST(KnownFailures, CutGrowsSlowerThanTheRootOfEyePaths) {
  const auto scene = diffuse_room().build();
  const auto camera = diffuse_room_camera(4);
  for (const Method method : k_cut_methods) {
    double before = 0;
    double first = 0;
    for (const std::uint32_t samples : {4u, 16u, 64u, 256u}) {
      Settings settings;
      settings.vpls = 2000;
      settings.samples = samples;
      settings.adaptation = 1;
      settings.clamp_scale = 1.0 / 800;
      SameLights lights(scene, camera, settings);
      const auto image = lights.cut(method);
      const double mean = mean_cut(image);
      std::cout << name(method) << ", " << samples << " eye paths: " << image.statistics.sensors / 16
                << " sensors, mean cut " << mean << '\n';
      EXPECT_EQ(image.statistics.capped_pixels, 0u);
      if (before > 0) {
        EXPECT_LT(mean, 2 * before) << name(method) << ' ' << samples;
        EXPECT_LT(mean, 2 * first) << name(method) << ' ' << samples;
      }
      before = mean;
      if (samples == 4) first = mean;
    }
  }
}

}  // namespace
}  // namespace manylight::test::known_failures_test
