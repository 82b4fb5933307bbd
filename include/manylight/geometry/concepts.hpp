// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstdint>
#include <optional>
#include <span>

#include "manylight/core/box.hpp"
#include "manylight/geometry/ray.hpp"
#include "manylight/geometry/shapes.hpp"

namespace manylight {

namespace detail {
template <class S>
struct AnyHitVisitor {
  void operator()(const Hit<S>&) const {}
};
}  // namespace detail

/// A ray-tracing backend over `Shapes`. Immutable after construction, callable from several threads at once.
///  - `closest_hit(ray)`: the hit of smallest t in [t_min, t_max], or none.
///  - `any_hit(ray)`: whether there is one.
///  - `all_hits(ray, visit)`: calls `visit(hit)` for every hit of the segment, both faces, in any order; a crossing of
///    an edge shared by two triangles of a closed mesh is reported once or twice but never missed.
///  - `any_hit_batch(rays, blocked)`: blocked[i] = any_hit(rays[i]) ? 1 : 0; may use the backend's packet calls.
///  - `bounds()`: box of all shapes. `shapes()`: what it was built from.
template <class G>
concept Geometry = requires(const G& geometry, const Ray<typename G::Scalar>& ray,
                            std::span<const Ray<typename G::Scalar>> rays, std::span<std::uint8_t> blocked,
                            const detail::AnyHitVisitor<typename G::Scalar>& visit) {
  typename G::Scalar;
  { geometry.closest_hit(ray) } -> std::same_as<std::optional<Hit<typename G::Scalar>>>;
  { geometry.any_hit(ray) } -> std::same_as<bool>;
  geometry.all_hits(ray, visit);
  geometry.any_hit_batch(rays, blocked);
  { geometry.bounds() } -> std::same_as<Box<typename G::Scalar>>;
  { geometry.shapes() } -> std::same_as<const Shapes<typename G::Scalar>&>;
};

}  // namespace manylight
