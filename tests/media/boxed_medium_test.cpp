// SPDX-License-Identifier: Apache-2.0
// Oracle: the exponential law over the part of a ray that is in the box.
#include "manylight/media/boxed_medium.hpp"

#include <cmath>
#include <string>

#include <gtest/gtest.h>
#include <glm/gtc/matrix_transform.hpp>

#include "manylight/media/homogeneous.hpp"
#include "media/media_support.hpp"

namespace manylight::test::boxed_medium_test {
namespace {

template <std::floating_point S>
using Boxed = BoxedMedium<Homogeneous<PlainPhase<S>>>;
static_assert(Medium<Boxed<float>> && Medium<Boxed<double>> && Boxed<float>::k_closed_form);

/// Extinction (0.5, 1, 2) / m in a cube of 2 m, turned by 45 degrees about z, its centre at (3, 0, 0).
template <std::floating_point S>
Boxed<S> turned_cube() {
  const glm::dmat4 turned =
      glm::rotate(glm::translate(glm::dmat4(1), glm::dvec3(3, 0, 0)), k_pi<double> / 4, {0, 0, 1});
  const glm::dmat4 cube = glm::translate(glm::scale(turned, glm::dvec3(2)), glm::dvec3(-0.5));
  return {Homogeneous<PlainPhase<S>>(Rgb<S>(S(0.25)), Rgb<S>(S(0.25), S(0.75), S(1.75))), Mat4<S>(cube)};
}

/// Metres of a ray along x at height y that are inside: the diagonal, 2 sqrt(2), less twice the height.
double chord(double y) { return 2 * (std::sqrt(2.0) - std::abs(y)); }

/// Planted bug seen to fail: the inner flight's distance not shifted to where the ray enters.
template <std::floating_point S>
void flights_end_in_the_box(double tolerance) {
  const Boxed<S> medium = turned_cube<S>();
  IndependentStream<S> stream(3, Stage::test, 0, 0);
  for (const double y : {0.0, 0.5, -1.25}) {
    const Ray<S> ray{{0, S(y), 0}, {1, 0, 0}};
    const Rgb<S> through = medium.transmittance(ray, k_infinity<S>, stream);
    const FlightMoments moments = fly(medium, ray, S(100), 40000, 7);
    for (int c = 0; c < 3; ++c) {
      const double oracle = std::exp(-0.5 * std::pow(2.0, c) * chord(y));
      const std::string what = "y " + std::to_string(y) + " channel " + std::to_string(c);
      EXPECT_NEAR(static_cast<double>(through[c]), oracle, tolerance) << what;
      expect_mean(moments.all[static_cast<std::size_t>(c)], 1, what, tolerance);
      expect_mean(moments.through[static_cast<std::size_t>(c)], oracle, what, tolerance);
    }
    EXPECT_EQ(medium.mean_transmittance(ray, k_infinity<S>), through);
  }
}
TEST(BoxedMedium, FlightsEndInTheBox) { flights_end_in_the_box<double>(1e-12); }
TEST(BoxedMedium, FlightsEndInTheBoxInFloat) { flights_end_in_the_box<float>(2e-6); }  // chords in float

TEST(BoxedMedium, OutsideOfTheBoxIsVacuum) {
  const Boxed<double> medium = turned_cube<double>();
  IndependentStream<double> stream(4, Stage::test, 0, 0);
  const Vec3<double> x(1, 0, 0);
  EXPECT_EQ(medium.sigma_t({3, 0, 0}, x), Rgb<double>(0.5, 1, 2));
  EXPECT_EQ(medium.sigma_s({3, 0, 0}, x), Rgb<double>(0.25, 0.75, 1.75));
  EXPECT_EQ(medium.sigma_t({2, 0.9, 0}, x), Rgb<double>(0));  // in the bounding box, beyond the turned face
  EXPECT_EQ(medium.sigma_s({2, 0.9, 0}, x), Rgb<double>(0));
  EXPECT_EQ(medium.min_sigma_t(), 0);
  for (const Ray<double>& ray : {Ray<double>{{0, 2, 0}, {1, 0, 0}}, Ray<double>{{6, 0, 0}, {1, 0, 0}}}) {
    for (int i = 0; i < 100; ++i) {
      const auto s = medium.sample(ray, 50.0, stream);
      EXPECT_FALSE(s.scattered);
      EXPECT_EQ(s.weight, Rgb<double>(1));
      EXPECT_EQ(s.t, 50.0);
    }
    EXPECT_EQ(medium.transmittance(ray, 50.0, stream), Rgb<double>(1));
  }
  // From the middle, and an end before the box.
  EXPECT_NEAR(medium.transmittance({{3, 0, 0}, x}, k_infinity<double>, stream).x, std::exp(-0.5 * std::sqrt(2.0)),
              1e-12);
  EXPECT_EQ(medium.transmittance({{0, 0, 0}, x}, 1.0, stream), Rgb<double>(1));
}

TEST(BoxedMedium, WrongBoxesAreNamed) { EXPECT_THROW(Boxed<double>({}, Mat4<double>(0)), ParameterError); }

}  // namespace
}  // namespace manylight::test::boxed_medium_test
