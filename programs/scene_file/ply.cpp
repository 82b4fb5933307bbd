// SPDX-License-Identifier: Apache-2.0
// Stanford PLY: ASCII and both binary forms; vertex positions, normals, texture coordinates, and faces.
#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <sstream>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "scene_file/mesh_files.hpp"

namespace manylight::scene_file {

namespace {

enum class Number { int8, uint8, int16, uint16, int32, uint32, float32, float64 };
enum class Format { ascii, little_endian, big_endian };

struct Property {
  std::string name;
  Number type = Number::float32;
  std::optional<Number> count_type;  ///< of a list
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  Format format = Format::ascii;
  std::vector<PlyElement> elements;
  std::size_t data_offset = 0;
};

[[noreturn]] void fail_ply(const std::filesystem::path& path, const std::string& reason) {
  throw SceneFileError(path.string(), 0, "", reason);
}

Number number_type(const std::filesystem::path& path, const std::string& name) {
  constexpr std::array<std::pair<std::string_view, Number>, 16> k_names{{{"char", Number::int8},
                                                                         {"int8", Number::int8},
                                                                         {"uchar", Number::uint8},
                                                                         {"uint8", Number::uint8},
                                                                         {"short", Number::int16},
                                                                         {"int16", Number::int16},
                                                                         {"ushort", Number::uint16},
                                                                         {"uint16", Number::uint16},
                                                                         {"int", Number::int32},
                                                                         {"int32", Number::int32},
                                                                         {"uint", Number::uint32},
                                                                         {"uint32", Number::uint32},
                                                                         {"float", Number::float32},
                                                                         {"float32", Number::float32},
                                                                         {"double", Number::float64},
                                                                         {"float64", Number::float64}}};
  for (const auto& [known, type] : k_names) {
    if (known == name) return type;
  }
  fail_ply(path, "damaged PLY header: unknown type '" + name + "'");
}

void parse_header_line(const std::filesystem::path& path, const std::string& line, Header& header) {
  std::istringstream in(line);
  std::string keyword;
  in >> keyword;
  std::string first;
  if (keyword == "format") {
    in >> first;
    if (first == "ascii")
      header.format = Format::ascii;
    else if (first == "binary_little_endian")
      header.format = Format::little_endian;
    else if (first == "binary_big_endian")
      header.format = Format::big_endian;
    else
      fail_ply(path, "unknown PLY format '" + first + "'");
  } else if (keyword == "element") {
    PlyElement element;
    if (!(in >> element.name >> element.count)) fail_ply(path, "damaged PLY header: '" + line + "'");
    header.elements.push_back(std::move(element));
  } else if (keyword == "property") {
    Property property;
    in >> first;
    if (first == "list") {
      in >> first;
      property.count_type = number_type(path, first);
      in >> first;
    }
    property.type = number_type(path, first);
    if (!(in >> property.name) || header.elements.empty()) fail_ply(path, "damaged PLY header: '" + line + "'");
    header.elements.back().properties.push_back(std::move(property));
  } else if (keyword != "ply" && keyword != "comment" && keyword != "obj_info" && !keyword.empty()) {
    fail_ply(path, "damaged PLY header: '" + line + "'");
  }
}

Header parse_header(const std::filesystem::path& path, const std::string& data) {
  if (data.rfind("ply", 0) != 0) fail_ply(path, "is not a PLY file");
  Header header;
  for (std::size_t begin = 0; begin < data.size();) {
    const std::size_t end = data.find('\n', begin);
    if (end == std::string::npos) break;
    std::string line = data.substr(begin, end - begin);
    if (!line.empty() && line.back() == '\r') line.pop_back();
    begin = end + 1;
    if (line == "end_header") {
      header.data_offset = begin;
      return header;
    }
    parse_header_line(path, line, header);
  }
  fail_ply(path, "truncated PLY header");
}

/// The numbers behind the header, one after the other.
class Source {
 public:
  Source(const std::filesystem::path& path, const std::string& data, const Header& header)
      : path_(path), data_(data), format_(header.format), at_(header.data_offset) {}

  [[nodiscard]] double next(Number type) {
    if (format_ == Format::ascii) return next_word();
    switch (type) {
      case Number::int8:
        return static_cast<double>(take<std::int8_t>());
      case Number::uint8:
        return static_cast<double>(take<std::uint8_t>());
      case Number::int16:
        return static_cast<double>(take<std::int16_t>());
      case Number::uint16:
        return static_cast<double>(take<std::uint16_t>());
      case Number::int32:
        return static_cast<double>(take<std::int32_t>());
      case Number::uint32:
        return static_cast<double>(take<std::uint32_t>());
      case Number::float32:
        return static_cast<double>(take<float>());
      case Number::float64:
        return take<double>();
    }
    return 0;
  }

