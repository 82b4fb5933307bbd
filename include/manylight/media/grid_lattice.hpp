// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>

#include "manylight/core/box.hpp"
#include "manylight/core/error.hpp"
#include "manylight/geometry/ray.hpp"
#include "manylight/geometry/transform.hpp"

namespace manylight {

/// Where the n samples of an axis lie. `at_vertices`: at the ends of n - 1 cells that span the box, as in Mitsuba's
/// gridvolume; `at_centers`: in the middle of n cells, and constant over the outer half of the first and last.
enum class GridSamples : std::uint8_t { at_vertices, at_centers };

/// How a grid of samples fills space.
template <std::floating_point S>
struct GridPlacement {
  Box<S> box{Vec3<S>(S(0)), Vec3<S>(S(1))};      ///< of the whole, all copies, before `to_world`
  Mat4<S> to_world{S(1)};                        ///< affine; afterwards metres
  std::array<std::uint32_t, 3> copies{1, 1, 1};  ///< per axis; more than 1: so many periods of n cells, joined smoothly
  GridSamples samples = GridSamples::at_vertices;
};

/// Part of a ray inside a grid's box, in lattice coordinates; `s` is metres from where the ray enters.
template <std::floating_point S>
struct GridSegment {
  Vec3<S> entry;      ///< lattice coordinates at s = 0
  Vec3<S> direction;  ///< cells per metre
  S t_entry;          ///< of the ray, m
  S length;           ///< m, finite and positive
  [[nodiscard]] Vec3<S> at(S s) const noexcept { return entry + direction * s; }
};

/// The coordinates of a grid: [0, cells] per axis over the whole box, one unit per cell. Positions are relative to
/// where a ray enters, so that they keep their digits however far away it starts.
template <std::floating_point S>
class GridLattice {
 public:
  /// Throws ParameterError.
  GridLattice(const std::array<std::uint32_t, 3>& size, const GridPlacement<S>& placement);

  [[nodiscard]] Vec3<S> from_world(const Vec3<S>& p) const noexcept { return linear_ * p + offset_; }
  [[nodiscard]] bool contains(const Vec3<S>& g) const noexcept {  // false of NaN
    return g.x >= S(0) && g.y >= S(0) && g.z >= S(0) && g.x <= cells_.x && g.y <= cells_.y && g.z <= cells_.z;
  }
  /// The part of `ray` (unit direction) up to `t_max` that lies in the closed box; none if it has no length.
  [[nodiscard]] std::optional<GridSegment<S>> clip(const Ray<S>& ray, S t_max) const noexcept;

  [[nodiscard]] const std::array<std::uint32_t, 3>& size() const noexcept { return size_; }
  [[nodiscard]] std::uint32_t copies(int axis) const noexcept { return copies_[static_cast<std::size_t>(axis)]; }
  /// Cells of the whole.
  [[nodiscard]] const Vec3<S>& cells() const noexcept { return cells_; }
  /// Cells of one copy.
  [[nodiscard]] std::uint32_t cells_of_copy(int axis) const noexcept {
    const std::uint32_t n = size_[static_cast<std::size_t>(axis)];
    return copies(axis) == 1 && samples_ == GridSamples::at_vertices ? n - 1 : n;
  }
  /// Lattice coordinate of sample 0: 0 or a half.
  [[nodiscard]] S first_sample() const noexcept { return samples_ == GridSamples::at_vertices ? S(0) : S(0.5); }
  /// Sample number `i`, of magnitude below 2^22, of an axis: repeated or held at the border.
  [[nodiscard]] std::uint32_t sample(int axis, std::int32_t i) const noexcept {
    const auto a = static_cast<std::size_t>(axis);
    const auto n = static_cast<std::int32_t>(size_[a]);
    if (i >= 0 && i < n) return static_cast<std::uint32_t>(i);
    if (copies_[a] == 1) return static_cast<std::uint32_t>(i < 0 ? 0 : n - 1);
    return static_cast<std::uint32_t>(((i % n) + n) % n);
  }
  /// x varies fastest.
  [[nodiscard]] std::size_t index(std::uint32_t x, std::uint32_t y, std::uint32_t z) const noexcept {
    return (std::size_t{z} * size_[1] + y) * size_[0] + x;
  }
  [[nodiscard]] std::size_t sample_count() const noexcept { return std::size_t{size_[0]} * size_[1] * size_[2]; }
  [[nodiscard]] const Box<S>& world_bounds() const noexcept { return world_bounds_; }
  /// Longest segment in the box, m.
  [[nodiscard]] S world_diagonal() const noexcept { return world_diagonal_; }
  /// A direction of the grid's own frame, turned as tangents are, to the world; unit, if it is not 0.
  [[nodiscard]] Vec3<S> to_world_direction(const Vec3<S>& w) const noexcept {
    return detail::normalize_or_zero<S>(to_world_ * w);
  }

 private:
  using Mat3 = glm::mat<3, 3, S, glm::defaultp>;
  void place(const GridPlacement<S>& placement);

