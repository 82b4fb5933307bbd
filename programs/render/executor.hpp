// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "manylight/core/executor.hpp"

namespace manylight::render {

/// The executor of all that the program renders: oneTBB where it is installed, else one thread. It hides the kind of task,
/// so that oneTBB is compiled once instead of per task and kind of scene; tasks are tiles or larger, a call each is nothing.
class ProgramExecutor {
 public:
  /// 0 threads: as many as the machine has.
  explicit ProgramExecutor(std::uint32_t threads);

  template <class Task>
  void for_each_index(std::size_t n, const Task& task) const {
    run(n, &task, [](const void* hidden, std::size_t i) { (*static_cast<const Task*>(hidden))(i); });
  }
  [[nodiscard]] std::size_t concurrency() const;

 private:
  struct Threads;

  void run(std::size_t n, const void* task, void (*call)(const void* task, std::size_t i)) const;

  std::shared_ptr<const Threads> threads_;
};

static_assert(Executor<ProgramExecutor>);

}  // namespace manylight::render
