// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "integrator/common_scenes.hpp"
#include "manylight/integrator/photon_map.hpp"

// Density estimates by the nearest photons, and photon mapping with final gather. Comparisons over 16 runs have a
// false-alarm rate of 1e-3 each; seeds are fixed.

namespace manylight::test::photon_map_test {
namespace {

using S = double;
using V = Vec3<S>;
using SmoothBuilder = SceneBuilder<Bvh<S>, SmoothMaterial<S>>;
using SmoothSceneType = SmoothScene<Bvh<S>>;

SmoothMaterial<S> matte(S albedo) { return Lambertian<S>{Rgb<S>(albedo)}; }

/// A Poisson process of that density in the square [-0.4, 0.4]^2 of the plane z = 0: of every 4th photon the normal is
/// turned round, of others it is tilted a little.
std::vector<Photon<S>> poisson_photons(S density, IndependentStream<S>& stream) {
  constexpr S k_area = 0.64;
  std::vector<Photon<S>> photons;
  for (S t = -std::log(1 - stream.next()); t < density * k_area; t -= std::log(1 - stream.next())) {
    Photon<S> photon;
    const Vec2<S> u = stream.next_2d();
    photon.position = {0.8 * u.x - 0.4, 0.8 * u.y - 0.4, 0};
    photon.ng = photons.size() % 4 == 0 ? V(0, 0, -1) : glm::normalize(V(0.1, 0, 1));
    photon.power = Rgb<S>(1);
    photons.push_back(photon);
  }
  return photons;
}

/// Reference sheet, section 3.1: lambda = 1000, k = 50: E[1 / (pi r_k^2)] = lambda / (k - 1) = 20.408 with the relative
/// standard deviation 1 / sqrt(k - 2) = 0.1443; the sum of weights has the expectation lambda for every kernel, and
/// also where the largest radius cuts half of the lookups short. Caught: the farthest photon counted.
TEST(PhotonDensity, NearestPhotonsOfAPoissonProcess) {
  constexpr unsigned k_runs = 2500, k_count = 50;
  const S half_full = std::sqrt(50 / (1000 * k_pi<S>));
  RunningMoments inverse_area;
  std::array<RunningMoments, 4> density;
  NearestPhotons<S> scratch;
  for (unsigned run = 0; run < k_runs; ++run) {
    auto stream = IndependentSampler<S>{1}.stream(Stage::test, run);
    const PhotonMap<Photon<S>> map(poisson_photons(1000, stream));
    for (unsigned i = 0; i < density.size(); ++i) {
      const auto kernel = std::array{PhotonKernel::constant, PhotonKernel::cone, PhotonKernel::epanechnikov,
                                     PhotonKernel::constant}[i];
      S sum = 0;
      const S radius = estimate_by_nearest(map, PhotonDisc<S>{}, k_count, i == 3 ? half_full : 0.4, kernel, scratch,
                                           [&](const Photon<S>& photon, S weight) { sum += photon.power.x * weight; });
      density[i].add(sum);
      if (i == 0) inverse_area.add(1 / (k_pi<S> * radius * radius));
    }
  }
  const double limit = normal_limit(sidak_level(1e-3, 5));
  EXPECT_NEAR(inverse_area.mean(), 20.408, limit * inverse_area.standard_error());
  // The standard deviation of 2500 runs is known to 1 / sqrt(5000), with the tails of 1 / r^2 to 2 %.
  EXPECT_NEAR(std::sqrt(inverse_area.variance()) / inverse_area.mean(), 0.1443, 0.1443 * 0.08);
  for (const RunningMoments& moments : density) {
    EXPECT_NEAR(moments.mean(), 1000, limit * moments.standard_error());
    EXPECT_LT(moments.standard_error(), 4);
  }
}

/// The same by looking at all photons: sides, slab and ball. Caught: the slab left out.
TEST(PhotonDensity, QueriesEqualALookAtAll) {
  auto stream = IndependentSampler<S>{2}.stream(Stage::test, 0);
  std::vector<Photon<S>> photons;
  for (int i = 0; i < 2000; ++i) {
    Photon<S> photon;
    photon.position = V(stream.next(), stream.next(), 0.2 * stream.next());
    photon.ng = glm::normalize(V(stream.next() - 0.5, stream.next() - 0.5, stream.next() - 0.5));
    photons.push_back(photon);
    if (i % 10 == 0) photons.push_back(photon);
  }
  const PhotonMap<Photon<S>> map(photons);
  ASSERT_EQ(map.size(), photons.size());
  NearestPhotons<S> found;
  for (int query = 0; query < 50; ++query) {
    const PhotonDisc<S> disc{V(stream.next(), stream.next(), 0.2 * stream.next()), glm::normalize(V(0.1, -0.2, 1)),
                             query % 2 == 0};
    const S radius = 0.3;
    std::vector<S> inside;
    for (const Photon<S>& p : photons) {
      const V d = p.position - disc.center;
      const S facing = glm::dot(p.ng, disc.normal);
      if (facing < 0.5 && !(disc.both_sides && facing < -0.5)) continue;
      const S height = std::abs(glm::dot(d, glm::normalize(disc.normal + (facing < 0 ? -p.ng : p.ng))));
      if (glm::length(d) < radius && height < 0.1 * radius) inside.push_back(std::max(glm::length(d), 10 * height));
    }
    std::sort(inside.begin(), inside.end());
    std::vector<S> visited;
    map.for_each_within(disc, radius, [&](const Photon<S>&, S squared) { visited.push_back(std::sqrt(squared)); });
    std::sort(visited.begin(), visited.end());
    ASSERT_EQ(visited.size(), inside.size());
    const std::size_t count = 7;
    map.find_nearest(disc, count, radius, found);
    ASSERT_EQ(found.size(), std::min(count, inside.size()));
    std::sort(found.begin(), found.end());
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_NEAR(std::sqrt(found[i].first), inside[i], 1e-12);  // squares and roots in another order
    }
  }
}

TEST(PhotonDensity, NoPhotonsAndPhotonsInOnePlace) {
  NearestPhotons<S> scratch;
  int added = 0;
  const auto add = [&](const Photon<S>&, S weight) { added += std::isfinite(weight) ? 1 : 100; };
  EXPECT_EQ(estimate_by_nearest(PhotonMap<Photon<S>>(), PhotonDisc<S>{}, 5, 1.0, PhotonKernel::constant, scratch, add), 1);
  const PhotonMap<Photon<S>> heap(std::vector<Photon<S>>(100));
  EXPECT_EQ(estimate_by_nearest(heap, PhotonDisc<S>{}, 5, 1.0, PhotonKernel::constant, scratch, add), 0);
  EXPECT_EQ(added, 0);
}

/// A cube whose walls emit 1 - albedo: radiance 1 everywhere.
SmoothBuilder cube(S albedo) {
  SmoothBuilder builder;
  auto walls = box_mesh<S>({-1, -1, -1}, {1, 1, 1});
  walls.flip_normals = true;
  builder.emit(builder.mesh(walls, matte(albedo)), Rgb<S>(1 - albedo));
  return builder;
}

/// Photons straight from the walls carry their flux, 24 pi (1 - albedo), and all together 1 / (1 - albedo) of it.
/// Caught: no division by the survival of roulette.
TEST(PhotonTrace, FluxIsConserved) {
  constexpr S k_albedo = 0.6;
  const auto scene = cube(k_albedo).build();
  const S flux = 24 * k_pi<S> * (1 - k_albedo);
  RunningMoments first, all;
  for (unsigned pass = 0; pass < 16; ++pass) {
    RayCounts rays;
    const auto photons = trace_photons(scene, PhotonPaths{2000}, pass, IndependentSampler<S>{3}, SerialExecutor{}, rays);
    S sum_first = 0, sum_all = 0;
    for (const Photon<S>& photon : photons.surface) {
      sum_all += photon.power.x;
      if (photon.edges == 1) sum_first += photon.power.x;
      EXPECT_GT(glm::dot(photon.ng, photon.wi), 0);
      EXPECT_FALSE(photon.is_caustic);
    }
    first.add(sum_first);
    all.add(sum_all);
  }
  const double limit = student_limit(sidak_level(1e-3, 2), 15);
  EXPECT_NEAR(first.mean(), flux, limit * first.standard_error());
  EXPECT_NEAR(all.mean(), flux / (1 - k_albedo), limit * all.standard_error());
  EXPECT_LT(all.standard_error(), 0.01 * all.mean());
}

/// Irradiance pi all over the cube, next to its edges as well. 3 %: 4000 samples share photons, so that their mean is
/// known to about 1 %, and 64 probes measure a part of a disc to 2 %. Caught: the covered part taken for all of
/// the disc.
TEST(IrradianceMap, IsEvenUpToTheEdges) {
  const auto scene = cube(0.5).build();
  RayCounts rays;
  auto photons = trace_photons(scene, PhotonPaths{20000}, 0, IndependentSampler<S>{4}, SerialExecutor{}, rays);
  const PhotonMap<Photon<S>> map(std::move(photons.surface));
  const auto irradiance = irradiance_map(scene, map, IrradianceConfig<S>{}, SerialExecutor{}, rays);
  RunningMoments everywhere, at_edges;
  for (std::size_t i = 0; i < irradiance.size(); ++i) {
    const V p = glm::abs(irradiance[i].position);
    everywhere.add(irradiance[i].irradiance.x / k_pi<S>);
    if (p.x + p.y + p.z - std::max({p.x, p.y, p.z}) - std::min({p.x, p.y, p.z}) > 0.95) {
      at_edges.add(irradiance[i].irradiance.x / k_pi<S>);
    }
  }
  EXPECT_GT(at_edges.count(), 200U);
  EXPECT_NEAR(everywhere.mean(), 1, 0.02);
  EXPECT_NEAR(at_edges.mean(), 1, 0.03);
}

Film render_photon_map(const SmoothSceneType& scene, const AnyCamera<S>& camera, const PhotonMapConfig& config,
                       std::uint32_t samples, std::uint64_t seed) {
  const IndependentSampler<S> sampler{seed};
  const auto maps = prepare_photon_maps(scene, config, sampler, SerialExecutor{});
  const PhotonMapIntegrator<SmoothSceneType> integrator(scene, config, maps);
  Film film;
  film.pixels.assign(std::size_t{camera.width()} * camera.height(), Rgb<double>(0));
  film.invalid = accumulate_photon_map_samples(integrator, camera, ReconstructionFilter<S>::box(), Window::of(camera),
                                               sampler, 0, samples, film.pixels, SerialExecutor{})
                     .invalid;
  for (Rgb<double>& p : film.pixels) p /= samples;
  return film;
}

/// Reference sheet 7.4: 1 in a cube and in a sphere, with the irradiance found before or at each lookup. 1 %: edges. Of
/// paths of at most 3 segments 1 - albedo^3. Caught: emitters behind gather rays without the weight; photons of longer
/// paths.
TEST(PhotonMapping, ClosedFurnace) {
  SmoothBuilder sphere;
  sphere.emit(sphere.sphere({V(0), 1, true}, matte(0.5)), Rgb<S>(0.5));
  const auto camera = look_at<S>({0.3, 0.2, 0.1}, {1, 0.2, 0}, 60, 4);
  for (const auto& scene : {cube(0.5).build(), sphere.build()}) {
    for (const unsigned stride : {0U, 4U}) {
      for (const unsigned max_edges : {3U, k_unlimited_edges}) {
        PhotonMapConfig config;
        config.light_paths = 4000;
        config.max_edges = max_edges;
        config.irradiance_stride = stride;
        RunningMoments mean;
        for (unsigned run = 0; run < 6; ++run) {
          const Film film = render_photon_map(scene, camera, config, 8, run);
          EXPECT_EQ(film.invalid, 0U);
          mean.add(film.mean().x);
        }
        // 0.01 for irradiance taken from the nearest sample and the probes of edges.
        EXPECT_NEAR(mean.mean(), max_edges == 3 ? 0.875 : 1.0, student_limit(1e-3, 5) * mean.standard_error() + 0.01);
        EXPECT_LT(mean.standard_error(), 0.005);
      }
    }
  }
}

/// A matte room with a box, a mirror and a ball of glass, whose caustic is one on the floor, seen in the mirror as
/// well.
SmoothBuilder room_with_glass() {
  SmoothBuilder builder;
  builder.mesh(box_mesh<S>({-1, -1, -1}, {1, 1, 1}), matte(0.6));
  builder.mesh(box_mesh<S>({-0.7, 0.3, -1}, {-0.3, 0.7, -0.4}), matte(0.5));
  builder.emit(builder.mesh(parallelogram<S>({0, 0, 0.95}, {0, 0.8, 0}, {0.8, 0, 0}), matte(0)), Rgb<S>(1));
  builder.sphere({{0.4, 0.2, -0.5}, 0.35, false}, Dielectric<S>{1.5}, false);
  builder.sphere({{-0.2, -0.1, -0.75}, 0.25, false}, Mirror<S>{Rgb<S>(0.9)});
  builder.point_light({-0.6, -0.5, 0.5}, 0.2);
  return builder;
}

/// Against path tracing, by blocks of 4 x 4 pixels, with 4 % for the blur of caustics and lookups. The point light has
/// caustics that paths cannot find: it is left out there. Caught: caustics counted at emitters hit as well; the map of
/// caustics left out.
TEST(PhotonMapping, EqualsPathTracing) {
  SmoothBuilder builder = room_with_glass();
  builder.lights.points.clear();
  const auto scene = builder.build();
  const auto camera = look_at<S>({0, -0.95, 0}, {0, 1, -0.5}, 75, 8);
  PhotonMapConfig config;
  config.light_paths = 5000;
  config.caustic_paths = 40000;
  std::array<RunningMoments, 4> path, map;
  constexpr unsigned k_runs = 16;
  for (unsigned run = 0; run < k_runs; ++run) {
    Settings settings;
    settings.samples = 80;
    settings.seed = 100 + run;
    const Film of_path = render(Method::path, scene, camera, settings);
    const Film of_map = render_photon_map(scene, camera, config, 24, run);
    EXPECT_EQ(of_map.invalid, 0U);
    std::array<double, 4> sum_path{}, sum_map{};
    for (std::size_t i = 0; i < 64; ++i) {
      const std::size_t block = i / 32 * 2 + i % 8 / 4;
      sum_path[block] += of_path.pixels[i].x / 16;
      sum_map[block] += of_map.pixels[i].x / 16;
    }
    for (std::size_t block = 0; block < 4; ++block) {
      path[block].add(sum_path[block]);
      map[block].add(sum_map[block]);
    }
  }
  const double limit = student_limit(sidak_level(1e-3, 4), k_runs - 1);
  for (std::size_t block = 0; block < 4; ++block) {
    const double error = std::hypot(path[block].standard_error(), map[block].standard_error());
    EXPECT_NEAR(map[block].mean(), path[block].mean(), limit * error + 0.04 * path[block].mean()) << block;
    EXPECT_LT(error, 0.03 * path[block].mean()) << block;
  }
}

/// A window has the bits of the whole image, and ranges of samples those of all at once.
TEST(PhotonMapping, WindowsAndRanges) {
  const auto scene = room_with_glass().build();
  const auto camera = look_at<S>({0, -0.95, 0}, {0, 1, -0.5}, 75, 6);
  PhotonMapConfig config;
  config.light_paths = 500;
  config.caustic_paths = 500;
  const IndependentSampler<S> sampler{7};
  const auto filter = ReconstructionFilter<S>::box();
  const auto maps = prepare_photon_maps(scene, config, sampler, SerialExecutor{});
  EXPECT_GT(maps.caustics.size(), 0U);
  const PhotonMapIntegrator<SmoothSceneType> integrator(scene, config, maps);
  const Window window{1, 2, 4, 5};
  std::vector<Rgb<double>> whole(36, Rgb<double>(0)), part(9, Rgb<double>(0));
  accumulate_photon_map_samples(integrator, camera, filter, Window::of(camera), sampler, 0, 3, whole, SerialExecutor{});
  accumulate_photon_map_samples(integrator, camera, filter, window, sampler, 0, 1, part, SerialExecutor{});
  accumulate_photon_map_samples(integrator, camera, filter, window, sampler, 1, 2, part, SerialExecutor{});
  for (std::uint32_t y = 2; y < 5; ++y) {
    for (std::uint32_t x = 1; x < 4; ++x) EXPECT_EQ(part[window.index(x, y)], whole[y * 6 + x]);
  }
  EXPECT_THROW(accumulate_photon_map_samples(integrator, camera, filter, window, sampler, 0, 1, whole, SerialExecutor{}),
               ParameterError);
}

TEST(PhotonMapping, BadParametersThrow) {
  const auto expect_throw = [](const auto& change) {
    PhotonMapConfig config;
    EXPECT_NO_THROW(config.validate());
    change(config);
    EXPECT_THROW(config.validate(), ParameterError);
  };
  expect_throw([](PhotonMapConfig& c) { c.light_paths = 0; });
  expect_throw([](PhotonMapConfig& c) { c.caustic_paths = std::size_t{1} << 32; });
  expect_throw([](PhotonMapConfig& c) { c.max_edges = 0; });
  expect_throw([](PhotonMapConfig& c) { c.neighbours = 1; });
  expect_throw([](PhotonMapConfig& c) { c.max_radius = -1; });
  expect_throw([](PhotonMapConfig& c) { c.max_radius = std::numeric_limits<double>::quiet_NaN(); });
  expect_throw([](PhotonMapConfig& c) { c.max_caustic_radius = std::numeric_limits<double>::infinity(); });
  expect_throw([](PhotonMapConfig& c) { c.gather_rays = 0; });
  expect_throw([](PhotonMapConfig& c) { c.light_samples = 0; });
  expect_throw([](PhotonMapConfig& c) { c.glossy_pdf = 0; });
}

}  // namespace
}  // namespace manylight::test::photon_map_test
