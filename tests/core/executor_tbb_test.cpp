// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <vector>

#include "manylight/core/tbb_executor.hpp"

namespace manylight::executor_tbb_test {
namespace {

// Planted bug seen: the range started at 1.
TEST(TbbExecutor, CallsEveryIndexOnceForAnyNumberOfThreads) {
  for (const std::size_t threads : {0u, 1u, 2u, 7u}) {
    const TbbExecutor executor(threads);
    std::vector<std::atomic<int>> calls(10'000);
    executor.for_each_index(calls.size(), [&](std::size_t i) { calls[i].fetch_add(1); });
    for (const auto& n : calls) ASSERT_EQ(n.load(), 1) << threads << " threads";
  }
}

TEST(TbbExecutor, RunsNoMoreTasksAtOnceThanAskedFor) {
  for (const std::size_t threads : {1u, 2u}) {
    const TbbExecutor executor(threads);
    EXPECT_EQ(executor.concurrency(), threads);
    std::atomic<int> running = 0, most = 0;
    executor.for_each_index(2000, [&](std::size_t) {
      const int now = running.fetch_add(1) + 1;
      for (int seen = most.load(); now > seen && !most.compare_exchange_weak(seen, now);) {
      }
      running.fetch_sub(1);
    });
    EXPECT_LE(static_cast<std::size_t>(most.load()), threads);
  }
}

TEST(TbbExecutor, PassesExceptionsOn) {
  const TbbExecutor executor(2);
  const auto task = [](std::size_t i) {
    if (i == 300) throw std::runtime_error("three hundred");
  };
  EXPECT_THROW(executor.for_each_index(1000, task), std::runtime_error);
}

TEST(TbbExecutor, CallsNothingForNoWork) {
  std::atomic<int> calls = 0;
  TbbExecutor(2).for_each_index(0, [&](std::size_t) { calls.fetch_add(1); });
  EXPECT_EQ(calls.load(), 0);
}

// Nested use must neither deadlock nor lose tasks.
TEST(TbbExecutor, CanBeUsedInsideATask) {
  const TbbExecutor executor(2);
  std::atomic<int> calls = 0;
  executor.for_each_index(8,
                          [&](std::size_t) { executor.for_each_index(16, [&](std::size_t) { calls.fetch_add(1); }); });
  EXPECT_EQ(calls.load(), 128);
}

}  // namespace
}  // namespace manylight::executor_tbb_test
