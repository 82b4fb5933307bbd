// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <sstream>
#include <string>

#include "scene_file/error.hpp"

namespace manylight::scene_file {

/// Throws the SceneFileError "<path>: <field>: is <value>, allowed: <allowed>" of a field of a binary file.
template <class Value>
[[noreturn]] void fail_field(const std::filesystem::path& path, const std::string& field, const Value& value,
                             const std::string& allowed) {
  std::ostringstream reason;
  reason << "is " << value << ", allowed: " << allowed;
  throw SceneFileError(path.string(), 0, field, reason.str());
}

}  // namespace manylight::scene_file
