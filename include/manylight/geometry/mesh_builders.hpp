// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <concepts>
#include <cstdint>
#include <utility>

// Everything for making meshes: builders here, and what is done to a mesh before it is rendered.
#include "manylight/core/vector.hpp"
#include "manylight/geometry/shapes.hpp"
#include "manylight/geometry/transform.hpp"
#include "manylight/geometry/validate.hpp"
#include "manylight/geometry/vertex_normals.hpp"

namespace manylight {

namespace detail {

/// Adds the square center + [-1,1] u_axis + [-1,1] v_axis with uv over [0,1]^2 and the given normal.
template <std::floating_point S>
void append_square(TriangleMesh<S>& mesh, const Vec3<S>& center, const Vec3<S>& u_axis, const Vec3<S>& v_axis,
                   const Vec3<S>& normal) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const Vec2<S>& uv : {Vec2<S>(0, 0), Vec2<S>(1, 0), Vec2<S>(1, 1), Vec2<S>(0, 1)}) {
    mesh.positions.push_back(center + u_axis * (S(2) * uv.x - S(1)) + v_axis * (S(2) * uv.y - S(1)));
    mesh.normals.push_back(normal);
    mesh.uvs.push_back(uv);
  }
  // Counter-clockwise seen from the side of the normal.
  if (glm::dot(glm::cross(u_axis, v_axis), normal) > S(0)) {
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.triangles.push_back({first + 2, first + 3, first});
  } else {
    mesh.triangles.push_back({first, first + 2, first + 1});
    mesh.triangles.push_back({first + 2, first, first + 3});
  }
}

}  // namespace detail

/// The square [-1,1]^2 in the plane z = 0 moved by `m`: normal +z, uv = (x + 1, y + 1) / 2.
template <std::floating_point S>
[[nodiscard]] TriangleMesh<S> rectangle_mesh(const Mat4<S>& m = Mat4<S>(S(1))) {
  TriangleMesh<S> mesh;
  detail::append_square<S>(mesh, Vec3<S>(0), {1, 0, 0}, {0, 1, 0}, {0, 0, 1});
  return transform(std::move(mesh), m);
}

/// The cube [-1,1]^3 moved by `m`: each face has its own four vertices, outward normals and uv over [0,1]^2, laid out
/// as Mitsuba's cube.
template <std::floating_point S>
[[nodiscard]] TriangleMesh<S> cube_mesh(const Mat4<S>& m = Mat4<S>(S(1))) {
  struct Face {
    Vec3<S> u_axis, v_axis;
  };
  const std::array<Face, 6> faces{Face{{0, 0, 1}, {1, 0, 0}},  Face{{-1, 0, 0}, {0, 0, -1}},
                                  Face{{0, 1, 0}, {0, 0, -1}}, Face{{0, 1, 0}, {1, 0, 0}},
                                  Face{{0, 1, 0}, {0, 0, 1}},  Face{{0, -1, 0}, {1, 0, 0}}};
  TriangleMesh<S> mesh;
  for (const Face& face : faces) {
    // v runs against the right-handed order of the other two axes.
    const Vec3<S> normal = glm::cross(face.v_axis, face.u_axis);
    detail::append_square<S>(mesh, normal, face.u_axis, face.v_axis, normal);
  }
  return transform(std::move(mesh), m);
}

}  // namespace manylight
