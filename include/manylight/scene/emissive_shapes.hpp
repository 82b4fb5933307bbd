// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "manylight/core/error.hpp"
#include "manylight/core/frame.hpp"
#include "manylight/core/warp.hpp"
#include "manylight/geometry/ray.hpp"
#include "manylight/geometry/shapes.hpp"
#include "manylight/geometry/surface_point.hpp"
#include "manylight/scene/emitter_list.hpp"
#include "manylight/scene/sphere_cone.hpp"

namespace manylight {

/// A point drawn on an emissive primitive.
template <std::floating_point S>
struct EmitterPoint {
  Vec3<S> position;
  S error;  ///< bound of the absolute error of each coordinate, m
  Vec3<S> ng;
  Vec2<S> uv;
};

/// The emissive primitives of a scene in one row: all triangles of emissive meshes, then spheres, then disks. Corners
/// are copied, so that it stands alone and samples without indirection: 40 bytes per triangle in float, 24 more if
/// textured.
template <std::floating_point S>
class EmissiveShapes {
 public:
  EmissiveShapes() = default;

  /// Throws ParameterError for an emitter on a shape that does not exist or emits already, and for a mean radiance that
  /// is negative or not finite.
  EmissiveShapes(const std::vector<AreaEmitter<S>>& emitters, const Shapes<S>& shapes) {
    emitter_of_shape_.assign(shapes.size(), k_none);
    for (const auto& emitter : emitters) register_shape(emitter, shapes);
    for (std::uint32_t shape = 0; shape < shapes.size(); ++shape) {
      if (emitter_of_shape_[shape] == k_none) continue;
      Emitter& emitter = emitters_[emitter_of_shape_[shape]];
      emitter.first = count();
      if (shapes.is_mesh(shape)) {
        add_mesh(emitter, emitter_of_shape_[shape], shapes.meshes[shape]);
      } else if (shapes.is_sphere(shape)) {
        spheres_.push_back({shapes.sphere(shape), emitter_of_shape_[shape]});
      } else {
        disks_.push_back({shapes.disk(shape), emitter_of_shape_[shape]});
      }
    }
    triangles_.shrink_to_fit();
    uvs_.shrink_to_fit();
  }

  [[nodiscard]] std::uint32_t count() const noexcept {
    return static_cast<std::uint32_t>(triangles_.size() + spheres_.size() + disks_.size());
  }
  [[nodiscard]] bool is_emitter(std::uint32_t shape) const noexcept {
    return shape < emitter_of_shape_.size() && emitter_of_shape_[shape] != k_none;
  }
  /// Primitive that holds a surface point of an emissive shape.
  [[nodiscard]] std::uint32_t primitive_of(const SurfacePoint<S>& p) const noexcept {
    return emitters_[emitter_of_shape_[p.shape]].first + p.primitive;
  }
  [[nodiscard]] std::uint32_t shape_of(std::uint32_t primitive) const noexcept { return emitter(primitive).shape; }
  /// Index of the primitive within its shape.
  [[nodiscard]] std::uint32_t index_in_shape(std::uint32_t primitive) const noexcept {
    return primitive - emitter(primitive).first;
  }
  [[nodiscard]] bool two_sided(std::uint32_t primitive) const noexcept { return emitter(primitive).two_sided; }

  /// Radiance leaving a surface point towards the unit vector `wo`, W m^-2 sr^-1; 0 for shapes that do not emit and on
  /// the inner side of one-sided emitters.
  [[nodiscard]] Rgb<S> emitted(const SurfacePoint<S>& p, const Vec3<S>& wo) const noexcept {
    if (!is_emitter(p.shape)) return Rgb<S>(0);
    const Emitter& emitter = emitters_[emitter_of_shape_[p.shape]];
    return emits_towards(emitter.two_sided, glm::dot(p.ng, wo)) ? emitter.radiance.eval(p.uv) : Rgb<S>(0);
  }
  [[nodiscard]] static bool emits_towards(bool two_sided, S cosine) noexcept {
    return cosine > S(0) || (two_sided && cosine < S(0));
  }
  [[nodiscard]] Rgb<S> radiance(std::uint32_t primitive, const Vec2<S>& uv) const noexcept {
    return emitter(primitive).radiance.eval(uv);
  }

  [[nodiscard]] S area(std::uint32_t primitive) const noexcept {
    if (primitive < triangles_.size()) {
      const auto& p = triangles_[primitive].corners;
      return static_cast<S>(glm::length(triangle_cross(p[0], p[1], p[2])) / 2);
    }
    if (primitive < first_disk()) return S(4) * k_pi<S> * sqr(sphere(primitive).radius);
    return k_pi<S> * sqr(disk(primitive).radius);
  }

