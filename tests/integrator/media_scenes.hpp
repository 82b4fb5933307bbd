// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "integrator/builders.hpp"
#include "manylight/geometry/bvh.hpp"
#include "manylight/media/any_medium.hpp"
#include "manylight/media/fiber_medium.hpp"
#include "manylight/media/heterogeneous.hpp"
#include "manylight/media/homogeneous.hpp"
#include "manylight/scattering/any_of.hpp"
#include "manylight/scattering/any_phase.hpp"
#include "manylight/scattering/dielectric.hpp"
#include "manylight/scattering/gaussian_fiber.hpp"
#include "manylight/scattering/henyey_greenstein.hpp"
#include "manylight/scattering/lambertian.hpp"

// Scenes with participating media, in double.

namespace manylight::test {

/// Lambertian or smooth glass, or such that only tells two media apart.
struct FoggyShader {
  using Material = AnyOf<Lambertian<double>, Dielectric<double>>;
  static constexpr bool k_may_be_transparent = true;
  static constexpr bool k_may_absorb = false;
  Material surface{};
  bool is_open = false;
  bool is_glass = false;

  [[nodiscard]] Material material(const SurfacePoint<double>&, bool) const noexcept { return surface; }
  [[nodiscard]] bool is_two_sided() const noexcept { return !is_glass; }
  [[nodiscard]] bool is_transparent() const noexcept { return is_open; }
  [[nodiscard]] double opacity(const SurfacePoint<double>&) const noexcept { return is_open ? 0 : 1; }
};

using Fog = Homogeneous<HenyeyGreenstein<double>>;
using Smoke = Heterogeneous<HenyeyGreenstein<double>>;
/// Makes the fibers of a cloth, which share a table.
struct Fibers {
  std::shared_ptr<const GaussianFiberTable<double>> table;
  [[nodiscard]] GaussianFiber<double> operator()(const Vec3<double>& axis) const noexcept { return {*table, axis}; }
  [[nodiscard]] double max_projected_area() const noexcept { return table->sigma(1.0); }
};
using Cloth = FiberMedium<Fibers, GridVolume<double>>;
using FoggyPhase = AnyPhase<HenyeyGreenstein<double>, GaussianFiber<double>>;
using FoggyMedium = AnyMediumWith<FoggyPhase, Fog, Smoke, Cloth>;
using FoggyScene = Scene<Bvh<double>, FoggyShader, SceneMedia<FoggyMedium>>;

[[nodiscard]] inline Fog fog(double sigma_a, double sigma_s, double g = 0) {
  return Fog(Rgb<double>(sigma_a), Rgb<double>(sigma_s), {g});
}
/// A medium of density 1 / m all over the box [lo, hi].
[[nodiscard]] inline Smoke even_smoke(const Vec3<double>& lo, const Vec3<double>& hi, double scale, double albedo,
                                      double g = 0) {
  GridPlacement<double> placement;
  placement.box = Box<double>{lo, hi};
  GridVolume<double> density({2, 2, 2}, GridVolume<double>::Samples(8, 1.0F), placement);
  return Smoke(std::move(density), scale, Rgb<double>(albedo), {g});
}

/// Threads in stripes along x and y by turns, all over the box [lo, hi]; `scale`: twice the density of fibers, 1 / m.
[[nodiscard]] inline Cloth striped_cloth(const Vec3<double>& lo, const Vec3<double>& hi, double scale, double albedo,
                                         double gamma) {
  GridPlacement<double> placement;
  placement.box = Box<double>{lo, hi};
  GridVolume<double>::Samples density;
  std::vector<Vec3<double>> axes;
  for (int i = 0; i < 8 * 8 * 2; ++i) {
    density.push_back(i % 3 == 0 ? 0.4F : 1.0F);
    axes.push_back(i / 8 % 2 == 0 ? Vec3<double>(1, 0, 0.3) : Vec3<double>(0, 1, -0.2));
  }
  return Cloth(GridVolume<double>({8, 8, 2}, std::move(density), placement), axes, scale, Rgb<double>(albedo),
               Fibers{std::make_shared<const GaussianFiberTable<double>>(gamma)});
}

/// Collects meshes and spheres, what they are made of and what is inside and outside of them.
class FoggyBuilder {
 public:
  using S = double;
  EmitterList<S> lights;
  std::vector<FoggyMedium> media;
  MediumId outside = k_vacuum;

  void mesh(TriangleMesh<S> shape, double albedo, std::optional<MediaSides> sides = {}) {
    shapes_.meshes.push_back(std::move(shape));
    meshes_.push_back({{Lambertian<S>{Rgb<S>(albedo)}, false, false}, sides});
  }
  void open_mesh(TriangleMesh<S> shape, const MediaSides& sides) {
    shapes_.meshes.push_back(std::move(shape));
    meshes_.push_back({{{}, true, false}, sides});
  }
  void open_sphere(const Vec3<S>& center, S radius, const MediaSides& sides) {
    shapes_.spheres.push_back({center, radius, false});
    spheres_.push_back({{{}, true, false}, sides});
  }
  void glass_sphere(const Vec3<S>& center, S radius, S ior, const MediaSides& sides) {
    shapes_.spheres.push_back({center, radius, false});
    spheres_.push_back({{Dielectric<S>{ior}, false, true}, sides});
  }
  /// A black mesh that emits on the side of its normal.
  void lamp(TriangleMesh<S> shape, double radiance) {
    lights.areas.push_back({static_cast<std::uint32_t>(meshes_.size()), Texture<S>(Rgb<S>(radiance)), false});
    mesh(std::move(shape), 0);
  }
  void point_light(const Vec3<S>& position, S intensity) { lights.points.push_back({position, Rgb<S>(intensity)}); }

  [[nodiscard]] FoggyScene build() const {
    std::vector<FoggyShader> shaders;
    std::vector<std::optional<MediaSides>> boundaries;
    std::vector<std::uint32_t> ids;
    for (const auto* list : {&meshes_, &spheres_}) {
      for (const Part& part : *list) {
        ids.push_back(static_cast<std::uint32_t>(shaders.size()));
        shaders.push_back(part.shader);
        boundaries.push_back(part.sides);
      }
    }
    return FoggyScene(Bvh<S>(shapes_), shaders, ids, lights, SceneMedia<FoggyMedium>(media, boundaries, outside));
  }

 private:
  struct Part {
    FoggyShader shader;
    std::optional<MediaSides> sides;
  };
  Shapes<S> shapes_;
  std::vector<Part> meshes_, spheres_;
};

/// A box of fog before a wall with a lamp. `media[0]` fills the box.
[[nodiscard]] inline FoggyBuilder fog_box(const FoggyMedium& medium) {
  FoggyBuilder builder;
  builder.media = {medium};
  builder.open_mesh(box_mesh<double>({-1, -1, -1}, {1, 1, 1}), {k_vacuum, 1});
  builder.mesh(parallelogram<double>({0, 0, 1.5}, {3, 0, 0}, {0, 3, 0}), 0.6);
  builder.mesh(parallelogram<double>({0, -1.2, 0}, {3, 0, 0}, {0, 0, 3}), 0.6);
  builder.lamp(parallelogram<double>({0, 2, 0}, {0.5, 0, 0}, {0, 0, 0.5}), 10);
  return builder;
}
[[nodiscard]] inline PerspectiveCamera<double> box_camera() { return look_at<double>({0.5, 0.2, -4}, {0, 0, 0}, 40, 4); }

}  // namespace manylight::test
