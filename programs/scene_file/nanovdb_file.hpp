// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <nanovdb/NanoVDB.h>

namespace manylight::scene_file {

/// The bytes of one grid, aligned as NanoVDB needs them.
class NanovdbBytes {
 public:
  explicit NanovdbBytes(std::size_t size) : blocks_(size / k_alignment + 1), size_(size) {}
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] unsigned char* data() { return blocks_.data()->bytes.data(); }
  [[nodiscard]] const unsigned char* data() const { return blocks_.data()->bytes.data(); }
  /// What lies `at` bytes from the front; the caller has checked that it is there.
  template <class T>
  [[nodiscard]] const T& as(std::size_t at) const {
    return *reinterpret_cast<const T*>(data() + at);
  }

 private:
  static constexpr std::size_t k_alignment = NANOVDB_DATA_ALIGNMENT;
  struct alignas(k_alignment) Block {
    std::array<unsigned char, k_alignment> bytes;
  };
  std::vector<Block> blocks_;
  std::size_t size_;
};

/// A grid as a file holds it, unpacked. Its kind is that of the directory, its bytes are not checked yet.
struct StoredNanovdbGrid {
  std::string name;
  nanovdb::GridType type = nanovdb::GridType::Unknown;
  NanovdbBytes bytes;
};

/// The grid of that name, or the only one, or the one called "density". Throws SceneFileError.
///
/// The envelope is read here and not by nanovdb::io::readGrid, which believes every size in it.
[[nodiscard]] StoredNanovdbGrid unpack_nanovdb_grid(const std::filesystem::path& path, const std::string& data,
                                                    const std::optional<std::string>& gridname);

/// Whether a grid has the checksum that its header states, if any: that of `head` bytes from the front, and that of the
/// nodes, whose place and size are given in NanoVDB's order: upper ones, lower ones, leaves. All of these must lie
/// inside of `bytes`. Versions after 32.6.0 count otherwise, and pass.
[[nodiscard]] bool has_right_checksum(const NanovdbBytes& bytes, std::size_t head, bool is_empty,
                                      const std::vector<std::array<std::size_t, 2>>& nodes);

}  // namespace manylight::scene_file
