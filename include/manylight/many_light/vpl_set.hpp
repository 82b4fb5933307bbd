// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "manylight/core/executor.hpp"
#include "manylight/path/light_subpath.hpp"
#include "manylight/scene/instants.hpp"

namespace manylight {

struct VplConfig {
  /// VPLs that light paths shall leave, those of point and directional lights not counted: they come on top. The path
  /// that reaches the count is finished.
  std::size_t count = 1'000'000;
  unsigned max_edges = 0xFFFF;  ///< longest full path, segments
};

/// The virtual point lights of a scene, in the order of their paths; exact ones first.
template <class Scene>
struct VplSet {
  std::vector<VertexOf<Scene>> vpls;          ///< strength = I, W
  std::size_t path_count = 0;                 ///< N
  /// I_avg: mean luminance of I over VPLs that are not exact, W. In motion each lights one of n instants n times as
  /// strongly; this is its mean over the shutter interval, which is what a pixel gets of it.
  typename Scene::Scalar mean_intensity = 0;
};

namespace detail {
/// Marks the vertices from `first` on as of an instant, if the scene moves.
template <AnyVertex V>
void set_instant(std::vector<V>& vertices, std::size_t first, [[maybe_unused]] std::uint32_t instant) noexcept {
  if constexpr (V::k_moves) {
    for (std::size_t i = first; i < vertices.size(); ++i) vertices[i].instant = static_cast<InstantId>(instant);
  }
}

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
    if (light.is_spot()) {
      v.kind = VertexKind::spot_emitter;
      v.ng = light.axis;
      v.w = {light.beam_width, light.cutoff, S(0)};
    }
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

/// Light paths of one task, in order, with the end of each in `vpls`.
template <class Scene>
struct LightBatch {
  std::vector<VertexOf<Scene>> vpls;
  std::vector<std::uint32_t> path_ends;
  RayCounts rays;
};

/// Paths of the next round: as many as the `missing` VPLs need at the yield so far, so that small sets trace few paths in
/// vain; at least one for each of 32 tasks, at most 32 x 512. The first round is small, as it knows no yield: in a white
/// room a path may leave a hundred VPLs. Any number gives the same set: every path has its own random numbers, and surplus
/// ones are dropped.
[[nodiscard]] inline std::size_t next_round(std::size_t missing, std::size_t found, std::size_t paths) noexcept {
  if (paths == 0) return 32;
  const double paths_per_vpl = (static_cast<double>(paths) + 1) / (static_cast<double>(found) + 2);
  return static_cast<std::size_t>(std::clamp(std::ceil(static_cast<double>(missing) * paths_per_vpl), 32.0, 16384.0));
}

/// Traces the paths [first, first + count), a few per task; in path order.
template <class Scene, Sampler Random, Executor Exec>
[[nodiscard]] std::vector<LightBatch<Scene>> trace_light_paths(const Scene& scene, unsigned max_edges,
                                                               const Random& sampler, const Exec& executor,
                                                               std::size_t first, std::size_t count) {
  const std::size_t per_batch = (count + 31) / 32;
  std::vector<LightBatch<Scene>> batches((count + per_batch - 1) / per_batch);
  executor.for_each_index(batches.size(), [&](std::size_t b) {
    LightBatch<Scene>& batch = batches[b];
    const std::size_t end = std::min(count, (b + 1) * per_batch);
    for (std::size_t i = b * per_batch; i < end; ++i) {
      // The paths of an instant fill the space of paths together.
      const auto instant = static_cast<std::uint32_t>((first + i) % instant_count(scene));
      auto stream = sampler.stream(Stage::light, instant, static_cast<std::uint32_t>((first + i) / instant_count(scene)));
      const auto& now = at_instant(scene, instant);
      const std::size_t first_vpl = batch.vpls.size();
      LightSubpath<std::remove_cvref_t<decltype(now)>, decltype(stream)>(now, max_edges, stream, batch.rays, batch.vpls)
          .trace();
      set_instant(batch.vpls, first_vpl, instant);
      batch.path_ends.push_back(static_cast<std::uint32_t>(batch.vpls.size()));
    }
  });
  return batches;
}

/// How many of `count` paths, which take the instants in turn, show the instant of `v`.
template <AnyVertex V>
[[nodiscard]] std::size_t paths_of(const V& v, std::size_t count, std::uint32_t instants) noexcept {
  if constexpr (V::k_moves) {
    return count / instants + (v.instant < count % instants ? 1 : 0);
  } else {
    return count;
  }
}

/// Divides by the number of paths of an instant and averages; exact VPLs are left as they are.
template <class Scene>
void normalise(VplSet<Scene>& set, std::size_t exact_count, std::uint32_t instants) {
  using S = typename Scene::Scalar;
  if (set.vpls.size() == exact_count) return;
  double sum = 0;
  for (std::size_t i = exact_count; i < set.vpls.size(); ++i) {
    set.vpls[i].strength /= static_cast<S>(paths_of(set.vpls[i], set.path_count, instants));
    sum += static_cast<double>(luminance(set.vpls[i].strength));
  }
  set.mean_intensity = static_cast<S>(sum / static_cast<double>(set.vpls.size() - exact_count) / instants);
}

/// Whether light paths can leave a VPL: not if they consist of the emission alone and that is exact.
template <class Scene>
[[nodiscard]] bool has_inexact_vpls(const Scene& scene, unsigned max_edges) noexcept {
  const auto& emitters = scene.emitters();
  if (emitters.empty() || max_edges < 2) return false;
  return max_edges > 2 || emitters.count() > emitters.points().size() + emitters.directionals().size();
}
}  // namespace detail

/// Traces light subpaths until they have left `config.count` VPLs. The set does not depend on the
/// executor. Where paths leave less than one VPL in 16, in a scene almost without surfaces, the set is smaller.
template <class Scene, Sampler Random, Executor Exec>
[[nodiscard]] VplSet<Scene> trace_vpls(const Scene& scene, const VplConfig& config, const Random& sampler,
                                       const Exec& executor, RayCounts& rays) {
  VplSet<Scene> set;
  for (std::uint32_t instant = 0; instant < instant_count(scene); ++instant) {
    const std::size_t first = set.vpls.size();
    detail::append_exact_vpls(at_instant(scene, instant), set.vpls);
    detail::set_instant(set.vpls, first, instant);
  }
  const std::size_t exact_count = set.vpls.size();
  const auto found = [&] { return set.vpls.size() - exact_count; };
  if (!detail::has_inexact_vpls(scene, config.max_edges)) return set;
  // Paths of delta lights into the void leave nothing: a bound on the number of paths ends such scenes.
  // 2^32 paths have random numbers of their own.
  const std::size_t max_paths = std::min<std::size_t>(16 * config.count + 1, std::numeric_limits<std::uint32_t>::max());
  while ((found() < config.count || set.path_count < instant_count(scene)) && set.path_count < max_paths) {
    const std::size_t missing = config.count - std::min(found(), config.count);
    const std::size_t round =
        std::min(detail::next_round(missing, found(), set.path_count), max_paths - set.path_count);
    for (const auto& batch :
         detail::trace_light_paths(scene, config.max_edges, sampler, executor, set.path_count, round)) {
      rays += batch.rays;
      std::size_t begin = 0;
      for (std::size_t i = 0; i < batch.path_ends.size(); ++i) {
        if (found() >= config.count && set.path_count >= instant_count(scene)) break;
        const std::size_t end = batch.path_ends[i];
        for (std::size_t v = begin; v < end; ++v) set.vpls.push_back(batch.vpls[v]);
        begin = end;
        ++set.path_count;
      }
    }
  }
  detail::normalise(set, exact_count, instant_count(scene));
  return set;
}

}  // namespace manylight
