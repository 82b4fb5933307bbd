// SPDX-License-Identifier: Apache-2.0
#include "render/progress.hpp"

#include <unistd.h>

#include <cstdio>

#include <fmt/core.h>

namespace manylight::render {

ProgressLine::ProgressLine(std::string title, bool quiet)
    : title_(std::move(title)), quiet_(quiet), is_terminal_(isatty(STDERR_FILENO) == 1) {}

ProgressLine::~ProgressLine() {
  if (is_open_) fmt::print(stderr, "\n");
}

void ProgressLine::update(double part) {
  if (quiet_) return;
  const std::lock_guard lock(mutex_);
  const double now = clock_.seconds();
  const double mark = is_terminal_ ? now : part;
  const bool is_due = mark - last_drawn_ >= 0.1 || last_drawn_ < 0 || part >= 1;
  if (!is_due) return;
  last_drawn_ = mark;
  const double left = part > 0 ? now * (1 - part) / part : 0;
  if (is_terminal_) {
    fmt::print(stderr, "\r{}: {:3.0f} %, {:.0f} s left   ", title_, 100 * part, left);
    is_open_ = true;
  } else {
    fmt::print(stderr, "{}: {:3.0f} %, {:.0f} s left\n", title_, 100 * part, left);
  }
  std::fflush(stderr);
}

void ProgressLine::note(const std::string& text) {
  if (quiet_) return;
  const std::lock_guard lock(mutex_);
  fmt::print(stderr, "{}{}\n", is_open_ ? "\n" : "", text);
  is_open_ = false;
}

}  // namespace manylight::render
