// SPDX-License-Identifier: Apache-2.0
#pragma once

// Bridge to Embree: include it only where Embree is installed and linked. Tested with 3.13.5; the branches for Embree 4
// are written by its documentation and were type-checked against its declarations, but never run. Where both are
// installed, 3 is taken.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "manylight/core/config.hpp"
#include "manylight/geometry/concepts.hpp"
#include "manylight/geometry/embree_scene.hpp"

namespace manylight {

/// Ray tracing by Embree, in float: a model of `Geometry`. Meshes are native and traced in the robust mode; spheres and
/// disks are user geometry with the code that `Bvh` uses. `any_hit_batch` traces streams (Embree 3) or packets
/// of 16 (Embree 4, which has no streams).
class EmbreeGeometry {
 public:
  using Scalar = float;

  /// Builds over `shapes`, which it keeps. Throws GeometryError if a shape is not valid (see `validate`), EmbreeError
  /// if Embree fails. Embree builds with its own threads.
  explicit EmbreeGeometry(Shapes<float> shapes) : scene_(std::move(shapes)) {}

  [[nodiscard]] std::optional<Hit<float>> closest_hit(const Ray<float>& ray) const noexcept;
  [[nodiscard]] bool any_hit(const Ray<float>& ray) const noexcept;
  /// `visit(const Hit<float>&)` for every hit, in no particular order. Allocates when there is one.
  template <class Visit>
  void all_hits(const Ray<float>& ray, const Visit& visit) const;
  void any_hit_batch(std::span<const Ray<float>> rays, std::span<std::uint8_t> blocked) const noexcept;

  [[nodiscard]] Box<float> bounds() const noexcept { return scene_.bounds(); }
  [[nodiscard]] const Shapes<float>& shapes() const noexcept { return scene_.model().shapes; }

 private:
  using Query = detail::EmbreeQuery;

  [[nodiscard]] Query make_query(std::vector<Hit<float>>* hits = nullptr) const noexcept;
  [[nodiscard]] static RTCRay to_embree(const Ray<float>& ray) noexcept;
  void intersect(RTCRayHit& ray, Query& query) const noexcept;

  detail::EmbreeScene scene_;
};

inline auto EmbreeGeometry::make_query(std::vector<Hit<float>>* hits) const noexcept -> Query {
  Query query;
#if RTC_VERSION_MAJOR >= 4
  rtcInitRayQueryContext(&query.context);
#else
  rtcInitIntersectContext(&query.context);
  if (hits != nullptr) query.context.filter = &detail::embree_store_and_reject;
#endif
  query.model = &scene_.model();
  query.hits = hits;
  return query;
}

inline RTCRay EmbreeGeometry::to_embree(const Ray<float>& ray) noexcept {
  RTCRay out;
  out.org_x = ray.origin.x;
  out.org_y = ray.origin.y;
  out.org_z = ray.origin.z;
  out.tnear = ray.t_min;
  out.dir_x = ray.direction.x;
  out.dir_y = ray.direction.y;
  out.dir_z = ray.direction.z;
  out.time = 0.0f;
  out.tfar = ray.t_max;
  out.mask = ~0u;
  out.id = 0;
  out.flags = 0;
  return out;
}

inline void EmbreeGeometry::intersect(RTCRayHit& ray, Query& query) const noexcept {
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.context = &query.context;
  if (query.hits != nullptr) {
    arguments.filter = &detail::embree_store_and_reject;
    arguments.flags = RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER;
  }
  rtcIntersect1(scene_.handle(), &ray, &arguments);
#else
  rtcIntersect1(scene_.handle(), &query.context, &ray);
#endif
}

inline std::optional<Hit<float>> EmbreeGeometry::closest_hit(const Ray<float>& ray) const noexcept {
  Query query = make_query();
  RTCRayHit found;
  found.ray = to_embree(ray);
  intersect(found, query);
  if (found.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  return scene_.model().to_hit(found.ray.tfar, found.hit.geomID, found.hit.primID, found.hit.u, found.hit.v);
}

inline bool EmbreeGeometry::any_hit(const Ray<float>& ray) const noexcept {
  Query query = make_query();
  RTCRay embree_ray = to_embree(ray);
#if RTC_VERSION_MAJOR >= 4
  RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  arguments.context = &query.context;
  rtcOccluded1(scene_.handle(), &embree_ray, &arguments);
#else
  rtcOccluded1(scene_.handle(), &query.context, &embree_ray);
#endif
  return embree_ray.tfar < embree_ray.tnear;
}

template <class Visit>
void EmbreeGeometry::all_hits(const Ray<float>& ray, const Visit& visit) const {
  std::vector<Hit<float>> hits;
  Query query = make_query(&hits);
  RTCRayHit found;
  found.ray = to_embree(ray);
  intersect(found, query);
  // Visited here and not in Embree's callback, through which an exception could not pass.
  for (const Hit<float>& hit : hits) visit(hit);
}

#if RTC_VERSION_MAJOR >= 4
inline void EmbreeGeometry::any_hit_batch(std::span<const Ray<float>> rays,
                                          std::span<std::uint8_t> blocked) const noexcept {
  MANYLIGHT_ASSERT(rays.size() == blocked.size());
  constexpr std::size_t k_packet = 16;
  Query query = make_query();
  RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  arguments.context = &query.context;
  for (std::size_t begin = 0; begin < rays.size(); begin += k_packet) {
    const std::size_t count = std::min(k_packet, rays.size() - begin);
    RTCRay16 packet{};
    alignas(64) std::array<int, k_packet> valid{};
    for (std::size_t i = 0; i < count; ++i) {
      const Ray<float>& ray = rays[begin + i];
      valid[i] = -1;
      packet.org_x[i] = ray.origin.x;
      packet.org_y[i] = ray.origin.y;
      packet.org_z[i] = ray.origin.z;
      packet.dir_x[i] = ray.direction.x;
      packet.dir_y[i] = ray.direction.y;
      packet.dir_z[i] = ray.direction.z;
      packet.tnear[i] = ray.t_min;
      packet.tfar[i] = ray.t_max;
      packet.mask[i] = ~0u;
    }
    rtcOccluded16(valid.data(), scene_.handle(), &packet, &arguments);
    for (std::size_t i = 0; i < count; ++i) blocked[begin + i] = packet.tfar[i] < packet.tnear[i] ? 1 : 0;
  }
}
#else
inline void EmbreeGeometry::any_hit_batch(std::span<const Ray<float>> rays,
                                          std::span<std::uint8_t> blocked) const noexcept {
  MANYLIGHT_ASSERT(rays.size() == blocked.size());
  // A stream that fits the first-level cache. Incoherent rays, living room and Sponza: 1.3 to 1.4 times the rate of
  // single rays; packets of 16 reach 1.2 to 1.3.
  constexpr std::size_t k_stream = 256;
  std::array<RTCRay, k_stream> stream;
  Query query = make_query();
  for (std::size_t begin = 0; begin < rays.size(); begin += k_stream) {
    const std::size_t count = std::min(k_stream, rays.size() - begin);
    for (std::size_t i = 0; i < count; ++i) stream[i] = to_embree(rays[begin + i]);
    rtcOccluded1M(scene_.handle(), &query.context, stream.data(), static_cast<unsigned>(count), sizeof(RTCRay));
    for (std::size_t i = 0; i < count; ++i) blocked[begin + i] = stream[i].tfar < stream[i].tnear ? 1 : 0;
  }
}
#endif

static_assert(Geometry<EmbreeGeometry>);

}  // namespace manylight
