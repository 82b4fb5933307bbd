// SPDX-License-Identifier: Apache-2.0
#include "manylight/geometry/bvh.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <thread>
#include <vector>

#include "geometry/test_meshes.hpp"

namespace manylight::test::bvh_test {
namespace {

/// Runs tasks from the last to the first, half of them on a second thread.
struct BackwardsExecutor {
  template <class Task>
  void for_each_index(std::size_t n, const Task& task) const {
    std::jthread other([&] {
      for (std::size_t i = n; i-- > 0;) {
        if (i % 2 == 1) task(i);
      }
    });
    for (std::size_t i = n; i-- > 0;) {
      if (i % 2 == 0) task(i);
    }
  }
  [[nodiscard]] std::size_t concurrency() const noexcept { return 2; }
};

// Oracle: the serial build, bit for bit.
TEST(Bvh, DoesNotDependOnTheExecutor) {
  Shapes<float> shapes;
  shapes.meshes.push_back(soup<float>(20000, 0.05, 1));
  add_analytic_shapes(shapes, 2);
  const Bvh<float> serial(shapes);
  const Bvh<float> backwards(shapes, BackwardsExecutor{});
  EXPECT_EQ(serial.bytes(), backwards.bytes());
  for (const Ray<float>& ray : mixed_rays<float>(20000, 3)) {
    const auto a = serial.closest_hit(ray);
    const auto b = backwards.closest_hit(ray);
    ASSERT_EQ(a.has_value(), b.has_value());
    if (a) {
      ASSERT_EQ(std::memcmp(&*a, &*b, sizeof *a), 0);
    }
    // The order of visits shows the shape of the tree.
    std::vector<std::uint32_t> order_a, order_b;
    serial.all_hits(ray, [&](const Hit<float>& hit) { order_a.push_back(hit.primitive); });
    backwards.all_hits(ray, [&](const Hit<float>& hit) { order_b.push_back(hit.primitive); });
    ASSERT_EQ(order_a, order_b);
  }
}

// Of hits at the same t the one of smallest (shape, primitive) is reported, wherever it lies in the tree.
// Planted bug: the later one wins.
TEST(Bvh, TiesGoToTheSmallestId) {
  Shapes<float> shapes;
  const TriangleMesh<float> once{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}, {}, {}};
  for (int i = 0; i < 50; ++i) shapes.meshes.push_back(once);
  for (TriangleMesh<float>& mesh : shapes.meshes) mesh.triangles.assign(7, {0, 1, 2});
  shapes.meshes[0].positions[0].z = shapes.meshes[0].positions[1].z = shapes.meshes[0].positions[2].z = 1.0f;
  const auto hit = Bvh<float>(shapes).closest_hit({{0.25f, 0.25f, -1}, {0, 0, 1}});
  ASSERT_TRUE(hit.has_value());
  EXPECT_EQ(hit->shape, 1u);
  EXPECT_EQ(hit->primitive, 0u);
}

// Rays along coordinate planes that are faces of boxes: 0 times infinity must not lose them.
TEST(Bvh, RaysInTheFacesOfBoxes) {
  Shapes<double> shapes;
  shapes.meshes.push_back(cube_mesh<double>());
  const Bvh<double> geometry(shapes);
  for (const double side : {-1.0, 1.0}) {
    for (const double zero : {0.0, -0.0}) {
      EXPECT_TRUE(geometry.any_hit({{side, 0.3, -3}, {zero, zero, 1}})) << side << zero;
      EXPECT_TRUE(geometry.any_hit({{0.3, side, 3}, {zero, zero, -1}})) << side << zero;
      EXPECT_TRUE(geometry.any_hit({{-3, side, side}, {1, zero, zero}})) << side << zero;
    }
  }
}

// Queries stay finite and quiet for rays that mean nothing.
TEST(Bvh, SurvivesSenselessRays) {
  Shapes<float> shapes;
  shapes.meshes.push_back(soup<float>(100, 0.5, 4));
  add_analytic_shapes(shapes, 5);
  const Bvh<float> geometry(shapes);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(geometry.any_hit({{nan, 0, 0}, {0, 0, 1}}));
  EXPECT_FALSE(geometry.any_hit({{0, 0, 0}, {nan, nan, nan}}));
  EXPECT_FALSE(geometry.any_hit({{0, 0, 0}, {0, 0, 0}}));
  EXPECT_FALSE(geometry.any_hit({{0, 0, 0}, {0, 0, 1}, 2.0f, 1.0f}));
}

}  // namespace
}  // namespace manylight::test::bvh_test
