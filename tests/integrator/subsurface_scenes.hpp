// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>
#include <vector>

#include "integrator/builders.hpp"
#include "manylight/geometry/bvh.hpp"
#include "manylight/scattering/falloff_profiles.hpp"
#include "manylight/scattering/lambertian.hpp"
#include "manylight/scattering/subsurface.hpp"

// Scenes with objects that scatter below their surface, in double.

namespace manylight::test {

using Jade = Subsurface<ExponentialFalloff<double>>;

/// A surface, two-sided if it is Lambertian, and what is below it.
template <Material M>
struct JadeShaderOf {
  using Material = M;
  using Subsurface = Jade;
  static constexpr bool k_may_be_transparent = false;
  static constexpr bool k_may_absorb = false;
  Material surface{};
  Jade inside{};
  bool scatters_below = false;

  [[nodiscard]] Material material(const SurfacePoint<double>&, bool) const noexcept { return surface; }
  [[nodiscard]] bool is_two_sided() const noexcept { return !surface.is_delta(); }
  [[nodiscard]] const Jade* subsurface() const noexcept { return scatters_below ? &inside : nullptr; }
};
using JadeShader = JadeShaderOf<Lambertian<double>>;
using JadeScene = Scene<Bvh<double>, JadeShader>;

[[nodiscard]] inline Jade jade(double rho, double length, double eta = 1) {
  Jade below;
  below.falloff = ExponentialFalloff<double>(Rgb<double>(length));
  below.rho = Rgb<double>(rho);
  below.eta = eta;
  return below;
}

template <Material M>
class JadeBuilderOf {
 public:
  using S = double;
  using Shader = JadeShaderOf<M>;
  using SceneType = Scene<Bvh<double>, Shader>;
  EmitterList<S> lights;

  void mesh(TriangleMesh<S> shape, double albedo) { mesh(std::move(shape), M(Lambertian<S>{Rgb<S>(albedo)})); }
  void mesh(TriangleMesh<S> shape, const M& surface) { add(std::move(shape), {surface, {}, false}); }
  void mesh(TriangleMesh<S> shape, const Jade& inside, double albedo = 0) {
    mesh(std::move(shape), inside, M(Lambertian<S>{Rgb<S>(albedo)}));
  }
  void mesh(TriangleMesh<S> shape, const Jade& inside, const M& surface) {
    add(std::move(shape), {surface, inside, true});
  }
  void sphere(const Vec3<S>& center, S radius, const Jade& inside, double albedo = 0) {
    sphere(center, radius, inside, M(Lambertian<S>{Rgb<S>(albedo)}));
  }
  void sphere(const Vec3<S>& center, S radius, const Jade& inside, const M& surface) {
    shapes_.spheres.push_back({center, radius, false});
    of_spheres_.push_back({surface, inside, true});
  }
  void lamp(TriangleMesh<S> shape, double radiance) {
    lights.areas.push_back({static_cast<std::uint32_t>(of_meshes_.size()), Texture<S>(Rgb<S>(radiance)), false});
    mesh(std::move(shape), 0.0);
  }
  void sky(double radiance) {
    lights.environments.emplace_back();
    lights.environments.back().radiance = Rgb<S>(radiance);
  }

  [[nodiscard]] SceneType build() const {
    std::vector<Shader> shaders = of_meshes_;
    shaders.insert(shaders.end(), of_spheres_.begin(), of_spheres_.end());
    std::vector<std::uint32_t> ids(shaders.size());
    for (std::size_t i = 0; i < ids.size(); ++i) ids[i] = static_cast<std::uint32_t>(i);
    return SceneType(Bvh<S>(shapes_), shaders, ids, lights);
  }

 private:
  void add(TriangleMesh<S> shape, const Shader& shader) {
    shapes_.meshes.push_back(std::move(shape));
    of_meshes_.push_back(shader);
  }
  Shapes<S> shapes_;
  std::vector<Shader> of_meshes_, of_spheres_;
};
using JadeBuilder = JadeBuilderOf<Lambertian<double>>;

}  // namespace manylight::test
