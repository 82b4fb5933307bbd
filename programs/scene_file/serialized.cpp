// SPDX-License-Identifier: Apache-2.0
// Mitsuba's .serialized: zlib streams, one per mesh, and a table of their places at the end.
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <vector>

#include "scene_file/mesh_files.hpp"

namespace manylight::scene_file {

namespace {

[[noreturn]] void fail_file(const std::filesystem::path& path, const std::string& reason) {
  throw SceneFileError(path.string(), 0, "", reason);
}

constexpr std::uint32_t k_has_normals = 0x0001;
constexpr std::uint32_t k_has_uvs = 0x0002;
constexpr std::uint32_t k_has_colors = 0x0008;
constexpr std::uint32_t k_face_normals = 0x0010;
constexpr std::uint32_t k_double_precision = 0x2000;

/// Inflates the zlib stream that starts behind the four header bytes of a mesh, piece by piece.
class InflateReader {
 public:
  InflateReader(const std::filesystem::path& path, const std::string& data, std::size_t begin, std::size_t end)
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
T value_at(const std::filesystem::path& path, const std::string& data, std::size_t offset) {
  if (data.size() < sizeof(T) || offset > data.size() - sizeof(T)) fail_file(path, "is truncated");
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
  if ((flags & k_face_normals) != 0) mesh.normals.clear();
  for (std::uint64_t i = 0; i < triangle_count; ++i) {
    std::array<std::uint32_t, 3> triangle{};
    in.read(triangle.data(), sizeof(triangle));
    mesh.triangles.push_back(triangle);
  }
  return mesh;
}

}  // namespace

TriangleMesh<float> read_serialized(const std::filesystem::path& path, int index) {
  const std::string data = read_file_bytes(path);
  if (value_at<std::uint16_t>(path, data, 0) != 0x041C) fail_file(path, "is not a .serialized mesh file");
  const int version = value_at<std::uint16_t>(path, data, 2);
  if (version != 3 && version != 4)
    fail_file(path, "has version " + std::to_string(version) + ", supported are 3 and 4");
  const auto count = value_at<std::uint32_t>(path, data, data.size() - 4);
  const std::size_t width = version == 4 ? 8 : 4;
  if (count == 0 || count > (data.size() - 4) / width) fail_file(path, "mesh table is damaged");
  if (index < 0 || static_cast<std::uint32_t>(index) >= count) {
    fail_file(path, "shape_index is " + std::to_string(index) + ", allowed: 0 to " + std::to_string(count - 1));
  }
  const std::size_t table = data.size() - 4 - count * width;
  const auto offset = [&](std::size_t i) -> std::size_t {
    if (i == count) return table;
    return version == 4 ? static_cast<std::size_t>(value_at<std::uint64_t>(path, data, table + i * width))
                        : value_at<std::uint32_t>(path, data, table + i * width);
  };
  const std::size_t header = offset(static_cast<std::size_t>(index));  // two numbers of 16 bits, then the zlib stream
  const std::size_t end = offset(static_cast<std::size_t>(index) + 1);
  if (end > table || header > end || end - header <= 4) fail_file(path, "mesh table is damaged");
  InflateReader reader(path, data, header + 4, end);
  return inflate_mesh(path, reader, version);
}

}  // namespace manylight::scene_file
