// SPDX-License-Identifier: Apache-2.0
// The two backends against each other on larger meshes, and on a scanned one where the reference scenes are known.
#include "manylight/geometry/embree.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "geometry/test_meshes.hpp"
#include "manylight/geometry/bvh.hpp"

namespace manylight::test::agreement_embree_test {
namespace {

/// Rays across the box: from a random point around it to a random point in it.
std::vector<Ray<float>> rays_across(const Box<float>& box, std::size_t count, std::uint64_t seed) {
  Random random(seed);
  const Vec3<double> center(box.center());
  const Vec3<double> half = Vec3<double>(box.extent()) * 0.5;
  std::vector<Ray<float>> rays(count);
  for (Ray<float>& ray : rays) {
    const Vec3<float> origin(center + half * (2.0 * random.in_cube()));
    ray = {origin, Vec3<float>(center + half * random.in_cube()) - origin};
  }
  return rays;
}

// Oracle: the other backend. Both round, so rays within rounding of an edge on a silhouette may differ: the band is
// about 1e-6 of the mesh's size wide, its share of rays a few in 1e5 by the length of all silhouettes.
void expect_agreement(Shapes<float> shapes, std::size_t ray_count) {
  const EmbreeGeometry embree(shapes);
  const Bvh<float> bvh(std::move(shapes));
  const std::vector<Ray<float>> rays = rays_across(bvh.bounds(), ray_count, 1);
  std::size_t hits = 0, different_hit = 0, different_any = 0, far = 0;
  for (const Ray<float>& ray : rays) {
    const auto a = bvh.closest_hit(ray);
    const auto b = embree.closest_hit(ray);
    different_any += bvh.any_hit(ray) != embree.any_hit(ray) ? 1 : 0;
    if (a.has_value() != b.has_value()) {
      ++different_hit;
    } else if (a) {
      ++hits;
      // t is of order 1; at grazing angles its rounding grows by 1 / cosine, so a few may be off by more.
      far += std::abs(a->t - b->t) > 1e-4f * (std::abs(a->t) + 1) ? 1 : 0;
    }
  }
  EXPECT_GT(hits, ray_count / 10);
  EXPECT_LE(different_hit, ray_count / 10000);
  EXPECT_LE(different_any, ray_count / 10000);
  EXPECT_LE(far, ray_count / 10000);
}

TEST(Agreement, MixedShapes) {
  Shapes<float> shapes;
  shapes.meshes = {soup<float>(20000, 0.05, 3), rippled_sphere<float>(64, 0.3), slivers<float>(300, 4)};
  add_analytic_shapes(shapes, 5);
  expect_agreement(std::move(shapes), 50000);
}

TEST(Agreement, FarFromTheOrigin) {
  Shapes<float> shapes;
  shapes.meshes = {rippled_sphere<float>(64, 0.3, k_placements[3])};
  expect_agreement(std::move(shapes), 50000);
}

/// Vertices (x, y, z first) and triangles of an ASCII PLY file.
TriangleMesh<float> read_ascii_ply(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::size_t vertices = 0, faces = 0;
  std::string line;
  while (std::getline(file, line) && line.rfind("end_header", 0) != 0) {
    std::istringstream in(line);
    std::string element, kind;
    in >> element >> kind;
    if (element == "element" && kind == "vertex") in >> vertices;
    if (element == "element" && kind == "face") in >> faces;
  }
  TriangleMesh<float> mesh;
  for (std::size_t i = 0; i < vertices && std::getline(file, line); ++i) {
    Vec3<float> p(0);
    std::istringstream(line) >> p.x >> p.y >> p.z;
    mesh.positions.push_back(p);
  }
  for (std::size_t i = 0; i < faces && std::getline(file, line); ++i) {
    int corners = 0;
    std::array<std::uint32_t, 3> triangle{};
    std::istringstream(line) >> corners >> triangle[0] >> triangle[1] >> triangle[2];
    if (corners == 3) mesh.triangles.push_back(triangle);
  }
  return mesh;
}

TEST(Agreement, ScannedMesh) {
  const std::filesystem::path file =
      std::filesystem::path(MANYLIGHT_REFERENCE_SCENES) / "dragon" / "dragon_vrip_res2.ply";
  Shapes<float> shapes;
  if (std::string(MANYLIGHT_REFERENCE_SCENES).empty()) {
    // Without the scan, a mesh of its size made here.
    shapes.meshes.push_back(rippled_sphere<float>(220, 0.3));
  } else {
    ASSERT_TRUE(std::filesystem::exists(file)) << file;
    shapes.meshes.push_back(read_ascii_ply(file));
  }
  EXPECT_GT(shapes.meshes[0].triangles.size(), 100000u);
  expect_agreement(std::move(shapes), 100000);
}

}  // namespace
}  // namespace manylight::test::agreement_embree_test
