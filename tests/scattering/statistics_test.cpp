// SPDX-License-Identifier: Apache-2.0
// The statistical harness itself: special functions against published values, and that it rejects what it must.
#include "support/chi_square.hpp"
#include "support/jacobian.hpp"
#include "support/z_test.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "manylight/core/sampler.hpp"
#include "manylight/core/warp.hpp"

namespace manylight::test::statistics_test {
namespace {

TEST(Statistics, ChiSquareTailEqualsTabulatedValues) {
  EXPECT_NEAR(chi_square_p_value(10, 18.307), 0.0500006, 5e-8);    // half a unit of the last tabulated digit
  EXPECT_NEAR(chi_square_p_value(63, 90.0), 0.0144145, 5e-8);      // the same
  EXPECT_NEAR(chi_square_p_value(2, 3.0), std::exp(-1.5), 1e-14);  // exact: exponential; some ulp
  EXPECT_DOUBLE_EQ(chi_square_p_value(5, 0.0), 1.0);
}

TEST(Statistics, LimitsEqualTabulatedValues) {
  const double level = sidak_level(0.01, 4096);
  EXPECT_NEAR(level, 2.454e-6, 5e-10);  // half a unit of the last tabulated digit, as all of these
  EXPECT_NEAR(normal_limit(level), 4.712, 5e-4);
  EXPECT_NEAR(student_limit(level, 15), 7.338, 5e-4);
  EXPECT_NEAR(student_limit(level, 63), 5.183, 5e-4);
  const double small = sidak_level(0.05, 262144);
  EXPECT_NEAR(normal_limit(small), 5.203, 5e-4);
  EXPECT_NEAR(student_limit(small, 15), 9.002, 5e-4);
}

TEST(Statistics, MomentsAreExact) {
  RunningMoments moments;
  for (const double x : {1.0, 2.0, 4.0, 9.0}) moments.add(x);
  EXPECT_DOUBLE_EQ(moments.mean(), 4.0);
  EXPECT_NEAR(moments.variance(), 38.0 / 3.0, 1e-14);  // some ulp
  EXPECT_NEAR(moments.standard_error(), std::sqrt(38.0 / 12.0), 1e-14);
}

TEST(Statistics, ZTestCountsOutliersAndNans) {
  const std::vector<double> value{1.0, 1.0, 9.0, std::nan("")};
  const std::vector<double> error(4, 0.5);
  const std::vector<double> reference(4, 1.2);
  const std::vector<double> exact(4, 0.0);
  const ZTestResult result = z_test(value, error, reference, exact, 0.01);
  EXPECT_EQ(result.failures, 2u);
  EXPECT_EQ(result.tests, 4u);
}

/// Chi-square of a cosine-weighted sampler against `density`.
template <class Density>
ChiSquareResult cosine_against(const Density& density) {
  IndependentStream<double> stream(7, Stage::test, 1, 0);
  const auto draw = [&]() -> std::optional<Vec3<double>> {
    return warp::square_to_cosine_hemisphere(stream.next_2d());
  };
  return sphere_chi_square(draw, density, 200000);
}

TEST(Statistics, ChiSquareAcceptsTheRightAndRejectsTheWrongDensity) {
  EXPECT_GT(cosine_against([](const Vec3<double>& w) { return warp::cosine_hemisphere_pdf(w); }).p_value, 1e-4);
  // A missing cosine, a lobe 2 % too wide, and a density that lacks 1 % of its mass: all must be seen.
  EXPECT_LT(cosine_against([](const Vec3<double>& w) { return w.z > 0 ? 0.5 / k_pi<double> : 0.0; }).p_value, 1e-6);
  EXPECT_LT(cosine_against([](const Vec3<double>& w) {
              return w.z > 0 ? (0.98 * w.z + 0.01) / (0.99 * k_pi<double>)*0.99 : 0.0;
            }).p_value,
            0.5);
  EXPECT_FALSE(
      cosine_against([](const Vec3<double>& w) { return 0.99 * warp::cosine_hemisphere_pdf(w); }).passes(1e-6));
  EXPECT_FALSE(
      cosine_against([](const Vec3<double>& w) { return 1.01 * warp::cosine_hemisphere_pdf(w); }).passes(1e-6));
  // A density that is zero where draws land is rejected outright.
  EXPECT_FALSE(cosine_against([](const Vec3<double>& w) {
                 return w.z > 0.1 ? warp::cosine_hemisphere_pdf(w) : 0.0;
               }).failure.empty());
}

TEST(Statistics, JacobianRecoversAKnownDensity) {
  const auto map = [](const Vec2<double>& u) -> std::optional<Vec3<double>> { return warp::square_to_cone(u, 0.3); };
  const auto density = density_by_jacobian(map, {0.37, 0.61}, 1e-4);
  ASSERT_TRUE(density.has_value());
  EXPECT_NEAR(*density / warp::cone_pdf(0.3), 1.0, 1e-6);  // central differences: h^2 = 1e-8 times third derivatives
}

TEST(Statistics, QuadratureIsExactOnKnownIntegrals) {
  EXPECT_NEAR(integrate_hemisphere([](const Vec3<double>& w) { return w.z; }), k_pi<double>, 1e-12);  // Gauss is exact
  const double n = 200;
  const double lobe = integrate_hemisphere([&](const Vec3<double>& w) { return std::pow(std::max(w.x, 0.0), n); });
  EXPECT_NEAR(lobe, k_pi<double> / (n + 1), 2e-6);  // half of a full lobe 2 pi / (n + 1); the stated accuracy
}

}  // namespace
}  // namespace manylight::test::statistics_test
