// SPDX-License-Identifier: Apache-2.0
#pragma once

// Bounds over all directions as quad-trees on the faces of a cube [Walter 2012, section 5.3; theory 6.3]: the one
// representation in which patterns of any kind merge. Each leaf bounds its cell's directions, each inner node is the
// maximum of its four children.
//
// Departure: the sheet stops at cells whose bound is near their largest value. That leaves whole faces as one cell with
// a lobe in it, tight where the lobe is and useless beside it. Here a cell is split if its bound is far above its
// smallest known value, and the one whose excess over the cell's values integrates to most comes first.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "manylight/core/box.hpp"
#include "manylight/core/direction_set.hpp"

namespace manylight {

/// When a cell is split.
struct CubeMapLimits {
  std::uint32_t nodes = 64;  ///< most nodes, 6 or more; 8 bytes each in single precision
  unsigned depth = 7;        ///< most subdivisions of a face, up to 11
  double ratio = 1.25;       ///< bounds over the smallest value known in the cell that need no split
  double floor = 0.02;       ///< nor do bounds below this part of the largest value
};

template <std::floating_point S>
class CubeMap {
 public:
  struct Node {
    S max;                   ///< bound over the cell
    std::uint32_t children;  ///< index of the first of four, 0: none
  };

  [[nodiscard]] std::size_t size() const noexcept { return nodes_.size(); }
  /// Over all directions.
  [[nodiscard]] S max() const noexcept {
    S most = S(0);
    for (std::size_t face = 0; face < 6; ++face) most = std::max(most, nodes_[face].max);
    return most;
  }

  /// Subdivides where `bound(DirectionSet)` is far above `value(direction)` at the cell's centre and corners.
  template <class Bound, class Value>
  void build(const Bound& bound, const Value& value, const CubeMapLimits& limits = {});

  /// Makes this the maximum of both, with cells merged until there are at most `nodes`: first those that lose little.
  void merge(const CubeMap& a, const CubeMap& b, std::uint32_t nodes = CubeMapLimits{}.nodes);

  /// Bound over the directions of all vectors in the box.
  [[nodiscard]] S sup(const Box<S>& vectors) const noexcept;

 private:
  /// A square [u0, u0 + size] x [v0, v0 + size] of a face; faces are [-1, 1]^2.
  struct Cell {
    unsigned face;
    S u0, v0, size;
    [[nodiscard]] Cell child(unsigned i) const noexcept {
      const S half = size / S(2);
      return {face, u0 + (i & 1U ? half : S(0)), v0 + (i & 2U ? half : S(0)), half};
    }
    /// The vector with a component of +-1 along the face's axis.
    [[nodiscard]] Vec3<S> at(S u, S v) const noexcept {
      const int axis = static_cast<int>(face / 2);
      Vec3<S> p;
      p[axis] = face % 2 == 0 ? S(1) : S(-1);
      p[(axis + 1) % 3] = u;
      p[(axis + 2) % 3] = v;
      return glm::normalize(p);
    }
    [[nodiscard]] std::array<Vec3<S>, 4> corners() const noexcept {
      return {at(u0, v0), at(u0 + size, v0), at(u0, v0 + size), at(u0 + size, v0 + size)};
    }
    [[nodiscard]] Vec3<S> center() const noexcept { return at(u0 + size / S(2), v0 + size / S(2)); }
    /// A cone around the cell: a circular one of less than 90 degrees is convex, so that the corners suffice.
    [[nodiscard]] DirectionSet<S> enclosing() const noexcept {
      const Vec3<S> axis = center();
      S sine = S(0);
      S cosine = S(1);
      for (const Vec3<S>& corner : corners()) {
        const S s = glm::length(glm::cross(axis, corner));  // all below 90 degrees: ordered by sine
        if (s > sine) {
          sine = s;
          cosine = glm::dot(axis, corner);
        }
      }
      return DirectionSet<S>({axis, cosine, sine});
    }
  };
  /// A cell that may be split; the heap's top has the largest excess.
  struct Open {
    S excess;  ///< (bound - mean of known values) times the area on the face
    S least;   ///< known value
    std::uint32_t node;
    unsigned depth;
    Cell cell;
    friend bool operator<(const Open& a, const Open& b) noexcept {
      return a.excess != b.excess ? a.excess < b.excess : a.node > b.node;
    }
  };

  [[nodiscard]] static Cell face_cell(unsigned face) noexcept { return {face, S(-1), S(-1), S(2)}; }
  void unite(std::uint32_t to, const CubeMap& a, std::uint32_t i, const CubeMap& b, std::uint32_t j);
  void collapse(std::size_t nodes);
  void take_maxima() noexcept;
  [[nodiscard]] S sup_of_face(unsigned face, S u0, S u1, S v0, S v1, S known) const noexcept;

