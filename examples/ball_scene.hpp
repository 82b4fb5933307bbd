// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the examples of materials and bounds share: a ball on a disk under a sun and a lamp, rendered by bidirectional
// lightcuts and by path tracing.

#include "manylight/manylight.hpp"

namespace example {

using namespace manylight;

/// Mean radiance of 32 x 32 pixels, W/m^2/sr, and what the cuts cost.
struct Comparison {
  double by_cuts = 0;
  double by_paths = 0;
  double mean_cut = 0;
  std::uint64_t bound_violations = 0;
};

/// Ball and disk of one material, bounded by `bounds`.
template <Material M, PatternBounds<M> B = AutomaticBounds>
[[nodiscard]] Comparison render_ball(const M& material, const B& bounds = {}) {
  Shapes<float> shapes;
  shapes.spheres = {{.center = {0, 0, 5}}};
  shapes.disks = {{.center = {0, -1, 5}, .normal = {0, 1, 0}, .radius = 6},
                  {.center = {-2, 3, 4}, .normal = {0, -1, 0}, .radius = 0.5F}};
  EmitterList<float> lights;
  lights.directionals = {{.direction = {0.5F, -1, 1}, .irradiance = Rgb<float>(10)}};
  lights.areas = {{.shape = 2, .radiance = Rgb<float>(20)}};
  const std::vector<UniformShader<M>> shaders = {{material}};
  const Scene scene(Bvh<float>(shapes), shaders, {0, 0, 0}, lights);
  const PerspectiveCamera<float> camera({.horizontal_fov = 30, .width = 32, .height = 32});
  const auto filter = ReconstructionFilter<float>::box();
  const IndependentSampler<float> sampler{1};
  const SerialExecutor executor;

  const ManyLightConfig config{.vpls = 5'000, .eye_paths = 16, .window = {}};
  const auto side = prepare_lights(scene, camera, filter, config, sampler, executor);
  const LightTree<std::remove_const_t<decltype(scene)>> tree(side.lights.vpls, executor, bounds);
  const auto cuts = render_bidirectional_lightcuts(scene, camera, filter, config, side, tree, sampler, executor,
                                                   NoProgress{}, bounds);
  std::vector<Rgb<double>> sums(32 * 32, Rgb<double>(0));
  accumulate_path_samples(PathIntegrator(scene, PathConfig{}), camera, filter, Window::of(camera), sampler, 0, 256, sums,
                          executor);

  Comparison result;
  for (std::size_t i = 0; i < sums.size(); ++i) {
    result.by_cuts += static_cast<double>(cuts.image.pixels[i].x) / 1024;
    result.by_paths += sums[i].x / 256 / 1024;
  }
  result.mean_cut = static_cast<double>(cuts.statistics.pairs.cut_size) / 1024;
  result.bound_violations = cuts.statistics.pairs.bound_violations;
  return result;
}

}  // namespace example
