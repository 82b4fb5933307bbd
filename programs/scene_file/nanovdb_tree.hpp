// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <type_traits>
#include <vector>

#include <nanovdb/NanoVDB.h>

#include "scene_file/field_error.hpp"
#include "scene_file/nanovdb_file.hpp"

namespace manylight::scene_file {

/// The tree of a stored grid, all offsets of which have been followed once and found to lead inside of its bytes:
/// NanoVDB itself would follow them unseen. Throws SceneFileError.
template <class Build>
class NanovdbTree {
 public:
  using Leaf = nanovdb::NanoLeaf<Build>;
  using Lower = nanovdb::NanoLower<Build>;
  using Upper = nanovdb::NanoUpper<Build>;
  using Root = nanovdb::NanoRoot<Build>;
  using Value = typename Root::ValueType;
  using Coord = nanovdb::Coord;
  /// A cube of `side` voxels with one value, active or other than the background.
  struct Tile {
    Coord origin;
    std::int32_t side;
    Value value;
  };
  struct LeafPlace {
    Coord origin;
    const Leaf* leaf;
  };

  NanovdbTree(const std::filesystem::path& path, const StoredNanovdbGrid& grid)
      : path_(path), field_("grid '" + grid.name + "'"), bytes_(grid.bytes) {
    check_header();
    visit_root();
    const bool is_breadth_first =
        Leaf::FIXED_SIZE && (header().mFlags & static_cast<std::uint32_t>(nanovdb::GridFlags::IsBreadthFirst)) != 0;
    std::vector<std::array<std::size_t, 2>> nodes;
    for (std::size_t level = 3; level-- > 0;) {
      if (nodes_[level].size() != tree().mNodeCount[level]) damaged("number of nodes");
      if (is_breadth_first) std::sort(nodes_[level].begin(), nodes_[level].end());
      for (const std::size_t at : nodes_[level]) nodes.push_back({at, k_sizes[level]});
    }
    const std::size_t head = sizeof(nanovdb::GridData) + sizeof(TreeData) + root().memUsage();
    if (head > bytes_.size() || !has_right_checksum(bytes_, head, root().tileCount() == 0, nodes)) damaged("checksum");
  }

  [[nodiscard]] const nanovdb::GridData& header() const { return bytes_.as<nanovdb::GridData>(0); }
  [[nodiscard]] const Value& background() const { return root().background(); }
  /// Of all active values; empty if there are none.
  [[nodiscard]] const nanovdb::CoordBBox& active() const { return active_; }
  [[nodiscard]] const std::vector<Tile>& tiles() const { return tiles_; }
  [[nodiscard]] const std::vector<LeafPlace>& leaves() const { return leaves_; }

 private:
  using TreeData = nanovdb::TreeData<3>;
  static constexpr std::size_t k_tree_at = sizeof(nanovdb::GridData);
  static constexpr std::array<std::size_t, 3> k_sizes{sizeof(Leaf), sizeof(Lower), sizeof(Upper)};

  [[nodiscard]] const TreeData& tree() const { return bytes_.as<TreeData>(k_tree_at); }
  [[nodiscard]] const Root& root() const { return bytes_.as<Root>(root_at_); }
  [[noreturn]] void damaged(const char* what) const {
    throw SceneFileError(path_.string(), 0, field_, std::string("is damaged: wrong ") + what);
  }

