// SPDX-License-Identifier: Apache-2.0
#pragma once

// Small scenes shared by tests, in any scalar, material and geometry backend. Each returns shapes and emitters;
// `compose` turns them into a Scene with one uniform shader per shape.

#include <cstdint>
#include <utility>
#include <vector>

#include "manylight/geometry/bvh.hpp"
#include "manylight/geometry/mesh_builders.hpp"
#include "manylight/scene/scene.hpp"

namespace manylight::test {

template <std::floating_point S>
struct SceneParts {
  Shapes<S> shapes;
  EmitterList<S> emitters;
};

/// Shapes by pieces. Meshes come first in the ids: add them before spheres.
template <std::floating_point S>
struct PartsBuilder {
  SceneParts<S> parts;

  /// The parallelogram center + [-1,1] u + [-1,1] v, geometric normal along cross(u, v); returns its shape id.
  std::uint32_t rectangle(const Vec3<S>& center, const Vec3<S>& u, const Vec3<S>& v) {
    TriangleMesh<S> mesh;
    mesh.positions = {center - u - v, center + u - v, center + u + v, center - u + v};
    mesh.triangles = {{0, 1, 2}, {2, 3, 0}};
    mesh.uvs = {Vec2<S>(0, 0), Vec2<S>(1, 0), Vec2<S>(1, 1), Vec2<S>(0, 1)};
    parts.shapes.meshes.push_back(std::move(mesh));
    return static_cast<std::uint32_t>(parts.shapes.meshes.size() - 1);
  }
  /// Shading normals of mesh `shape`, the same at all corners up to a turn about `axis` that differs by corner.
  void bend(std::uint32_t shape, const Vec3<S>& normal, const Vec3<S>& sideways) {
    TriangleMesh<S>& mesh = parts.shapes.meshes[shape];
    mesh.normals.clear();
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
      const S sign = i % 2 == 0 ? S(1) : S(-0.5);
      mesh.normals.push_back(glm::normalize(normal + sideways * sign));
    }
  }
  void emit(std::uint32_t shape, const Rgb<S>& radiance, bool two_sided = false) {
    parts.emitters.areas.push_back({shape, Texture<S>(radiance), two_sided});
  }
};

/// The inside of a sphere around the origin, normals inwards. Shape 0; emits if `radiance` is positive.
template <std::floating_point S>
[[nodiscard]] SceneParts<S> inside_of_sphere(S radius, S radiance) {
  SceneParts<S> parts;
  Sphere<S> sphere;
  sphere.radius = radius;
  sphere.flip_normals = true;
  parts.shapes.spheres.push_back(sphere);
  if (radiance > S(0)) parts.emitters.areas.push_back({0, Texture<S>(Rgb<S>(radiance)), false});
  return parts;
}

/// Floor (shape 0, z = 0, normal up) and ceiling (shape 1, z = height, normal down), both [-half, half]^2; no light.
template <std::floating_point S>
[[nodiscard]] SceneParts<S> two_quads(S half, S height) {
  PartsBuilder<S> b;
  b.rectangle(Vec3<S>(0), {half, 0, 0}, {0, half, 0});
  b.rectangle({0, 0, height}, {0, half, 0}, {half, 0, 0});
  return b.parts;
}

/// A box [-1,1]^3 with all normals inwards, open at y = -1 (where a camera looks in): floor 0, ceiling 1, back 2,
/// left 3, right 4, lamp 5 (half-side 0.3 at z = 0.98, facing down, radiance (10, 8, 6)), block top 6 and block side 7.
template <std::floating_point S>
[[nodiscard]] SceneParts<S> cornell_like_box() {
  PartsBuilder<S> b;
  b.rectangle({0, 0, -1}, {1, 0, 0}, {0, 1, 0});
  b.rectangle({0, 0, 1}, {0, 1, 0}, {1, 0, 0});
  b.rectangle({0, 1, 0}, {1, 0, 0}, {0, 0, 1});
  b.rectangle({-1, 0, 0}, {0, 1, 0}, {0, 0, 1});
  b.rectangle({1, 0, 0}, {0, 0, 1}, {0, 1, 0});
  const std::uint32_t lamp = b.rectangle({0, 0, S(0.98)}, {0, S(0.3), 0}, {S(0.3), 0, 0});
  b.rectangle({S(0.3), S(0.2), S(-0.4)}, {S(0.3), S(0.1), 0}, {S(-0.1), S(0.3), 0});
  b.rectangle({S(0.4), S(-0.1), S(-0.7)}, {S(0.3), S(0.1), 0}, {0, 0, S(0.3)});
  b.emit(lamp, Rgb<S>(10, 8, 6));
  return b.parts;
}

/// One material per shape. `materials` has one entry for all shapes, or one per shape.
template <class G, Material M>
[[nodiscard]] Scene<G, UniformShader<M>> compose(const SceneParts<typename M::Scalar>& parts,
                                                 const std::vector<M>& materials, bool two_sided = true) {
  std::vector<UniformShader<M>> shaders;
  for (const M& m : materials) shaders.push_back(UniformShader<M>{m, two_sided});
  std::vector<std::uint32_t> shader_of_shape;
  for (std::uint32_t id = 0; id < parts.shapes.size(); ++id) {
    shader_of_shape.push_back(materials.size() == 1 ? 0 : id);
  }
  return Scene<G, UniformShader<M>>(G(parts.shapes), std::move(shaders), std::move(shader_of_shape), parts.emitters);
}
/// The same with the reference backend.
template <Material M>
[[nodiscard]] auto compose_bvh(const SceneParts<typename M::Scalar>& parts, const std::vector<M>& materials,
                               bool two_sided = true) {
  return compose<Bvh<typename M::Scalar>, M>(parts, materials, two_sided);
}

}  // namespace manylight::test
