// SPDX-License-Identifier: Apache-2.0
// Oracles: sigma_t of cylinders in closed form; optical thickness by the midpoint rule.
#include "manylight/media/fiber_medium.hpp"

#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/ext/matrix_transform.hpp>

#include "manylight/core/warp.hpp"
#include "media/media_support.hpp"

namespace manylight::test::fiber_medium_test {
namespace {

template <std::floating_point S>
using Fibers = FiberMedium<Cylinders<S>, GridVolume<S, S>>;
static_assert(Medium<Fibers<float>> && Medium<Fibers<double>>);

TEST(PackedDirection, IsAccurateToAThousandthOfARadian) {
  IndependentStream<double> stream(1, Stage::test, 0, 0);
  double worst = 0;
  for (int i = 0; i < 200000; ++i) {
    const Vec3<double> w = warp::square_to_sphere(stream.next_2d());
    const Vec3<double> v = PackedDirection(w * 3.0).unpack<double>();
    EXPECT_NEAR(glm::length(v), 1, 1e-15);  // some ulp
    worst = std::max(worst, glm::length(glm::cross(w, v)));
  }
  EXPECT_LT(worst, 0.06 * k_pi<double> / 180);  // as documented
  for (const Vec3<float>& w :
       {Vec3<float>(1, 0, 0), Vec3<float>(0, -1, 0), Vec3<float>(0, 0, 1), Vec3<float>(0, 0, -1)}) {
    EXPECT_EQ(PackedDirection(w).unpack<float>(), w);
  }
  EXPECT_EQ(PackedDirection().unpack<float>(), Vec3<float>(0, 0, 1));
}

TEST(FiberMedium, ExtinctionIsTwiceDensityTimesProjectedArea) {
  const auto density = make_grid<double, double>({3, 3, 3}, [](auto x, auto, auto) { return x * 0.5; });
  const std::vector<Vec3<double>> axes(27, Vec3<double>(0, 2, 0));
  const Fibers<double> medium(density, axes, 10, Rgb<double>(0.9, 0.5, 0.1), {});
  const Vec3<double> x(0.75, 0.2, 0.6);                         // density .75
  EXPECT_NEAR(medium.sigma_t(x, {1, 0, 0}).y, 2 * 7.5, 1e-12);  // some ulp
  EXPECT_NEAR(medium.sigma_t(x, {0, 1, 0}).x, 0, 1e-12);
  EXPECT_NEAR(medium.sigma_t(x, glm::normalize(Vec3<double>(0, 1, -1))).x, 15 * std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(medium.sigma_s(x, {0, 0, 1}).z, 1.5, 1e-12);
  EXPECT_EQ(medium.phase(x).axis, Vec3<double>(0, 1, 0));
  EXPECT_EQ(medium.sigma_t({1.5, 0, 0}, {1, 0, 0}), Rgb<double>(0));
  EXPECT_EQ(medium.bytes(), 27 * (sizeof(double) + 3) + sizeof(double));
}

// Fibers in the grid's own x direction; the grid is turned by 90 degrees about z, so they run along y of the world.
// Planted bug seen to fail: axes as given.
TEST(FiberMedium, AxesTurnWithTheGrid) {
  GridPlacement<double> placement;
  placement.to_world =
      glm::scale(glm::rotate(Mat4<double>(1), k_pi<double> / 2, Vec3<double>(0, 0, 1)), Vec3<double>(3, 1, 1));
  const auto density = make_grid<double, double>(
      {2, 2, 2}, [](auto, auto, auto) { return 1; }, placement);
  const Fibers<double> medium(density, std::vector<Vec3<double>>(8, Vec3<double>(1, 0, 0)), 1, Rgb<double>(1), {});
  EXPECT_NEAR(medium.sigma_t({-0.5, 1.5, 0.5}, {0, 1, 0}).x, 0, 1e-12);
  EXPECT_NEAR(medium.sigma_t({-0.5, 1.5, 0.5}, {1, 0, 0}).x, 2, 1e-12);
}

/// Fibers of changing axes in half of the voxels; those of empty voxels are NaN.
template <std::floating_point S>
Fibers<S> tangle(S scale, std::uint32_t block = 8) {
  GridPlacement<S> placement;
  placement.copies = {2, 1, 1};
  const auto density = make_grid<S, S>({9, 10, 11}, rough_noise, placement);
  std::vector<Vec3<S>> axes;
  IndependentStream<S> stream(3, Stage::test, 0, 0);
  for (std::size_t i = 0; i < density.lattice().sample_count(); ++i) {
    const Vec3<S> w = warp::square_to_sphere(stream.next_2d());
    axes.push_back(density.sample(i) > S(0) ? w : Vec3<S>(std::numeric_limits<S>::quiet_NaN()));
  }
  return Fibers<S>(density, axes, scale, Rgb<S>(S(0.8)), {}, block);
}

// Planted bug seen to fail: no axes in empty voxels beside filled ones.
TEST(FiberMedium, EveryPointWithDensityHasAnAxisOfANeighbour) {
  const auto density = make_grid<double, double>(
      {3, 3, 3}, [](auto x, auto y, auto z) { return x == 1 && y == 1 && z == 1 ? 1.0 : 0.0; });
  std::vector<Vec3<double>> axes(27, Vec3<double>(std::nan("")));
  axes[13] = {1, 0, 0};
  const Fibers<double> medium(density, axes, 1, Rgb<double>(1), {});
  for (const double u : {0.05, 0.2, 0.3, 0.7, 0.95}) {
    const Vec3<double> x(u, 1 - u, 0.4);
    EXPECT_GT(density.eval(x), 0.0);
    EXPECT_EQ(medium.axis(x), Vec3<double>(1, 0, 0));
    EXPECT_NEAR(medium.sigma_t(x, {1, 0, 0}).x, 0, 1e-12);
  }
}

template <std::floating_point S>
void flights_are_unbiased(double slack) {
  std::uint64_t seed = 10;
  for (const std::uint32_t block : {2U, 8U, 100U}) {
    const Fibers<S> medium = tangle<S>(S(4), block);
    for (const Vec3<S>& w : {Vec3<S>(1, 0, 0), glm::normalize(Vec3<S>(1, S(0.3), S(-0.2)))}) {
      const Ray<S> ray{Vec3<S>(S(0.1), S(0.2), S(0.7)) - w, w};
      const double oracle = std::exp(-midpoint_thickness(medium, ray, 3.0, 100000));
      const FlightMoments flights = fly(medium, ray, S(3), 60000, ++seed);
      expect_mean(flights.through[0], oracle, "flights", slack);
      expect_mean(flights.all[0], 1, "all flights", slack);
      expect_mean(transmit(medium, ray, S(3), 60000, ++seed), oracle, "ratios", slack);
    }
  }
}
// The midpoint rule errs by a step at every change of axis: 3e-5 m at some 30 of them, to and fro.
TEST(FiberMedium, FlightsAreUnbiased) { flights_are_unbiased<double>(1e-4); }
// And a flight that ends within rounding of a change of axis is weighed by the caller with the other one.
TEST(FiberMedium, FlightsAreUnbiasedInFloat) { flights_are_unbiased<float>(3e-4); }

TEST(FiberMedium, AlongParallelFibersAllLightGetsThrough) {
  const auto density = make_grid<float, float>({4, 4, 4}, [](auto, auto, auto) { return 1; });
  const Fibers<float> medium(density, std::vector<Vec3<float>>(64, Vec3<float>(0, 0, -1)), 50, Rgb<float>(1), {});
  IndependentStream<float> stream(4, Stage::test, 0, 0);
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(medium.transmittance({{0.5F, 0.5F, -1}, {0, 0, 1}}, 5, stream), Rgb<float>(1));
    EXPECT_FALSE(medium.sample({{0.5F, 0.5F, -1}, {0, 0, 1}}, 5, stream).scattered);
  }
}

TEST(FiberMedium, WrongInputIsNamed) {
  const auto density = make_grid<double, double>({2, 2, 2}, [](auto x, auto, auto) { return x; });
  const auto message = [&](std::vector<Vec3<double>> axes, double scale = 1, std::size_t count = 8) -> std::string {
    try {
      axes.resize(count, Vec3<double>(1, 0, 0));
      static_cast<void>(Fibers<double>(density, axes, scale, Rgb<double>(1), {}));
    } catch (const ParameterError& error) {
      return error.what();
    }
    return "none";
  };
  using testing::HasSubstr;
  const Vec3<double> nan(std::nan(""));
  EXPECT_EQ(message({nan}), "none") << "empty there";
  EXPECT_THAT(message({nan, nan}), HasSubstr("fiber axis 1 is (nan, nan, nan), allowed: finite and not 0 where"));
  EXPECT_THAT(message({nan, Vec3<double>(0)}), HasSubstr("fiber axis 1 is (0"));
  EXPECT_THAT(message({}, 1, 7), HasSubstr("number of fiber axes is 7, allowed: the number of density values, 8"));
  EXPECT_THAT(message({}, -3), HasSubstr("fiber density scale is -3"));
  EXPECT_THAT(message({}, 1e7), HasSubstr("largest optical thickness of the fibers"));
}

}  // namespace
}  // namespace manylight::test::fiber_medium_test
