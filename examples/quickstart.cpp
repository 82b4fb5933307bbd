// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <fstream>
#include "manylight/manylight.hpp"
using namespace manylight;
int main() {
  Shapes<float> shapes;  // metres; the camera sits at the origin and looks along +z, +y is up, +x to the left
  shapes.spheres = {{.center = {0.7F, -0.5F, 5}, .radius = 0.5F}, {.center = {-0.5F, -0.3F, 5.6F}, .radius = 0.7F}};
  shapes.disks = {{.center = {0, -1, 5}, .normal = {0, 1, 0}, .radius = 4},  // ids count spheres first: floor 2, lamp 3
                  {.center = {2, 4, 3}, .normal = {0, -1, 0}, .radius = 1}};
  EmitterList<float> emitters;
  emitters.areas = {{.shape = 3, .radiance = Rgb<float>(15)}};
  emitters.environments = {{.radiance = {0.05F, 0.1F, 0.2F}}};
  const std::vector<UniformShader<Lambertian<float>>> paints = {{{Rgb<float>(0.8F, 0.2F, 0.1F)}}, {{Rgb<float>(0.7F)}}};
  const Scene scene(Bvh<float>(shapes), paints, {0, 1, 1, 1}, emitters);
  const PerspectiveCamera<float> camera({.horizontal_fov = 40, .width = 320, .height = 200});
  const auto filter = ReconstructionFilter<float>::box();
  const ManyLightConfig config{.vpls = 20'000, .eye_paths = 16};
  const IndependentSampler<float> sampler{.seed = 1};
  const SerialExecutor threads;
  const auto lights = prepare_lights(scene, camera, filter, config, sampler, threads);
  const LightTree<std::remove_const_t<decltype(scene)>> tree(lights.lights.vpls, threads);
  const auto picture = render_bidirectional_lightcuts(scene, camera, filter, config, lights, tree, sampler, threads);
  std::ofstream file("quickstart.ppm", std::ios::binary);
  file << "P6 320 200 255\n";
  for (const Rgb<float>& p : picture.image.pixels)
    for (int c = 0; c < 3; ++c) file.put(static_cast<char>(255 * std::pow(std::min(p[c], 1.0F), 1 / 2.2F)));
}