  /// Flux, W. Of a textured primitive the mean of a fixed set of points, mixed with the texture's own mean so that it
  /// cannot vanish where the texture is not black.
  [[nodiscard]] Rgb<S> flux(std::uint32_t primitive) const noexcept {
    const Emitter& e = emitter(primitive);
    return (e.two_sided ? S(2) : S(1)) * k_pi<S> * area(primitive) * mean_radiance(primitive);
  }

  /// A point uniform in area.
  [[nodiscard]] EmitterPoint<S> sample_area(std::uint32_t primitive, const Vec2<S>& u) const noexcept {
    if (primitive < triangles_.size()) return triangle_point(primitive, warp::square_to_triangle(u));
    if (primitive < first_disk()) return sphere_point(sphere(primitive), warp::square_to_sphere(u));
    return disk_point(disk(primitive), warp::square_to_disk(u));
  }

  /// The cone in which a sphere is seen from outside; none for other primitives, from inside, and for spheres that emit
  /// inwards only: a receiver on the wall of such a sphere may lie outside it by rounding and must see all of it.
  [[nodiscard]] std::optional<SphereCone<S>> cone(std::uint32_t primitive, const Vec3<S>& reference) const noexcept {
    if (primitive < triangles_.size() || primitive >= first_disk()) return std::nullopt;
    const Sphere<S>& s = sphere(primitive);
    if (s.flip_normals && !emitter(primitive).two_sided) return std::nullopt;
    return SphereCone<S>::seen_from(reference, s.center, s.radius);
  }
  /// The point of a sphere with the given unit outward normal.
  [[nodiscard]] EmitterPoint<S> point_on_sphere(std::uint32_t primitive, const Vec3<S>& outward) const noexcept {
    return sphere_point(sphere(primitive), outward);
  }

  /// Memory of the primitives, bytes.
  [[nodiscard]] std::size_t bytes() const noexcept {
    return triangles_.capacity() * sizeof(Triangle) + uvs_.capacity() * sizeof(std::array<Vec2<S>, 3>) +
           spheres_.capacity() * sizeof(EmissiveSphere) + disks_.capacity() * sizeof(EmissiveDisk) +
           emitters_.capacity() * sizeof(Emitter) + emitter_of_shape_.capacity() * sizeof(std::uint32_t);
  }

 private:
  static constexpr std::uint32_t k_none = 0xFFFFFFFFu;

  struct Emitter {
    Texture<S> radiance;
    std::uint32_t shape;
    std::uint32_t first;     ///< its first primitive
    std::uint32_t first_uv;  ///< its first entry of uvs_, k_none: no uv needed or known
    bool two_sided;
  };
  /// Corners are ordered so that the outer side is along cross(b - a, c - a), flipped meshes included.
  struct Triangle {
    std::array<Vec3<S>, 3> corners;
    std::uint32_t emitter;
  };
  struct EmissiveSphere {
    Sphere<S> sphere;
    std::uint32_t emitter;
  };
  struct EmissiveDisk {
    Disk<S> disk;
    std::uint32_t emitter;
  };

  void register_shape(const AreaEmitter<S>& emitter, const Shapes<S>& shapes) {
    require(emitter.shape < shapes.size(), "shape of an area emitter", emitter.shape, "an existing shape id");
    const std::string name = "area emitter on shape " + std::to_string(emitter.shape);
    require(emitter_of_shape_[emitter.shape] == k_none, name, "given twice", "one emitter per shape");
    const Rgb<S> mean = emitter.radiance.mean();
    require(is_valid_radiance(mean), "mean radiance of " + name, std::min(mean.x, std::min(mean.y, mean.z)),
            "0 or positive, finite");
    emitter_of_shape_[emitter.shape] = static_cast<std::uint32_t>(emitters_.size());
    emitters_.push_back({emitter.radiance, emitter.shape, 0, k_none, emitter.two_sided});
  }

  void add_mesh(Emitter& emitter, std::uint32_t id, const TriangleMesh<S>& mesh) {
    const bool with_uv = !emitter.radiance.is_constant() && !mesh.uvs.empty();
    if (with_uv) emitter.first_uv = static_cast<std::uint32_t>(uvs_.size());
    for (auto triangle : mesh.triangles) {
      if (faces_away(mesh, triangle)) std::swap(triangle[1], triangle[2]);
      const auto [a, b, c] = triangle;
      triangles_.push_back({{mesh.positions[a], mesh.positions[b], mesh.positions[c]}, id});
      if (with_uv) uvs_.push_back({mesh.uvs[a], mesh.uvs[b], mesh.uvs[c]});
    }
  }

