// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include <glm/mat3x3.hpp>

#include "manylight/media/grid_volume.hpp"
#include "scene_file/context.hpp"
#include "scene_file/volume_grid.hpp"

namespace manylight::scene_file {

/// What a medium takes a coefficient or a direction from: a grid, or one value for all places.
struct Volume {
  const Element* element = nullptr;  ///< where it stands, for messages
  const Element* value = nullptr;    ///< of a constant: the element that holds it
  std::optional<VolumeGrid> grid;
  GridPlacement<float> placement;  ///< of the grid; of a constant only to_world
  /// From the frame that directions of the file are in to that of the grid, where to_world takes them up.
  glm::dmat3 to_grid_frame{1.0};
};

/// A <volume>, or a plain property in its place. Throws SceneFileError.
[[nodiscard]] Volume parse_volume(Context& context, const Element& element);
/// The volume called `name`, if there is one.
[[nodiscard]] std::optional<Volume> take_volume(Context& context, Properties& properties, const char* name);

/// Of a constant. Throws SceneFileError.
[[nodiscard]] Rgb<float> constant_color(const Context& context, const Volume& volume);
/// Of a grid of one channel, not negative. Throws SceneFileError.
[[nodiscard]] GridVolume<float> density_grid(const Volume& volume);
/// Of a grid of one or three channels, each 0 to 1. Throws SceneFileError.
[[nodiscard]] GridVolume<float, Rgb<float>> albedo_grid(const Volume& volume);
/// Axes for each sample of `density`, in the frame of its grid: a grid of the same size and place, or one vector in
/// world coordinates. Throws SceneFileError.
[[nodiscard]] std::vector<Vec3<float>> fiber_axes(const Volume& axes, const Volume& density);

}  // namespace manylight::scene_file
