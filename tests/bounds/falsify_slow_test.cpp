// SPDX-License-Identifier: Apache-2.0
// 1000 configurations of 1000 directions and 20 ascents for every material and kind of bound.

#include "bounds/no_violation.hpp"
#include "manylight/bounds/analytic.hpp"

namespace manylight {
namespace {

template <class S>
class ThoroughFalsify : public ::testing::Test {};
using Scalars = ::testing::Types<float, double>;
TYPED_TEST_SUITE(ThoroughFalsify, Scalars);

TYPED_TEST(ThoroughFalsify, AutomaticBounds) {
  test::expect_no_violation<TypeParam>(AutomaticBounds{}, "automatic", 1000, {});
}
TYPED_TEST(ThoroughFalsify, AnalyticBounds) {
  test::expect_no_violation<TypeParam>(AnalyticBounds{}, "analytic", 1000, {});
}

}  // namespace
}  // namespace manylight
