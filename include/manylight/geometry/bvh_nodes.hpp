// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "manylight/core/box.hpp"
#include "manylight/core/vector.hpp"
#include "manylight/geometry/offset.hpp"
#include "manylight/geometry/pack.hpp"
#include "manylight/geometry/ray.hpp"

/// The memory that a ray walks through: nodes of as many children as a pack has lanes, and packs of triangles.
namespace manylight::detail {

/// Reference to a child: an inner node, or a leaf of `count` neighbours in one of the leaf arrays.
class ChildRef {
 public:
  /// Uninitialised: arrays of references stand on the stack of every query.
  ChildRef() noexcept = default;
  static constexpr std::uint32_t k_max_count = 8;
  static constexpr std::uint32_t k_max_index = (1u << 27) - 1;

  [[nodiscard]] static ChildRef inner(std::uint32_t node) noexcept { return ChildRef(node); }
  [[nodiscard]] static ChildRef triangle_leaf(std::uint32_t first, std::uint32_t count) noexcept {
    return ChildRef(k_leaf | ((count - 1) << 27) | first);
  }
  [[nodiscard]] static ChildRef analytic_leaf(std::uint32_t first, std::uint32_t count) noexcept {
    return ChildRef(k_leaf | k_analytic | ((count - 1) << 27) | first);
  }
  [[nodiscard]] bool is_leaf() const noexcept { return (bits_ & k_leaf) != 0; }
  [[nodiscard]] bool is_analytic() const noexcept { return (bits_ & k_analytic) != 0; }
  [[nodiscard]] std::uint32_t node() const noexcept { return bits_; }
  [[nodiscard]] std::uint32_t first() const noexcept { return bits_ & k_max_index; }
  [[nodiscard]] std::uint32_t count() const noexcept { return ((bits_ >> 27) & (k_max_count - 1)) + 1; }

 private:
  explicit ChildRef(std::uint32_t bits) noexcept : bits_(bits) {}
  static constexpr std::uint32_t k_leaf = 1u << 31;
  static constexpr std::uint32_t k_analytic = 1u << 30;
  std::uint32_t bits_;
};

/// Bounds of the children, lane by lane; an unused lane is an empty box, which no ray meets.
template <std::floating_point S>
struct alignas(64) WideNode {
  static constexpr std::size_t k_width = k_lanes<S>;
  /// planes[2 axis] are the lower, planes[2 axis + 1] the upper ones.
  std::array<Pack<S>, 6> planes;
  std::array<ChildRef, k_width> children{};

  WideNode() noexcept {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      planes[2 * axis] = broadcast(k_infinity<S>);
      planes[2 * axis + 1] = broadcast(-k_infinity<S>);
    }
  }
  /// Bounds are stored one ulp wider: a ray inside a face of the box, parallel to it, is then not lost.
  void set(std::size_t lane, const Box<S>& box, ChildRef child) noexcept {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto component = static_cast<int>(axis);
      planes[2 * axis][lane] = std::nextafter(box.lo[component], -k_infinity<S>);
      planes[2 * axis + 1][lane] = std::nextafter(box.hi[component], k_infinity<S>);
    }
    children[lane] = child;
  }
};

/// Whether all coordinates are finite, in one comparison.
template <std::floating_point S>
[[nodiscard]] inline bool is_traceable(const Ray<S>& ray) noexcept {
  const Vec3<S> sum = ray.origin + ray.direction;
  const S total = sum.x + sum.y + sum.z;
  return total - total == S(0);
}

/// A ray prepared for slab tests.
template <std::floating_point S>
struct SlabRay {
  std::array<Pack<S>, 3> origin;
  std::array<Pack<S>, 3> inverse_near;
  std::array<Pack<S>, 3> inverse_far;
  std::array<std::size_t, 3> near_plane;  ///< index in WideNode::planes; the far one is near ^ 1
  Pack<S> t_min;

  explicit SlabRay(const Ray<S>& ray) noexcept : t_min(broadcast(ray.t_min)) {
    // Smallest component that counts as one: its inverse times any sensible coordinate stays finite, so that 0 * inf
    // never makes a NaN.
    constexpr S k_tiny = sizeof(S) == 4 ? S(1e-18) : S(1e-150);
    // Slabs are widened by the rounding of subtraction, inverse and product, and once more by what the triangle test
    // itself may be off: a hit it reports is never behind a box it did not enter. [Ize 2013, "Robust BVH Ray
    // Traversal"]
    constexpr S k_slack = rounding_gamma<S>(6);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto component = static_cast<int>(axis);
      const S d = ray.direction[component];
      const S inverse = S(1) / (std::abs(d) < k_tiny ? std::copysign(k_tiny, d) : d);
      origin[axis] = broadcast(ray.origin[component]);
      inverse_near[axis] = broadcast(inverse * (S(1) - k_slack));
      inverse_far[axis] = broadcast(inverse * (S(1) + k_slack));
      near_plane[axis] = 2 * axis + (std::signbit(d) ? 1 : 0);
    }
  }
};

/// Where the ray enters each child of a node, and which children it meets before `t_max`.
template <std::floating_point S>
struct SlabHits {
  Pack<S> entry;
  PackMask<S> mask;
};

