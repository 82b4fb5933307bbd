// SPDX-License-Identifier: Apache-2.0
// Rays per second of the built-in hierarchy and of Embree: incoherent rays from random surface points in random
// directions, both queries. Reported beside them, in one run: the ratio to Embree's single-ray calls.
//
// Meshes: all .obj files of the folder named by the environment variable MANYLIGHT_BENCHMARK_MESHES, otherwise the
// living room of the reference scenes if they are known, otherwise a furnished room made here.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

#include "manylight/core/sampler.hpp"
#include "manylight/core/warp.hpp"
#include "manylight/geometry/bvh.hpp"
#include "manylight/geometry/mesh_builders.hpp"
#include "manylight/geometry/surface_point.hpp"
#ifdef MANYLIGHT_HAS_EMBREE
#include "manylight/geometry/embree.hpp"
#endif

namespace {

using namespace manylight;

constexpr std::size_t k_rays = std::size_t{1} << 19;

/// Positions and triangle fans of an OBJ file; all that rays need.
TriangleMesh<float> read_obj(const std::filesystem::path& path) {
  TriangleMesh<float> mesh;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    std::istringstream in(line);
    std::string key;
    in >> key;
    if (key == "v") {
      Vec3<float> p(0);
      in >> p.x >> p.y >> p.z;
      mesh.positions.push_back(p);
    } else if (key == "f") {
      std::vector<std::uint32_t> corners;
      for (std::string corner; in >> corner;) {
        const long index = std::strtol(corner.c_str(), nullptr, 10);
        corners.push_back(
            static_cast<std::uint32_t>(index > 0 ? index - 1 : static_cast<long>(mesh.positions.size()) + index));
      }
      for (std::size_t i = 2; i < corners.size(); ++i)
        mesh.triangles.push_back({corners[0], corners[i - 1], corners[i]});
    }
  }
  return mesh;
}

/// A sphere of 2 n^2 triangles, its radius rippled.
TriangleMesh<float> rippled_sphere(std::uint32_t n, const Vec3<float>& center, float radius, float ripples) {
  TriangleMesh<float> mesh;
  for (std::uint32_t i = 0; i <= n; ++i) {
    for (std::uint32_t j = 0; j <= n; ++j) {
      const float theta = k_pi<float> * static_cast<float>(i) / static_cast<float>(n);
      const float phi = 2 * k_pi<float> * static_cast<float>(j % n) / static_cast<float>(n);
      const float r = radius * (1 + 0.1f * std::sin(ripples * theta) * std::cos(ripples * phi));
      mesh.positions.push_back(
          center + r * Vec3<float>(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)));
    }
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    for (std::uint32_t j = 0; j < n; ++j) {
      const std::uint32_t a = i * (n + 1) + j;
      mesh.triangles.push_back({a, a + n + 1, a + n + 2});
      mesh.triangles.push_back({a, a + n + 2, a + 1});
    }
  }
  return mesh;
}

Shapes<float> furnished_room() {
  Shapes<float> shapes;
  shapes.meshes.push_back(cube_mesh<float>(Mat4<float>(5.0f)));
  for (int i = 0; i < 24; ++i) {
    const auto x = static_cast<float>(i);
    const Vec3<float> center{4 * std::cos(x * 2.4f) * std::sqrt(x / 24), 4 * std::sin(x * 2.4f) * std::sqrt(x / 24),
                             -4 + x * 0.3f};
    shapes.meshes.push_back(rippled_sphere(100, center, 0.4f, 3 + x));
  }
  return shapes;
}

Shapes<float> load_shapes() {
  namespace fs = std::filesystem;
  fs::path folder;
  if (const char* named = std::getenv("MANYLIGHT_BENCHMARK_MESHES")) folder = named;
#ifdef MANYLIGHT_REFERENCE_SCENES
  if (folder.empty() && !std::string(MANYLIGHT_REFERENCE_SCENES).empty()) {
    folder = fs::path(MANYLIGHT_REFERENCE_SCENES) / "living-room" / "models";
  }
#endif
  if (folder.empty() || !fs::is_directory(folder)) return furnished_room();
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".obj") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  Shapes<float> shapes;
  for (const fs::path& file : files) shapes.meshes.push_back(read_obj(file));
  return shapes;
}

const Shapes<float>& shapes() {
  static const Shapes<float> k_shapes = load_shapes();
  return k_shapes;
}