  void check_header() const {
    if (bytes_.size() < k_tree_at + sizeof(TreeData) + sizeof(Root)) {
      fail_field(path_, field_, std::to_string(bytes_.size()) + " bytes long",
                 std::to_string(k_tree_at + sizeof(TreeData) + sizeof(Root)) + " or more");
    }
    const std::uint64_t kind = header().mMagic - NANOVDB_MAGIC_NUMBER;
    if (kind != 0 && kind != std::uint64_t{1} << 56U) damaged("magic number");  // "NanoVDB0", since OpenVDB 11 "1"
    if (header().mVersion.getMajor() != NANOVDB_MAJOR_VERSION_NUMBER) damaged("version");
    if (header().mGridSize > bytes_.size()) damaged("size");
    if (header().mGridType != nanovdb::mapToGridType<Build>()) damaged("type of values");
  }
  /// Where a node of `size` bytes lies that is `offset` bytes from `from`. Sums wrap around; only their result counts.
  [[nodiscard]] std::size_t place(std::size_t from, std::uint64_t offset, std::size_t size) const {
    const std::size_t at = from + offset;
    if (at % NANOVDB_DATA_ALIGNMENT != 0 || at > bytes_.size() || bytes_.size() - at < size)
      damaged("offset of a node");
    return at;
  }
  void visit_root() {
    root_at_ = place(k_tree_at, tree().mNodeOffset[3], sizeof(Root));
    const auto* data = root().data();
    using RootTile = std::remove_cv_t<std::remove_pointer_t<decltype(data->tile(0))>>;
    const std::size_t room = bytes_.size() - root_at_ - sizeof(Root);
    if (room / sizeof(RootTile) < data->mTableSize) damaged("number of tiles");
    for (std::uint32_t i = 0; i < data->mTableSize; ++i) {
      const RootTile& tile = *data->tile(i);
      if (tile.isChild()) {
        visit<Upper>(root_at_, tile.child, tile.origin());
      } else {
        add_tile(tile.origin(), static_cast<std::int32_t>(Upper::DIM), tile.value, tile.state != 0);
      }
    }
  }
  template <class Node>
  void visit(std::size_t from, std::int64_t offset, const Coord& origin) {
    const std::size_t at = place(from, static_cast<std::uint64_t>(offset), sizeof(Node));
    std::vector<std::size_t>& known = nodes_[Node::LEVEL];
    // Tiles that share a node, or a few, could make a walk of any length.
    if (known.size() >= tree().mNodeCount[Node::LEVEL] || known.size() >= bytes_.size() / sizeof(Node)) {
      damaged("number of nodes");
    }
    known.push_back(at);
    const Node& node = bytes_.as<Node>(at);
    if constexpr (std::is_same_v<Node, Leaf>) {
      add_leaf(at, node, origin);
    } else {
      using Child = typename Node::ChildNodeType;
      const auto* data = node.data();
      for (std::uint32_t n = 0; n < Node::SIZE; ++n) {
        Coord o = Node::OffsetToLocalCoord(n);
        o <<= Child::TOTAL;
        o += origin;
        if (data->mChildMask.isOn(n)) {
          visit<Child>(at, data->mTable[n].child, o);
        } else {
          add_tile(o, static_cast<std::int32_t>(Child::DIM), data->mTable[n].value, data->mValueMask.isOn(n));
        }
      }
    }
  }
  void add_tile(const Coord& origin, std::int32_t side, const Value& value, bool is_active) {
    if (is_active) {
      active_.expand(origin);
      active_.expand(origin.offsetBy(side - 1));
    }
    if (is_active || value != background()) tiles_.push_back({origin, side, value});
  }
  void add_leaf(std::size_t at, const Leaf& leaf, const Coord& origin) {
    if constexpr (std::is_same_v<Build, nanovdb::FpN>) {  // followed by 512 codes of 1, 2, 4, 8 or 16 bits
      const unsigned log_bits = leaf.flags() >> 5U;
      if (log_bits > 4 || bytes_.size() - at - sizeof(Leaf) < std::size_t{64} << log_bits) damaged("width of values");
    }
    for (std::uint32_t n = 0; n < Leaf::SIZE; ++n) {
      if (leaf.valueMask().isOn(n)) active_.expand(origin + Leaf::OffsetToLocalCoord(n));
    }
    leaves_.push_back({origin, &leaf});
  }

  const std::filesystem::path& path_;
  std::string field_;
  const NanovdbBytes& bytes_;
  std::size_t root_at_ = 0;
  nanovdb::CoordBBox active_;
  std::vector<Tile> tiles_;
  std::vector<LeafPlace> leaves_;
  std::array<std::vector<std::size_t>, 3> nodes_;  ///< where they lie, by level
};

}  // namespace manylight::scene_file
