// SPDX-License-Identifier: Apache-2.0
// glTF through assimp.
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#include <fstream>
#include <glm/mat4x4.hpp>
#include <iterator>

#include "manylight/geometry/transform.hpp"
#include "scene_file/mesh_files.hpp"

namespace manylight::scene_file {

namespace {

[[noreturn]] void fail_file(const std::filesystem::path& path, const std::string& reason) {
  throw SceneFileError(path.string(), 0, "", reason);
}

Vec3<float> to_vec(const aiVector3D& v) { return {v.x, v.y, v.z}; }

glm::mat4 to_mat(const aiMatrix4x4& m) {
  return {m.a1, m.b1, m.c1, m.d1, m.a2, m.b2, m.c2, m.d2, m.a3, m.b3, m.c3, m.d3, m.a4, m.b4, m.c4, m.d4};
}

TriangleMesh<float> convert(const std::filesystem::path& path, const aiMesh& source, bool flips_v) {
  TriangleMesh<float> mesh;
  for (unsigned i = 0; i < source.mNumVertices; ++i) {
    mesh.positions.push_back(to_vec(source.mVertices[i]));
    if (source.HasNormals()) mesh.normals.push_back(to_vec(source.mNormals[i]));
    if (source.HasTextureCoords(0)) {
      const aiVector3D& uv = source.mTextureCoords[0][i];
      mesh.uvs.emplace_back(uv.x, flips_v ? 1.0F - uv.y : uv.y);
    }
  }
  for (unsigned f = 0; f < source.mNumFaces; ++f) {
    const aiFace& face = source.mFaces[f];
    if (face.mNumIndices < 3) continue;  // points and lines
    for (unsigned i = 0; i < 3; ++i) {
      if (face.mIndices[i] >= source.mNumVertices) {
        fail_file(path, "face " + std::to_string(f) + " has vertex index " + std::to_string(face.mIndices[i]) +
                            ", allowed: below " + std::to_string(source.mNumVertices));
      }
    }
    mesh.triangles.push_back({face.mIndices[0], face.mIndices[1], face.mIndices[2]});
  }
  return mesh;
}

void append(TriangleMesh<float>& target, TriangleMesh<float> part) {
  const auto offset = static_cast<std::uint32_t>(target.positions.size());
  // Attributes that only some parts have are dropped: half a set is of no use.
  const bool keeps_normals = offset == 0 || !target.normals.empty();
  const bool keeps_uvs = offset == 0 || !target.uvs.empty();
  if (!keeps_normals || part.normals.empty()) target.normals.clear(), part.normals.clear();
  if (!keeps_uvs || part.uvs.empty()) target.uvs.clear(), part.uvs.clear();
  target.positions.insert(target.positions.end(), part.positions.begin(), part.positions.end());
  target.normals.insert(target.normals.end(), part.normals.begin(), part.normals.end());
  target.uvs.insert(target.uvs.end(), part.uvs.begin(), part.uvs.end());
  for (auto triangle : part.triangles) {
    for (std::uint32_t& index : triangle) index += offset;
    target.triangles.push_back(triangle);
  }
}

void collect(const std::filesystem::path& path, const aiScene& scene, const aiNode& node, const glm::mat4& parent,
             bool flips_v, TriangleMesh<float>& mesh) {
  const glm::mat4 to_world = parent * to_mat(node.mTransformation);
  for (unsigned i = 0; i < node.mNumMeshes; ++i) {
    TriangleMesh<float> part = convert(path, *scene.mMeshes[node.mMeshes[i]], flips_v);
    if (to_world != glm::mat4(1.0F)) part = transform(std::move(part), to_world);
    append(mesh, std::move(part));
  }
  for (unsigned i = 0; i < node.mNumChildren; ++i) collect(path, scene, *node.mChildren[i], to_world, flips_v, mesh);
}

}  // namespace

TriangleMesh<float> read_gltf(const std::filesystem::path& path, bool flips_v) {
  Assimp::Importer importer;
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  const aiScene* scene = importer.ReadFile(path.string(), aiProcess_Triangulate);
  if (scene == nullptr || scene->mRootNode == nullptr) {
    const std::string reason = importer.GetErrorString();
    fail_file(path, reason.empty() ? "cannot be read" : reason);
  }
  TriangleMesh<float> mesh;
  // assimp turns the v of glTF, which counts from the top, to count from the bottom.
  collect(path, *scene, *scene->mRootNode, glm::mat4(1.0F), flips_v, mesh);
  if (mesh.triangles.empty()) fail_file(path, "empty mesh: the file holds no triangles");
  return mesh;
}

std::string read_file_bytes(const std::filesystem::path& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) fail_file(path, "is a folder, not a mesh file");
  std::ifstream in(path, std::ios::binary);
  if (!in) fail_file(path, "no such file, or not readable");
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

}  // namespace manylight::scene_file
