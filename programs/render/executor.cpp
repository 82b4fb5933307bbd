// SPDX-License-Identifier: Apache-2.0
#include "render/executor.hpp"

#ifdef MANYLIGHT_HAS_TBB
#include "manylight/core/tbb_executor.hpp"
#endif

namespace manylight::render {

struct ProgramExecutor::Threads {
#ifdef MANYLIGHT_HAS_TBB
  explicit Threads(std::uint32_t threads) : executor(threads) {}
  TbbExecutor executor;
#else
  explicit Threads(std::uint32_t /*threads*/) {}
  SerialExecutor executor;
#endif
};

ProgramExecutor::ProgramExecutor(std::uint32_t threads) : threads_(std::make_shared<const Threads>(threads)) {}

std::size_t ProgramExecutor::concurrency() const { return threads_->executor.concurrency(); }

void ProgramExecutor::run(std::size_t n, const void* task, void (*call)(const void*, std::size_t)) const {
  threads_->executor.for_each_index(n, [=](std::size_t i) { call(task, i); });
}

}  // namespace manylight::render
