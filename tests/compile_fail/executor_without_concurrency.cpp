// SPDX-License-Identifier: Apache-2.0
// expect: Executor
// expect: concurrency
#include "manylight/core/executor.hpp"

struct Pool {
  template <class Task>
  void for_each_index(std::size_t n, const Task& task) const {
    for (std::size_t i = 0; i < n; ++i) task(i);
  }
#ifdef MANYLIGHT_CORRECT
  std::size_t concurrency() const noexcept { return 1; }
#endif
};

void render(const manylight::Executor auto&) {}

int main() { render(Pool{}); }
