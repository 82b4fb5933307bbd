// SPDX-License-Identifier: Apache-2.0
#include "render/stop.hpp"

#include <unistd.h>
#include <ctime>

#include <atomic>
#include <csignal>
#include <cstdint>

namespace manylight::render {

namespace {

enum Writing : int { idle, writing, ended };

// All that the handler touches: lock-free atomics.
std::atomic<bool> is_stop_requested{false};
std::atomic<bool> is_end_requested{false};
std::atomic<int> writer{idle};
std::atomic<std::int64_t> first_signal{0};  // ns, 0: none yet
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free &&
              std::atomic<std::int64_t>::is_always_lock_free);

[[nodiscard]] std::int64_t now() noexcept {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec;
}

extern "C" void on_stop_signal(int) {
  // One step, as another thread may be here with the second signal.
  std::int64_t first = 0;
  if (first_signal.compare_exchange_strong(first, now())) {
    is_stop_requested = true;
    return;
  }
  // timeout(1) signals its child and then the group that it belongs to: one request, not two.
  constexpr std::int64_t k_same_request = 50'000'000;
  if (now() - first < k_same_request) return;
  is_end_requested = true;
  int expected = idle;
  if (writer.compare_exchange_strong(expected, ended)) _exit(k_exit_interrupted);
}

}  // namespace

void catch_stop_signals() {
  for (const int signal : {SIGINT, SIGTERM}) {
    struct sigaction action {};
    if (sigaction(signal, nullptr, &action) != 0 || action.sa_handler == SIG_IGN) continue;
    action = {};
    action.sa_handler = on_stop_signal;
    action.sa_flags = SA_RESTART;
    sigemptyset(&action.sa_mask);
    sigaddset(&action.sa_mask, SIGINT);
    sigaddset(&action.sa_mask, SIGTERM);
    sigaction(signal, &action, nullptr);
  }
}

bool stop_requested() noexcept { return is_stop_requested; }

WritingFile::WritingFile() noexcept {
  int expected = idle;
  // Another thread is in the handler, about to end the program.
  if (!writer.compare_exchange_strong(expected, writing)) {
    for (;;) pause();
  }
}

// Either the handler finds `idle`, or its request is found here.
WritingFile::~WritingFile() {
  writer = idle;
  if (is_end_requested) _exit(k_exit_interrupted);
}

}  // namespace manylight::render