  std::vector<Node> nodes_;  ///< the six faces, then groups of four, children behind their parent
};

template <std::floating_point S>
template <class Bound, class Value>
void CubeMap<S>::build(const Bound& bound, const Value& value, const CubeMapLimits& limits) {
  nodes_.clear();
  std::vector<Open> heap;
  S largest = S(0);
  const auto open = [&](const Cell& cell, unsigned depth, S at_most) {
    const S b = std::min(at_most, static_cast<S>(bound(cell.enclosing())));
    S least = value(cell.center());
    S sum = least;
    largest = std::max(largest, least);
    for (const Vec3<S>& corner : cell.corners()) {
      const S v = value(corner);
      least = std::min(least, v);
      largest = std::max(largest, v);
      sum += v;
    }
    heap.push_back({(b - sum / S(5)) * sqr(cell.size), least, static_cast<std::uint32_t>(nodes_.size()), depth, cell});
    std::push_heap(heap.begin(), heap.end());
    nodes_.push_back({b, 0});
  };
  for (unsigned face = 0; face < 6; ++face) open(face_cell(face), 0, k_infinity<S>);
  while (!heap.empty() && nodes_.size() + 4 <= limits.nodes) {
    std::pop_heap(heap.begin(), heap.end());
    const Open worst = heap.back();
    heap.pop_back();
    const S b = nodes_[worst.node].max;
    const bool is_tight = b <= static_cast<S>(limits.ratio) * worst.least;
    if (is_tight || worst.depth >= std::min(limits.depth, 11U) || b <= static_cast<S>(limits.floor) * largest) continue;
    nodes_[worst.node].children = static_cast<std::uint32_t>(nodes_.size());
    for (unsigned i = 0; i < 4; ++i) open(worst.cell.child(i), worst.depth + 1, b);
  }
  take_maxima();
}

template <std::floating_point S>
void CubeMap<S>::take_maxima() noexcept {
  for (std::size_t i = nodes_.size(); i-- > 0;) {
    const std::uint32_t c = nodes_[i].children;
    if (c == 0) continue;
    nodes_[i].max =
        std::max(std::max(nodes_[c].max, nodes_[c + 1].max), std::max(nodes_[c + 2].max, nodes_[c + 3].max));
  }
}

template <std::floating_point S>
void CubeMap<S>::merge(const CubeMap& a, const CubeMap& b, std::uint32_t nodes) {
  nodes_.assign(6, {S(0), 0});
  for (std::uint32_t face = 0; face < 6; ++face) unite(face, a, face, b, face);
  collapse(nodes);
}

/// Node `to` becomes the maximum of two subtrees; a leaf stands for all cells inside it.
template <std::floating_point S>
void CubeMap<S>::unite(std::uint32_t to, const CubeMap& a, std::uint32_t i, const CubeMap& b, std::uint32_t j) {
  const Node x = a.nodes_[i];
  const Node y = b.nodes_[j];
  nodes_[to].max = std::max(x.max, y.max);
  if (x.children == 0 && y.children == 0) return;
  const auto children = static_cast<std::uint32_t>(nodes_.size());
  nodes_[to].children = children;
  nodes_.resize(nodes_.size() + 4);
  for (std::uint32_t k = 0; k < 4; ++k) {
    unite(children + k, a, x.children == 0 ? i : x.children + k, b, y.children == 0 ? j : y.children + k);
  }
}

/// Replaces groups of four leaves by their maximum: those within 25 % of it, then those that add least to the map's
/// integral, until at most `nodes` are left.
template <std::floating_point S>
void CubeMap<S>::collapse(std::size_t nodes) {
  std::size_t count = nodes_.size();
  const auto loss = [&](std::uint32_t i) {  // relative: what the four lose against their maximum
    const std::uint32_t c = nodes_[i].children;
    const S sum = nodes_[c].max + nodes_[c + 1].max + nodes_[c + 2].max + nodes_[c + 3].max;
    const S least =
        std::min(std::min(nodes_[c].max, nodes_[c + 1].max), std::min(nodes_[c + 2].max, nodes_[c + 3].max));
    return std::pair<bool, S>(least >= S(0.75) * nodes_[i].max, S(4) * nodes_[i].max - sum);
  };
  struct Group {
    S cost;
    std::uint32_t node;
    bool operator<(const Group& other) const noexcept {  // heap: cheapest first
      return cost != other.cost ? cost > other.cost : node < other.node;
    }
  };
  std::vector<std::uint32_t> parent(nodes_.size(), 0);
  std::vector<S> area(nodes_.size(), S(1));
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
    for (std::uint32_t k = 0; nodes_[i].children != 0 && k < 4; ++k) {
      parent[nodes_[i].children + k] = i;
      area[nodes_[i].children + k] = area[i] / S(4);
    }
  }
  std::vector<Group> heap;
  const auto offer = [&](std::uint32_t i) {
    const std::uint32_t c = nodes_[i].children;
    if (c == 0) return;
    for (std::uint32_t k = 0; k < 4; ++k) {
      if (nodes_[c + k].children != 0) return;
    }
    const auto [is_close, lost] = loss(i);
    heap.push_back({is_close ? S(0) : lost * area[i], i});
    std::push_heap(heap.begin(), heap.end());
  };
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) offer(i);
  while (!heap.empty() && (count > nodes || !(heap.front().cost > S(0)))) {
    std::pop_heap(heap.begin(), heap.end());
    const std::uint32_t i = heap.back().node;
    heap.pop_back();
    nodes_[i].children = 0;
    count -= 4;
    if (i >= 6) offer(parent[i]);
  }
  // What is left, moved together.
  std::vector<Node> kept(nodes_.begin(), nodes_.begin() + 6);
  for (std::size_t i = 0; i < kept.size(); ++i) {
    const std::uint32_t c = kept[i].children;
    if (c == 0) continue;
    kept[i].children = static_cast<std::uint32_t>(kept.size());
    for (std::uint32_t k = 0; k < 4; ++k) kept.push_back(nodes_[c + k]);
  }
  nodes_ = std::move(kept);
}

