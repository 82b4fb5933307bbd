// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include <glm/common.hpp>

#include "manylight/media/grid_volume.hpp"

namespace manylight {

/// The stretch of a ray in one block of a grid.
template <std::floating_point S>
struct BlockStretch {
  S majorant;  ///< at least every value that the grid has between `lo` and `hi`
  S s0, s1;    ///< m from the entry of the GridSegment, s0 <= s1
  Vec3<S> lo;  ///< of the block, lattice coordinates
  Vec3<S> hi;
  /// The segment's point at `s`, which rounding must not carry into a block with another majorant.
  [[nodiscard]] Vec3<S> at(const GridSegment<S>& segment, S s) const noexcept {
    return glm::clamp(segment.at(s), lo, hi);
  }
};

/// Maxima of a grid over blocks of about `cells_per_block`^3 cells, and the walk of a ray through the blocks
/// [Amanatides and Woo 1987; Szirmay-Kalos 2011]. Each axis of a copy of the grid is cut into blocks of equal,
/// possibly fractional width, so that the copies of a repeated grid share their maxima. 4 or 8 bytes per block.
template <std::floating_point S>
class BlockMajorants {
 public:
  static constexpr std::uint32_t k_cells_per_block = 8;

  /// `cells_per_block` of more than the grid's cells makes a single block. Throws ParameterError for 0.
  template <class T>
  explicit BlockMajorants(const GridVolume<S, T>& grid, std::uint32_t cells_per_block = k_cells_per_block) {
    require(cells_per_block > 0, "cells per majorant block", cells_per_block, "1 or more");
    const GridLattice<S>& lattice = grid.lattice();
    for (int axis = 0; axis < 3; ++axis) {
      const std::uint32_t cells = lattice.cells_of_copy(axis);
      const std::uint32_t count = (cells - 1) / cells_per_block + 1;
      count_[static_cast<std::size_t>(axis)] = count;
      width_[axis] = static_cast<S>(cells) / static_cast<S>(count);
      total_[axis] = static_cast<std::int32_t>(count * lattice.copies(axis));
    }
    find_maxima(grid);
  }

  /// Calls `visit(stretch)`, which returns whether to go on, for the blocks along `segment` in turn.
  template <class Visit>
  void walk(const GridSegment<S>& segment, const Visit& visit) const noexcept;

  [[nodiscard]] S maximum() const noexcept { return maximum_; }
  [[nodiscard]] std::size_t bytes() const noexcept { return maxima_->capacity() * sizeof(S); }

 private:
  using Index = glm::vec<3, std::int32_t, glm::defaultp>;
  template <class T>
  void find_maxima(const GridVolume<S, T>& grid);
  [[nodiscard]] S majorant(const Index& block) const noexcept {
    const auto of_copy = [&](int axis) {
      const auto b = static_cast<std::uint32_t>(block[axis]);
      const std::uint32_t count = count_[static_cast<std::size_t>(axis)];
      return b < count ? b : b % count;  // divisions are slow, and most grids have one copy
    };
    return (*maxima_)[(std::size_t{of_copy(2)} * count_[1] + of_copy(1)) * count_[0] + of_copy(0)];
  }

