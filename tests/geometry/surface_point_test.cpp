// SPDX-License-Identifier: Apache-2.0
#include "manylight/geometry/surface_point.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "geometry/test_meshes.hpp"
#include "manylight/geometry/analytic_shapes.hpp"

namespace manylight::test::surface_point_test {
namespace {

template <class S>
class SurfacePointTest : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(SurfacePointTest, Scalars);

template <class S>
Shapes<S> one_triangle() {
  Shapes<S> shapes;
  shapes.meshes.push_back({{{0, 0, 0}, {2, 0, 0}, {0, 2, 0}}, {{0, 1, 2}}, {}, {}});
  return shapes;
}
template <class S>
SurfacePoint<S> point_of(const Shapes<S>& shapes, S u = S(0.25), S v = S(0.5)) {
  return surface_point(shapes, Ray<S>{}, Hit<S>{S(1), 0, 0, u, v});
}

TYPED_TEST(SurfacePointTest, TriangleWithoutNormalsFollowsItsWinding) {
  using S = TypeParam;
  Shapes<S> shapes = one_triangle<S>();
  SurfacePoint<S> point = point_of(shapes);
  EXPECT_EQ(point.position, Vec3<S>(S(0.5), 1, 0));
  EXPECT_EQ(point.ng, Vec3<S>(0, 0, 1));
  EXPECT_EQ(point.ns, Vec3<S>(0, 0, 1));
  EXPECT_EQ(point.uv, Vec2<S>(S(0.25), S(0.5)));
  EXPECT_EQ(point.dpdu, Vec3<S>(0));
  EXPECT_GT(point.error, S(0));
  shapes.meshes[0].flip_normals = true;
  EXPECT_EQ(point_of(shapes).ng, Vec3<S>(0, 0, -1));
}

// Planted bug: ng left on the winding's side.
TYPED_TEST(SurfacePointTest, VertexNormalsDecideTheSide) {
  using S = TypeParam;
  Shapes<S> shapes = one_triangle<S>();
  shapes.meshes[0].normals.assign(3, glm::normalize(Vec3<S>(1, 0, -2)));
  SurfacePoint<S> point = point_of(shapes);
  EXPECT_EQ(point.ng, Vec3<S>(0, 0, -1));
  EXPECT_GT(glm::dot(point.ns, point.ng), S(0));
  shapes.meshes[0].flip_normals = true;
  point = point_of(shapes);
  EXPECT_EQ(point.ng, Vec3<S>(0, 0, 1));
  EXPECT_GT(glm::dot(point.ns, point.ng), S(0));
}

TYPED_TEST(SurfacePointTest, ZeroNormalsFallBack) {
  using S = TypeParam;
  Shapes<S> shapes = one_triangle<S>();
  shapes.meshes[0].normals.assign(3, Vec3<S>(0));
  EXPECT_EQ(point_of(shapes).ns, Vec3<S>(0, 0, 1));
}

// Oracle: position is linear in uv, x = 4 u + 2 and y = -2 v, so dp/du = (4, 0, 0).
TYPED_TEST(SurfacePointTest, TangentFollowsUv) {
  using S = TypeParam;
  Shapes<S> shapes = one_triangle<S>();
  shapes.meshes[0].uvs = {{S(-0.5), 0}, {0, 0}, {S(-0.5), -1}};
  const SurfacePoint<S> point = point_of(shapes);
  EXPECT_EQ(point.dpdu, Vec3<S>(4, 0, 0));
  EXPECT_EQ(point.uv, Vec2<S>(S(-0.375), S(-0.5)));
  shapes.meshes[0].uvs.assign(3, {1, 1});
  EXPECT_EQ(point_of(shapes).dpdu, Vec3<S>(0));
}

// Oracle: the sphere's and disk's equations, in double; the position satisfies them to within `error`.
TYPED_TEST(SurfacePointTest, AnalyticPointsLieOnTheirShapes) {
  using S = TypeParam;
  Shapes<S> shapes;
  add_analytic_shapes(shapes, 1);
  shapes.spheres[1].flip_normals = true;
  Random random(2);
  int checked = 0;
  for (int i = 0; i < 20000; ++i) {
    const auto id = static_cast<std::uint32_t>(random.next() * double(shapes.size()));
    const Vec3<double> center(shapes.is_sphere(id) ? shapes.sphere(id).center : shapes.disk(id).center);
    const double radius = double(shapes.is_sphere(id) ? shapes.sphere(id).radius : shapes.disk(id).radius);
    const Vec3<double> origin = 50.0 * random.direction();
    const Vec3<double> target = center + radius * random.in_cube();
    const Ray<S> ray{Vec3<S>(origin), Vec3<S>(target - origin)};
    detail::visit_crossings(shapes, id, ray, [&](S t) {
      ++checked;
      const SurfacePoint<S> point = surface_point(shapes, ray, Hit<S>{t, id, 0, S(0), S(0)});
      const Vec3<double> from_center = Vec3<double>(point.position) - center;
      const double bound = double(point.error) * std::sqrt(3.0);  // `error` is per coordinate
      const Vec3<double> normal(point.ng);
      if (shapes.is_sphere(id)) {
        const double side = shapes.sphere(id).flip_normals ? -1 : 1;
        ASSERT_NEAR(glm::length(from_center), radius, bound);
        ASSERT_NEAR(glm::length(normal * side - glm::normalize(from_center)), 0, 4 * bound / radius);
      } else {
        ASSERT_NEAR(glm::dot(from_center, Vec3<double>(shapes.disk(id).normal)), 0, bound);
        ASSERT_LE(glm::length(from_center), radius + bound + 1e-5 * radius);  // t's rounding at 50 m, along the disk
        ASSERT_EQ(point.ng, shapes.disk(id).normal);
      }
      ASSERT_TRUE(point.uv.x >= 0 && point.uv.x <= 1 && point.uv.y >= 0 && point.uv.y <= 1);
      ASSERT_NEAR(glm::dot(point.dpdu, point.ng), 0, 8 * std::numeric_limits<S>::epsilon() * glm::length(point.dpdu));
    });
  }
  EXPECT_GT(checked, 10000);
}

// Oracle: corners interpolated in double. The bound must hold and not be idle: at most 100 ulp of the coordinates.
// Planted bug: gamma(1) instead of gamma(7).
TYPED_TEST(SurfacePointTest, ErrorBoundsTheTrianglePosition) {
  using S = TypeParam;
  Random random(3);
  double worst = 0;
  for (int i = 0; i < 50000; ++i) {
    Shapes<S> shapes = one_triangle<S>();
    std::vector<Vec3<S>>& p = shapes.meshes[0].positions;
    const double size = std::pow(10.0, -3 * random.next());
    const Vec3<double> center = 10.0 * random.in_cube();
    for (Vec3<S>& corner : p) corner = Vec3<S>(center + size * random.in_cube());
    const S v = static_cast<S>(random.next());
    const S u = static_cast<S>(random.next() * (1 - double(v)));
    const SurfacePoint<S> point = point_of(shapes, u, v);
    using Real = long double;
    const Real w = 1 - Real(u) - Real(v);
    for (int axis = 0; axis < 3; ++axis) {
      const Real exact = w * Real(p[0][axis]) + Real(u) * Real(p[1][axis]) + Real(v) * Real(p[2][axis]);
      worst = std::max(worst, static_cast<double>(std::abs(exact - Real(point.position[axis])) / Real(point.error)));
    }
    ASSERT_LE(double(point.error), 100 * double(std::numeric_limits<S>::epsilon()) * 12);
  }
  EXPECT_LE(worst, 1.0);
}

}  // namespace
}  // namespace manylight::test::surface_point_test
