// SPDX-License-Identifier: Apache-2.0
#include "manylight/geometry/mesh_builders.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include <glm/gtc/matrix_transform.hpp>

#include "geometry/test_meshes.hpp"
#include "manylight/core/error.hpp"
#include "manylight/geometry/surface_point.hpp"

namespace manylight::test::mesh_builders_test {
namespace {

using testing::HasSubstr;

template <class Shape>
std::string message_of(const Shape& shape) {
  try {
    validate(shape, "mesh 'teapot'");
  } catch (const GeometryError& error) {
    return error.what();
  }
  return "";
}

TEST(Validate, NamesMeshElementValueAndRange) {
  const TriangleMesh<float> good{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 0, 0}}, {}, {}};
  EXPECT_EQ(message_of(good), "");  // the second triangle has no area: legal

  TriangleMesh<float> mesh = good;
  mesh.triangles.clear();
  EXPECT_THAT(message_of(mesh), HasSubstr("mesh 'teapot' is an empty mesh"));
  mesh = good;
  mesh.triangles[1][2] = 3;
  EXPECT_EQ(message_of(mesh), "mesh 'teapot', triangle 1: index is 3, allowed: below 3 (vertices)");
  mesh = good;
  mesh.positions[2].y = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(message_of(mesh), "mesh 'teapot', vertex 2: position is not finite");
  mesh = good;
  mesh.normals.resize(2);
  EXPECT_EQ(message_of(mesh), "mesh 'teapot': number of normals is 2, allowed: 0 or 3");
  mesh = good;
  mesh.uvs.resize(4);
  EXPECT_EQ(message_of(mesh), "mesh 'teapot': number of uvs is 4, allowed: 0 or 3");
  mesh = good;
  mesh.normals.assign(3, Vec3<float>(std::numeric_limits<float>::infinity()));
  EXPECT_THAT(message_of(mesh), HasSubstr("vertex 0: normal is not finite"));
}

TEST(Validate, SpheresAndDisks) {
  EXPECT_EQ(message_of(Sphere<double>{}), "");
  EXPECT_EQ(message_of(Disk<double>{}), "");
  EXPECT_EQ(message_of(Sphere<double>{{0, 0, 0}, -1.5}),
            "mesh 'teapot': sphere radius is -1.5, allowed: finite and above 0");
  EXPECT_THAT(message_of(Disk<double>{{0, 0, 0}, {0, 0, 2}, {1, 0, 0}, 1}),
              HasSubstr("length of the disk's normal is 2"));
  EXPECT_THAT(message_of(Disk<double>{{0, 0, 0}, {0, 0, 1}, {0, 0, 1}, 1}), HasSubstr("tangent"));
}

TEST(MeshBuilders, RectangleFacesUpWithUv) {
  const TriangleMesh<double> mesh = rectangle_mesh<double>(glm::scale(Mat4<double>(1.0), Vec3<double>(2, 3, 1)));
  validate(mesh, "rectangle");
  ASSERT_EQ(mesh.triangles.size(), 2u);
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3<double> cross = triangle_cross(mesh.positions[a], mesh.positions[b], mesh.positions[c]);
    EXPECT_EQ(cross, Vec3<double>(0, 0, 24));  // twice half of 4 x 6
  }
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(mesh.normals[i], Vec3<double>(0, 0, 1));
    EXPECT_EQ(mesh.uvs[i], Vec2<double>((mesh.positions[i].x + 2) / 4, (mesh.positions[i].y + 3) / 6));
  }
}

// Oracle: the cube's faces by hand: outward winding and normals, area 4 each, uv a square on each.
TEST(MeshBuilders, CubeIsClosedAndFacesOut) {
  const TriangleMesh<float> mesh = cube_mesh<float>();
  validate(mesh, "cube");
  ASSERT_EQ(mesh.triangles.size(), 12u);
  ASSERT_EQ(mesh.positions.size(), 24u);
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3<double> cross = triangle_cross(mesh.positions[a], mesh.positions[b], mesh.positions[c]);
    EXPECT_EQ(Vec3<float>(cross), mesh.normals[a] * 4.0f);
    EXPECT_GT(glm::dot(Vec3<float>(cross), mesh.positions[a]), 0.0f);
    const Vec2<float> e1 = mesh.uvs[b] - mesh.uvs[a];
    const Vec2<float> e2 = mesh.uvs[c] - mesh.uvs[a];
    EXPECT_EQ(std::abs(e1.x * e2.y - e1.y * e2.x), 1.0f);
  }
  // Two corners of the layout that texture scenes rely on.
  const auto uv_at = [&](const Vec3<float>& p, const Vec3<float>& n) {
    for (std::size_t i = 0; i < 24; ++i) {
      if (mesh.positions[i] == p && mesh.normals[i] == n) return mesh.uvs[i];
    }
    return Vec2<float>(-1);
  };
  EXPECT_EQ(uv_at({1, -1, -1}, {0, -1, 0}), Vec2<float>(0, 1));
  EXPECT_EQ(uv_at({1, 1, 1}, {0, 0, 1}), Vec2<float>(1, 1));
}

