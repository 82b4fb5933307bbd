// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "scene_file/error.hpp"
#include "scene_file/scene_description.hpp"

namespace manylight::scene_file {

struct LoadOptions {
  std::map<std::string, std::string> defines;  ///< values of $parameters; win over the file's <default> elements
  bool is_lenient = false;  ///< unknown materials become grey Lambertian ones, with a warning each
};

/// Loads a Mitsuba XML scene (versions 0.4 to 3.0, the subset of docs/program.md) with its meshes and textures. Throws
/// SceneFileError, image_io::ImageFileError or another manylight::Error: one line naming file, line and element.
[[nodiscard]] SceneDescription load_scene(const std::filesystem::path& path, const LoadOptions& options = {});

}  // namespace manylight::scene_file
