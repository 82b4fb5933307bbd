// SPDX-License-Identifier: Apache-2.0
#pragma once

// Shapes as Embree has them; embree.hpp is what users include.

#if __has_include(<embree3/rtcore.h>)
#include <embree3/rtcore.h>
#else
#include <embree4/rtcore.h>
#endif

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "manylight/core/box.hpp"
#include "manylight/core/error.hpp"
#include "manylight/core/vector.hpp"
#include "manylight/geometry/analytic_shapes.hpp"
#include "manylight/geometry/ray.hpp"
#include "manylight/geometry/shapes.hpp"
#include "manylight/geometry/triangle.hpp"
#include "manylight/geometry/validate.hpp"

namespace manylight {

/// Embree could not make a device or a scene: unsupported processor, no memory.
class EmbreeError : public Error {
 public:
  using Error::Error;
};

namespace detail {

/// What Embree's ids stand for.
struct EmbreeModel {
  Shapes<float> shapes;
  /// Per mesh: Embree's primitive -> triangle; empty where they are the same (no zero-area triangle left out).
  std::vector<std::vector<std::uint32_t>> triangle_of;

  [[nodiscard]] Hit<float> to_hit(float t, unsigned geometry, unsigned primitive, float u, float v) const noexcept {
    if (geometry == shapes.meshes.size()) return {t, geometry + primitive, 0, 0.0f, 0.0f};
    const std::vector<std::uint32_t>& of_mesh = triangle_of[geometry];
    return {t, geometry, of_mesh.empty() ? primitive : of_mesh[primitive], u, v};
  }
};

/// A query, its context first: Embree hands that through to the callbacks. With `hits` set, they store every hit and accept
/// none.
struct EmbreeQuery {
#if RTC_VERSION_MAJOR >= 4
  RTCRayQueryContext context;
#else
  RTCIntersectContext context;
#endif
  const EmbreeModel* model;
  std::vector<Hit<float>>* hits;
};
static_assert(std::is_standard_layout_v<EmbreeQuery>);

// ---- callbacks ------------------------------------------------------------------------------

inline void embree_bounds(const RTCBoundsFunctionArguments* arguments) {
  const Shapes<float>& shapes = static_cast<const EmbreeModel*>(arguments->geometryUserPtr)->shapes;
  const auto shape = static_cast<std::uint32_t>(shapes.meshes.size()) + arguments->primID;
  const Box<float> box = analytic_bounds(shapes, shape);
  RTCBounds& out = *arguments->bounds_o;
  out.lower_x = box.lo.x;
  out.lower_y = box.lo.y;
  out.lower_z = box.lo.z;
  out.upper_x = box.hi.x;
  out.upper_y = box.hi.y;
  out.upper_z = box.hi.z;
}

/// One ray of Embree's packet of n.
[[nodiscard]] inline Ray<float> ray_of_packet(RTCRayN* rays, unsigned n, unsigned i) noexcept {
  return {{RTCRayN_org_x(rays, n, i), RTCRayN_org_y(rays, n, i), RTCRayN_org_z(rays, n, i)},
          {RTCRayN_dir_x(rays, n, i), RTCRayN_dir_y(rays, n, i), RTCRayN_dir_z(rays, n, i)},
          RTCRayN_tnear(rays, n, i),
          RTCRayN_tfar(rays, n, i)};
}

inline void embree_intersect(const RTCIntersectFunctionNArguments* arguments) {
  const Shapes<float>& shapes = static_cast<const EmbreeModel*>(arguments->geometryUserPtr)->shapes;
  const auto shape = static_cast<std::uint32_t>(shapes.meshes.size()) + arguments->primID;
  const EmbreeQuery& query = *reinterpret_cast<const EmbreeQuery*>(arguments->context);
  const unsigned n = arguments->N;
  RTCRayN* rays = RTCRayHitN_RayN(arguments->rayhit, n);
  RTCHitN* hits = RTCRayHitN_HitN(arguments->rayhit, n);
  for (unsigned i = 0; i < n; ++i) {
    if (arguments->valid[i] == 0) continue;
    visit_crossings(shapes, shape, ray_of_packet(rays, n, i), [&](float t) {
      if (query.hits != nullptr) {
        query.hits->push_back({t, shape, 0, 0.0f, 0.0f});
      } else if (t <= RTCRayN_tfar(rays, n, i)) {
        RTCRayN_tfar(rays, n, i) = t;
        RTCHitN_geomID(hits, n, i) = arguments->geomID;
        RTCHitN_primID(hits, n, i) = arguments->primID;
        RTCHitN_u(hits, n, i) = 0.0f;
        RTCHitN_v(hits, n, i) = 0.0f;
      }
    });
  }
}

inline void embree_occluded(const RTCOccludedFunctionNArguments* arguments) {
  const Shapes<float>& shapes = static_cast<const EmbreeModel*>(arguments->geometryUserPtr)->shapes;
  const auto shape = static_cast<std::uint32_t>(shapes.meshes.size()) + arguments->primID;
  const unsigned n = arguments->N;
  for (unsigned i = 0; i < n; ++i) {
    if (arguments->valid[i] == 0) continue;
    visit_crossings(shapes, shape, ray_of_packet(arguments->ray, n, i), [&](float) {
      RTCRayN_tfar(arguments->ray, n, i) = -std::numeric_limits<float>::infinity();
    });
  }
}

/// A filter: with it a closest-hit query meets every triangle and returns none.
inline void embree_store_and_reject(const RTCFilterFunctionNArguments* arguments) {
  const EmbreeQuery& query = *reinterpret_cast<const EmbreeQuery*>(arguments->context);
  const unsigned n = arguments->N;
  for (unsigned i = 0; i < n; ++i) {
    if (arguments->valid[i] == 0) continue;
    arguments->valid[i] = 0;
    query.hits->push_back(query.model->to_hit(RTCRayN_tfar(arguments->ray, n, i), RTCHitN_geomID(arguments->hit, n, i),
                                              RTCHitN_primID(arguments->hit, n, i), RTCHitN_u(arguments->hit, n, i),
                                              RTCHitN_v(arguments->hit, n, i)));
  }
}

// ---- construction ---------------------------------------------------------------------------

/// Shapes, which it keeps, built by a device of its own. Movable.
class EmbreeScene {
 public:
  /// Throws GeometryError, EmbreeError.
  explicit EmbreeScene(Shapes<float> shapes);

