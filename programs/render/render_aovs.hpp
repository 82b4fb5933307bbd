// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/setup.hpp"

namespace manylight::render {

/// First surfaces, mean of 16 samples per pixel.
struct FirstHitImages {
  Image<float> normal;  ///< shading normal, world
  Image<float> albedo;
  Image<float> depth;   ///< m from the camera
};

template <class Geometry, class Shader, class Media>
[[nodiscard]] FirstHitImages render_first_hits(const Setup<Geometry, Shader, Media>& setup, JobResult& result) {
  constexpr std::uint32_t k_samples = 16;
  const Image<float> black(setup.window.width(), setup.window.height());
  FirstHitImages images{black, black, black};
  const auto render_tile = [&](const Window& tile) {
    RayCounts rays;
    for (std::uint32_t y = tile.y0; y < tile.y1; ++y) {
      for (std::uint32_t x = tile.x0; x < tile.x1; ++x) {
        const std::size_t pixel = setup.window.index(x, y);
        for (std::uint32_t i = 0; i < k_samples; ++i) {
          auto stream = setup.sampler.stream(Stage::eye, film_index(setup.camera, x, y), i);
          const std::uint32_t instant =
              sample_instant(instant_count(setup.scene), setup.sampler, film_index(setup.camera, x, y), i);
          const auto& scene = at_instant(setup.scene, instant);
          const Ray<float> ray = camera_ray(at_instant(setup.camera, instant), setup.filter, x, y, stream);
          const auto point = scene.intersect(ray, stream, rays);
          if (!point) continue;
          const auto hit = scene.interaction(*point, -ray.direction);
          images.normal.pixels[pixel] += hit.frame.n / float{k_samples};
          images.albedo.pixels[pixel] += hit.material.albedo() / float{k_samples};
          images.depth.pixels[pixel] += Rgb<float>(glm::length(point->position - ray.origin) / float{k_samples});
        }
      }
    }
    return rays;
  };
  for (const RayCounts& rays : for_each_tile(setup.window, setup.executor, render_tile, NoProgress{})) {
    result.statistics.add_rays(rays);
  }
  return images;
}

/// The auxiliary images that every method has.
template <class Geometry, class Shader, class Media>
void render_aovs(const Setup<Geometry, Shader, Media>& setup, JobResult& result) {
  const auto wants = [&](const char* name) { return setup.options.aovs.contains(name); };
  if (!wants("normal") && !wants("albedo") && !wants("depth")) return;
  FirstHitImages images = render_first_hits(setup, result);
  if (wants("normal")) result.aovs["normal"] = std::move(images.normal);
  if (wants("albedo")) result.aovs["albedo"] = std::move(images.albedo);
  if (wants("depth")) result.aovs["depth"] = std::move(images.depth);
}

}  // namespace manylight::render
