// SPDX-License-Identifier: Apache-2.0
// Wavefront OBJ: v, vt, vn and f; groups and materials are ignored.
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string_view>
#include <system_error>
#include <unordered_map>
#include <vector>

#include "scene_file/mesh_files.hpp"

namespace manylight::scene_file {

namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

/// Takes the next word off the front of `line`.
std::string_view next_word(std::string_view& line) {
  std::size_t begin = 0;
  while (begin < line.size() && is_blank(line[begin])) ++begin;
  std::size_t end = begin;
  while (end < line.size() && !is_blank(line[end])) ++end;
  const std::string_view word = line.substr(begin, end - begin);
  line.remove_prefix(end);
  return word;
}

/// Indices of one corner into positions, texture coordinates and normals; -1: none.
using Corner = std::array<std::int64_t, 3>;

struct CornerHash {
  std::size_t operator()(const Corner& corner) const noexcept {
    std::uint64_t hash = 0;
    for (const std::int64_t index : corner) {
      hash = (hash ^ static_cast<std::uint64_t>(index)) * 0x9E3779B97F4A7C15ULL;
      hash ^= hash >> 29U;
    }
    return static_cast<std::size_t>(hash);
  }
};

class ObjReader {
 public:
  ObjReader(const std::filesystem::path& path, bool flips_v) : path_(path), flips_v_(flips_v) {}

  TriangleMesh<float> read(const std::string& text) {
    for (std::size_t begin = 0; begin < text.size();) {
      ++line_;
      const std::size_t end = std::min(text.find('\n', begin), text.size());
      read_line(std::string_view(text).substr(begin, end - begin));
      begin = end + 1;
    }
    if (mesh_.triangles.empty()) throw SceneFileError(path_.string(), 0, "", "empty mesh: the file holds no faces");
    if (uvs_.empty()) mesh_.uvs.clear();
    if (normals_.empty()) mesh_.normals.clear();
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void fail_line(std::string_view element, const std::string& reason) const {
    throw SceneFileError(path_.string(), line_, element, reason);
  }

  void read_line(std::string_view line) {
    if (!line.empty() && line.back() == '\\') fail_line("", "lines continued by '\\' are not supported");
    line = line.substr(0, line.find('#'));
    const std::string_view keyword = next_word(line);
    if (keyword == "v") {
      positions_.push_back({number("v", line), number("v", line), number("v", line)});
    } else if (keyword == "vn") {
      normals_.push_back({number("vn", line), number("vn", line), number("vn", line)});
    } else if (keyword == "vt") {
      const float u = number("vt", line);
      const float v = number("vt", line);
      uvs_.push_back({u, flips_v_ ? 1.0F - v : v});
    } else if (keyword == "f") {
      read_face(line);
    }
  }

  [[nodiscard]] float number(std::string_view keyword, std::string_view& line) const {
    const std::string_view word = next_word(line);
    const std::size_t sign = !word.empty() && word.front() == '+' ? 1 : 0;  // from_chars takes no plus
    float value = 0;
    const auto [end, code] = std::from_chars(word.data() + sign, word.data() + word.size(), value);
    const bool is_tiny = code == std::errc::result_out_of_range && word.find("e-") != std::string_view::npos;
    if (is_tiny) return 0.0F;
    if (code != std::errc() || end != word.data() + word.size() || !std::isfinite(value)) {
      fail_line(keyword, "'" + std::string(word) + "' is not a finite number");
    }
    return value;
  }

  void read_face(std::string_view line) {
    std::array<std::uint32_t, 3> triangle{};
    std::size_t corners = 0;
    for (std::string_view word = next_word(line); !word.empty(); word = next_word(line)) {
      const std::uint32_t vertex = vertex_of(parse_corner(word));
      if (corners > 2) triangle[1] = triangle[2];
      triangle[std::min<std::size_t>(corners, 2)] = vertex;
      if (++corners > 2) mesh_.triangles.push_back(triangle);
    }
    if (corners < 3) fail_line("f", "a face needs at least 3 vertices, this one has " + std::to_string(corners));
  }

  /// "7", "7/2", "7//3" or "7/2/3", counted from 1, or from the end if negative.
  [[nodiscard]] Corner parse_corner(std::string_view word) const {
    const std::array<std::size_t, 3> counts{positions_.size(), uvs_.size(), normals_.size()};
    constexpr std::array<std::string_view, 3> k_names{"vertex", "texture coordinate", "normal"};
    Corner corner{-1, -1, -1};
    std::string_view rest = word;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t slash = rest.find('/');
      const std::string_view part = rest.substr(0, slash);
      if (!part.empty()) corner[i] = parse_index(part, counts[i], k_names[i]);
      if (slash == std::string_view::npos) break;
      if (i == 2) fail_line("f", "'" + std::string(word) + "' is not a corner of a face");
      rest.remove_prefix(slash + 1);
    }
    if (corner[0] < 0) fail_line("f", "'" + std::string(word) + "' has no vertex index");
    return corner;
  }

  [[nodiscard]] std::int64_t parse_index(std::string_view part, std::size_t count, std::string_view name) const {
    std::int64_t index = 0;
    const auto [end, code] = std::from_chars(part.data(), part.data() + part.size(), index);
    const auto signed_count = static_cast<std::int64_t>(count);
    const std::int64_t from_zero = index < 0 ? index + signed_count : index - 1;
    const bool is_number = code == std::errc() && end == part.data() + part.size();
    if (!is_number || from_zero < 0 || from_zero >= signed_count) {
      fail_line("f", std::string(name) + " index is " + std::string(part) + ", allowed: 1 to " + std::to_string(count));
    }
    return from_zero;
  }

  /// Corners with the same three indices share a vertex.
  std::uint32_t vertex_of(const Corner& corner) {
    const auto next = static_cast<std::uint32_t>(mesh_.positions.size());
    const auto [found, is_new] = vertices_.emplace(corner, next);
    if (!is_new) return found->second;
    const auto at = [](std::int64_t index) { return static_cast<std::size_t>(index); };
    mesh_.positions.push_back(positions_[at(corner[0])]);
    mesh_.uvs.push_back(corner[1] < 0 ? Vec2<float>(0) : uvs_[at(corner[1])]);
    mesh_.normals.push_back(corner[2] < 0 ? Vec3<float>(0) : normals_[at(corner[2])]);
    return next;
  }

  const std::filesystem::path& path_;
  bool flips_v_;
  int line_ = 0;
  std::vector<Vec3<float>> positions_;
  std::vector<Vec3<float>> normals_;
  std::vector<Vec2<float>> uvs_;
  std::unordered_map<Corner, std::uint32_t, CornerHash> vertices_;
  TriangleMesh<float> mesh_;
};

}  // namespace

TriangleMesh<float> read_obj(const std::filesystem::path& path, bool flips_v) {
  return ObjReader(path, flips_v).read(read_file_bytes(path));
}

}  // namespace manylight::scene_file