template <std::floating_point S>
S CubeMap<S>::sup(const Box<S>& vectors) const noexcept {
  S most = S(0);
  constexpr S k_margin = S(8) * std::numeric_limits<S>::epsilon();
  for (unsigned face = 0; face < 6; ++face) {
    const int axis = static_cast<int>(face / 2);
    // Along the face's axis from `near` to `far`, and only what is in front of the face counts.
    const S far = face % 2 == 0 ? vectors.hi[axis] : -vectors.lo[axis];
    const S near = std::max(S(0), face % 2 == 0 ? vectors.lo[axis] : -vectors.hi[axis]);
    if (far < S(0) || nodes_[face].max <= most) continue;
    // Quotient by the end of [near, far] that makes it largest; -1 and 1 are the face's own ends, so that quotients of
    // 0 by 0 and by 0 need no care beyond their sign.
    const auto quotient = [&](S x, S divisor) {
      return divisor > S(0) ? x / divisor : x > S(0) ? k_infinity<S> : x < S(0) ? -k_infinity<S> : S(0);
    };
    const auto range = [&](int other) {
      const S lo = vectors.lo[other];
      const S hi = vectors.hi[other];
      const S from = quotient(lo, lo >= S(0) ? far : near);
      const S to = quotient(hi, hi >= S(0) ? near : far);
      return std::pair<S, S>(from - k_margin * (S(1) + std::abs(from)), to + k_margin * (S(1) + std::abs(to)));
    };
    const auto [u0, u1] = range((axis + 1) % 3);
    const auto [v0, v1] = range((axis + 2) % 3);
    if (u0 > S(1) || u1 < S(-1) || v0 > S(1) || v1 < S(-1)) continue;
    most = sup_of_face(face, u0, u1, v0, v1, most);
  }
  return most;
}

/// The larger of `known` and the bound over a rectangle of a face.
template <std::floating_point S>
S CubeMap<S>::sup_of_face(unsigned face, S u0, S u1, S v0, S v1, S known) const noexcept {
  struct Visit {
    std::uint32_t node;
    Cell cell;
  };
  std::array<Visit, 3 * 11 + 4> stack;  // three siblings wait per level, plus the four of the last
  std::size_t size = 0;
  stack[size++] = {face, face_cell(face)};
  while (size > 0) {
    const Visit visit = stack[--size];
    const Cell& cell = visit.cell;
    const Node& node = nodes_[visit.node];
    if (node.max <= known || cell.u0 > u1 || cell.u0 + cell.size < u0 || cell.v0 > v1 || cell.v0 + cell.size < v0)
      continue;
    const bool is_inside = u0 <= cell.u0 && cell.u0 + cell.size <= u1 && v0 <= cell.v0 && cell.v0 + cell.size <= v1;
    if (is_inside || node.children == 0) {
      known = node.max;
      continue;
    }
    for (unsigned i = 0; i < 4; ++i) stack[size++] = {node.children + i, cell.child(i)};
  }
  return known;
}

}  // namespace manylight
