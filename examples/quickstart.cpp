// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <fstream>
#include "manylight/manylight.hpp"
using namespace manylight;

int main() {
  Shapes<float> shapes;  // in metres; ids count spheres before disks
  shapes.spheres = {{.center = {-0.7F, 0.5F, 0}, .radius = 0.5F}, {.center = {0.6F, 0.7F, -0.5F}, .radius = 0.7F}};
  shapes.disks = {{.normal = {0, 1, 0}, .radius = 5}, {.center = {1, 3, 1}, .normal = {0, -1, 0}, .radius = 0.8F}};
  using Shader = UniformShader<Lambertian<float>>;
  const std::vector<Shader> paints = {{{Rgb<float>(0.8F, 0.3F, 0.1F)}}, {{Rgb<float>(0.7F)}}};
  EmitterList<float> lights;
  lights.areas = {{.shape = 3, .radiance = Texture<float>(Rgb<float>(12))}};
  lights.environments = {{.radiance = {0.05F, 0.08F, 0.15F}}};
  const Scene<Bvh<float>, Shader> scene(Bvh<float>(shapes), paints, {0, 1, 1, 1}, lights);

  const auto camera = look_at<float>({0, 1.2F, 5}, {0, 0.6F, 0}, {0, 1, 0}, 40, 320, 200);
  const auto image = bidirectional_lightcuts(scene, camera, {.vpls = 20'000, .eye_paths = 16});

  std::ofstream file("quickstart.ppm", std::ios::binary);
  file << "P6 320 200 255\n";
  for (const Rgb<float>& pixel : image.pixels)
    for (int c = 0; c < 3; ++c) file.put(static_cast<char>(255 * std::pow(std::min(pixel[c], 1.0F), 1 / 2.2F)));
}
