// SPDX-License-Identifier: Apache-2.0
#pragma once

// Virtual point lights, [Walter 2012, section 5.1]; theory sheet, section 2.3. beta = N B_j c'_j is the power that one
// light path carries towards its next vertex; a VPL there gets the intensity N I_j = beta alpha |wi.ns| / |wi.ng|.

#include <cmath>
#include <vector>

#include "manylight/path/connect.hpp"
#include "manylight/path/walk.hpp"

namespace manylight {

/// The VPL of an emission, strength N I_l. Point and directional lights are left to `exact_vpls`.
template <class Scene>
[[nodiscard]] VertexOf<Scene> emission_vertex(const EmissionSample<typename Scene::Scalar>& emission) {
  VertexOf<Scene> v;
  v.strength = emission.intensity;
  if (is_infinite(emission.kind)) {
    v.kind = VertexKind::infinite_emitter;
    v.position = -emission.wo;
  } else {
    v.kind = emission.kind == EmitterKind::point ? VertexKind::point_emitter
             : emission.two_sided                ? VertexKind::two_sided_area_emitter
                                                 : VertexKind::area_emitter;
    v.position = emission.position;
    v.error = emission.error;
    v.ng = emission.ng;
  }
  v.exact = is_delta(emission.kind);
  return v;
}

/// Traces one light subpath and appends its VPLs (strength N I, so not yet divided by the number of paths) to `out`.
/// Keeps VPLs with at most `max_edges - 2` segments behind them: no longer path can be connected. `Sink`: what has
/// `push_back`; if it has `scattered(is_delta)` too, that is told every direction drawn and ends the path by false.
template <class Scene, SampleStream Stream, class Sink = std::vector<VertexOf<Scene>>>
class LightSubpath {
 public:
  using S = typename Scene::Scalar;

  LightSubpath(const Scene& scene, unsigned max_edges, Stream& stream, RayCounts& rays, Sink& out)
      : scene_(scene), max_edges_(max_edges), stream_(stream), rays_(rays), out_(out) {}

  void trace() {
    const S u_select = stream_.next();
    const Vec2<S> u_position = stream_.next_2d();
    const auto emission = scene_.emitters().sample_emission(u_select, u_position, stream_.next_2d());
    if (!emission) return;
    if (!is_delta(emission->kind) && max_edges_ >= 2) out_.push_back(emission_vertex<Scene>(*emission));
    WalkState<S> walk{start_ray(*emission), emission->beta};
    if constexpr (Scene::k_has_media) {
      // Light from infinity does not get through a medium without end.
      if (is_infinite(emission->kind) && scene_.media().outside() != k_vacuum) return;
      walk.medium = medium_at(scene_, walk.ray, rays_);
    }
    for (unsigned edges = 1; edges + 2 <= max_edges_; ++edges) {
      const Arrival<Scene> arrival = advance(scene_, walk, stream_, rays_);
      const Vec3<S> wi = -walk.ray.direction;
      if constexpr (Scene::k_has_media) {
        if (arrival.collision) {
          if (!scatter_and_store(walk, *arrival.collision, wi, edges)) return;
          continue;
        }
      }
      if (!arrival.surface) return;
      const auto hit = scene_.interaction(*arrival.surface, wi, walk.medium);
      if (!(std::abs(glm::dot(wi, hit.ng)) > S(0))) return;
      if constexpr (Scene::k_has_subsurface) {
        if (const auto* below = subsurface_at(scene_, hit, wi)) {
          if (!scatter_with_below(walk, hit, Submersion<Scene>(hit, *below, wi), wi, edges)) return;
          continue;
        }
      }
      if (!scatter_and_store(walk, hit, wi, edges)) return;
    }
  }

 private:
  [[nodiscard]] static Ray<S> start_ray(const EmissionSample<S>& emission) {
    const bool on_surface = emission.kind == EmitterKind::area;
    return {on_surface ? offset_origin(emission.position, emission.error, emission.ng, emission.wo) : emission.position,
            emission.wo};
  }

  template <class Hit>
  bool scatter_and_store(WalkState<S>& walk, const Hit& hit, const Vec3<S>& wi, unsigned edges) {
    const bool delta_only = is_delta(hit);
    auto vertex = vertex_at<Scene>(hit, wi, Walk::light, walk.beta);
    if (!delta_only && !(vertex.alpha > S(0))) return false;
    const S q = survival(delta_only ? walk.beta : vertex.strength);
    if (!survives(walk, q)) return false;
    if (!delta_only) {
      if (q < S(1)) vertex.strength /= q;
      store(vertex, edges);
    }
    return leave(walk, hit, wi);
  }

  /// A surface that also scatters below: a VPL for each, then the walk takes one of the ways.
  template <class Hit>
  bool scatter_with_below(WalkState<S>& walk, const Hit& hit, const Submersion<Scene>& submersion, const Vec3<S>& wi,
                          unsigned& edges) {
    if (!survives(walk, survival(walk.beta * (submersion.albedo() + albedo(hit))))) return false;
    store(submersion.vertex(walk.beta), edges);
    if (!is_delta(hit)) store(vertex_at<Scene>(hit, wi, Walk::light, walk.beta), edges);
    const S probability = submersion.probability();
    if (!(stream_.next() < probability)) {
      walk.beta /= S(1) - probability;
      return leave(walk, hit, wi);
    }
    const auto passage = submersion.pass(scene_, stream_, rays_);
    if (!passage) return false;
    walk.beta *= passage->factor / probability;
    return ++edges + 2 <= max_edges_ && scatter_and_store(walk, passage->out, wi, edges);
  }

  void store(VertexOf<Scene> vertex, unsigned edges) {
    vertex.edges = static_cast<std::uint16_t>(edges);
    if (max_channel(vertex.strength) > S(0) && is_finite(vertex.strength)) out_.push_back(vertex);
  }

  template <class Hit>
  bool leave(WalkState<S>& walk, const Hit& hit, const Vec3<S>& wi) {
    const std::optional<ScatterSample<S>> sample = sample_scatter<Scene>(hit, wi, Walk::light, stream_);
    if (!sample) return false;
    if constexpr (requires { out_.scattered(true); }) {
      if (!out_.scattered(sample->is_delta)) return false;
    }
    continue_walk(scene_, walk, hit, *sample);
    return true;
  }

  /// Roulette that keeps every VPL near the mean intensity flux / N, as the clamp assumes: q = min(1, N I / flux).
  [[nodiscard]] S survival(const Rgb<S>& power) const noexcept {
    return std::min(S(1), max_channel(power) / max_channel(scene_.emitters().total_flux()));
  }
  bool survives(WalkState<S>& walk, S q) {
    if (!(q > S(0))) return false;
    if (q < S(1)) {
      if (stream_.next() >= q) return false;
      walk.beta /= q;
    }
    return true;
  }

  const Scene& scene_;
  unsigned max_edges_;
  Stream& stream_;
  RayCounts& rays_;
  Sink& out_;
};

}  // namespace manylight
