// SPDX-License-Identifier: Apache-2.0
// Mesh files: OBJ, PLY and glTF through assimp, and Mitsuba's .serialized.
#include <zlib.h>

#include <array>
#include <cstring>
#include <fstream>

#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <glm/mat4x4.hpp>

#include "manylight/geometry/transform.hpp"
#include "scene_file/context.hpp"

namespace manylight::scene_file {

namespace {

[[noreturn]] void fail_file(const std::filesystem::path& path, const std::string& reason) {
  throw SceneFileError(path.string(), 0, "", reason);
}

// ---- assimp ----------------------------------------------------------------------------------

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

// ---- .serialized -----------------------------------------------------------------------------

constexpr std::uint32_t k_has_normals = 0x0001;
constexpr std::uint32_t k_has_uvs = 0x0002;
constexpr std::uint32_t k_has_colors = 0x0008;
constexpr std::uint32_t k_double_precision = 0x2000;

/// Inflates the zlib stream that starts behind the four header bytes of a mesh, piece by piece.
class InflateReader {
 public:
  InflateReader(const std::filesystem::path& path, const std::vector<char>& data, std::size_t begin, std::size_t end)
      : path_(path) {
    // zlib's interface takes a pointer to non-const that it does not write through.
    stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(data.data() + begin));
    stream_.avail_in = static_cast<uInt>(end - begin);
    if (inflateInit(&stream_) != Z_OK) fail_file(path_, "cannot be inflated");
  }
  ~InflateReader() { inflateEnd(&stream_); }
  InflateReader(const InflateReader&) = delete;
  InflateReader& operator=(const InflateReader&) = delete;

  void read(void* target, std::size_t size) {
    auto* out = static_cast<Bytef*>(target);
    while (size > 0) {
      const auto piece = static_cast<uInt>(std::min<std::size_t>(size, 1U << 30U));
      stream_.next_out = out;
      stream_.avail_out = piece;
      const int code = inflate(&stream_, Z_SYNC_FLUSH);
      const std::size_t got = piece - stream_.avail_out;
      if ((code != Z_OK && code != Z_STREAM_END) || got == 0) fail_file(path_, "mesh data is truncated or damaged");
      out += got;
      size -= got;
    }
  }
  template <class T>
  [[nodiscard]] T value() {
    T result{};
    read(&result, sizeof(T));
    return result;
  }

 private:
  const std::filesystem::path& path_;
  z_stream stream_{};
};

template <class T>
T value_at(const std::filesystem::path& path, const std::vector<char>& data, std::size_t offset) {
  if (offset + sizeof(T) > data.size()) fail_file(path, "is truncated");
  T result;
  std::memcpy(&result, data.data() + offset, sizeof(T));
  return result;
}

std::vector<float> read_floats(InflateReader& in, std::size_t count, bool is_double) {
  std::vector<float> values;
  constexpr std::size_t k_chunk = 1U << 16U;  // grown piece by piece: a damaged count must not exhaust memory
  while (values.size() < count) {
    const std::size_t n = std::min(k_chunk, count - values.size());
    const std::size_t first = values.size();
    values.resize(first + n);
    if (is_double) {
      std::vector<double> wide(n);
      in.read(wide.data(), n * sizeof(double));
      for (std::size_t i = 0; i < n; ++i) values[first + i] = static_cast<float>(wide[i]);
    } else {
      in.read(values.data() + first, n * sizeof(float));
    }
  }
  return values;
}

std::vector<Vec3<float>> as_vectors(const std::vector<float>& values) {
  std::vector<Vec3<float>> result;
  for (std::size_t i = 0; i + 2 < values.size(); i += 3) result.emplace_back(values[i], values[i + 1], values[i + 2]);
  return result;
}

TriangleMesh<float> inflate_mesh(const std::filesystem::path& path, InflateReader& in, int version) {
  const auto flags = in.value<std::uint32_t>();
  if (version >= 4) {
    while (in.value<char>() != 0) {
    }  // the mesh's name
  }
  const auto vertex_count = in.value<std::uint64_t>();
  const auto triangle_count = in.value<std::uint64_t>();
  if (vertex_count > 0xFFFFFFFFU || triangle_count > 0xFFFFFFFFU) fail_file(path, "mesh data is damaged");
  const bool is_double = (flags & k_double_precision) != 0;
  TriangleMesh<float> mesh;
  mesh.positions = as_vectors(read_floats(in, 3 * vertex_count, is_double));
  if ((flags & k_has_normals) != 0) mesh.normals = as_vectors(read_floats(in, 3 * vertex_count, is_double));
  if ((flags & k_has_uvs) != 0) {
    const std::vector<float> uvs = read_floats(in, 2 * vertex_count, is_double);
    for (std::size_t i = 0; i + 1 < uvs.size(); i += 2) mesh.uvs.emplace_back(uvs[i], uvs[i + 1]);
  }
  if ((flags & k_has_colors) != 0) static_cast<void>(read_floats(in, 3 * vertex_count, is_double));
  for (std::uint64_t i = 0; i < triangle_count; ++i) {
    std::array<std::uint32_t, 3> triangle{};
    in.read(triangle.data(), sizeof(triangle));
    mesh.triangles.push_back(triangle);
  }
  return mesh;
}

}  // namespace

