// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "manylight/core/box.hpp"
#include "manylight/geometry/transform.hpp"
#include "scene_file/error.hpp"

namespace manylight::scene_file {

/// What a file of grid samples holds. Numbers are as stored, but for bytes, which become fractions of 255.
struct VolumeGrid {
  static constexpr std::int32_t k_largest_side = 1 << 16;  ///< samples along an axis, of either format

  std::array<std::uint32_t, 3> size{};  ///< samples along x, y, z
  std::uint32_t channels = 1;           ///< 1: densities or the like; 3: colours or directions
  Box<float> box;                       ///< of a .vol file: what it fills, in the frame of the file
  /// Of an .nvdb file, instead of the box: sample (i, j, k) lies where this affine map takes (i, j, k), in the frame
  /// of the file.
  std::optional<Mat4<double>> from_samples;
  std::vector<float> values;  ///< channels of a sample side by side, x varies fastest, then y; all finite

  [[nodiscard]] std::size_t sample_count() const noexcept { return std::size_t{size[0]} * size[1] * size[2]; }
};

/// Reads one of two formats, told apart by the first bytes of the file.
///
/// Version 3 of Mitsuba's grid volumes: "VOL", the version, then little-endian a type (1: float32, 2: float16,
/// 3: unsigned bytes), three sizes, the number of channels (1 or 3), a bounding box of six floats, and the samples, the
/// first of each axis on the box's face.
///
/// NanoVDB, as `read_nanovdb_grid` says; `gridname` chooses one of the grids of such a file.
///
/// Throws SceneFileError naming the file, the field, its value and what is allowed. Values of any sign pass: what they
/// mean is known to the medium that they are for.
[[nodiscard]] VolumeGrid read_volume_grid(const std::filesystem::path& path,
                                          const std::optional<std::string>& gridname = std::nullopt);

}  // namespace manylight::scene_file
