// SPDX-License-Identifier: Apache-2.0
#include "manylight/core/executor.hpp"

#include <gtest/gtest.h>

#include <stdexcept>
#include <vector>

namespace manylight::executor_test {
namespace {

TEST(SerialExecutor, CallsEveryIndexOnceInOrder) {
  std::vector<std::size_t> calls;
  SerialExecutor{}.for_each_index(5, [&](std::size_t i) { calls.push_back(i); });
  EXPECT_EQ(calls, (std::vector<std::size_t>{0, 1, 2, 3, 4}));
}

TEST(SerialExecutor, CallsNothingForNoWork) {
  SerialExecutor{}.for_each_index(0, [](std::size_t) { FAIL(); });
  EXPECT_EQ(SerialExecutor{}.concurrency(), 1u);
}

TEST(SerialExecutor, PassesExceptionsOn) {
  const auto task = [](std::size_t i) {
    if (i == 3) throw std::runtime_error("three");
  };
  EXPECT_THROW(SerialExecutor{}.for_each_index(5, task), std::runtime_error);
}

}  // namespace
}  // namespace manylight::executor_test