TriangleMesh<float> read_mesh(const Element& element, const std::filesystem::path& path, bool flips_v) {
  Assimp::Importer importer;
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  const aiScene* scene = importer.ReadFile(path.string(), aiProcess_Triangulate | aiProcess_JoinIdenticalVertices);
  if (scene == nullptr || scene->mRootNode == nullptr) {
    std::string reason = importer.GetErrorString();
    fail_file(path, reason.empty() ? "cannot be read" : reason);
  }
  TriangleMesh<float> mesh;
  collect(path, *scene, *scene->mRootNode, glm::mat4(1.0F), flips_v, mesh);
  if (mesh.triangles.empty()) fail(element, path.string() + " holds no triangles");
  return mesh;
}

TriangleMesh<float> read_serialized(const Element& element, const std::filesystem::path& path, int index) {
  std::ifstream in(path, std::ios::binary);
  const std::vector<char> data{std::istreambuf_iterator<char>(in), {}};
  if (!in.good() && !in.eof()) fail_file(path, "cannot be read");
  if (value_at<std::uint16_t>(path, data, 0) != 0x041C) fail_file(path, "is not a .serialized mesh file");
  const int version = value_at<std::uint16_t>(path, data, 2);
  if (version != 3 && version != 4) fail_file(path, "has version " + std::to_string(version) + ", supported are 3 and 4");
  const auto count = value_at<std::uint32_t>(path, data, data.size() - 4);
  const std::size_t width = version == 4 ? 8 : 4;
  if (count == 0 || count > data.size() / width) fail_file(path, "mesh table is damaged");
  if (index < 0 || static_cast<std::uint32_t>(index) >= count) {
    fail(element, "shape_index is " + std::to_string(index) + ", allowed: 0 to " + std::to_string(count - 1));
  }
  const std::size_t table = data.size() - 4 - count * width;
  const auto offset = [&](std::size_t i) -> std::size_t {
    if (i == count) return table;
    return version == 4 ? static_cast<std::size_t>(value_at<std::uint64_t>(path, data, table + i * width))
                        : value_at<std::uint32_t>(path, data, table + i * width);
  };
  const std::size_t begin = offset(static_cast<std::size_t>(index)) + 4;
  const std::size_t end = offset(static_cast<std::size_t>(index) + 1);
  if (begin >= end || end > data.size()) fail_file(path, "mesh table is damaged");
  InflateReader reader(path, data, begin, end);
  return inflate_mesh(path, reader, version);
}

}  // namespace manylight::scene_file
