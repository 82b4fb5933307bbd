// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <memory>
#include <string>

#include <sys/wait.h>

#include <gtest/gtest.h>

#include "programs/scratch.hpp"

namespace manylight::test {

/// A test with a folder of its own.
class ScratchTest : public ::testing::Test {
 protected:
  void SetUp() override { scratch_ = std::make_unique<Scratch>(); }
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    return scratch_->write(name, text);
  }
  [[nodiscard]] std::filesystem::path path(const std::string& name) const { return *scratch_ / name; }
  [[nodiscard]] std::size_t file_count() const {
    const std::filesystem::directory_iterator files(scratch_->folder());
    return static_cast<std::size_t>(std::distance(begin(files), end(files)));
  }

 private:
  std::unique_ptr<Scratch> scratch_;
};

/// A scene of one lit floor of material `bsdf`; `extra` goes inside <scene>.
inline std::string floor_scene(const std::string& extra = "", const std::string& bsdf = "<bsdf type=\"diffuse\"/>") {
  return "<scene version=\"3.0.0\">"
         "<integrator type=\"path\"><integer name=\"max_depth\" value=\"3\"/></integrator>"
         "<sensor type=\"perspective\"><float name=\"fov\" value=\"40\"/>"
         "<transform name=\"to_world\"><lookat origin=\"0,0,5\" target=\"0,0,0\" up=\"0,1,0\"/></transform>"
         "<film type=\"hdrfilm\"><integer name=\"width\" value=\"8\"/><integer name=\"height\" value=\"6\"/></film>"
         "</sensor>"
         "<shape type=\"rectangle\">" +
         bsdf + "</shape><emitter type=\"point\"><point name=\"position\" x=\"0\" y=\"0\" z=\"2\"/></emitter>" + extra +
         "</scene>";
}

/// What a program printed and how it ended.
struct ProgramRun {
  int exit_code = -1;
  std::string output;  ///< standard output and error
};

inline ProgramRun run_program(const std::string& command) {
  ProgramRun run;
  std::FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return run;
  std::array<char, 4096> buffer{};
  while (std::size_t n = std::fread(buffer.data(), 1, buffer.size(), pipe)) run.output.append(buffer.data(), n);
  const int status = pclose(pipe);
  run.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return run;
}

}  // namespace manylight::test
