// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>
#include <vector>

#include "integrator/same_lights.hpp"
#include "support/random_vertices.hpp"

// Scenes of textured, diffuse and glossy surfaces under every kind of light.

namespace manylight::test {

/// A texture as the diffuse colour under a lobe of gloss, or none.
struct TexturedShader {
  using S = double;
  enum class Kind { diffuse, phong, ward };
  using Material = AnyOf<Lambertian<S>, DiffusePhong<S>, DiffuseWard<S>>;
  static constexpr bool k_may_be_transparent = false;
  static constexpr bool k_may_absorb = false;
  Texture<S> color{};
  Kind kind = Kind::diffuse;
  S gloss = 0;      ///< albedo of the lobe
  S roughness = 1;  ///< exponent, or alpha

  [[nodiscard]] Material material(const SurfacePoint<S>& point, bool) const noexcept {
    const Lambertian<S> base{color.eval(point.uv)};
    if (kind == Kind::phong) return DiffusePhong<S>({base, 1}, {Phong<S>{Rgb<S>(gloss), roughness}, 1});
    if (kind == Kind::ward) return DiffuseWard<S>({base, 1}, {Ward<S>{Rgb<S>(gloss), roughness, roughness / 2}, 1});
    return base;
  }
  [[nodiscard]] bool is_two_sided() const noexcept { return true; }
};

using TexturedScene = Scene<Bvh<double>, TexturedShader>;

/// Shapes with a shader each. Meshes first, as Shapes numbers them.
struct TexturedBuilder {
  using S = double;
  Shapes<S> shapes;
  std::vector<TexturedShader> shaders;
  EmitterList<S> lights;

  std::uint32_t mesh(TriangleMesh<S> shape, const TexturedShader& shader) {
    shapes.meshes.push_back(std::move(shape));
    shaders.push_back(shader);
    return static_cast<std::uint32_t>(shaders.size() - 1);
  }
  void sphere(const Sphere<S>& shape, const TexturedShader& shader) {
    shapes.spheres.push_back(shape);
    shaders.push_back(shader);
  }
  [[nodiscard]] TexturedScene build() const {
    std::vector<std::uint32_t> ids(shaders.size());
    for (std::size_t i = 0; i < ids.size(); ++i) ids[i] = static_cast<std::uint32_t>(i);
    return TexturedScene(Bvh<S>(shapes), shaders, ids, lights);
  }
};

}  // namespace manylight::test
