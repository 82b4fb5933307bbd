// SPDX-License-Identifier: Apache-2.0
#pragma once

/// Ctrl-C and what schedulers send (SIGINT, SIGTERM): the first asks for what there is so far, the second ends at once.
namespace manylight::render {

/// Exit code of a program ended by Ctrl-C, to a shell.
inline constexpr int k_exit_interrupted = 130;

/// From now on the first signal only sets a flag, and the second ends the program with k_exit_interrupted, though not
/// in the middle of a WritingFile. A signal ignored at the start of the program, as by nohup, stays ignored.
void catch_stop_signals();

[[nodiscard]] bool stop_requested() noexcept;

/// While one is alive a second signal waits: a file is written as a whole or not at all, and no temporary one is left.
class WritingFile {
 public:
  WritingFile() noexcept;
  ~WritingFile();
  WritingFile(const WritingFile&) = delete;
  WritingFile& operator=(const WritingFile&) = delete;
};

}  // namespace manylight::render
