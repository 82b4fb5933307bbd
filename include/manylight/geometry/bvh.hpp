// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "manylight/core/box.hpp"
#include "manylight/core/config.hpp"
#include "manylight/core/executor.hpp"
#include "manylight/core/vector.hpp"
#include "manylight/geometry/analytic_shapes.hpp"
#include "manylight/geometry/bvh_build.hpp"
#include "manylight/geometry/bvh_nodes.hpp"
#include "manylight/geometry/concepts.hpp"
#include "manylight/geometry/ray.hpp"
#include "manylight/geometry/shapes.hpp"
#include "manylight/geometry/triangle.hpp"
#include "manylight/geometry/validate.hpp"

namespace manylight {

namespace detail {
/// In which order a ray visits the children of a node.
enum class Order { nearest_first, any };
}  // namespace detail

/// The built-in ray-tracing backend: a wide bounding volume hierarchy, needing nothing but the compiler. A model of
/// `Geometry` for float and double.
///
/// Nodes have as many children as a vector register has lanes (8 floats with AVX, 4 without). Triangles are tested a
/// pack at a time, watertight at shared edges; spheres and disks are analytic. Where two hits have the same t, the one
/// of smaller (shape, primitive) is the closest, so results do not depend on the tree. Zero-area triangles are never
/// hit. About 65 bytes per triangle besides the shapes.
template <std::floating_point S>
class Bvh {
 public:
  using Scalar = S;

  /// Builds over `shapes`, which it keeps. Throws GeometryError if a shape is not valid (see `validate`).
  template <Executor E = SerialExecutor>
  explicit Bvh(Shapes<S> shapes, const E& executor = E{});

  [[nodiscard]] std::optional<Hit<S>> closest_hit(const Ray<S>& ray) const noexcept;
  [[nodiscard]] bool any_hit(const Ray<S>& ray) const noexcept;
  /// `visit(const Hit<S>&)` for every hit, in no particular order.
  template <class Visit>
  void all_hits(const Ray<S>& ray, const Visit& visit) const;
  void any_hit_batch(std::span<const Ray<S>> rays, std::span<std::uint8_t> blocked) const noexcept;

  [[nodiscard]] Box<S> bounds() const noexcept { return bounds_; }
  [[nodiscard]] const Shapes<S>& shapes() const noexcept { return shapes_; }
  /// Bytes of the hierarchy and its packed triangles, without the shapes.
  [[nodiscard]] std::size_t bytes() const noexcept {
    return nodes_.size() * sizeof(Node) + packs_.size() * sizeof(TrianglePack) +
           analytic_.size() * sizeof(std::uint32_t);
  }

 private:
  using Node = detail::WideNode<S>;
  using TrianglePack = detail::TrianglePack<S>;
  using ChildRef = detail::ChildRef;
  using Ref = detail::PrimitiveRef<S>;
  using BinaryNode = detail::BinaryNode<S>;
  using Pack = detail::Pack<S>;

  static constexpr std::size_t k_width = Node::k_width;
  static constexpr std::uint32_t k_max_sah_depth = 64;
  /// Depth of the binary tree, of which each level leaves at most k_width - 1 siblings on the stack.
  static constexpr std::size_t k_stack_size = (k_max_sah_depth + 32) * (k_width - 1) + 1;

  /// What waits on the stack, with where the ray enters it.
  struct Waiting {
    S entry;
    ChildRef child;
  };

  [[nodiscard]] static std::vector<Ref> collect_refs(const Shapes<S>& shapes);
  void collapse(const std::vector<BinaryNode>& binary, const std::vector<Ref>& refs);
  [[nodiscard]] ChildRef make_leaf(const BinaryNode& node, const std::vector<Ref>& refs);
  template <detail::Order order, class Leaf>
  void walk(const Ray<S>& ray, const S& t_max, const Leaf& leaf) const;
  [[nodiscard]] static ChildRef push_all_but_nearest(Waiting nearest, const Node& node, const Pack& entry,
                                                     detail::LaneSet lanes, Waiting* stack, std::size_t& size) noexcept;
  template <class Found>
  void test_leaf(ChildRef leaf, const Ray<S>& ray, const detail::ShearRay<S>& shear, const S& t_max,
                 const Found& found) const;

