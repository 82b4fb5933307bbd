// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <sstream>
#include <string>
#include <string_view>

#include "manylight/core/error.hpp"
#include "manylight/core/vector.hpp"
#include "manylight/geometry/shapes.hpp"

namespace manylight {

namespace detail {

template <class... Parts>
[[noreturn]] void throw_geometry_error(const Parts&... parts) {
  std::ostringstream out;
  (out << ... << parts);
  throw GeometryError(out.str());
}

}  // namespace detail

/// Throws GeometryError, naming `name` and the element, if the mesh is empty, an index is out of range, a vertex,
/// normal or uv is not finite, or the normals or uvs are not one per vertex. Zero-area triangles are legal: never hit.
template <std::floating_point S>
void validate(const TriangleMesh<S>& mesh, std::string_view name) {
  using detail::throw_geometry_error;
  const std::size_t count = mesh.positions.size();
  if (mesh.triangles.empty()) throw_geometry_error(name, " is an empty mesh: 0 triangles, allowed: at least 1");
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (const std::uint32_t index : mesh.triangles[i]) {
      if (index >= count) {
        throw_geometry_error(name, ", triangle ", i, ": index is ", index, ", allowed: below ", count, " (vertices)");
      }
    }
  }
  if (!mesh.normals.empty() && mesh.normals.size() != count) {
    throw_geometry_error(name, ": number of normals is ", mesh.normals.size(), ", allowed: 0 or ", count);
  }
  if (!mesh.uvs.empty() && mesh.uvs.size() != count) {
    throw_geometry_error(name, ": number of uvs is ", mesh.uvs.size(), ", allowed: 0 or ", count);
  }
  const auto require_finite = [name](bool finite, std::string_view what, std::size_t i) {
    if (!finite) throw_geometry_error(name, ", vertex ", i, ": ", what, " is not finite");
  };
  for (std::size_t i = 0; i < count; ++i) require_finite(is_finite(mesh.positions[i]), "position", i);
  for (std::size_t i = 0; i < mesh.normals.size(); ++i) require_finite(is_finite(mesh.normals[i]), "normal", i);
  for (std::size_t i = 0; i < mesh.uvs.size(); ++i) {
    require_finite(std::isfinite(mesh.uvs[i].x) && std::isfinite(mesh.uvs[i].y), "uv", i);
  }
}

/// Throws GeometryError unless centre and radius are finite and the radius is above 0.
template <std::floating_point S>
void validate(const Sphere<S>& sphere, std::string_view name) {
  if (!is_finite(sphere.center)) detail::throw_geometry_error(name, ": sphere centre is not finite");
  if (!(sphere.radius > S(0)) || !std::isfinite(sphere.radius)) {
    detail::throw_geometry_error(name, ": sphere radius is ", sphere.radius, ", allowed: finite and above 0");
  }
}

/// Throws GeometryError unless centre and radius are finite, the radius above 0, and normal and tangent perpendicular
/// unit vectors.
template <std::floating_point S>
void validate(const Disk<S>& disk, std::string_view name) {
  constexpr S k_tolerance = S(1e-4);  // what single-precision files keep of a unit vector, and some
  if (!is_finite(disk.center)) detail::throw_geometry_error(name, ": disk centre is not finite");
  if (!(disk.radius > S(0)) || !std::isfinite(disk.radius)) {
    detail::throw_geometry_error(name, ": disk radius is ", disk.radius, ", allowed: finite and above 0");
  }
  const S length = glm::length(disk.normal);
  if (!(std::abs(length - S(1)) < k_tolerance)) {
    detail::throw_geometry_error(name, ": length of the disk's normal is ", length, ", allowed: 1");
  }
  if (!(std::abs(glm::length(disk.tangent) - S(1)) < k_tolerance) ||
      !(std::abs(glm::dot(disk.normal, disk.tangent)) < k_tolerance)) {
    detail::throw_geometry_error(name, ": the disk's tangent must be a unit vector perpendicular to its normal");
  }
}

/// Validates every shape, named by kind and index.
template <std::floating_point S>
void validate(const Shapes<S>& shapes) {
  for (std::size_t i = 0; i < shapes.meshes.size(); ++i) validate(shapes.meshes[i], "mesh " + std::to_string(i));
  for (std::size_t i = 0; i < shapes.spheres.size(); ++i) validate(shapes.spheres[i], "sphere " + std::to_string(i));
  for (std::size_t i = 0; i < shapes.disks.size(); ++i) validate(shapes.disks[i], "disk " + std::to_string(i));
}

}  // namespace manylight
