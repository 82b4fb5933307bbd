// SPDX-License-Identifier: Apache-2.0
// A user's own Executor: plain threads and one shared counter. Results do not depend on it, bit for bit.
#include <atomic>
#include <cstdio>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "manylight/core/executor.hpp"
#include "manylight/core/sampler.hpp"
#include "manylight/core/warp.hpp"

class ThreadExecutor {
 public:
  explicit ThreadExecutor(std::size_t threads) : threads_(threads) {}

  template <class Task>
  void for_each_index(std::size_t n, const Task& task) const {
    std::atomic<std::size_t> next{0};
    std::exception_ptr error;
    std::mutex error_mutex;
    const auto work = [&] {
      try {
        for (std::size_t i = next++; i < n; i = next++) task(i);
      } catch (...) {
        const std::scoped_lock lock(error_mutex);
        if (!error) error = std::current_exception();
        next = n;  // nobody starts another task
      }
    };
    {
      std::vector<std::jthread> pool;
      for (std::size_t t = 1; t < threads_; ++t) pool.emplace_back(work);
      work();
    }  // joins
    if (error) std::rethrow_exception(error);
  }
  [[nodiscard]] std::size_t concurrency() const noexcept { return threads_; }

 private:
  std::size_t threads_;
};

static_assert(manylight::Executor<ThreadExecutor>);

/// Means of the cosine of cosine-weighted directions; each batch writes to its own place.
template <manylight::Executor E>
std::vector<double> batches(const E& executor) {
  const manylight::IndependentSampler<double> sampler{7};
  std::vector<double> means(1000);
  executor.for_each_index(means.size(), [&](std::size_t batch) {
    double sum = 0;
    for (std::uint32_t sample = 0; sample < 100; ++sample) {
      auto stream = sampler.stream(manylight::Stage::test, batch, sample);
      sum += manylight::warp::square_to_cosine_hemisphere(stream.next_2d()).z;
    }
    means[batch] = sum / 100;
  });
  return means;
}

int main() {
  const bool equal = batches(ThreadExecutor(7)) == batches(manylight::SerialExecutor{});
  std::printf("7 threads and 1 thread give %s results\n", equal ? "the same" : "different");

  bool caught = false;
  try {
    ThreadExecutor(2).for_each_index(10, [](std::size_t i) {
      if (i == 3) throw 3;
    });
  } catch (int i) {
    caught = i == 3;
  }
  std::printf("a task's exception %s its caller\n", caught ? "reaches" : "does not reach");
  return equal && caught ? 0 : 1;
}
