// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <mutex>
#include <string>

namespace manylight::render {

/// Seconds since construction.
class Stopwatch {
 public:
  [[nodiscard]] double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// A line on standard error with the part done and the time left: redrawn on a terminal, a line per tenth elsewhere.
class ProgressLine {
 public:
  ProgressLine(std::string title, bool quiet);
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// Safe to call from several threads.
  void operator()(std::size_t done, std::size_t total) { update(static_cast<double>(done) / static_cast<double>(total)); }
  void update(double part);
  /// A line of its own.
  void note(const std::string& text);

 private:
  std::string title_;
  bool quiet_;
  bool is_terminal_;
  std::mutex mutex_;
  Stopwatch clock_;
  double last_drawn_ = -1;  ///< s on a terminal, part done elsewhere
  bool is_open_ = false;
};

}  // namespace manylight::render
