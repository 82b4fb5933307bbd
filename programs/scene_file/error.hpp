// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "manylight/core/error.hpp"

namespace manylight::scene_file {

/// Something wrong in a scene file, or in a file that it names. One line: file, line if known, element, reason.
class SceneFileError : public Error {
 public:
  SceneFileError(std::string_view file, int line, std::string_view element, std::string_view reason)
      : Error(message(file, line, element, reason)) {}

 private:
  static std::string message(std::string_view file, int line, std::string_view element, std::string_view reason) {
    std::string text(file);
    if (line > 0) text += ':' + std::to_string(line);
    text += ": ";
    if (!element.empty()) text += std::string(element) + ": ";
    text += reason;
    for (char& c : text) {
      if (static_cast<unsigned char>(c) < 0x20) c = ' ';  // what a file says must not break the one line
    }
    return text;
  }
};

}  // namespace manylight::scene_file