TEST(Transform, NormalsStayPerpendicular) {
  const Mat4<double> m =
      glm::rotate(glm::scale(Mat4<double>(1.0), Vec3<double>(3, 0.5, 1)), 0.7, Vec3<double>(1, 2, 3));
  const TriangleMesh<double> mesh = cube_mesh<double>(m);
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3<double> cross = glm::normalize(triangle_cross(mesh.positions[a], mesh.positions[b], mesh.positions[c]));
    EXPECT_NEAR(glm::dot(cross, mesh.normals[a]), 1.0, 1e-14);  // rounding of two normalisations
  }
  EXPECT_THROW((void)cube_mesh<double>(glm::scale(Mat4<double>(1.0), Vec3<double>(1, 0, 1))), GeometryError);
}

TEST(Transform, SpheresAndDisksKeepTheirKind) {
  const Mat4<float> moved = glm::translate(Mat4<float>(1.0f), {1, 2, 3});
  const Sphere<float> sphere = transform(Sphere<float>{{1, 0, 0}, 2}, glm::scale(moved, Vec3<float>(3)));
  EXPECT_EQ(sphere.center, Vec3<float>(4, 2, 3));
  EXPECT_EQ(sphere.radius, 6.0f);
  EXPECT_THROW((void)transform(Sphere<float>{}, glm::scale(moved, Vec3<float>(1, 2, 1))), GeometryError);

  const Disk<float> disk = transform(Disk<float>{}, glm::scale(moved, Vec3<float>(3, 3, 0.1f)));
  EXPECT_EQ(disk.radius, 3.0f);
  EXPECT_EQ(disk.normal, Vec3<float>(0, 0, 1));
  validate(disk, "disk");
  EXPECT_THROW((void)transform(Disk<float>{}, glm::scale(moved, Vec3<float>(1, 2, 1))), GeometryError);
}

/// A cube whose faces share their eight corners.
TriangleMesh<double> welded_cube() {
  TriangleMesh<double> mesh;
  for (std::uint32_t i = 0; i < 8; ++i) mesh.positions.push_back({i & 1, (i >> 1) & 1, (i >> 2) & 1});
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

// Oracle: below 90 degrees each face keeps its own normals (24 vertices); above, each corner has one along its
// diagonal. Planted bugs: comparison turned round; weights by area instead of angle (the diagonals then fail).
TEST(SmoothNormals, CreasesOfACube) {
  TriangleMesh<double> sharp = welded_cube();
  compute_smooth_normals(sharp, 89.0);
  validate(sharp, "sharp");
  EXPECT_EQ(sharp.positions.size(), 24u);
  for (const auto& [a, b, c] : sharp.triangles) {
    const Vec3<double> face = triangle_cross(sharp.positions[a], sharp.positions[b], sharp.positions[c]);
    for (const std::uint32_t i : {a, b, c}) EXPECT_NEAR(glm::dot(sharp.normals[i], face), 1.0, 1e-14);
  }
  TriangleMesh<double> smooth = welded_cube();
  compute_smooth_normals(smooth, 91.0);
  EXPECT_EQ(smooth.positions.size(), 8u);
  for (std::size_t i = 0; i < 8; ++i) {
    const Vec3<double> diagonal = glm::normalize(smooth.positions[i] - 0.5);
    EXPECT_NEAR(glm::dot(smooth.normals[i], diagonal), 1.0, 1e-14);
  }
}

// Oracle: a fine sphere's vertex normals are its radii; unwelded triangles are welded by position.
TEST(SmoothNormals, SphereNormalsAreRadii) {
  const TriangleMesh<double> welded = rippled_sphere<double>(32, 0.0);
  TriangleMesh<double> mesh;
  for (const auto& corners : welded.triangles) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const std::uint32_t i : corners) mesh.positions.push_back(welded.positions[i]);
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  compute_smooth_normals(mesh, 30.0);
  EXPECT_EQ(mesh.positions.size(), welded.positions.size());
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    EXPECT_GT(glm::dot(mesh.normals[i], mesh.positions[i]), std::cos(0.02));  // faces of 0.1 rad: second order in it
  }
}

TEST(SmoothNormals, SeamsInUvStaySplitAndZeroAreaIsHarmless) {
  TriangleMesh<float> mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {0, 1, 0}, {-1, 0, 0}},
                           {{0, 1, 2}, {3, 4, 5}, {0, 0, 0}},
                           {},
                           {{0, 0}, {1, 0}, {0, 1}, {1, 0}, {1, 1}, {0, 0}}};
  compute_smooth_normals(mesh, 180.0f);
  validate(mesh, "seam");
  EXPECT_EQ(mesh.positions.size(), 6u);
  for (const Vec3<float>& normal : mesh.normals) EXPECT_EQ(normal, Vec3<float>(0, 0, 1));
  EXPECT_THROW(compute_smooth_normals(mesh, -1.0f), ParameterError);
}

}  // namespace
}  // namespace manylight::test::mesh_builders_test
