// SPDX-License-Identifier: Apache-2.0
#pragma once

// The two walks of bidirectional path tracing [Veach 1997, chapter 10], with what their vertices' weights need.

#include <cmath>
#include <optional>

#include "manylight/path/bidirectional_vertex.hpp"

namespace manylight {

/// Whether light walks from infinity are made: not if a medium without end is outside of all boundaries, for then there is
/// no place where they could start.
template <class Scene>
[[nodiscard]] bool has_walks_from_infinity(const Scene& scene) noexcept {
  if constexpr (Scene::k_has_media) return scene.media().outside() == k_vacuum;
  return true;
}

/// EmissionSample::projected_pdf of light walks from the direction `wi` at infinity; of `light` where it was drawn. 0 if
/// there are none.
template <class Scene>
[[nodiscard]] typename Scene::Scalar walk_start_pdf(const Scene& scene, const Vec3<typename Scene::Scalar>& wi) noexcept {
  using S = typename Scene::Scalar;
  return has_walks_from_infinity(scene) ? scene.emitters().projected_pdf_emission_environment(wi) : S(0);
}
template <class Scene>
[[nodiscard]] typename Scene::Scalar walk_start_pdf(const Scene& scene,
                                                    const DirectSample<typename Scene::Scalar>& light) noexcept {
  using S = typename Scene::Scalar;
  return light.infinite && !has_walks_from_infinity(scene) ? S(0) : scene.emitters().projected_pdf_emission(light);
}

/// Density with which `sample_direct` draws the start of a light walk for the point `reference`, sr^-1; of point lights
/// times the squared distance, of directional ones the selection alone.
template <class Scene>
[[nodiscard]] typename Scene::Scalar start_pdf_direct(const Scene& scene,
                                                      const EmissionSample<typename Scene::Scalar>& start,
                                                      const Vec3<typename Scene::Scalar>& reference) noexcept {
  using S = typename Scene::Scalar;
  if (is_infinite(start.kind)) return start.pdf_direction;
  const Vec3<S> segment = start.position - reference;
  if (start.kind == EmitterKind::point) return start.pdf_position * glm::dot(segment, segment);
  SurfacePoint<S> point{};
  point.position = start.position;
  point.ng = start.ng;
  point.shape = start.shape;
  point.primitive = start.primitive;
  return scene.emitters().pdf_direct(reference, point, glm::normalize(segment));
}

/// Traces walks of one scene.
template <class Scene, SampleStream Stream>
class BidirectionalWalk {
  static_assert(!Scene::k_has_subsurface,
                "manylight::BidirectionalWalk: bidirectional path tracing knows no subsurface scattering; a scene whose "
                "shader has a Subsurface is rendered by PathIntegrator or by bidirectional lightcuts");

 public:
  using S = typename Scene::Scalar;

  BidirectionalWalk(const Scene& scene, Stream& stream, RayCounts& rays) : scene_(scene), stream_(stream), rays_(rays) {}

  /// A light walk of at most `max_edges` segments into `path`. Strengths are those of one walk: I, W.
  void trace_light(unsigned max_edges, Subpath<Scene>& path) {
    path.clear();
    const S u_select = stream_.next();
    const Vec2<S> u_position = stream_.next_2d();
    const auto start = scene_.emitters().sample_emission(u_select, u_position, stream_.next_2d());
    if (!start || !(max_channel(start->beta) > S(0))) return;
    if (is_infinite(start->kind) && !has_walks_from_infinity(scene_)) return;
    path.start = start;
    previous_ = start->position;
    const bool on_surface = start->kind == EmitterKind::area;
    const Ray<S> ray{
        on_surface ? offset_origin(start->position, start->error, start->ng, start->wo) : start->position, start->wo};
    state_ = {ray, start->beta, Rgb<S>(0), medium_at(scene_, ray, rays_)};
    go(Walk::light, max_edges, path);
  }

  /// An eye walk of at most `max_edges` segments from the camera ray; `weights` of its first segment.
  void trace_eye(const Ray<S>& ray, const PartialWeights<S>& weights, unsigned max_edges, Subpath<Scene>& path) {
    path.clear();
    previous_ = ray.origin;
    weights_ = weights;
    state_ = {ray, Rgb<S>(1), Rgb<S>(0), medium_at(scene_, ray, rays_)};
    go(Walk::eye, max_edges, path);
  }

 private:
  void go(Walk walk, unsigned max_edges, Subpath<Scene>& path) {
    for (unsigned edges = 1; edges <= max_edges; ++edges) {
      const Arrival<Scene> arrival = advance(scene_, state_, stream_, rays_);
      const Vec3<S> known = -state_.ray.direction;
      const bool is_last = edges == max_edges;
      if constexpr (Scene::k_has_media) {
        if (arrival.collision) {
          if (!vertex(*arrival.collision, known, walk, is_last, path)) return;
          continue;
        }
      }
      if (!arrival.surface) {
        if (walk == Walk::eye) escape(path);
        return;
      }
      const auto hit = scene_.interaction(*arrival.surface, known, state_.medium);
      if (!vertex(hit, known, walk, is_last, path)) return;
    }
  }

