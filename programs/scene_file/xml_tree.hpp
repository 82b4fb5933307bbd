// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "scene_file/error.hpp"

/// The scene file as a tree of elements, with includes spliced in and $parameters replaced.
namespace manylight::scene_file {

struct Element {
  std::string tag;  ///< lower case without underscores: "lookat" for both lookAt and look_at
  std::map<std::string, std::string, std::less<>> attributes;
  std::vector<std::unique_ptr<Element>> children;
  std::shared_ptr<const std::string> file;
  int line = 0;

  /// Value of an attribute, or the empty string.
  [[nodiscard]] const std::string& get(std::string_view attribute) const;
  [[nodiscard]] bool has(std::string_view attribute) const { return attributes.find(attribute) != attributes.end(); }
  /// "<bsdf type=\"diffuse\" id=\"wall\">", for messages.
  [[nodiscard]] std::string describe() const;
};

/// Throws SceneFileError naming the element's file and line.
[[noreturn]] void fail(const Element& element, std::string_view reason);

struct Document {
  Element root;
  int major_version = 3;  ///< of the file format: 0 for 0.4 to 0.6, 2 and 3 for the later ones
  std::vector<std::filesystem::path> search_paths;  ///< folder of the scene file, then those of its <path> elements

  /// The first search path that holds `name`; throws at `element` if none does.
  [[nodiscard]] std::filesystem::path resolve(const Element& element, const std::string& name) const;
};

using Definitions = std::map<std::string, std::string, std::less<>>;

/// Reads a file with all that it includes. `definitions` win over the file's <default> elements; one that no element
/// uses is an error. Throws SceneFileError.
[[nodiscard]] Document read_document(const std::filesystem::path& path, const Definitions& definitions);

/// "toWorld" and "to_world" -> "to_world".
[[nodiscard]] std::string snake_case(std::string_view name);

/// "a, b and c"
[[nodiscard]] std::string listed(const std::vector<std::string>& names);

}  // namespace manylight::scene_file
