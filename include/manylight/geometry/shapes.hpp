// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "manylight/core/vector.hpp"

namespace manylight {

/// Indexed triangles, world frame. `normals` and `uvs` are per vertex and may be empty.
/// The geometric normal of a triangle (a, b, c) is along cross(b - a, c - a).
template <std::floating_point S>
struct TriangleMesh {
  std::vector<Vec3<S>> positions;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<Vec3<S>> normals;
  std::vector<Vec2<S>> uvs;
  bool flip_normals = false;  ///< turns geometric and shading normals to the other side
};

/// Sphere; outside is away from the centre. uv: azimuth / (2 pi), polar angle from +z / pi.
template <std::floating_point S>
struct Sphere {
  Vec3<S> center{0};
  S radius = S(1);
  bool flip_normals = false;
};

/// Flat disk; outside is along `normal` (unit). uv: (radius, azimuth / (2 pi)).
template <std::floating_point S>
struct Disk {
  Vec3<S> center{0};
  Vec3<S> normal{0, 0, 1};
  Vec3<S> tangent{1, 0, 0};  ///< unit, perpendicular to `normal`: azimuth 0
  S radius = S(1);
};

/// All shapes of a scene. Shape ids count the meshes first, then the spheres, then the disks.
template <std::floating_point S>
struct Shapes {
  std::vector<TriangleMesh<S>> meshes;
  std::vector<Sphere<S>> spheres;
  std::vector<Disk<S>> disks;

  [[nodiscard]] std::size_t size() const noexcept { return meshes.size() + spheres.size() + disks.size(); }
  [[nodiscard]] bool is_mesh(std::uint32_t id) const noexcept { return id < meshes.size(); }
  [[nodiscard]] bool is_sphere(std::uint32_t id) const noexcept {
    return id >= meshes.size() && id < meshes.size() + spheres.size();
  }
  [[nodiscard]] bool is_disk(std::uint32_t id) const noexcept { return id >= meshes.size() + spheres.size(); }
  [[nodiscard]] const Sphere<S>& sphere(std::uint32_t id) const { return spheres[id - meshes.size()]; }
  [[nodiscard]] const Disk<S>& disk(std::uint32_t id) const { return disks[id - meshes.size() - spheres.size()]; }
};

}  // namespace manylight
