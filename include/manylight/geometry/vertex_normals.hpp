// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "manylight/core/error.hpp"
#include "manylight/core/vector.hpp"
#include "manylight/geometry/shapes.hpp"
#include "manylight/geometry/triangle.hpp"

namespace manylight {

/// Replaces the vertex normals by the mean of the adjacent triangles' normals, each weighted by its angle at the
/// vertex. A vertex of zero-area triangles only gets (0,0,0), which `surface_point` reads as "use the geometric
/// normal". [Thürmer and Wüthrich 1998, "Computing Vertex Normals from Polygonal Facets"]
template <std::floating_point S>
void compute_vertex_normals(TriangleMesh<S>& mesh) {
  std::vector<Vec3<double>> sums(mesh.positions.size(), Vec3<double>(0));
  for (const std::array<std::uint32_t, 3>& corner : mesh.triangles) {
    const std::array<Vec3<double>, 3> p{Vec3<double>(mesh.positions[corner[0]]),
                                        Vec3<double>(mesh.positions[corner[1]]),
                                        Vec3<double>(mesh.positions[corner[2]])};
    const Vec3<double> normal = detail::normalize_or_zero(glm::cross(p[1] - p[0], p[2] - p[0]));
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3<double> a = p[(i + 1) % 3] - p[i];
      const Vec3<double> b = p[(i + 2) % 3] - p[i];
      sums[corner[i]] += normal * std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
    }
  }
  mesh.normals.resize(mesh.positions.size());
  std::transform(sums.begin(), sums.end(), mesh.normals.begin(),
                 [](const Vec3<double>& sum) { return Vec3<S>(detail::normalize_or_zero(sum)); });
}

namespace detail {

/// One corner of a triangle, sortable by the vertex it stands for: position, then uv.
template <std::floating_point S>
struct CornerKey {
  std::array<S, 5> vertex;
  std::uint32_t triangle;
  std::uint32_t corner;
};

template <std::floating_point S>
[[nodiscard]] std::vector<CornerKey<S>> sorted_corners(const TriangleMesh<S>& mesh) {
  std::vector<CornerKey<S>> corners;
  corners.reserve(3 * mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::uint32_t c = 0; c < 3; ++c) {
      const std::uint32_t index = mesh.triangles[t][c];
      const Vec3<S> p = mesh.positions[index] + S(0);  // turns -0 into 0, so that equal positions sort as equal
      const Vec2<S> uv = mesh.uvs.empty() ? Vec2<S>(0) : mesh.uvs[index] + S(0);
      corners.push_back({{p.x, p.y, p.z, uv.x, uv.y}, static_cast<std::uint32_t>(t), c});
    }
  }
  std::sort(corners.begin(), corners.end(), [](const CornerKey<S>& a, const CornerKey<S>& b) {
    if (a.vertex != b.vertex) return a.vertex < b.vertex;
    return a.triangle != b.triangle ? a.triangle < b.triangle : a.corner < b.corner;
  });
  return corners;
}

}  // namespace detail

/// Smooth normals with creases: corners at the same position and uv share a vertex (and so a normal) if their faces'
/// normals differ by less than `max_angle_degrees`; elsewhere the vertex is split. Greedy as Mitsuba's
/// `maxSmoothAngle`: the first face of a cluster decides which others join it. Renumbers the vertices.
template <std::floating_point S>
void compute_smooth_normals(TriangleMesh<S>& mesh, S max_angle_degrees) {
  require(max_angle_degrees >= S(0) && max_angle_degrees <= S(180), "maximum smooth angle", max_angle_degrees,
          "0 to 180 degrees");
  const double cos_threshold = std::cos(double(max_angle_degrees) * k_pi<double> / 180.0);
  std::vector<Vec3<double>> face_normals(mesh.triangles.size());
  std::transform(mesh.triangles.begin(), mesh.triangles.end(), face_normals.begin(),
                 [&mesh](const std::array<std::uint32_t, 3>& t) {
                   return detail::normalize_or_zero(
                       triangle_cross(mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]));
                 });
  const auto corners = detail::sorted_corners(mesh);
  constexpr std::uint32_t k_unset = ~std::uint32_t{0};
  TriangleMesh<S> result;
  result.flip_normals = mesh.flip_normals;
  result.triangles.assign(mesh.triangles.size(), {k_unset, k_unset, k_unset});
  const auto vertex_of = [&result](const detail::CornerKey<S>& corner) -> std::uint32_t& {
    return result.triangles[corner.triangle][corner.corner];
  };
  for (auto begin = corners.begin(); begin != corners.end();) {
    const auto end = std::find_if(begin, corners.end(), [&](const auto& c) { return c.vertex != begin->vertex; });
    for (auto seed = begin; seed != end; ++seed) {
      if (vertex_of(*seed) != k_unset) continue;
      const auto index = static_cast<std::uint32_t>(result.positions.size());
      result.positions.push_back({seed->vertex[0], seed->vertex[1], seed->vertex[2]});
      if (!mesh.uvs.empty()) result.uvs.push_back({seed->vertex[3], seed->vertex[4]});
      const Vec3<double> normal = face_normals[seed->triangle];
      for (auto other = seed; other != end; ++other) {
        const Vec3<double> other_normal = face_normals[other->triangle];
        const bool joins = other == seed || other_normal == normal || glm::dot(normal, other_normal) > cos_threshold;
        if (joins && vertex_of(*other) == k_unset) vertex_of(*other) = index;
      }
    }
    begin = end;
  }
  compute_vertex_normals(result);
  mesh = std::move(result);
}

}  // namespace manylight