  [[nodiscard]] RTCScene handle() const noexcept { return scene_.get(); }
  [[nodiscard]] const EmbreeModel& model() const noexcept { return *model_; }
  [[nodiscard]] const Box<float>& bounds() const noexcept { return bounds_; }

 private:
  struct DeviceDeleter {
    void operator()(RTCDevice device) const noexcept { rtcReleaseDevice(device); }
  };
  struct SceneDeleter {
    void operator()(RTCScene scene) const noexcept { rtcReleaseScene(scene); }
  };

  void add_mesh(std::uint32_t id);
  void add_analytic_shapes();
  void check() const;

  std::unique_ptr<EmbreeModel> model_;  ///< on the heap: callbacks hold its address while the object may be moved
  std::unique_ptr<std::remove_pointer_t<RTCDevice>, DeviceDeleter> device_;
  std::unique_ptr<std::remove_pointer_t<RTCScene>, SceneDeleter> scene_;
  Box<float> bounds_;
};

inline EmbreeScene::EmbreeScene(Shapes<float> shapes) : model_(std::make_unique<EmbreeModel>()) {
  validate(shapes);
  model_->shapes = std::move(shapes);
  device_.reset(rtcNewDevice(nullptr));
  if (!device_) {
    throw EmbreeError("Embree made no device, error " + std::to_string(static_cast<int>(rtcGetDeviceError(nullptr))));
  }
  scene_.reset(rtcNewScene(device_.get()));
  check();
#if RTC_VERSION_MAJOR >= 4
  rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS);
#else
  rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
#endif
  model_->triangle_of.resize(model_->shapes.meshes.size());
  for (std::size_t id = 0; id < model_->shapes.meshes.size(); ++id) add_mesh(static_cast<std::uint32_t>(id));
  add_analytic_shapes();
  rtcCommitScene(scene_.get());
  check();
  RTCBounds box;
  rtcGetSceneBounds(scene_.get(), &box);
  bounds_ = {{box.lower_x, box.lower_y, box.lower_z}, {box.upper_x, box.upper_y, box.upper_z}};
}

inline void EmbreeScene::check() const {
  const RTCError error = rtcGetDeviceError(device_.get());
  if (error != RTC_ERROR_NONE) throw EmbreeError("Embree failed with error " + std::to_string(static_cast<int>(error)));
}

inline void EmbreeScene::add_mesh(std::uint32_t id) {
  const TriangleMesh<float>& mesh = model_->shapes.meshes[id];
  std::vector<std::uint32_t>& triangle_of = model_->triangle_of[id];
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto [a, b, c] = mesh.triangles[t];
    if (has_area(mesh.positions[a], mesh.positions[b], mesh.positions[c])) triangle_of.push_back(t);
  }
  if (triangle_of.empty()) return;
  const RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
  // Embree's own buffers: it reads 16 bytes per vertex, past the end of an array of 12-byte ones.
  void* vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Vec3<float>),
                                           mesh.positions.size());
  void* indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                          sizeof(std::array<std::uint32_t, 3>), triangle_of.size());
  check();
  std::copy(mesh.positions.begin(), mesh.positions.end(), static_cast<Vec3<float>*>(vertices));
  std::transform(triangle_of.begin(), triangle_of.end(), static_cast<std::array<std::uint32_t, 3>*>(indices),
                 [&mesh](std::uint32_t t) { return mesh.triangles[t]; });
  if (triangle_of.size() == mesh.triangles.size()) triangle_of = {};
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene_.get(), geometry, id);
  rtcReleaseGeometry(geometry);
  check();
}

/// All spheres and disks are one geometry, its id behind the meshes': shape id = geometry + primitive.
inline void EmbreeScene::add_analytic_shapes() {
  const Shapes<float>& shapes = model_->shapes;
  if (shapes.spheres.empty() && shapes.disks.empty()) return;
  const RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(shapes.spheres.size() + shapes.disks.size()));
  rtcSetGeometryUserData(geometry, model_.get());
  rtcSetGeometryBoundsFunction(geometry, &embree_bounds, nullptr);
  rtcSetGeometryIntersectFunction(geometry, &embree_intersect);
  rtcSetGeometryOccludedFunction(geometry, &embree_occluded);
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene_.get(), geometry, static_cast<unsigned>(shapes.meshes.size()));
  rtcReleaseGeometry(geometry);
  check();
}

}  // namespace detail
}  // namespace manylight