  Shapes<S> shapes_;
  Box<S> bounds_;
  std::vector<Node> nodes_;
  std::vector<TrianglePack> packs_;
  std::vector<std::uint32_t> analytic_;  ///< shape ids
};

// ---- construction ---------------------------------------------------------------------------

template <std::floating_point S>
template <Executor E>
Bvh<S>::Bvh(Shapes<S> shapes, const E& executor) : shapes_(std::move(shapes)) {
  validate(shapes_);
  std::vector<Ref> refs = collect_refs(shapes_);
  if (refs.empty()) return;
  detail::BvhBuildConfig config;
  config.leaf_lanes = static_cast<std::uint32_t>(TrianglePack::k_width);
  config.max_leaf_size = static_cast<std::uint32_t>(TrianglePack::k_width);
  config.max_sah_depth = k_max_sah_depth;
  const std::vector<BinaryNode> binary = detail::BvhBuilder<S>(config).build(refs, executor);
  bounds_ = binary.front().box;
  collapse(binary, refs);
}

template <std::floating_point S>
auto Bvh<S>::collect_refs(const Shapes<S>& shapes) -> std::vector<Ref> {
  std::vector<Ref> refs;
  for (std::size_t m = 0; m < shapes.meshes.size(); ++m) {
    const TriangleMesh<S>& mesh = shapes.meshes[m];
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const auto [i, j, k] = mesh.triangles[t];
      const Vec3<S>& a = mesh.positions[i];
      const Vec3<S>& b = mesh.positions[j];
      const Vec3<S>& c = mesh.positions[k];
      if (!has_area(a, b, c)) continue;
      refs.push_back({glm::min(glm::min(a, b), c), static_cast<std::uint32_t>(m), glm::max(glm::max(a, b), c),
                      static_cast<std::uint32_t>(t)});
    }
  }
  for (std::size_t id = shapes.meshes.size(); id < shapes.size(); ++id) {
    const auto shape = static_cast<std::uint32_t>(id);
    const Box<S> box = detail::analytic_bounds(shapes, shape);
    refs.push_back({box.lo, shape, box.hi, Ref::k_analytic});
  }
  if (refs.size() > ChildRef::k_max_index) {
    detail::throw_geometry_error("number of triangles is ", refs.size(), ", allowed: at most ", ChildRef::k_max_index);
  }
  return refs;
}

template <std::floating_point S>
auto Bvh<S>::make_leaf(const BinaryNode& node, const std::vector<Ref>& refs) -> ChildRef {
  if (refs[node.child].is_analytic()) {
    const auto first = static_cast<std::uint32_t>(analytic_.size());
    for (std::uint32_t i = 0; i < node.count; ++i) analytic_.push_back(refs[node.child + i].shape);
    return ChildRef::analytic_leaf(first, node.count);
  }
  const auto first = static_cast<std::uint32_t>(packs_.size());
  for (std::uint32_t i = 0; i < node.count; ++i) {
    const std::size_t lane = i % TrianglePack::k_width;
    if (lane == 0) packs_.emplace_back();
    const Ref& ref = refs[node.child + i];
    const TriangleMesh<S>& mesh = shapes_.meshes[ref.shape];
    const auto [a, b, c] = mesh.triangles[ref.primitive];
    packs_.back().set(lane, {mesh.positions[a], mesh.positions[b], mesh.positions[c]}, ref.shape, ref.primitive);
  }
  return ChildRef::triangle_leaf(first, static_cast<std::uint32_t>(packs_.size()) - first);
}

/// Makes wide nodes: a node's children are found by opening, from the binary node's two on, the inner child of largest
/// area until all lanes are taken.
template <std::floating_point S>
void Bvh<S>::collapse(const std::vector<BinaryNode>& binary, const std::vector<Ref>& refs) {
  struct Open {
    std::uint32_t binary;
    std::uint32_t wide;
  };
  nodes_.emplace_back();
  std::vector<Open> open{{0, 0}};
  while (!open.empty()) {
    const Open current = open.back();
    open.pop_back();
    std::array<std::uint32_t, k_width> children{current.binary};
    std::size_t count = 1;
    while (count < k_width) {
      std::size_t largest = count;
      for (std::size_t i = 0; i < count; ++i) {
        const BinaryNode& child = binary[children[i]];
        if (child.is_leaf()) continue;
        if (largest == count || child.box.half_area() > binary[children[largest]].box.half_area()) largest = i;
      }
      if (largest == count) break;
      const std::uint32_t first = binary[children[largest]].child;
      children[largest] = first;
      children[count++] = first + 1;
    }
    for (std::size_t i = 0; i < count; ++i) {
      const BinaryNode& child = binary[children[i]];
      if (child.is_leaf()) {
        nodes_[current.wide].set(i, child.box, make_leaf(child, refs));
      } else {
        const auto wide = static_cast<std::uint32_t>(nodes_.size());
        nodes_.emplace_back();
        nodes_[current.wide].set(i, child.box, ChildRef::inner(wide));
        open.push_back({children[i], wide});
      }
    }
  }
}

// ---- queries --------------------------------------------------------------------------------

