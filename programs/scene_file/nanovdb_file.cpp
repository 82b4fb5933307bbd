// SPDX-License-Identifier: Apache-2.0
// The envelope of NanoVDB files: segments, each a header, a directory of grids, and the grids.
#if defined(MANYLIGHT_HAS_NANOVDB)

#include "scene_file/nanovdb_file.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>

#include <nanovdb/util/IO.h>
#include <zlib.h>

#include "scene_file/field_error.hpp"

namespace manylight::scene_file {

namespace {

using NanovdbHeader = nanovdb::io::Header;
using NanovdbMeta = nanovdb::io::MetaData;

struct NanovdbEntry {
  NanovdbMeta meta;
  nanovdb::io::Codec codec;  ///< of the segment
  std::string name;
  std::size_t at = 0;  ///< of its bytes in the file, all of which are there
};

std::string bytes_long(std::uint64_t n) { return std::to_string(n) + " bytes long"; }

class NanovdbDirectory {
 public:
  NanovdbDirectory(const std::filesystem::path& path, const std::string& data) : path_(path), data_(data) {
    do {
      read_segment();
    } while (left() > 0);
  }
  [[nodiscard]] const std::vector<NanovdbEntry>& entries() const { return entries_; }

 private:
  [[nodiscard]] std::size_t left() const { return data_.size() - at_; }
  template <class T>
  T take(const char* what) {
    if (left() < sizeof(T)) fail_field(path_, what, bytes_long(left()), std::to_string(sizeof(T)));
    T value;
    std::memcpy(static_cast<void*>(&value), data_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    return value;
  }
  void read_segment() {
    const auto header = take<NanovdbHeader>("header");
    // OpenVDB 11 gave files a magic number of their own, with the last character 2.
    std::string magic = data_.substr(at_ - sizeof(header), 8);
    if (magic != "NanoVDB0" && magic != "NanoVDB2") {
      for (char& c : magic) c = c > ' ' && c <= '~' ? c : '?';
      fail_field(path_, "magic", "'" + magic + "'", "NanoVDB0 or NanoVDB2");
    }
    const std::uint32_t version = header.version.getMajor();
    constexpr std::uint32_t k_version = NANOVDB_MAJOR_VERSION_NUMBER;
    if (version != k_version) fail_field(path_, "version", version, std::to_string(k_version));
    const std::size_t first = entries_.size();
    for (int i = 0; i < header.gridCount; ++i) read_entry(header.codec);
    for (std::size_t i = first; i < entries_.size(); ++i) {
      NanovdbEntry& entry = entries_[i];
      if (left() < entry.meta.fileSize) {
        fail_field(path_, "grid '" + entry.name + "'", bytes_long(left()), std::to_string(entry.meta.fileSize));
      }
      entry.at = at_;
      at_ += entry.meta.fileSize;
    }
  }
  void read_entry(nanovdb::io::Codec codec) {
    NanovdbEntry entry{take<NanovdbMeta>("grid directory"), codec, "", 0};
    const std::size_t length = entry.meta.nameSize;
    if (left() < length) fail_field(path_, "grid name", bytes_long(left()), std::to_string(length));
    entry.name = data_.substr(at_, length);
    entry.name.resize(std::min(entry.name.find('\0'), length));
    at_ += length;
    entries_.push_back(std::move(entry));
  }

  const std::filesystem::path& path_;
  const std::string& data_;
  std::size_t at_ = 0;
  std::vector<NanovdbEntry> entries_;
};

const NanovdbEntry& choose(const std::filesystem::path& path, const std::vector<NanovdbEntry>& entries,
                           const std::optional<std::string>& gridname) {
  if (entries.empty()) throw SceneFileError(path.string(), 0, "", "holds no grid");
  if (!gridname && entries.size() == 1) return entries.front();
  const std::string wanted = gridname.value_or("density");
  std::string names;
  for (const NanovdbEntry& entry : entries) {
    if (entry.name == wanted) return entry;
    names += (names.empty() ? "'" : ", '") + entry.name + "'";
  }
  fail_field(path, "gridname", gridname ? "'" + wanted + "'" : "not given, and no grid is called 'density'", names);
}

void inflate_into(const std::filesystem::path& path, const NanovdbEntry& entry, const std::string& data,
                  NanovdbBytes& bytes) {
  const auto* packed = reinterpret_cast<const Bytef*>(data.data()) + entry.at + 8;
  auto size = static_cast<uLongf>(bytes.size());
  const int status = uncompress(bytes.data(), &size, packed, static_cast<uLong>(entry.meta.fileSize - 8));
  if (status == Z_OK && size == bytes.size()) return;
  throw SceneFileError(path.string(), 0, "grid '" + entry.name + "'", "is damaged: its bytes cannot be unpacked");
}

/// Throws unless the size in memory fits to that in the file: nothing is allocated for a number alone.
void check_size(const std::filesystem::path& path, const NanovdbEntry& entry, const std::string& data) {
  const std::uint64_t size = entry.meta.gridSize;
  const std::uint64_t packed = entry.meta.fileSize;
  const std::string what = "grid '" + entry.name + "'";
  if (entry.codec == nanovdb::io::Codec::NONE) {
    if (packed != size) fail_field(path, what, bytes_long(packed), std::to_string(size));
    return;
  }
  if (entry.codec != nanovdb::io::Codec::ZIP) {
    const bool is_blosc = entry.codec == nanovdb::io::Codec::BLOSC;
    const std::string codec = is_blosc ? "BLOSC" : std::to_string(static_cast<int>(entry.codec));
    fail_field(path, "compression", codec, "none or ZIP (nanovdb_convert --none or --zip writes them)");
  }
  std::uint64_t stated = 0;
  if (packed < sizeof(stated)) fail_field(path, what, bytes_long(packed), "8 or more when compressed");
  std::memcpy(&stated, data.data() + entry.at, sizeof(stated));
  if (stated != packed - 8) fail_field(path, what + ", packed size", stated, std::to_string(packed - 8));
  constexpr std::uint64_t k_most = 1032;  // what a byte of deflate can stand for
  if (size / k_most > packed) fail_field(path, what, bytes_long(size), "at most " + std::to_string(k_most * packed));
}

}  // namespace

StoredNanovdbGrid unpack_nanovdb_grid(const std::filesystem::path& path, const std::string& data,
                                      const std::optional<std::string>& gridname) {
  const NanovdbDirectory directory(path, data);
  const NanovdbEntry& entry = choose(path, directory.entries(), gridname);
  check_size(path, entry, data);
  StoredNanovdbGrid grid{entry.name, entry.meta.gridType, NanovdbBytes(entry.meta.gridSize)};
  if (entry.codec == nanovdb::io::Codec::ZIP) {
    inflate_into(path, entry, data, grid.bytes);
  } else if (grid.bytes.size() > 0) {
    std::memcpy(grid.bytes.data(), data.data() + entry.at, grid.bytes.size());
  }
  return grid;
}

bool has_right_checksum(const NanovdbBytes& bytes, std::size_t head, bool is_empty,
                        const std::vector<std::array<std::size_t, 2>>& nodes) {
  constexpr std::uint32_t k_none = 0xFFFFFFFFU;
  const auto& header = bytes.as<nanovdb::GridData>(0);
  const auto of_head = static_cast<std::uint32_t>(header.mChecksum);
  const auto of_nodes = static_cast<std::uint32_t>(header.mChecksum >> 32U);
  if ((of_head == k_none && of_nodes == k_none) || nanovdb::Version(32, 6, 0) < header.mVersion) return true;
  const auto sum = [](const void* from, std::size_t size) {
    return static_cast<std::uint32_t>(crc32_z(0, static_cast<const Bytef*>(from), size));
  };
  constexpr std::size_t k_skipped = 16;  // the magic number and the checksum itself
  if (sum(bytes.data() + k_skipped, head - k_skipped) != of_head) return false;
  if (of_nodes == k_none || is_empty) return true;
  // The sums of the nodes are summed as uint_fast32_t, which has 8 bytes where the file was written under Linux and 4
  // under Windows.
  std::vector<std::uint32_t> short_sums;
  std::vector<std::uint64_t> long_sums;
  for (const auto& [at, size] : nodes) {
    short_sums.push_back(sum(bytes.data() + at, size));
    long_sums.push_back(short_sums.back());
  }
  return sum(long_sums.data(), 8 * long_sums.size()) == of_nodes ||
         sum(short_sums.data(), 4 * short_sums.size()) == of_nodes;
}

}  // namespace manylight::scene_file

#endif
