// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "integrator/builders.hpp"
#include "manylight/geometry/bvh.hpp"
#include "manylight/scattering/lambertian.hpp"

// A room with every difficulty but mirrors, for tests without closed solutions. Double precision keeps rounding out of
// them.

namespace manylight::test {

[[nodiscard]] inline Lambertian<double> grey(double albedo) { return {Rgb<double>(albedo)}; }

/// Room [-1,1]^3, ceiling light, two walls of different albedo; `ball` is put on the floor.
template <Material M>
[[nodiscard]] SceneBuilder<Bvh<double>, M> cornell(const M& ball) {
  SceneBuilder<Bvh<double>, M> builder;
  const auto wall = [&](Vec3<double> center, Vec3<double> u, Vec3<double> v, const Rgb<double>& albedo) {
    builder.mesh(parallelogram<double>(center, u, v), M(Lambertian<double>{albedo}));
  };
  wall({0, 0, -1}, {1, 0, 0}, {0, 1, 0}, Rgb<double>(0.7));
  wall({0, 0, 1}, {0, 1, 0}, {1, 0, 0}, Rgb<double>(0.7));
  wall({-1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.6, 0.1, 0.1});
  wall({1, 0, 0}, {0, 0, 1}, {0, 1, 0}, {0.1, 0.5, 0.1});
  wall({0, 1, 0}, {0, 0, 1}, {1, 0, 0}, Rgb<double>(0.7));
  wall({0, -1, 0}, {1, 0, 0}, {0, 0, 1}, Rgb<double>(0.7));
  builder.emit(builder.mesh(parallelogram<double>({0, 0, 0.98}, {0, 0.4, 0}, {0.4, 0, 0}), M(grey(0.0))),
               Rgb<double>(10));
  builder.sphere({{0.3, 0.1, -0.6}, 0.4, false}, ball);
  return builder;
}

[[nodiscard]] inline const PerspectiveCamera<double>& room_camera() {
  static const auto camera = look_at<double>({0, -0.95, 0}, {0, 1, -0.2}, 70, 12);
  return camera;
}

}  // namespace manylight::test
