// SPDX-License-Identifier: Apache-2.0
// 1000 configurations of 1000 directions and 20 ascents for every material and kind of bound.

#include "bounds/no_violation.hpp"
#include "manylight/bounds/analytic.hpp"

namespace manylight::falsify_slow_test {
namespace {

TEST(ThoroughFalsify, AutomaticBoundsInFloat) {
  test::expect_no_violation<float>(AutomaticBounds{}, "automatic", 1000, {});
}
TEST(ThoroughFalsify, AutomaticBoundsInDouble) {
  test::expect_no_violation<double>(AutomaticBounds{}, "automatic", 1000, {});
}
TEST(ThoroughFalsify, AnalyticBoundsInFloat) {
  test::expect_no_violation<float>(AnalyticBounds{}, "analytic", 1000, {});
}

}  // namespace
}  // namespace manylight::falsify_slow_test
