// SPDX-License-Identifier: Apache-2.0
#pragma once

// The two walks of bidirectional path tracing [Veach 1997, chapter 10], with what their vertices' weights need.

#include <cmath>
#include <optional>

#include "manylight/path/bidirectional_start.hpp"
#include "manylight/path/bidirectional_vertex.hpp"

namespace manylight {

/// Traces walks of one scene.
template <class Scene, SampleStream Stream>
class BidirectionalWalk {
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
      const Place place{walk, edges, edges == max_edges};
      if constexpr (Scene::k_has_media) {
        if (arrival.collision) {
          if (!vertex(*arrival.collision, known, place, path)) return;
          continue;
        }
      }
      if (!arrival.surface) {
        if (walk == Walk::eye) escape(path);
        return;
      }
      const auto hit = scene_.interaction(*arrival.surface, known, state_.medium);
      if constexpr (Scene::k_has_subsurface) {
        if (const auto* below = subsurface_at(scene_, hit, known)) {
          const Submersion<Scene> submersion(hit, *below, known);
          if (!vertices_with_below(hit, submersion, known, place, max_edges, edges, path)) return;
          continue;
        }
      }
      if (!vertex(hit, known, place, path)) return;
    }
  }

  struct Place {
    Walk walk;
    unsigned edges;
    bool is_last;
  };

  /// Adds the vertex where the walk stands and draws the next direction; false where the walk ends.
  template <class Hit>
  bool vertex(const Hit& hit, const Vec3<S>& known, Place place, Subpath<Scene>& path) {
    BidirectionalVertex<Scene> v = arrived(hit, known, place, path);
    const bool goes_on = !place.is_last && leave(hit, known, place.walk, S(1), v);
    path.vertices.push_back(v);
    previous_ = v.vertex.position;
    return goes_on;
  }

  /// The vertex where the walk has come to, as far as nothing depends on where it goes on; `place` becomes the last where
  /// the direction grazes.
  template <class Hit>
  [[nodiscard]] BidirectionalVertex<Scene> arrived(const Hit& hit, const Vec3<S>& known, Place& place,
                                                   const Subpath<Scene>& path) {
    BidirectionalVertex<Scene> v;
    v.vertex = vertex_at<Scene>(hit, known, place.walk, state_.beta);
    v.vertex.edges = static_cast<std::uint16_t>(place.edges);
    v.is_delta = manylight::is_delta(hit);
    const S cosine = density_cosine(v.vertex, known);
    if (place.walk == Walk::eye) emission(hit, known, path, v);
    if (cosine > S(0)) {
      arrive(place.walk, v.vertex.position, cosine, path);
    } else {
      place.is_last = true;
      v.is_delta = true;
    }
    v.weights = weights_;
    absorption(hit, known, v);
    if constexpr (Scene::k_has_subsurface && requires { hit.point; }) {
      v.below.scattering = scene_.shader(hit.point.shape).subsurface();
      v.below.outward = hit.point.ng;
    }
    return v;
  }

  /// The same for a surface that scatters below, too, met from outside: adds the inner vertex, and where the walk goes that
  /// way, the outer one, which is one edge further.
  template <class Hit>
  bool vertices_with_below(const Hit& hit, const Submersion<Scene>& submersion, const Vec3<S>& known, Place place,
                           unsigned max_edges, unsigned& edges, Subpath<Scene>& path) {
    BidirectionalVertex<Scene> surface = arrived(hit, known, place, path);
    BidirectionalVertex<Scene> inner = surface;
    inner.vertex = submersion.vertex(state_.beta);
    inner.vertex.material = surface.vertex.material;
    inner.vertex.shading = surface.vertex.shading;
    inner.vertex.edges = surface.vertex.edges;
    inner.is_delta = false;
    inner.emission = Rgb<S>(0);
    const S share = place.is_last ? S(0) : detail::share_below(inner, known);
    const bool goes_below = !place.is_last && stream_.next() < share;
    const bool goes_on = !place.is_last && !goes_below && leave(hit, known, place.walk, S(1) - share, surface);
    path.vertices.push_back(surface);
    path.vertices.push_back(inner);
    previous_ = surface.vertex.position;
    // Nothing is connected with the end of an eye walk.
    if (!goes_below || (place.walk == Walk::eye && edges + 1 == max_edges)) return goes_on;
    const S q = share * survival_into(*inner.below.scattering, glm::dot(known, inner.below.outward));
    if (!(stream_.next() * share < q)) return false;
    const auto passage = submersion.pass(scene_, stream_, rays_);
    if (!passage) return false;
    state_.beta *= passage->factor / q;
    ++edges;
    return outer_vertex(passage->out, inner, q, {place.walk, edges, edges == max_edges}, path);
  }

  /// Where the walk comes out of the object; `q`: share of walks that went in, of those that came to `inner`.
  bool outer_vertex(const Surfacing<Scene>& out, const BidirectionalVertex<Scene>& inner, S q, const Place& place,
                    Subpath<Scene>& path) {
    BidirectionalVertex<Scene> v;
    v.vertex = vertex_at<Scene>(out, out.point.ng, place.walk, state_.beta);
    v.vertex.edges = static_cast<std::uint16_t>(place.edges);
    v.below = {out.below, out.point.ng, passage_pdf(*out.below, glm::length(out.point.position - previous_))};
    weights_.pass_below(q * v.below.passage_pdf, return_pdf(inner, inner.vertex.w, other_walk(place.walk)));
    v.weights = weights_;
    // Other walks that come here from outside choose between the object's surface and its inside.
    const auto from_outside = scene_.interaction(out.point, out.point.ng, out.medium);
    const auto as_surface = surface_vertex<VertexOf<Scene>>(from_outside, out.point.ng);
    v.vertex.material = as_surface.material;
    v.vertex.shading = as_surface.shading;
    if constexpr (Scene::ShaderType::k_may_absorb) v.absorption.here = v.absorption.beyond = state_.sigma_a;
    const bool goes_on = !place.is_last && leave(out, out.point.ng, place.walk, S(1), v);
    path.vertices.push_back(v);
    previous_ = v.vertex.position;
    return goes_on;
  }
  [[nodiscard]] static constexpr Walk other_walk(Walk walk) noexcept {
    return walk == Walk::eye ? Walk::light : Walk::eye;
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
    const EnvironmentLight<S> light = scene_.emitters().environment_light(direction);
    if (is_black(light.radiance)) return;
    path.environment = state_.beta * light.radiance;
    path.environment_weight =
        path.vertices.empty() ? S(1)
                              : weight_of_hit(weights_, light.pdf, walk_start_pdf(scene_, direction));
  }

  /// `share`: of the walks that come here and leave this way rather than below.
  template <class Hit>
  bool leave(const Hit& hit, const Vec3<S>& known, Walk walk, S share, BidirectionalVertex<Scene>& v) {
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
      const S pdf = v.vertex.is_in_medium() ? sample->pdf : share * q * sample->pdf;
      weights_.leave(cosine, pdf, return_pdf(v, sample->direction, other_walk(walk)));
    }
    continue_walk(scene_, state_, hit, *sample);
    state_.beta /= share * q;
    return true;
  }

  template <class Hit>
  [[nodiscard]] S survival_at(const Hit& hit, const Vec3<S>& known) const noexcept {
    if constexpr (requires { hit.below; }) {
      return survival_out(*hit.below);
    } else if constexpr (requires { hit.point; }) {
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