template <std::floating_point S>
[[nodiscard]] inline SlabHits<S> intersect(const WideNode<S>& node, const SlabRay<S>& ray,
                                           const Pack<S>& t_max) noexcept {
  std::array<Pack<S>, 3> near;
  std::array<Pack<S>, 3> far;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    near[axis] = (node.planes[ray.near_plane[axis]] - ray.origin[axis]) * ray.inverse_near[axis];
    far[axis] = (node.planes[ray.near_plane[axis] ^ 1] - ray.origin[axis]) * ray.inverse_far[axis];
  }
  const Pack<S> entry = pack_max<S>(pack_max<S>(near[0], near[1]), pack_max<S>(near[2], ray.t_min));
  const Pack<S> exit = pack_min<S>(pack_min<S>(far[0], far[1]), pack_min<S>(far[2], t_max));
  return {entry, entry <= exit};
}

/// As many triangles as a pack has lanes, corner by corner and axis by axis. Unused lanes repeat one point: never hit.
template <std::floating_point S>
struct alignas(64) TrianglePack {
  static constexpr std::size_t k_width = k_lanes<S>;
  std::array<std::array<Pack<S>, 3>, 3> corners{};  ///< [axis][corner]
  std::array<std::uint32_t, k_width> shapes{};
  std::array<std::uint32_t, k_width> primitives{};

  void set(std::size_t lane, const std::array<Vec3<S>, 3>& p, std::uint32_t shape, std::uint32_t primitive) noexcept {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t corner = 0; corner < 3; ++corner)
        corners[axis][corner][lane] = p[corner][static_cast<int>(axis)];
    }
    shapes[lane] = shape;
    primitives[lane] = primitive;
  }
};

/// A ray prepared for triangle tests: the axis along which it runs fastest becomes z, and a shear turns it onto z.
template <std::floating_point S>
struct ShearRay {
  std::array<std::size_t, 3> axis;  ///< world axes that serve as x, y, z
  std::array<Pack<S>, 3> origin;    ///< in that order
  Pack<S> shear_x, shear_y, inverse_z;
  Pack<S> t_min;

  explicit ShearRay(const Ray<S>& ray) noexcept : t_min(broadcast(ray.t_min)) {
    const Vec3<S> d = ray.direction;
    const Vec3<S> size = glm::abs(d);
    const std::size_t z = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
    axis = {(z + 1) % 3, (z + 2) % 3, z};
    const auto component = [&](std::size_t i) { return d[static_cast<int>(axis[i])]; };
    shear_x = broadcast(component(0) / component(2));
    shear_y = broadcast(component(1) / component(2));
    inverse_z = broadcast(S(1) / component(2));
    for (std::size_t i = 0; i < 3; ++i) origin[i] = broadcast(ray.origin[static_cast<int>(axis[i])]);
  }
};

/// The triangles of a pack that a ray meets, with ray parameter and weights of the second and third corner.
template <std::floating_point S>
struct TriangleHits {
  LaneSet lanes;
  Pack<S> t, u, v;
};

/// Watertight at shared edges: the sign of an edge function depends on the edge alone, and an edge belongs to both its
/// triangles. Both faces. [Woop, Benthin and Wald 2013, "Watertight Ray/Triangle Intersection"; inclusive edges make
/// the recomputation in double unnecessary]
template <std::floating_point S>
[[nodiscard]] inline TriangleHits<S> intersect(const TrianglePack<S>& pack, const ShearRay<S>& ray,
                                               const Pack<S>& t_max) noexcept {
  std::array<Pack<S>, 3> x, y, z;
  for (std::size_t corner = 0; corner < 3; ++corner) {
    z[corner] = pack.corners[ray.axis[2]][corner] - ray.origin[2];
    x[corner] = (pack.corners[ray.axis[0]][corner] - ray.origin[0]) - ray.shear_x * z[corner];
    y[corner] = (pack.corners[ray.axis[1]][corner] - ray.origin[1]) - ray.shear_y * z[corner];
  }
  const Pack<S> weight_a = difference_of_products<S>(x[2], y[1], y[2], x[1]);
  const Pack<S> weight_b = difference_of_products<S>(x[0], y[2], y[0], x[2]);
  const Pack<S> weight_c = difference_of_products<S>(x[1], y[0], y[1], x[0]);
  const Pack<S> lowest = pack_min<S>(pack_min<S>(weight_a, weight_b), weight_c);
  const Pack<S> highest = pack_max<S>(pack_max<S>(weight_a, weight_b), weight_c);
  const Pack<S> determinant = weight_a + weight_b + weight_c;
  const Pack<S> zero{};
  const PackMask<S> inside = ((lowest >= zero) | (highest <= zero)) & (determinant != zero);
  if (!LaneSet::of<S>(inside).any()) return {LaneSet::none(), zero, zero, zero};
  const Pack<S> inverse = broadcast(S(1)) / determinant;
  const Pack<S> t = (weight_a * z[0] + weight_b * z[1] + weight_c * z[2]) * inverse * ray.inverse_z;
  const PackMask<S> in_range = (t >= ray.t_min) & (t <= t_max);
  return {LaneSet::of<S>(inside & in_range), t, weight_b * inverse, weight_c * inverse};
}

}  // namespace manylight::detail
