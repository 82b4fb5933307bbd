// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "manylight/geometry/shapes.hpp"
#include "scene_file/error.hpp"

/// Mesh files, each read as one mesh in its own frame. `flips_v`: v becomes 1 - v. Polygons become fans of triangles.
/// All throw SceneFileError naming the file and, where there is one, the line or element; what they return is
/// `validate`d by nobody yet.
///
/// OBJ and PLY have readers of their own: assimp 5.2 aborts the whole program on some damaged PLY files and names no
/// line of a bad OBJ index.
namespace manylight::scene_file {

[[nodiscard]] TriangleMesh<float> read_obj(const std::filesystem::path& path, bool flips_v);
[[nodiscard]] TriangleMesh<float> read_ply(const std::filesystem::path& path, bool flips_v);
/// All meshes of the file's scene, moved by its nodes. Through assimp.
[[nodiscard]] TriangleMesh<float> read_gltf(const std::filesystem::path& path, bool flips_v);
/// Mesh number `index` of a Mitsuba .serialized file, version 3 or 4.
[[nodiscard]] TriangleMesh<float> read_serialized(const std::filesystem::path& path, int index);

/// The whole file. Throws SceneFileError.
[[nodiscard]] std::string read_file_bytes(const std::filesystem::path& path);

}  // namespace manylight::scene_file
