// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "manylight/core/box.hpp"
#include "manylight/core/error.hpp"
#include "manylight/core/frame.hpp"
#include "manylight/core/sampler.hpp"
#include "manylight/core/spectrum.hpp"
#include "manylight/core/warp.hpp"

namespace manylight::basics_test {
namespace {

template <class S>
class Basics : public ::testing::Test {
 protected:
  static constexpr S k_rounding = S(8) * std::numeric_limits<S>::epsilon();  // about eight roundings of numbers near 1
};
using Scalars = ::testing::Types<float, double>;
TYPED_TEST_SUITE(Basics, Scalars);

template <class S>
void expect_orthonormal(const Frame<S>& f, S tolerance) {
  EXPECT_NEAR(glm::dot(f.s, f.s), S(1), tolerance);
  EXPECT_NEAR(glm::dot(f.t, f.t), S(1), tolerance);
  EXPECT_NEAR(glm::dot(f.s, f.t), S(0), tolerance);
  EXPECT_NEAR(glm::dot(f.s, f.n), S(0), tolerance);
  EXPECT_NEAR(glm::dot(f.t, f.n), S(0), tolerance);
  EXPECT_NEAR(glm::length(glm::cross(f.s, f.t) - f.n), S(0), tolerance) << "left-handed";
}

// Planted bug seen: std::copysign replaced by 1 (fails at n = -z).
TYPED_TEST(Basics, FrameIsRightHandedAndOrthonormalForEveryNormal) {
  using S = TypeParam;
  IndependentStream<S> stream(1, Stage::test, 0, 0);
  for (int i = 0; i < 1000; ++i) {
    const Vec3<S> n = glm::normalize(warp::square_to_sphere(stream.next_2d()));
    expect_orthonormal(Frame<S>(n), this->k_rounding);
    const Vec3<S> w = warp::square_to_sphere(stream.next_2d());
    const Frame<S> frame(n);
    EXPECT_NEAR(glm::length(frame.to_world(frame.to_local(w)) - w), S(0), this->k_rounding);
    EXPECT_NEAR(frame.to_local(w).z, glm::dot(w, n), this->k_rounding);
  }
  for (const Vec3<S>& n : {Vec3<S>(0, 0, 1), Vec3<S>(0, 0, -1), Vec3<S>(1, 0, 0), Vec3<S>(0, -1, 0),
                           glm::normalize(Vec3<S>(S(1e-6), 0, -1)), Vec3<S>(1, 0, -S(0))}) {
    expect_orthonormal(Frame<S>(n), this->k_rounding);
  }
}

// Planted bug seen: cross(s, n) for t.
TYPED_TEST(Basics, FrameFollowsATangentOfAnyLength) {
  using S = TypeParam;
  const Vec3<S> n = glm::normalize(Vec3<S>(1, 2, 3));
  for (const S length : {S(1e-4), S(1), S(1e4)}) {
    const Vec3<S> tangent = Vec3<S>(3, 0, 1) * length;
    const Frame<S> frame(n, tangent);
    expect_orthonormal(frame, this->k_rounding);
    EXPECT_GT(glm::dot(frame.s, tangent), S(0));
    EXPECT_NEAR(glm::dot(frame.t, tangent) / length, S(0), this->k_rounding * S(4));  // |tangent| / length is near 3
  }
}

TYPED_TEST(Basics, FrameSurvivesUselessTangents) {
  using S = TypeParam;
  const Vec3<S> n = glm::normalize(Vec3<S>(1, 2, 3));
  const S nan = std::numeric_limits<S>::quiet_NaN();
  for (const Vec3<S>& tangent : {Vec3<S>(0), n, -n * S(5), Vec3<S>(nan)}) {
    expect_orthonormal(Frame<S>(n, tangent), this->k_rounding);
  }
}

TYPED_TEST(Basics, BoxGrowsFromEmpty) {
  using S = TypeParam;
  Box<S> box;
  EXPECT_TRUE(box.is_empty());
  EXPECT_EQ(box.extent(), Vec3<S>(0));
  EXPECT_EQ(box.half_area(), S(0));
  EXPECT_FALSE(box.contains(Vec3<S>(0)));
  box.extend(Vec3<S>(1, 2, 3));
  EXPECT_FALSE(box.is_empty());
  EXPECT_EQ(box.diagonal(), S(0));
  box.extend(Vec3<S>(2, 4, 6));
  EXPECT_EQ(box.center(), Vec3<S>(S(1.5), 3, S(4.5)));
  EXPECT_EQ(box.half_area(), S(1 * 2 + 2 * 3 + 3 * 1));
  EXPECT_TRUE(box.contains(Vec3<S>(1, 4, 5)));
  EXPECT_FALSE(box.contains(Vec3<S>(0, 3, 5)));
  Box<S> same = box;
  same.extend(Box<S>{});
  EXPECT_EQ(same.lo, box.lo);
  EXPECT_EQ(same.hi, box.hi);
}

TYPED_TEST(Basics, SpectrumKnowsWhiteAndRejectsWhatAFilmMustNotHold) {
  using S = TypeParam;
  EXPECT_NEAR(luminance(Rgb<S>(1)), S(1), this->k_rounding);
  EXPECT_GT(luminance(Rgb<S>(0, 1, 0)), luminance(Rgb<S>(1, 0, 0)));
  EXPECT_GT(luminance(Rgb<S>(1, 0, 0)), luminance(Rgb<S>(0, 0, 1)));
  EXPECT_EQ(max_channel(Rgb<S>(1, 3, 2)), S(3));
  EXPECT_TRUE(is_black(Rgb<S>(0)));
  EXPECT_FALSE(is_black(Rgb<S>(0, 0, S(1e-30))));
  EXPECT_TRUE(is_valid_radiance(Rgb<S>(0, 1, 2)));
  EXPECT_FALSE(is_valid_radiance(Rgb<S>(0, S(-1e-9), 2)));
  EXPECT_FALSE(is_valid_radiance(Rgb<S>(0, std::numeric_limits<S>::quiet_NaN(), 2)));
  EXPECT_FALSE(is_valid_radiance(Rgb<S>(k_infinity<S>, 1, 2)));
}

TYPED_TEST(Basics, SafeSqrtMapsRoundingBelowZeroToZero) {
  using S = TypeParam;
  EXPECT_EQ(safe_sqrt(S(-1e-9)), S(0));
  EXPECT_EQ(safe_sqrt(S(4)), S(2));
  EXPECT_EQ(safe_sqrt(std::numeric_limits<S>::quiet_NaN()), S(0));
}

TEST(Errors, NameElementValueAndRangeInOneLine) {
  try {
    require(false, "lens radius", -0.5, "0 or positive");
    FAIL() << "nothing thrown";
  } catch (const ParameterError& error) {
    EXPECT_EQ(std::string(error.what()), "lens radius is -0.5, allowed: 0 or positive");
  }
  EXPECT_NO_THROW(require(true, "lens radius", 1, "0 or positive"));
  EXPECT_THROW(throw GeometryError("mesh"), Error);
  EXPECT_THROW(throw SceneError("scene"), Error);
}

}  // namespace
}  // namespace manylight::basics_test
