// SPDX-License-Identifier: Apache-2.0
// Every bound of every material of the toolkit, searched for values above it: 1000 configurations of 1000 directions
// and 20 ascents each (in the slow test; a tenth here). And that the search finds bounds that are 1 % too low.
// Deterministic.

#include "manylight/bounds/falsify.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "bounds/no_violation.hpp"
#include "manylight/bounds/analytic.hpp"

namespace manylight::falsify_test {
namespace {

/// A bound 1 % too low.
template <class B>
struct Lowered {
  B base{};
  template <class M, class Wi, class Wo>
  PatternSup<typename M::Scalar> sup(const M& m, const Wi& wi, const Wo& wo) const {
    const auto s = base.sup(m, wi, wo);
    return {s.eval * typename M::Scalar(0.99), s.eval_cos * typename M::Scalar(0.99)};
  }
};

// Planted bug seen to fail: no ascents.
TEST(Falsify, FindsTheMaximumOfAKnownPattern) {
  // cos(angle to a direction inside the cone)^50: maximum 1 there, which samples alone miss by some percent.
  const Vec3<double> peak = glm::normalize(Vec3<double>(0.3, 0.1, 1));
  const DirectionSet<double> set(Vec3<double>(0, 0, 1), 1.0);
  const auto value = [&](const Vec3<double>& w) { return std::pow(std::max(0.0, glm::dot(w, peak)), 5000.0); };
  const auto found = falsify(set, 1.0, value);
  EXPECT_FALSE(found.is_refuted());
  EXPECT_LT(found.slack(), 1.001);
  EXPECT_GT(glm::dot(found.at, peak), 1 - 1e-6);
  EXPECT_TRUE(falsify(set, 0.999, value).is_refuted());
  FalsifySearch blind;
  blind.ascents = 0;
  EXPECT_GT(falsify(set, 1.0, value, blind).slack(), 1.001) << "the ascents matter here";
}

TEST(Falsify, RefutesByNaN) {
  const auto value = [](const Vec3<double>&) { return std::numeric_limits<double>::quiet_NaN(); };
  EXPECT_TRUE(falsify(DirectionSet<double>(Vec3<double>(0, 0, 1), 0.1), 1.0, value).is_refuted());
}

// The thorough search is in falsify_slow_test.cpp.
TEST(Falsify, NoBoundOfTheToolkitIsRefuted) {
  FalsifySearch search;
  search.samples = 200;
  search.ascents = 4;
  test::expect_no_violation<float>(AutomaticBounds{}, "automatic", 20, search);
  test::expect_no_violation<double>(AutomaticBounds{}, "automatic", 20, search);
  test::expect_no_violation<float>(AnalyticBounds{}, "analytic", 20, search);
}

// In sets so narrow that a right bound is within 1 % of the maximum, one lowered by 1 % is refuted for every material.
TEST(Falsify, ABoundLoweredByOnePercentIsRefuted) {
  FalsifySearch search;
  search.samples = 100;
  search.ascents = 2;
  test::for_each_material<double>([&](const char* name, const auto& material) {
    EXPECT_GT(falsify_bounds(material, Lowered<AutomaticBounds>{}, 60, search, 1e-5).refuted, 0u) << name;
    EXPECT_GT(falsify_bounds(material, Lowered<AnalyticBounds>{}, 60, search, 1e-5).refuted, 0u) << name;
  });
}

}  // namespace
}  // namespace manylight::falsify_test
