// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstddef>

namespace manylight {

namespace detail {
struct AnyTask {
  void operator()(std::size_t) const {}
};
}  // namespace detail

/// Runs independent tasks. Contract: `for_each_index(n, task)` calls `task(i)` exactly once for each i in [0, n), in
/// any order, possibly at the same time, and returns when all are done; an exception thrown by a task is rethrown.
/// Results never depend on the executor: each task writes to its own place, reductions are made afterwards in
/// index order.
template <class E>
concept Executor = requires(const E& executor, std::size_t n, const detail::AnyTask& task) {
  executor.for_each_index(n, task);
  { executor.concurrency() } -> std::convertible_to<std::size_t>;
};

/// The model that needs nothing: one thread, in order.
struct SerialExecutor {
  template <class Task>
  void for_each_index(std::size_t n, const Task& task) const {
    for (std::size_t i = 0; i < n; ++i) task(i);
  }
  [[nodiscard]] std::size_t concurrency() const noexcept { return 1; }
};

static_assert(Executor<SerialExecutor>);

}  // namespace manylight