  /// Adds the vertex where the walk stands and draws the next direction; false where the walk ends.
  template <class Hit>
  bool vertex(const Hit& hit, const Vec3<S>& known, Walk walk, bool is_last, Subpath<Scene>& path) {
    BidirectionalVertex<Scene> v;
    v.vertex = vertex_at<Scene>(hit, known, walk, state_.beta);
    v.vertex.edges = static_cast<std::uint16_t>(path.vertices.size() + 1);
    v.is_delta = manylight::is_delta(hit);
    const S cosine = density_cosine(v.vertex, known);
    if (walk == Walk::eye) emission(hit, known, path, v);
    if (cosine > S(0)) {
      arrive(walk, v.vertex.position, cosine, path);
    } else {
      is_last = true;
      v.is_delta = true;
    }
    v.weights = weights_;
    absorption(hit, known, v);
    const bool goes_on = !is_last && leave(hit, known, walk, v);
    path.vertices.push_back(v);
    previous_ = v.vertex.position;
    return goes_on;
  }

  void arrive(Walk walk, const Vec3<S>& position, S cosine, const Subpath<Scene>& path) {
    if (walk == Walk::light && path.vertices.empty()) {
      weights_ = PartialWeights<S>::of_emission(start_pdf_direct(scene_, *path.start, position),
                                                path.start->projected_pdf(), cosine, manylight::is_delta(path.start->kind));
    } else {
      const Vec3<S> segment = position - previous_;
      weights_.arrive(glm::dot(segment, segment), cosine);
    }
  }

  /// s = 0. Nothing else finds a light that the first ray hits.
  template <class Hit>
  void emission(const Hit& hit, const Vec3<S>& wo, const Subpath<Scene>& path, BidirectionalVertex<Scene>& v) const {
    if constexpr (requires { hit.point; }) {
      const Emitters<S>& emitters = scene_.emitters();
      const Rgb<S> radiance = emitters.emitted(hit.point, wo);
      if (is_black(radiance)) return;
      v.emission = state_.beta * radiance;
      v.emission_weight = path.vertices.empty()
                              ? S(1)
                              : weight_of_hit(weights_, emitters.pdf_direct(previous_, hit.point, -wo),
                                              emitters.projected_pdf_emission(hit.point));
    }
  }
  void escape(Subpath<Scene>& path) const {
    const Vec3<S>& direction = state_.ray.direction;
    path.last_direction = direction;
    const Rgb<S> radiance = scene_.emitters().environment(direction);
    if (is_black(radiance)) return;
    path.environment = state_.beta * radiance;
    path.environment_weight =
        path.vertices.empty() ? S(1)
                              : weight_of_hit(weights_, scene_.emitters().pdf_direct_environment(direction),
                                              walk_start_pdf(scene_, direction));
  }

  template <class Hit>
  bool leave(const Hit& hit, const Vec3<S>& known, Walk walk, BidirectionalVertex<Scene>& v) {
    const S q = survival_at(hit, known);
    if (!(stream_.next() < q)) return false;
    const std::optional<ScatterSample<S>> sample = sample_scatter<Scene>(hit, known, walk, stream_);
    if (!sample) return false;
    const S cosine = density_cosine(v.vertex, sample->direction);
    if (!(cosine > S(0))) return false;
    v.left_by_dirac = sample->is_delta;
    if (sample->is_delta) {
      weights_.leave_by_dirac(cosine);
    } else {
      const S pdf = v.vertex.is_in_medium() ? sample->pdf : q * sample->pdf;
      const Walk other = walk == Walk::eye ? Walk::light : Walk::eye;
      weights_.leave(cosine, pdf, walk_pdf(v.vertex, sample->direction, known, other));
    }
    continue_walk(scene_, state_, hit, *sample);
    state_.beta /= q;
    return true;
  }

  template <class Hit>
  [[nodiscard]] S survival_at(const Hit& hit, const Vec3<S>& known) const noexcept {
    if constexpr (requires { hit.point; }) {
      return survival(hit.material, hit.frame.to_local(known));
    } else {
      const Rgb<S> sigma_t = scene_.media().medium(hit.medium).sigma_t(hit.position, known);
      S most = S(0);
      for (int channel = 0; channel < 3; ++channel) {
        if (sigma_t[channel] > S(0)) most = std::max(most, hit.sigma_s[channel] / sigma_t[channel]);
      }
      return std::min(most, S(0.99));
    }
  }

  /// The same rule as in `continue_walk`.
  template <class Hit>
  void absorption([[maybe_unused]] const Hit& hit, [[maybe_unused]] const Vec3<S>& known,
                  [[maybe_unused]] BidirectionalVertex<Scene>& v) const {
    if constexpr (Scene::ShaderType::k_may_absorb) {
      v.absorption.here = v.absorption.beyond = state_.sigma_a;
      if constexpr (requires { hit.point; }) {
        const bool goes_in = glm::dot(known, hit.point.ng) > S(0);
        v.absorption.beyond = goes_in ? scene_.shader(hit.point.shape).interior_absorption() : Rgb<S>(0);
      }
    }
  }

  const Scene& scene_;
  Stream& stream_;
  RayCounts& rays_;
  WalkState<S> state_{};
  PartialWeights<S> weights_{};
  Vec3<S> previous_{0};
};

}  // namespace manylight
