// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "manylight/geometry/mesh_builders.hpp"
#include "manylight/path/random_lines.hpp"

namespace manylight::test {

template <std::floating_point S>
[[nodiscard]] Shapes<S> disk_of(S radius, const Vec3<S>& center = Vec3<S>(0)) {
  Shapes<S> shapes;
  shapes.disks.push_back({center, {0, 0, 1}, {1, 0, 0}, radius});
  return shapes;
}
/// The square [-size, size]^2 at height z, of cells^2 squares cut in two.
template <std::floating_point S>
void append_grid(TriangleMesh<S>& mesh, int cells, S size, S z, const Vec3<S>& center = Vec3<S>(0)) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  const auto columns = static_cast<std::uint32_t>(cells + 1);
  for (std::uint32_t i = 0; i < columns; ++i) {
    for (std::uint32_t j = 0; j < columns; ++j) {
      const auto at = [&](std::uint32_t k) { return size * (S(2) * static_cast<S>(k) / static_cast<S>(cells) - S(1)); };
      mesh.positions.push_back(center + Vec3<S>(at(i), at(j), z));
    }
  }
  for (std::uint32_t i = 0; i + 1 < columns; ++i) {
    for (std::uint32_t j = 0; j + 1 < columns; ++j) {
      const std::uint32_t a = first + i * columns + j;
      mesh.triangles.push_back({a, a + columns, a + columns + 1});
      mesh.triangles.push_back({a, a + columns + 1, a + 1});
    }
  }
}
template <std::floating_point S>
[[nodiscard]] Shapes<S> grid_of(int cells, S size, const Vec3<S>& center = Vec3<S>(0)) {
  Shapes<S> shapes;
  shapes.meshes.emplace_back();
  append_grid(shapes.meshes.front(), cells, size, S(0), center);
  return shapes;
}

/// Crossings of each of `lines` lines.
template <Geometry G, SubsurfaceFalloff F>
[[nodiscard]] std::vector<int> counts_of(const G& geometry, const Vec3<typename G::Scalar>& center, const F& falloff,
                                         int lines, std::uint64_t seed) {
  using S = typename G::Scalar;
  std::vector<int> counts;
  for (int i = 0; i < lines; ++i) {
    IndependentStream<S> stream(seed, Stage::test, static_cast<std::uint64_t>(i), 0);
    int count = 0;
    random_lines(geometry, 0, center, falloff, 1, stream, [&](const SurfacePoint<S>&, S) { ++count; });
    counts.push_back(count);
  }
  return counts;
}

// Lines by hand through edges and vertices: positions are small multiples of powers of two, so that all is exact. On
// `rims`, edges of one triangle alone, backends may differ. Planted bug seen to fail: EdgeCrossings::is_new always
// true.
template <class G>
void edges_count_once(bool rims) {
  using S = typename G::Scalar;
  const auto crossings = [](const G& geometry, const Vec3<S>& through, const Vec3<S>& direction) {
    int count = 0;
    shape_crossings(geometry, 0, Ray<S>{through - direction, direction * S(2), S(0), S(1)},
                    [&](const Hit<S>&) { ++count; });
    return count;
  };
  const std::array<Vec3<S>, 3> directions{Vec3<S>(0, 0, 1), Vec3<S>(S(0.25), S(-0.5), -1), Vec3<S>(1, 0, S(0.5))};
  // On an edge along an axis, on a diagonal, on a vertex of six triangles, inside; on the rim, on a corner.
  std::vector<Vec3<S>> points{Vec3<S>(S(0.5), 0, 0), Vec3<S>(S(0.25), S(0.25), 0), Vec3<S>(1, -2, 0),
                              Vec3<S>(S(0.5), S(0.25), 0)};
  if (rims) points.insert(points.end(), {Vec3<S>(4, S(0.5), 0), Vec3<S>(4, 4, 0)});
  const G grid(grid_of(8, S(4)));
  for (const Vec3<S>& point : points) {
    for (const Vec3<S>& direction : directions) {
      EXPECT_EQ(crossings(grid, point, direction), 1) << point.x << ' ' << point.y;
    }
  }
  // Thinner than rounding of t: 2^-40 of half the line. The two sides have positions of their own.
  Shapes<S> slab;
  slab.meshes.emplace_back();
  append_grid(slab.meshes.front(), 8, S(4), S(0));
  append_grid(slab.meshes.front(), 8, S(4), S(0x1p-40));
  const G thin(slab);
  for (const Vec3<S>& point : points) EXPECT_EQ(crossings(thin, point, directions[0]), 2) << point.x << ' ' << point.y;
  // Every face of the cube has vertices of its own; one edge belongs to two.
  Shapes<S> shapes;
  shapes.meshes.push_back(cube_mesh<S>());
  const G cube(shapes);
  EXPECT_EQ(crossings(cube, Vec3<S>(1, 1, 0), Vec3<S>(S(0.5), S(0.5), 0)), 1);       // in by an edge
  EXPECT_EQ(crossings(cube, Vec3<S>(1, 1, 1), Vec3<S>(S(0.5), S(0.5), S(0.5))), 1);  // by a corner
  EXPECT_EQ(crossings(cube, Vec3<S>(0), Vec3<S>(2, 2, 0)), 2);                       // through two edges
  EXPECT_EQ(crossings(cube, Vec3<S>(0), Vec3<S>(2, 2, 2)), 2);                       // through two corners
}

}  // namespace manylight::test
