// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include <glm/mat4x4.hpp>

#include "manylight/geometry/shapes.hpp"

namespace manylight::scene_file {

/// A placement over time: between two key frames translation and scale are linear and the rotation turns evenly about one
/// axis; before the first and after the last it rests.
struct Keyframes {
  std::vector<std::pair<float, glm::mat4>> frames;  ///< by rising time, at least one; no shear

  [[nodiscard]] bool moves() const noexcept { return frames.size() > 1; }
  [[nodiscard]] glm::mat4 at(float time) const;
};

/// A shape that moves: in its own frame, before `to_world`.
struct ShapeMotion {
  std::uint32_t shape = 0;  ///< id
  std::variant<TriangleMesh<float>, Sphere<float>, Disk<float>> local;
  Keyframes to_world;
  /// The mesh as it is when the shutter closes, of the same triangles; at its opening it is `local`.
  std::optional<TriangleMesh<float>> closing;
};

}  // namespace manylight::scene_file
