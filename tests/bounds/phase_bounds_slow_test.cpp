// SPDX-License-Identifier: Apache-2.0
// As in phase_bounds_test.cpp, in both precisions and with five times the ascents.
#include <gtest/gtest.h>

#include "bounds/phase_no_violation.hpp"

namespace manylight::phase_bounds_slow_test {
namespace {

TEST(PhaseBoundsThorough, NoBoundIsRefuted) {
  test::expect_no_phase_violation<float>(1000, {1000, 20, 1});
  test::expect_no_phase_violation<double>(1000, {1000, 20, 2});
}

}  // namespace
}  // namespace manylight::phase_bounds_slow_test