/// From points uniform over all surfaces, in directions uniform over the sphere.
std::vector<Ray<float>> make_rays() {
  struct Triangle {
    std::uint32_t shape, primitive;
  };
  std::vector<Triangle> triangles;
  std::vector<double> areas;
  double total = 0;
  for (std::uint32_t m = 0; m < shapes().meshes.size(); ++m) {
    const TriangleMesh<float>& mesh = shapes().meshes[m];
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      const auto& c = mesh.triangles[t];
      total += glm::length(triangle_cross(mesh.positions[c[0]], mesh.positions[c[1]], mesh.positions[c[2]]));
      triangles.push_back({m, t});
      areas.push_back(total);
    }
  }
  std::vector<Ray<float>> rays(k_rays);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    IndependentStream<double> stream(1, Stage::test, i, 0);
    const auto at = std::upper_bound(areas.begin(), areas.end() - 1, stream.next() * total) - areas.begin();
    const Triangle triangle = triangles[static_cast<std::size_t>(at)];
    const Vec2<double> b = warp::square_to_triangle(stream.next_2d());
    const Hit<float> hit{0, triangle.shape, triangle.primitive, static_cast<float>(b.x), static_cast<float>(b.y)};
    const SurfacePoint<float> point = surface_point(shapes(), Ray<float>{}, hit);
    rays[i] = leaving_ray(point, Vec3<float>(warp::square_to_sphere(stream.next_2d())));
  }
  return rays;
}

const std::vector<Ray<float>>& rays() {
  static const std::vector<Ray<float>> k_all = make_rays();
  return k_all;
}

template <class G>
const G& backend() {
  static const G k_geometry{Shapes<float>(shapes())};
  return k_geometry;
}

template <class G>
std::size_t trace_closest() {
  std::size_t hits = 0;
  for (const Ray<float>& ray : rays()) hits += backend<G>().closest_hit(ray).has_value() ? 1 : 0;
  return hits;
}
template <class G>
std::size_t trace_any() {
  std::size_t hits = 0;
  for (const Ray<float>& ray : rays()) hits += backend<G>().any_hit(ray) ? 1 : 0;
  return hits;
}
template <class G>
std::size_t trace_batch() {
  static std::vector<std::uint8_t> blocked(k_rays);
  backend<G>().any_hit_batch(rays(), blocked);
  return static_cast<std::size_t>(std::count(blocked.begin(), blocked.end(), std::uint8_t{1}));
}

using Trace = std::size_t (*)();

void rate(benchmark::State& state, Trace trace) {
  std::size_t hits = trace();
  for (auto _ : state) benchmark::DoNotOptimize(hits = trace());
  state.counters["rays_per_second"] =
      benchmark::Counter(static_cast<double>(k_rays), benchmark::Counter::kIsIterationInvariantRate);
  state.counters["hit_fraction"] = static_cast<double>(hits) / static_cast<double>(k_rays);
}

#ifdef MANYLIGHT_HAS_EMBREE
/// Both in turn within one iteration, so that another process's load falls on both.
void ratio(benchmark::State& state, Trace ours, Trace embree) {
  const auto seconds = [](Trace trace) {
    const auto begin = std::chrono::steady_clock::now();
    benchmark::DoNotOptimize(trace());
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  seconds(ours);
  seconds(embree);
  std::vector<double> ratios;
  for (auto _ : state) ratios.push_back(seconds(embree) / seconds(ours));
  std::nth_element(ratios.begin(), ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2), ratios.end());
  state.counters["ratio_to_embree"] = ratios[ratios.size() / 2];
}
#endif

template <class G>
void build(benchmark::State& state) {
  for (auto _ : state) {
    const G geometry{Shapes<float>(shapes())};
    benchmark::DoNotOptimize(geometry.bounds());
  }
  std::size_t triangles = 0;
  for (const TriangleMesh<float>& mesh : shapes().meshes) triangles += mesh.triangles.size();
  state.counters["triangles"] = static_cast<double>(triangles);
}

#define MANYLIGHT_ROWS(G, name)                                                                             \
  BENCHMARK_CAPTURE(rate, name##_closest, &trace_closest<G>)->Unit(benchmark::kMillisecond)->UseRealTime(); \
  BENCHMARK_CAPTURE(rate, name##_any, &trace_any<G>)->Unit(benchmark::kMillisecond)->UseRealTime();         \
  BENCHMARK_CAPTURE(rate, name##_any_batch, &trace_batch<G>)->Unit(benchmark::kMillisecond)->UseRealTime(); \
  BENCHMARK_TEMPLATE(build, G)->Unit(benchmark::kMillisecond)->UseRealTime()

MANYLIGHT_ROWS(Bvh<float>, bvh);
#ifdef MANYLIGHT_HAS_EMBREE
MANYLIGHT_ROWS(EmbreeGeometry, embree);
BENCHMARK_CAPTURE(ratio, closest, &trace_closest<Bvh<float>>, &trace_closest<EmbreeGeometry>)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->Iterations(11);
BENCHMARK_CAPTURE(ratio, any, &trace_any<Bvh<float>>, &trace_any<EmbreeGeometry>)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->Iterations(11);
BENCHMARK_CAPTURE(ratio, batch_of_embree_to_its_single, &trace_batch<EmbreeGeometry>, &trace_any<EmbreeGeometry>)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->Iterations(11);
#endif

}  // namespace

BENCHMARK_MAIN();