  std::array<std::uint32_t, 3> count_{};  ///< of one copy
  Index total_{};                         ///< of all
  Vec3<S> width_{};                       ///< of a block, cells
  S maximum_ = S(0);
  std::shared_ptr<const std::vector<S>> maxima_;
};

template <std::floating_point S>
template <class T>
void BlockMajorants<S>::find_maxima(const GridVolume<S, T>& grid) {
  const GridLattice<S>& lattice = grid.lattice();
  // Samples that interpolation reaches from block b of an axis. Ends of blocks far up in a repeated grid round
  // differently from those of the first copy, unless the width is whole.
  const auto reach = [&](int axis, std::uint32_t b) {
    const S slack = S(4) * std::numeric_limits<S>::epsilon() * lattice.cells()[axis];
    const S margin = width_[axis] == std::floor(width_[axis]) ? S(0) : slack;
    const S lo = static_cast<S>(b) * width_[axis] - lattice.first_sample() - margin;
    const S hi = static_cast<S>(b + 1) * width_[axis] - lattice.first_sample() + margin;
    return std::array<std::int32_t, 2>{static_cast<std::int32_t>(std::floor(lo)),
                                       static_cast<std::int32_t>(std::ceil(hi))};
  };
  auto maxima = std::make_shared<std::vector<S>>(std::size_t{count_[0]} * count_[1] * count_[2]);
  std::size_t block = 0;
  for (std::uint32_t bz = 0; bz < count_[2]; ++bz) {
    for (std::uint32_t by = 0; by < count_[1]; ++by) {
      for (std::uint32_t bx = 0; bx < count_[0]; ++bx, ++block) {
        const auto xs = reach(0, bx);
        const auto ys = reach(1, by);
        const auto zs = reach(2, bz);
        S largest = S(0);
        for (std::int32_t z = zs[0]; z <= zs[1]; ++z) {
          for (std::int32_t y = ys[0]; y <= ys[1]; ++y) {
            for (std::int32_t x = xs[0]; x <= xs[1]; ++x) {
              const std::size_t i = lattice.index(lattice.sample(0, x), lattice.sample(1, y), lattice.sample(2, z));
              largest = std::max(largest, grid.sample(i));
            }
          }
        }
        // Rounding lifts an interpolated value above its terms by up to 5 epsilon; the media's products add a few.
        (*maxima)[block] = largest * (S(1) + S(16) * std::numeric_limits<S>::epsilon());
        maximum_ = std::max(maximum_, (*maxima)[block]);
      }
    }
  }
  maxima_ = std::move(maxima);
}

template <std::floating_point S>
template <class Visit>
void BlockMajorants<S>::walk(const GridSegment<S>& segment, const Visit& visit) const noexcept {
  Index block{};
  Index step{};
  Index last{};     // of the blocks ahead; its far face does not count: the segment's end is there, rounding included
  Index to_face{};  // from a block's number to that of the face ahead
  Vec3<S> inverse{S(0)};
  Vec3<S> next{k_infinity<S>};  // s of the face ahead per axis
  const auto face = [&](int axis) {
    const S plane = static_cast<S>(block[axis] + to_face[axis]) * width_[axis];
    const S s = (plane - segment.entry[axis]) * inverse[axis];
    next[axis] = block[axis] == last[axis] ? k_infinity<S> : s;
  };
  for (int axis = 0; axis < 3; ++axis) {
    const auto b = static_cast<std::int32_t>(segment.entry[axis] / width_[axis]);
    block[axis] = std::clamp(b, 0, total_[axis] - 1);
    const S d = segment.direction[axis];
    if (!(std::abs(d) * std::numeric_limits<S>::max() > S(1)))
      continue;  // 0, or without an inverse: stays in its layer
    step[axis] = d > S(0) ? 1 : -1;
    last[axis] = d > S(0) ? total_[axis] - 1 : 0;
    to_face[axis] = d > S(0) ? 1 : 0;
    inverse[axis] = S(1) / d;
    face(axis);
  }
  S s = S(0);
  for (;;) {
    // Which axis is next cannot be predicted: selections, not branches.
    int axis = next.y < next.x ? 1 : 0;
    const S of_two = std::min(next.x, next.y);
    axis = next.z < of_two ? 2 : axis;
    const S reached = std::min(of_two, next.z);
    // Behind s if rounding of the entry put it on the far side of a face.
    const S end = std::clamp(reached, s, segment.length);
    const Vec3<S> lo = Vec3<S>(block) * width_;
    if (!visit(BlockStretch<S>{majorant(block), s, end, lo, Vec3<S>(block + 1) * width_})) return;
    if (!(reached < segment.length)) return;
    s = end;
    block[axis] += step[axis];
    face(axis);
  }
}

}  // namespace manylight
