// SPDX-License-Identifier: Apache-2.0
#pragma once

// Bidirectional path tracing [Lafortune and Willems 1993; Veach 1997, chapter 10]: one light and one eye walk per sample, all
// their vertices connected with each other, with a drawn light and with the lens, each path weighted by the balance
// heuristic over all strategies that may make it. A strategy (s, t) has s vertices from the light and t from the lens; the
// path has s + t - 1 segments.

#include <vector>

#include "manylight/integrator/path.hpp"
#include "manylight/path/bidirectional_connect.hpp"

namespace manylight {

struct BidirectionalPathConfig {
  unsigned max_edges = k_unlimited_edges;  ///< longest path, segments
  bool with_lens = true;  ///< t = 1, if the camera is a LensCamera: light walks connected with the lens

  /// Throws ParameterError.
  void validate() const { require(max_edges >= 1, "maximum path length", max_edges, "at least 1 segment"); }
};

/// The light and the eye walk of a sample; to be used again for the next one.
template <class Scene>
struct SubpathPair {
  Subpath<Scene> light;
  Subpath<Scene> eye;
};

template <class Scene>
class BidirectionalPathIntegrator {
 public:
  using S = typename Scene::Scalar;

  BidirectionalPathIntegrator(const Scene& scene, const BidirectionalPathConfig& config)
      : scene_(scene), config_(config) {
    config.validate();
  }
  [[nodiscard]] const BidirectionalPathConfig& config() const noexcept { return config_; }
  [[nodiscard]] const Scene& scene() const noexcept { return scene_; }

  /// Whether light walks are connected with the lens of that type of camera.
  template <Camera C>
  [[nodiscard]] bool uses_lens() const noexcept {
    return LensCamera<C> && config_.with_lens;
  }

  /// Traces the light walk of a sample and connects it with the lens: calls
  /// `found(s, contribution)`, a LensContribution, W/m^2/sr per pixel of film. `light_paths`: how many light walks the
  /// image of one sample per pixel has.
  template <Camera C, SampleStream Stream, class Found>
  void trace_light(const C& camera, S light_paths, Stream& stream, RayCounts& rays, Subpath<Scene>& light,
                   const Found& found) const {
    // The path's last segment is a connection.
    BidirectionalWalk<Scene, Stream>(scene_, stream, rays).trace_light(config_.max_edges - 1, light);
    if constexpr (LensCamera<C>) {
      if (!config_.with_lens) return;
      for (const BidirectionalVertex<Scene>& v : light.vertices) {
        if (v.is_delta) continue;
        if (const auto seen = connect_with_lens(scene_, camera, v, light_paths, stream, rays)) {
          found(v.vertex.edges + 1u, *seen);
        }
      }
    }
  }

  /// Traces the eye walk of a sample along `ray` and connects it with its light walk: calls `found(s, t, contribution)`, a
  /// PathContribution.
  template <Camera C, SampleStream Stream, class Found>
  void trace_eye(const C& camera, const Ray<S>& ray, S light_paths, Stream& stream, RayCounts& rays,
                 SubpathPair<Scene>& walks, const Found& found) const {
    PartialWeights<S> weights;
    if constexpr (LensCamera<C>) {
      if (config_.with_lens) weights = PartialWeights<S>::of_lens(light_paths, camera.film_density(ray.direction));
    }
    BidirectionalWalk<Scene, Stream>(scene_, stream, rays).trace_eye(ray, weights, config_.max_edges, walks.eye);
    for (const BidirectionalVertex<Scene>& v : walks.eye.vertices) connect_eye_vertex(v, walks.light, stream, rays, found);
    if (!is_black(walks.eye.environment)) {
      found(0u, walks.eye.edges() + 2u,
            PathContribution<S>{walks.eye.environment, walks.eye.environment_weight});
    }
  }

 private:
  template <SampleStream Stream, class Found>
  void connect_eye_vertex(const BidirectionalVertex<Scene>& v, const Subpath<Scene>& light, Stream& stream,
                          RayCounts& rays, const Found& found) const {
    const unsigned edges = v.vertex.edges;
    if (!is_black(v.emission)) found(0u, edges + 1u, PathContribution<S>{v.emission, v.emission_weight});
    if (v.is_delta || edges >= config_.max_edges) return;
    if (const auto direct = connect_with_drawn_light(scene_, v, stream, rays)) found(1u, edges + 1u, *direct);
    for (const BidirectionalVertex<Scene>& l : light.vertices) {
      if (edges + 1u + l.vertex.edges > config_.max_edges) return;
      if (l.is_delta) continue;
      if (const auto joined = connect_vertices(scene_, v, l, stream, rays)) found(l.vertex.edges + 1u, edges + 1u, *joined);
    }
  }

  const Scene& scene_;
  BidirectionalPathConfig config_;
};

/// Of a scene in motion: one per instant; the walks of a sample live in one.
template <class S>
class BidirectionalPathIntegrator<Instants<S>> {
 public:
  BidirectionalPathIntegrator(const Instants<S>& scenes, const BidirectionalPathConfig& config) {
    for (std::uint32_t i = 0; i < scenes.instants(); ++i) integrators_.emplace_back(scenes.at(i), config);
  }
  [[nodiscard]] std::uint32_t instants() const noexcept { return static_cast<std::uint32_t>(integrators_.size()); }
  [[nodiscard]] const BidirectionalPathIntegrator<S>& at(std::uint32_t instant) const noexcept {
    return integrators_[instant];
  }

 private:
  std::vector<BidirectionalPathIntegrator<S>> integrators_;
};

}  // namespace manylight