/// Visits the leaves that the ray enters before `t_max`, which may shrink meanwhile; `leaf(child)` returns true to
/// stop.
template <std::floating_point S>
template <detail::Order order, class Leaf>
void Bvh<S>::walk(const Ray<S>& ray, const S& t_max, const Leaf& leaf) const {
  // A ray that is not finite would enter every box, unused lanes included.
  if (nodes_.empty() || !detail::is_traceable(ray)) return;
  const detail::SlabRay<S> slabs(ray);
  std::array<Waiting, k_stack_size> stack;
  std::size_t size = 0;
  ChildRef current = ChildRef::inner(0);
  for (;;) {
    if (current.is_leaf()) {
      if (leaf(current)) return;
    } else {
      const Node& node = nodes_[current.node()];
      const detail::SlabHits<S> hits = detail::intersect(node, slabs, detail::broadcast(t_max));
      detail::LaneSet lanes = detail::LaneSet::of<S>(hits.mask);
      if (lanes.any()) {
        const std::uint32_t lane = lanes.pop();
        current = node.children[lane];
        if (!lanes.any()) continue;
        if constexpr (order == detail::Order::any) {
          do stack[size++].child = node.children[lanes.pop()];
          while (lanes.any());
        } else {
          current = push_all_but_nearest({hits.entry[lane], current}, node, hits.entry, lanes, stack.data(), size);
        }
        continue;
      }
    }
    do {
      if (size == 0) return;
      current = stack[--size].child;
    } while (order == detail::Order::nearest_first && stack[size].entry > t_max);
  }
}

/// Of `nearest` and the node's children in `lanes`, returns the one entered first and pushes the others, far ones
/// first.
template <std::floating_point S>
auto Bvh<S>::push_all_but_nearest(Waiting nearest, const Node& node, const Pack& entry, detail::LaneSet lanes,
                                  Waiting* stack, std::size_t& size) noexcept -> ChildRef {
  const std::size_t bottom = size;
  do {
    const std::uint32_t lane = lanes.pop();
    Waiting next{entry[lane], node.children[lane]};
    if (next.entry < nearest.entry) std::swap(next, nearest);
    std::size_t at = size++;
    for (; at > bottom && stack[at - 1].entry < next.entry; --at) stack[at] = stack[at - 1];
    stack[at] = next;
  } while (lanes.any());
  return nearest.child;
}

/// Calls `found(hit)` for each hit in the leaf at or before `t_max`.
template <std::floating_point S>
template <class Found>
void Bvh<S>::test_leaf(ChildRef leaf, const Ray<S>& ray, const detail::ShearRay<S>& shear, const S& t_max,
                       const Found& found) const {
  const std::uint32_t end = leaf.first() + leaf.count();
  if (leaf.is_analytic()) {
    for (std::uint32_t i = leaf.first(); i < end; ++i) {
      const std::uint32_t shape = analytic_[i];
      const Ray<S> clipped{ray.origin, ray.direction, ray.t_min, t_max};
      detail::visit_crossings(shapes_, shape, clipped, [&](S t) { found(Hit<S>{t, shape, 0, S(0), S(0)}); });
    }
    return;
  }
  for (std::uint32_t i = leaf.first(); i < end; ++i) {
    const TrianglePack& pack = packs_[i];
    detail::TriangleHits<S> hits = detail::intersect(pack, shear, detail::broadcast(t_max));
    while (hits.lanes.any()) {
      const std::uint32_t lane = hits.lanes.pop();
      found(Hit<S>{hits.t[lane], pack.shapes[lane], pack.primitives[lane], hits.u[lane], hits.v[lane]});
    }
  }
}

template <std::floating_point S>
std::optional<Hit<S>> Bvh<S>::closest_hit(const Ray<S>& ray) const noexcept {
  const detail::ShearRay<S> shear(ray);
  std::optional<Hit<S>> closest;
  S t_max = ray.t_max;
  walk<detail::Order::nearest_first>(ray, t_max, [&](ChildRef leaf) {
    test_leaf(leaf, ray, shear, t_max, [&](const Hit<S>& hit) {
      const bool wins =
          !closest || hit.t < closest->t ||
          (hit.t == closest->t && std::pair(hit.shape, hit.primitive) < std::pair(closest->shape, closest->primitive));
      if (wins) {
        closest = hit;
        t_max = hit.t;
      }
    });
    return false;
  });
  return closest;
}

template <std::floating_point S>
bool Bvh<S>::any_hit(const Ray<S>& ray) const noexcept {
  const detail::ShearRay<S> shear(ray);
  bool blocked = false;
  walk<detail::Order::any>(ray, ray.t_max, [&](ChildRef leaf) {
    test_leaf(leaf, ray, shear, ray.t_max, [&](const Hit<S>&) { blocked = true; });
    return blocked;
  });
  return blocked;
}

template <std::floating_point S>
template <class Visit>
void Bvh<S>::all_hits(const Ray<S>& ray, const Visit& visit) const {
  const detail::ShearRay<S> shear(ray);
  walk<detail::Order::any>(ray, ray.t_max, [&](ChildRef leaf) {
    test_leaf(leaf, ray, shear, ray.t_max, visit);
    return false;
  });
}

template <std::floating_point S>
void Bvh<S>::any_hit_batch(std::span<const Ray<S>> rays, std::span<std::uint8_t> blocked) const noexcept {
  MANYLIGHT_ASSERT(rays.size() == blocked.size());
  for (std::size_t i = 0; i < rays.size(); ++i) blocked[i] = any_hit(rays[i]) ? 1 : 0;
}

static_assert(Geometry<Bvh<float>> && Geometry<Bvh<double>>);

}  // namespace manylight
