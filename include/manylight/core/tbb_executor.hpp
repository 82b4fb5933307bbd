// SPDX-License-Identifier: Apache-2.0
#pragma once

// Bridge to oneTBB: include it only where oneTBB is installed and linked (`TBB::tbb`).

#include <cstddef>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "manylight/core/executor.hpp"

namespace manylight {

/// Executor on a oneTBB arena of `threads` threads (0: as many as the machine has).
class TbbExecutor {
 public:
  explicit TbbExecutor(std::size_t threads = 0)
      : arena_(threads == 0 ? tbb::task_arena::automatic : static_cast<int>(threads)) {}

  template <class Task>
  void for_each_index(std::size_t n, const Task& task) const {
    arena_.execute([&] {
      tbb::parallel_for(tbb::blocked_range<std::size_t>(0, n, 1), [&](const tbb::blocked_range<std::size_t>& range) {
        for (std::size_t i = range.begin(); i != range.end(); ++i) task(i);
      });
    });
  }
  [[nodiscard]] std::size_t concurrency() const { return static_cast<std::size_t>(arena_.max_concurrency()); }

 private:
  mutable tbb::task_arena arena_;
};

static_assert(Executor<TbbExecutor>);

}  // namespace manylight