  std::array<std::uint32_t, 3> size_;
  std::array<std::uint32_t, 3> copies_;
  GridSamples samples_;
  Vec3<S> cells_;
  Mat3 linear_;
  Vec3<S> offset_;
  Mat3 to_world_;
  Box<S> world_bounds_;
  S world_diagonal_ = S(0);
};

template <std::floating_point S>
GridLattice<S>::GridLattice(const std::array<std::uint32_t, 3>& size, const GridPlacement<S>& placement)
    : size_(size), copies_(placement.copies), samples_(placement.samples) {
  // Beyond that many cells float positions would be coarser than an eighth of a cell.
  constexpr std::uint64_t k_most = std::uint64_t{1} << 21U;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const std::string name = std::string(" along ") + "xyz"[axis];
    require(copies_[a] >= 1 && copies_[a] <= k_most, "number of grid copies" + name, copies_[a], "1 to 2^21");
    const std::uint32_t least = samples_ == GridSamples::at_vertices && copies_[a] == 1 ? 2 : 1;
    require(size_[a] >= least && size_[a] <= k_most, "number of grid samples" + name, size_[a],
            std::to_string(least) + " to 2^21");
    const std::uint64_t cells = std::uint64_t{cells_of_copy(axis)} * copies_[a];
    require(cells <= k_most, "number of grid cells" + name, cells, "at most 2^21");
    cells_[axis] = static_cast<S>(cells);
    const S lo = placement.box.lo[axis];
    const S hi = placement.box.hi[axis];
    require(std::isfinite(lo), "lower end of the grid's box" + name, lo, "finite");
    require(std::isfinite(hi) && hi > lo, "upper end of the grid's box" + name, hi, "finite and above the lower end");
  }
  place(placement);
}

template <std::floating_point S>
void GridLattice<S>::place(const GridPlacement<S>& placement) {
  using DVec3 = Vec3<double>;
  const Mat4<double> m(placement.to_world);
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) {
      const std::string name = "grid transform, row " + std::to_string(row) + " column " + std::to_string(column);
      const double v = m[column][row];
      const double last = column == 3 ? 1.0 : 0.0;
      require(row < 3 ? std::isfinite(v) : v == last, name, v, row < 3 ? "finite" : "that of an affine map");
    }
  }
  const glm::mat<3, 3, double, glm::defaultp> linear(m);
  const double determinant = glm::determinant(linear);
  require(std::isfinite(determinant) && determinant != 0.0, "determinant of the grid transform", determinant,
          "finite and not 0");
  const DVec3 lo(placement.box.lo);
  const DVec3 scale = DVec3(cells_) / (DVec3(placement.box.hi) - lo);
  auto inverse = glm::inverse(linear);
  for (int column = 0; column < 3; ++column) inverse[column] *= scale;
  linear_ = Mat3(inverse);
  offset_ = Vec3<S>(-(inverse * DVec3(m[3])) - lo * scale);
  to_world_ = Mat3(linear);
  std::array<DVec3, 8> corners{};
  for (std::size_t i = 0; i < 8; ++i) {
    const DVec3 corner((i & 1U) != 0 ? placement.box.hi.x : lo.x, (i & 2U) != 0 ? placement.box.hi.y : lo.y,
                       (i & 4U) != 0 ? placement.box.hi.z : lo.z);
    corners[i] = detail::transform_point(m, corner);
    world_bounds_.extend(Vec3<S>(corners[i]));
  }
  double diagonal = 0;
  for (std::size_t i = 0; i < 4; ++i) diagonal = std::max(diagonal, glm::length(corners[i] - corners[7 - i]));
  world_diagonal_ = static_cast<S>(diagonal);
  const auto entries = {linear_[0], linear_[1], linear_[2], offset_};
  const bool usable = std::all_of(entries.begin(), entries.end(), [](const Vec3<S>& v) { return is_finite(v); });
  require(usable && std::isfinite(world_diagonal_), "determinant of the grid transform", determinant,
          "one whose inverse can be held");
}

template <std::floating_point S>
std::optional<GridSegment<S>> GridLattice<S>::clip(const Ray<S>& ray, S t_max) const noexcept {
  const Vec3<S> origin = from_world(ray.origin);
  const Vec3<S> direction = linear_ * ray.direction;
  if (!is_finite(origin) || !is_finite(direction)) return std::nullopt;
  S t0 = S(0);
  S t1 = t_max;
  for (int axis = 0; axis < 3; ++axis) {
    const S g = origin[axis];
    const S d = direction[axis];
    if (d == S(0)) {  // parallel to these faces; on one counts as inside
      if (!(g >= S(0) && g <= cells_[axis])) return std::nullopt;
      continue;
    }
    const S a = -g / d;
    const S b = (cells_[axis] - g) / d;
    t0 = std::max(t0, std::min(a, b));
    t1 = std::min(t1, std::max(a, b));
  }
  if (!(t0 < t1) || !std::isfinite(t1)) return std::nullopt;
  const Vec3<S> entry = glm::clamp(origin + direction * t0, Vec3<S>(S(0)), cells_);
  return GridSegment<S>{entry, direction, t0, t1 - t0};
}

}  // namespace manylight
