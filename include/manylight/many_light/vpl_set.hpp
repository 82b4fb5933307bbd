// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "manylight/core/executor.hpp"
#include "manylight/path/light_subpath.hpp"

namespace manylight {

struct VplConfig {
  std::size_t count = 1'000'000;  ///< VPLs wanted; the path that reaches the count is finished
  unsigned max_edges = 0xFFFF;    ///< longest full path, segments
};

/// The virtual point lights of a scene, in the order of their paths; exact ones first.
template <class Scene>
struct VplSet {
  std::vector<VertexOf<Scene>> vpls;  ///< strength = I, W
  std::size_t path_count = 0;         ///< N
  typename Scene::Scalar mean_intensity = 0;  ///< I_avg: mean luminance of I over VPLs that are not exact, W
};

namespace detail {
/// VPLs of point and directional lights: one each, with all of its flux. No path start repeats them.
template <class Scene>
void append_exact_vpls(const Scene& scene, std::vector<VertexOf<Scene>>& out) {
  using S = typename Scene::Scalar;
  for (const PointEmitter<S>& light : scene.emitters().points()) {
    VertexOf<Scene> v;
    v.kind = VertexKind::point_emitter;
    v.exact = true;
    v.position = light.position;
    v.ng = Vec3<S>(0);
    v.strength = light.intensity * (S(4) * k_pi<S>);
    if (max_channel(v.strength) > S(0)) out.push_back(v);
  }
  for (const DirectionalEmitter<S>& light : scene.emitters().directionals()) {
    VertexOf<Scene> v;
    v.kind = VertexKind::infinite_emitter;
    v.exact = true;
    v.position = -glm::normalize(light.direction);
    v.strength = light.irradiance * (k_pi<S> * sqr(scene.emitters().scene_radius()));
    if (max_channel(v.strength) > S(0)) out.push_back(v);
  }
}

/// Light paths of one task: [first, first + count), with the end of each path in `vpls`.
template <class Scene>
struct LightBatch {
  std::vector<VertexOf<Scene>> vpls;
  std::vector<std::uint32_t> path_ends;
  RayCounts rays;
};
}  // namespace detail

/// Traces light subpaths until `config.count` VPLs exist. Paths are independent of each other and of the executor.
template <class Scene, Sampler Random, Executor Exec>
[[nodiscard]] VplSet<Scene> trace_vpls(const Scene& scene, const VplConfig& config, const Random& sampler,
                                       const Exec& executor, RayCounts& rays) {
  using S = typename Scene::Scalar;
  constexpr std::size_t k_paths_per_batch = 512;
  constexpr std::size_t k_batches = 32;
  VplSet<Scene> set;
  detail::append_exact_vpls(scene, set.vpls);
  const std::size_t exact_count = set.vpls.size();
  if (scene.emitters().empty() || config.max_edges < 2) return set;
  // Paths of delta lights into the void leave nothing: a bound on the number of paths ends such scenes.
  const std::size_t max_paths = 16 * config.count + 1;
  bool done = set.vpls.size() >= config.count;
  while (!done && set.path_count < max_paths) {
    std::vector<detail::LightBatch<Scene>> batches(k_batches);
    executor.for_each_index(k_batches, [&](std::size_t b) {
      detail::LightBatch<Scene>& batch = batches[b];
      for (std::size_t i = 0; i < k_paths_per_batch; ++i) {
        auto stream = sampler.stream(Stage::light, set.path_count + b * k_paths_per_batch + i, 0);
        LightSubpath<Scene, decltype(stream)>(scene, config.max_edges, stream, batch.rays, batch.vpls).trace();
        batch.path_ends.push_back(static_cast<std::uint32_t>(batch.vpls.size()));
      }
    });
    for (const auto& batch : batches) {
      rays += batch.rays;
      std::size_t begin = 0;
      for (std::size_t i = 0; i < batch.path_ends.size() && !done; ++i) {
        const std::size_t end = batch.path_ends[i];
        for (std::size_t v = begin; v < end; ++v) set.vpls.push_back(batch.vpls[v]);
        begin = end;
        ++set.path_count;
        done = set.vpls.size() >= config.count;
      }
    }
  }
  double sum = 0;
  for (std::size_t i = exact_count; i < set.vpls.size(); ++i) {
    set.vpls[i].strength /= static_cast<S>(set.path_count);
    sum += static_cast<double>(luminance(set.vpls[i].strength));
  }
  if (set.vpls.size() > exact_count) {
    set.mean_intensity = static_cast<S>(sum / static_cast<double>(set.vpls.size() - exact_count));
  }
  return set;
}

}  // namespace manylight
