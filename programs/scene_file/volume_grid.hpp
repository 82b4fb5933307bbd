// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "manylight/core/box.hpp"
#include "scene_file/error.hpp"

namespace manylight::scene_file {

/// What a Mitsuba .vol file holds. Numbers are as stored, but for bytes, which become fractions of 255.
struct VolumeGrid {
  std::array<std::uint32_t, 3> size{};  ///< samples along x, y, z
  std::uint32_t channels = 1;           ///< 1: densities or the like; 3: colours or directions
  Box<float> box;                       ///< frame of the file
  std::vector<float> values;            ///< channels of a sample side by side, x varies fastest, then y; all finite

  [[nodiscard]] std::size_t sample_count() const noexcept { return std::size_t{size[0]} * size[1] * size[2]; }
};

/// Reads version 3 of Mitsuba's grid volumes: "VOL", the version, then little-endian a type (1: float32, 2: float16,
/// 3: unsigned bytes), three sizes, the number of channels (1 or 3), a bounding box of six floats, and the samples, the
/// first of each axis on the box's face. Throws SceneFileError naming the file, the field, its value and what is
/// allowed. Values of any sign pass: what they mean is known to the medium that they are for.
[[nodiscard]] VolumeGrid read_volume_grid(const std::filesystem::path& path);

}  // namespace manylight::scene_file
