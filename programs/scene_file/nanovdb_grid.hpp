// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "scene_file/volume_grid.hpp"

namespace manylight::scene_file {

/// By its first bytes.
[[nodiscard]] inline bool is_nanovdb(std::string_view data) { return data.substr(0, 7) == "NanoVDB"; }

/// Most numbers that a grid of such a file may become, channels counted: 2^30, 4 GiB.
inline constexpr std::size_t k_largest_nanovdb_grid = std::size_t{1} << 30U;

/// Reads a grid of a NanoVDB file of `data`, that of the name, or else the only one, or the one called "density". It
/// becomes dense over the bounding box of its active values, with the values that NanoVDB itself reads there: those of
/// inactive voxels are mostly the background's.
///
/// Files of version 32, plain or ZIP-compressed; of float, double (rounded), Vec3f (3 channels) and the quantised Fp4,
/// Fp8, Fp16 and FpN. Throws SceneFileError of all others, and in builds without NanoVDB (MANYLIGHT_HAS_NANOVDB).
[[nodiscard]] VolumeGrid read_nanovdb_grid(const std::filesystem::path& path, const std::string& data,
                                           const std::optional<std::string>& gridname);

}  // namespace manylight::scene_file
