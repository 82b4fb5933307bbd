// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "manylight/core/sampler.hpp"
#include "manylight/core/vector.hpp"
#include "manylight/core/warp.hpp"
#include "manylight/geometry/mesh_builders.hpp"
#include "manylight/geometry/ray.hpp"
#include "manylight/geometry/shapes.hpp"

namespace manylight::test {

/// How a scene is measured and where it lies.
struct Placement {
  const char* name;
  double scale;
  double shift;
};
inline constexpr Placement k_placements[] = {
    {"as is", 1, 0}, {"scaled by 1e-3", 1e-3, 0}, {"scaled by 1e4", 1e4, 0}, {"shifted by 1e4", 1, 1e4}};

template <class S>
[[nodiscard]] Vec3<S> place(const Vec3<double>& p, const Placement& placement) {
  return Vec3<S>(p * placement.scale + Vec3<double>(1, -0.7, 0.4) * placement.shift);
}

/// Variates for tests; the seed is part of the failure message by being constant in the test.
class Random {
 public:
  explicit Random(std::uint64_t seed) : stream_(seed, Stage::test, 0, 0) {}
  [[nodiscard]] double next() { return stream_.next(); }
  [[nodiscard]] Vec3<double> in_cube() {
    const double x = 2 * next() - 1;
    const double y = 2 * next() - 1;
    return {x, y, 2 * next() - 1};
  }
  [[nodiscard]] Vec3<double> direction() { return warp::square_to_sphere(stream_.next_2d()); }

 private:
  IndependentStream<double> stream_;
};

/// Closed sphere-like surface about the origin, without seam: `rings` x 2 `rings`, radius 1 +- `ripple`.
/// Star-shaped: every ray from near the origin leaves it exactly once.
template <class S>
[[nodiscard]] TriangleMesh<S> rippled_sphere(std::uint32_t rings, double ripple,
                                             const Placement& placement = k_placements[0]) {
  const std::uint32_t columns = 2 * rings;
  TriangleMesh<S> mesh;
  const auto add = [&](double theta, double phi) {
    const double r = 1 + ripple * std::sin(5 * theta) * std::sin(theta) * std::cos(4 * phi);
    mesh.positions.push_back(
        place<S>(r * Vec3<double>(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)),
                 placement));
  };
  add(0, 0);
  for (std::uint32_t i = 1; i < rings; ++i) {
    for (std::uint32_t j = 0; j < columns; ++j) add(k_pi<double> * i / rings, 2 * k_pi<double> * j / columns);
  }
  add(k_pi<double>, 0);
  const std::uint32_t last = static_cast<std::uint32_t>(mesh.positions.size()) - 1;
  const auto vertex = [&](std::uint32_t i, std::uint32_t j) { return 1 + (i - 1) * columns + j % columns; };
  for (std::uint32_t j = 0; j < columns; ++j) {
    mesh.triangles.push_back({0, vertex(1, j), vertex(1, j + 1)});
    for (std::uint32_t i = 1; i + 1 < rings; ++i) {
      mesh.triangles.push_back({vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1)});
      mesh.triangles.push_back({vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
    }
    mesh.triangles.push_back({vertex(rings - 1, j), last, vertex(rings - 1, j + 1)});
  }
  return mesh;
}

/// Unconnected triangles in [-1,1]^3 with edges of about `size`.
template <class S>
[[nodiscard]] TriangleMesh<S> soup(std::uint32_t count, double size, std::uint64_t seed) {
  Random random(seed);
  TriangleMesh<S> mesh;
  for (std::uint32_t i = 0; i < count; ++i) {
    const Vec3<double> corner = random.in_cube();
    for (int k = 0; k < 3; ++k) mesh.positions.push_back(Vec3<S>(corner + size * random.in_cube()));
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return mesh;
}

/// Triangles as long as the cube and 1e-6 as wide, and between them some without any area.
template <class S>
[[nodiscard]] TriangleMesh<S> slivers(std::uint32_t count, std::uint64_t seed) {
  Random random(seed);
  TriangleMesh<S> mesh;
  for (std::uint32_t i = 0; i < count; ++i) {
    const Vec3<S> a(random.in_cube());
    const Vec3<S> b(random.in_cube());
    mesh.positions.insert(mesh.positions.end(),
                          {a, b, i % 4 == 0 ? a : Vec3<S>(Vec3<double>(b) + 1e-6 * random.in_cube())});
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return mesh;
}

/// Same triangles many times, and triangles in a row along one axis: what splits of the hierarchy may stumble over.
template <class S>
[[nodiscard]] TriangleMesh<S> duplicates_and_rows() {
  TriangleMesh<S> mesh;
  const auto add = [&](double x) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(),
                          {Vec3<S>(Vec3<double>(x, -0.5, -0.5)), Vec3<S>(Vec3<double>(x, 0.5, -0.4)),
                           Vec3<S>(Vec3<double>(x, 0.1, 0.6))});
    mesh.triangles.push_back({first, first + 1, first + 2});
  };
  for (int i = 0; i < 100; ++i) add(0.25);
  for (int i = 0; i < 200; ++i) add(-0.9 + 0.009 * i);
  return mesh;
}

/// Spheres and disks, overlapping, of sizes from 1e-3 to 0.7.
template <class S>
void add_analytic_shapes(Shapes<S>& shapes, std::uint64_t seed) {
  Random random(seed);
  for (int i = 0; i < 20; ++i) {
    const double size = i == 0 ? 0.7 : std::pow(10.0, -3 * random.next());
    shapes.spheres.push_back({Vec3<S>(random.in_cube()), static_cast<S>(size)});
    const Vec3<double> normal = random.direction();
    const Vec3<double> tangent = glm::normalize(glm::cross(normal, random.direction()));
    shapes.disks.push_back({Vec3<S>(random.in_cube()), Vec3<S>(normal), Vec3<S>(tangent), static_cast<S>(size)});
  }
}

/// From anywhere around [-1,1]^3, one in four along axes or in their planes, segments finite and infinite.
template <class S>
[[nodiscard]] std::vector<Ray<S>> mixed_rays(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  std::vector<Ray<S>> rays(count);
  for (std::size_t i = 0; i < count; ++i) {
    Vec3<S> direction(random.direction() * std::pow(10.0, 2 * random.next() - 1));
    if (i % 4 == 1) direction[static_cast<int>(i / 4 % 3)] = i % 8 == 1 ? S(0) : -S(0);
    if (i % 16 == 5) direction[static_cast<int>((i / 4 + 1) % 3)] = S(0);
    rays[i] = {Vec3<S>(1.5 * random.in_cube()), direction};
    if (i % 3 == 1) rays[i].t_max = static_cast<S>(2 * random.next() / glm::length(Vec3<double>(direction)));
    if (i % 3 == 2) rays[i].t_min = static_cast<S>(0.5 * random.next() / glm::length(Vec3<double>(direction)));
  }
  return rays;
}

}  // namespace manylight::test