  /// Whether a triangle's outer side is against its winding: vertex normals outvote the winding, as in surface_point.
  [[nodiscard]] static bool faces_away(const TriangleMesh<S>& mesh, const std::array<std::uint32_t, 3>& t) noexcept {
    bool away = mesh.flip_normals;
    if (!mesh.normals.empty()) {
      const Vec3<double> normal = triangle_cross(mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]);
      const Vec3<double> shading(mesh.normals[t[0]] + mesh.normals[t[1]] + mesh.normals[t[2]]);
      if (glm::dot(normal, shading) < 0) away = !away;
    }
    return away;
  }

  [[nodiscard]] std::size_t first_disk() const noexcept { return triangles_.size() + spheres_.size(); }
  [[nodiscard]] const Sphere<S>& sphere(std::uint32_t i) const noexcept {
    return spheres_[i - triangles_.size()].sphere;
  }
  [[nodiscard]] const Disk<S>& disk(std::uint32_t i) const noexcept { return disks_[i - first_disk()].disk; }
  [[nodiscard]] const Emitter& emitter(std::uint32_t i) const noexcept {
    if (i < triangles_.size()) return emitters_[triangles_[i].emitter];
    if (i < first_disk()) return emitters_[spheres_[i - triangles_.size()].emitter];
    return emitters_[disks_[i - first_disk()].emitter];
  }

  [[nodiscard]] Rgb<S> mean_radiance(std::uint32_t primitive) const noexcept {
    const Emitter& e = emitter(primitive);
    const Rgb<S> overall = e.radiance.mean();
    if (e.radiance.is_constant()) return overall;
    constexpr int k_side = 4;
    Rgb<S> sum(0);
    for (int i = 0; i < k_side * k_side; ++i) {
      const Vec2<S> u{(static_cast<S>(i % k_side) + S(0.5)) / k_side, (static_cast<S>(i / k_side) + S(0.5)) / k_side};
      sum += e.radiance.eval(sample_area(primitive, u).uv);
    }
    return sum * (S(0.9) / (k_side * k_side)) + overall * S(0.1);
  }

  [[nodiscard]] EmitterPoint<S> triangle_point(std::uint32_t i, const Vec2<S>& b) const noexcept {
    const auto& p = triangles_[i].corners;
    const S b0 = S(1) - b.x - b.y;
    const Emitter& e = emitters_[triangles_[i].emitter];
    Vec2<S> uv = b;
    if (e.first_uv != k_none) {
      const auto& t = uvs_[e.first_uv + (i - e.first)];
      uv = t[0] * b0 + t[1] * b.x + t[2] * b.y;
    }
    const Vec3<S> sum = glm::abs(p[0] * b0) + glm::abs(p[1] * b.x) + glm::abs(p[2] * b.y);
    return {p[0] * b0 + p[1] * b.x + p[2] * b.y, surface_error(sum, glm::abs(p[1] - p[0]) + glm::abs(p[2] - p[0])),
            Vec3<S>(glm::normalize(triangle_cross(p[0], p[1], p[2]))), uv};
  }
  [[nodiscard]] static EmitterPoint<S> sphere_point(const Sphere<S>& s, const Vec3<S>& outward) noexcept {
    const S polar = std::acos(std::clamp(outward.z, S(-1), S(1))) * k_inv_pi<S>;
    return {s.center + outward * s.radius,
            surface_error(glm::abs(s.center) + s.radius, Vec3<S>(s.radius)),
            s.flip_normals ? -outward : outward,
            {detail::azimuth_fraction(outward.y, outward.x), polar}};
  }
  [[nodiscard]] static EmitterPoint<S> disk_point(const Disk<S>& d, const Vec2<S>& p) noexcept {
    const Vec3<S> bitangent = glm::cross(d.normal, d.tangent);
    return {d.center + (d.tangent * p.x + bitangent * p.y) * d.radius,
            surface_error(glm::abs(d.center) + d.radius, Vec3<S>(d.radius)),
            d.normal,
            {std::min(glm::length(p), S(1)), detail::azimuth_fraction(p.y, p.x)}};
  }
  /// Of a point interpolated from numbers of that magnitude on a shape of that extent; as in surface_point.
  [[nodiscard]] static S surface_error(const Vec3<S>& magnitude, const Vec3<S>& extent) noexcept {
    return rounding_gamma<S>(8) * detail::max_abs(magnitude) + detail::backend_error(detail::max_abs(extent));
  }

  std::vector<Emitter> emitters_;
  std::vector<std::uint32_t> emitter_of_shape_;
  std::vector<Triangle> triangles_;
  std::vector<std::array<Vec2<S>, 3>> uvs_;
  std::vector<EmissiveSphere> spheres_;
  std::vector<EmissiveDisk> disks_;
};

}  // namespace manylight
