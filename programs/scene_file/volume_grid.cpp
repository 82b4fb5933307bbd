// SPDX-License-Identifier: Apache-2.0
// Mitsuba's .vol files, as its gridvolume plugin reads them, and what tells a file's format.
#include "scene_file/volume_grid.hpp"

#include <bit>
#include <cmath>
#include <cstddef>
#include <string>

#include "scene_file/field_error.hpp"
#include "scene_file/mesh_files.hpp"
#include "scene_file/nanovdb_grid.hpp"

namespace manylight::scene_file {

namespace {

constexpr std::size_t k_header_bytes = 48;
constexpr std::array<const char*, 3> k_axes{"x", "y", "z"};

/// Little-endian numbers at any place of a file; the caller has checked that they are there.
class Bytes {
 public:
  explicit Bytes(const std::string& data) : data_(data) {}
  [[nodiscard]] std::uint32_t byte(std::size_t at) const { return static_cast<unsigned char>(data_[at]); }
  [[nodiscard]] std::uint32_t bits16(std::size_t at) const { return byte(at) | byte(at + 1) << 8U; }
  [[nodiscard]] std::uint32_t bits32(std::size_t at) const { return bits16(at) | bits16(at + 2) << 16U; }
  [[nodiscard]] std::int32_t int32(std::size_t at) const { return std::bit_cast<std::int32_t>(bits32(at)); }
  [[nodiscard]] float float32(std::size_t at) const { return std::bit_cast<float>(bits32(at)); }
  /// IEEE 754 binary16.
  [[nodiscard]] float float16(std::size_t at) const {
    const std::uint32_t bits = bits16(at);
    const auto exponent = static_cast<int>((bits >> 10U) & 0x1FU);
    const auto fraction = static_cast<float>(bits & 0x3FFU);
    float magnitude = std::ldexp(1024.0F + fraction, exponent - 25);
    if (exponent == 0) magnitude = std::ldexp(fraction, -24);
    if (exponent == 31) magnitude = fraction > 0 ? std::nanf("") : INFINITY;
    return (bits & 0x8000U) != 0 ? -magnitude : magnitude;
  }

 private:
  const std::string& data_;
};

enum class Storage : std::int32_t { float32 = 1, float16 = 2, bytes = 3 };

std::size_t bytes_of(Storage storage) {
  switch (storage) {
    case Storage::float32:
      return 4;
    case Storage::float16:
      return 2;
    case Storage::bytes:
      break;
  }
  return 1;
}

float value_at(const Bytes& in, std::size_t at, Storage storage) {
  switch (storage) {
    case Storage::float32:
      return in.float32(at);
    case Storage::float16:
      return in.float16(at);
    case Storage::bytes:
      break;
  }
  return static_cast<float>(in.byte(at)) / 255.0F;
}

/// Sizes, channels and box of a whole header.
VolumeGrid read_header(const std::filesystem::path& path, const Bytes& in) {
  VolumeGrid grid;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int32_t n = in.int32(8 + 4 * axis);
    if (n < 1 || n > VolumeGrid::k_largest_side) {
      fail_field(path, std::string("resolution along ") + k_axes[axis], n,
                 "1 to " + std::to_string(VolumeGrid::k_largest_side));
    }
    grid.size[axis] = static_cast<std::uint32_t>(n);
  }
  const std::int32_t channels = in.int32(20);
  if (channels != 1 && channels != 3) fail_field(path, "number of channels", channels, "1 or 3");
  grid.channels = static_cast<std::uint32_t>(channels);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<int>(axis);
    grid.box.lo[i] = in.float32(24 + 4 * axis);
    grid.box.hi[i] = in.float32(36 + 4 * axis);
    const std::string name = std::string("bounding box along ") + k_axes[axis];
    if (!std::isfinite(grid.box.lo[i])) fail_field(path, name + ", lower end", grid.box.lo[i], "finite");
    if (!std::isfinite(grid.box.hi[i]) || !(grid.box.hi[i] > grid.box.lo[i])) {
      fail_field(path, name + ", upper end", grid.box.hi[i], "finite and above the lower end");
    }
  }
  return grid;
}

VolumeGrid read_vol_grid(const std::filesystem::path& path, const std::string& data) {
  if (data.size() < k_header_bytes) {
    fail_field(path, "header", std::to_string(data.size()) + " bytes long", std::to_string(k_header_bytes));
  }
  const Bytes in(data);
  if (in.byte(3) != 3) fail_field(path, "version", in.byte(3), "3");
  const std::int32_t type = in.int32(4);
  if (type < 1 || type > 3) fail_field(path, "type", type, "1 (float32), 2 (float16), 3 (bytes)");
  const auto storage = static_cast<Storage>(type);
  VolumeGrid grid = read_header(path, in);
  // At most 2^48 * 3 * 4: no overflow. Compared with what is there before anything is allocated.
  const std::size_t count = grid.sample_count() * grid.channels;
  const std::size_t bytes = count * bytes_of(storage);
  if (data.size() - k_header_bytes != bytes) {
    fail_field(path, "data", std::to_string(data.size() - k_header_bytes) + " bytes long",
               std::to_string(bytes) + " for the resolution, channels and type stated");
  }
  grid.values.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const float value = value_at(in, k_header_bytes + i * bytes_of(storage), storage);
    if (!std::isfinite(value)) fail_field(path, "value " + std::to_string(i), value, "finite");
    grid.values.push_back(value);
  }
  return grid;
}

}  // namespace

VolumeGrid read_volume_grid(const std::filesystem::path& path, const std::optional<std::string>& gridname) {
  const std::string data = read_file_bytes(path);
  if (is_nanovdb(data)) return read_nanovdb_grid(path, data, gridname);
  if (data.compare(0, 4, " BDV") == 0) {
    throw SceneFileError(path.string(), 0, "", "is an OpenVDB file, allowed: what nanovdb_convert makes of it");
  }
  if (data.compare(0, 3, "VOL") != 0) throw SceneFileError(path.string(), 0, "", "is not a .vol grid file, nor .nvdb");
  if (gridname) fail_field(path, "gridname", "'" + *gridname + "'", "none, as the one grid of a .vol file has no name");
  return read_vol_grid(path, data);
}

}  // namespace manylight::scene_file