 private:
  template <class T>
  [[nodiscard]] T take() {
    if (data_.size() - at_ < sizeof(T)) fail_ply(path_, "truncated PLY data");
    std::array<char, sizeof(T)> bytes;
    std::memcpy(bytes.data(), data_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    const bool is_native = (format_ == Format::little_endian) == (std::endian::native == std::endian::little);
    if (!is_native) std::reverse(bytes.begin(), bytes.end());
    return std::bit_cast<T>(bytes);
  }

  [[nodiscard]] double next_word() {
    const auto is_space = [](char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; };
    while (at_ < data_.size() && is_space(data_[at_])) ++at_;
    if (at_ == data_.size()) fail_ply(path_, "truncated PLY data");
    double value = 0;
    const char* const begin = data_.data() + at_;
    const auto [end, code] = std::from_chars(begin, data_.data() + data_.size(), value);
    const bool is_whole = end == data_.data() + data_.size() || is_space(*end);
    if (code != std::errc() || !is_whole) {
      fail_ply(path_, "damaged PLY data: '" + std::string(begin, std::find_if(begin, begin + remaining(), is_space)) +
                          "' is not a number");
    }
    at_ = static_cast<std::size_t>(end - data_.data());
    return value;
  }

  [[nodiscard]] std::ptrdiff_t remaining() const {
    return static_cast<std::ptrdiff_t>(std::min<std::size_t>(data_.size() - at_, 40));
  }

  const std::filesystem::path& path_;
  const std::string& data_;
  Format format_;
  std::size_t at_;
};

/// Where a vertex property goes: 0 to 2 position, 3 to 5 normal, 6 and 7 texture coordinates; none: skipped.
std::optional<std::size_t> slot_of(const std::string& name) {
  constexpr std::array<std::pair<std::string_view, std::size_t>, 14> k_slots{{{"x", 0},
                                                                              {"y", 1},
                                                                              {"z", 2},
                                                                              {"nx", 3},
                                                                              {"ny", 4},
                                                                              {"nz", 5},
                                                                              {"u", 6},
                                                                              {"v", 7},
                                                                              {"s", 6},
                                                                              {"t", 7},
                                                                              {"texture_u", 6},
                                                                              {"texture_v", 7},
                                                                              {"texcoord_u", 6},
                                                                              {"texcoord_v", 7}}};
  for (const auto& [known, slot] : k_slots) {
    if (known == name) return slot;
  }
  return std::nullopt;
}

std::vector<double> next_list(const std::filesystem::path& path, Source& source, const Property& property) {
  const double count = source.next(*property.count_type);
  if (!(count >= 0 && count <= 65535 && count == std::floor(count)))
    fail_ply(path, "damaged PLY data: length of a list");
  std::vector<double> values;
  for (int i = 0; i < static_cast<int>(count); ++i) values.push_back(source.next(property.type));
  return values;
}

void read_vertices(const std::filesystem::path& path, Source& source, const PlyElement& element, bool flips_v,
                   TriangleMesh<float>& mesh) {
  std::array<bool, 8> has{};
  for (const Property& property : element.properties) {
    if (const auto slot = slot_of(property.name)) has[*slot] = true;
  }
  if (!has[0] || !has[1] || !has[2]) fail_ply(path, "vertices have no x, y and z");
  for (std::uint64_t i = 0; i < element.count; ++i) {
    std::array<float, 8> value{};
    for (const Property& property : element.properties) {
      if (property.count_type) {
        static_cast<void>(next_list(path, source, property));
        continue;
      }
      const double number = source.next(property.type);
      if (const auto slot = slot_of(property.name)) value[*slot] = static_cast<float>(number);
    }
    mesh.positions.push_back({value[0], value[1], value[2]});
    if (has[3] && has[4] && has[5]) mesh.normals.push_back({value[3], value[4], value[5]});
    if (has[6] && has[7]) mesh.uvs.push_back({value[6], flips_v ? 1.0F - value[7] : value[7]});
  }
}

void add_face(const std::filesystem::path& path, const std::vector<double>& corners, std::uint64_t face,
              TriangleMesh<float>& mesh) {
  const std::string where = "face " + std::to_string(face);
  const auto count = static_cast<double>(mesh.positions.size());
  for (const double index : corners) {
    if (index >= 0 && index < count && index == std::floor(index)) continue;
    std::ostringstream text;
    text << where << ": vertex index is " << index << ", allowed: 0 to " << count - 1;
    fail_ply(path, text.str());
  }
  if (corners.size() < 3)
    fail_ply(path, where + " has " + std::to_string(corners.size()) + " vertices, allowed: 3 or more");
  const auto index = [&corners](std::size_t i) { return static_cast<std::uint32_t>(corners[i]); };
  for (std::size_t i = 2; i < corners.size(); ++i) mesh.triangles.push_back({index(0), index(i - 1), index(i)});
}

void read_faces(const std::filesystem::path& path, Source& source, const PlyElement& element,
                TriangleMesh<float>& mesh) {
  for (std::uint64_t face = 0; face < element.count; ++face) {
    for (const Property& property : element.properties) {
      if (!property.count_type) {
        static_cast<void>(source.next(property.type));
        continue;
      }
      const std::vector<double> list = next_list(path, source, property);
      if (property.name == "vertex_indices" || property.name == "vertex_index") add_face(path, list, face, mesh);
    }
  }
}

void skip(const std::filesystem::path& path, Source& source, const PlyElement& element) {
  for (std::uint64_t i = 0; i < element.count; ++i) {
    for (const Property& property : element.properties) {
      if (property.count_type)
        static_cast<void>(next_list(path, source, property));
      else
        static_cast<void>(source.next(property.type));
    }
  }
}

}  // namespace

TriangleMesh<float> read_ply(const std::filesystem::path& path, bool flips_v) {
  const std::string data = read_file_bytes(path);
  const Header header = parse_header(path, data);
  Source source(path, data, header);
  TriangleMesh<float> mesh;
  for (const PlyElement& element : header.elements) {
    // Without properties an element takes no bytes, whatever its count says.
    if (element.properties.empty()) continue;
    if (element.name == "vertex")
      read_vertices(path, source, element, flips_v, mesh);
    else if (element.name == "face")
      read_faces(path, source, element, mesh);
    else
      skip(path, source, element);
  }
  if (mesh.triangles.empty()) fail_ply(path, "empty mesh: the file holds no faces");
  return mesh;
}

}  // namespace manylight::scene_file
