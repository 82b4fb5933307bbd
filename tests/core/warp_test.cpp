// SPDX-License-Identifier: Apache-2.0
// Each warp maps uniform variates to its stated density: a second, independently derived map back to the unit square
// (the distribution function) must give uniform variates again. Chi-square over 13 x 13 cells (odd: no edge on a plane
// of symmetry), 200,000 draws, false alarm 1e-4 each, fixed seed.
#include "manylight/core/warp.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "manylight/core/sampler.hpp"
#include "support/chi_square.hpp"

namespace manylight::test::warp_test {
namespace {

template <class ToSquare>
void expect_uniform(const ToSquare& draw_to_square) {
  constexpr int k_side = 13, k_count = 200'000;
  std::vector<ExpectedCount> cells(k_side * k_side, {double(k_count) / (k_side * k_side), 0, ""});
  IndependentStream<double> stream(6, Stage::test, 0, 0);
  for (int i = 0; i < k_count; ++i) {
    const Vec2<double> v = draw_to_square(stream.next_2d());
    ASSERT_TRUE(v.x >= 0 && v.x <= 1 && v.y >= 0 && v.y <= 1) << v.x << " " << v.y;
    const int x = std::min(static_cast<int>(v.x * k_side), k_side - 1);
    const int y = std::min(static_cast<int>(v.y * k_side), k_side - 1);
    cells[static_cast<std::size_t>(y * k_side + x)].observed += 1;
  }
  const auto result = chi_square(cells);
  EXPECT_TRUE(result.passes(1e-4)) << result.describe();
}

double turn(double y, double x) {
  const double t = std::atan2(y, x) / (2 * k_pi<double>);
  return t < 0 ? t + 1 : t;
}

// Planted bug seen: u.x for the radius.
TEST(Warp, DiskIsUniform) {
  expect_uniform([](const Vec2<double>& u) {
    const Vec2<double> p = warp::square_to_disk(u);
    return Vec2<double>(glm::dot(p, p), turn(p.y, p.x));
  });
  EXPECT_EQ(warp::square_to_disk(Vec2<double>(0.5)), Vec2<double>(0));
}

TEST(Warp, SphereIsUniform) {
  expect_uniform([](const Vec2<double>& u) {
    const Vec3<double> w = warp::square_to_sphere(u);
    EXPECT_NEAR(glm::length(w), 1, 1e-14);  // a few ulp
    return Vec2<double>((w.z + 1) / 2, turn(w.y, w.x));
  });
}

// Planted bug seen: the disk squeezed by a variate.
TEST(Warp, CosineHemisphereFollowsTheCosine) {
  expect_uniform([](const Vec2<double>& u) {
    const Vec3<double> w = warp::square_to_cosine_hemisphere(u);
    EXPECT_GT(w.z, 0);
    EXPECT_EQ(warp::cosine_hemisphere_pdf(w), w.z * k_inv_pi<double>);
    return Vec2<double>(std::min(w.z * w.z, 1.0), turn(w.y, w.x));
  });
  EXPECT_EQ(warp::cosine_hemisphere_pdf(Vec3<double>(0, 0, -1)), 0);
}

TEST(Warp, CosineHemisphereInFloatNeverHasDensityZero) {
  for (const float x : {0.0F, 0.5F, 1.0F - 0x1p-24F}) {
    for (const float y : {0.0F, 0.5F, 1.0F - 0x1p-24F}) {
      EXPECT_GT(warp::cosine_hemisphere_pdf(warp::square_to_cosine_hemisphere(Vec2<float>(x, y))), 0.0F);
    }
  }
}

TEST(Warp, ConeIsUniform) {
  for (const double cos_max : {0.95, 0.2, -0.5}) {
    expect_uniform([=](const Vec2<double>& u) {
      const Vec3<double> w = warp::square_to_cone(u, cos_max);
      return Vec2<double>((1 - w.z) / (1 - cos_max), turn(w.y, w.x));
    });
    EXPECT_NEAR(warp::cone_pdf(cos_max) * 2 * k_pi<double> * (1 - cos_max), 1, 1e-14);  // a few ulp
  }
}

// P(b1 <= t) = 1 - (1 - t)^2; b2 / (1 - b1) uniform. Planted bug seen: no square root.
TEST(Warp, TriangleIsUniform) {
  expect_uniform([](const Vec2<double>& u) {
    const Vec2<double> b = warp::square_to_triangle(u);
    EXPECT_LE(b.x + b.y, 1);
    return Vec2<double>(1 - (1 - b.x) * (1 - b.x), std::min(b.y / (1 - b.x), 1.0));
  });
}

TEST(Warp, TentFollowsItsDistributionFunction) {
  for (const double u : {0.0, 0.1, 0.5, 0.7, 0.999}) {
    const double x = warp::interval_to_tent(u);
    EXPECT_NEAR(x < 0 ? (1 + x) * (1 + x) / 2 : 1 - (1 - x) * (1 - x) / 2, u, 1e-15);  // a few ulp
  }
}

}  // namespace
}  // namespace manylight::test::warp_test
