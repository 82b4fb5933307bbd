// SPDX-License-Identifier: Apache-2.0
#pragma once

// Recursive virtual point sensors, [Walter 2012, section 5.1, Eq. 20] with the repairs of the theory sheet, section 2.2:
// beta_j = A_j c_j is the cosine-free throughput, S_j = beta_j alpha_j; both stay finite at grazing hits.

#include <cmath>
#include <utility>

#include "manylight/bounds/automatic.hpp"
#include "manylight/path/connect.hpp"
#include "manylight/path/direct_light.hpp"
#include "manylight/path/weighting.hpp"

namespace manylight {

/// A VPS with what its weights need to know of the vertices before it.
template <AnyVertex V, class Record>
struct SensorOf {
  V vertex;
  Record record;
};
template <class Scene, class W>
using Sensor = SensorOf<VertexOf<Scene>, typename W::Record>;

/// Bound of the sensor's own D over all light-side directions, sr^-1.
template <AnyVertex V, std::floating_point S = typename V::Scalar>
[[nodiscard]] inline S sup_sensor_d(const V& v) noexcept {
  if constexpr (V::k_may_be_in_medium) {
    if (v.is_in_medium()) return AutomaticBounds{}.sup_phase(v.phase, v.w, DirectionSet<S>());
  }
  if (v.is_outer()) return k_inv_pi<S>;
  const Vec3<S> wo = v.shading.frame().to_local(v.w);
  const S cosine = std::abs(glm::dot(v.w, v.ng));
  return cosine > S(0) ? AutomaticBounds{}.sup(v.material, DirectionSet<S>(), wo).eval * cosine / v.alpha : S(0);
}

/// Traces one eye subpath from the camera ray and hands its parts to `visitor`:
///  - `visitor.emission(radiance)`: light of an emitter that the path met itself or, where the weighting takes hits, that
///    was drawn for one of its vertices in place of such a hit, weighted, W/m^2/sr;
///  - `visitor.sensor(Sensor)`: a VPS to be connected.
/// `weight`: filter weight over number of eye samples of the pixel. Paths longer than `max_edges` contribute nothing.
template <class Scene, class W, SampleStream Stream, class Visitor>
class EyeSubpath {
  static_assert(Weighting<W>,
                "manylight::EyeSubpath: the weighting must model Weighting: Scalar, Record, start, extend, extend_delta, "
                "weight, hit_weight, binding, hit_binding, takes_hits, prune, prune_delta, limit, clamp, light_limit");

 public:
  using S = typename Scene::Scalar;

  EyeSubpath(const Scene& scene, const W& weighting, unsigned max_edges, Stream& stream, RayCounts& rays,
             Visitor& visitor)
      : scene_(scene), weighting_(weighting), max_edges_(max_edges), stream_(stream), rays_(rays), visitor_(visitor) {}

  void trace(const Ray<S>& camera_ray, S weight) {
    WalkState<S> walk{camera_ray, Rgb<S>(weight), Rgb<S>(0), medium_at(scene_, camera_ray, rays_)};
    typename W::Record record = weighting_.start();
    Step previous{};
    for (unsigned edges = 1; edges <= max_edges_; ++edges) {
      const Arrival<Scene> arrival = advance(scene_, walk, stream_, rays_);
      if constexpr (Scene::k_has_media) {
        if (arrival.collision) {
          record = arrive(record, previous, transit(previous, arrival.collision->position));
          if (!visit(walk, record, *arrival.collision, edges, previous)) return;
          continue;
        }
      }
      const std::optional<SurfacePoint<S>>& point = arrival.surface;
      if (!point) {
        const Rgb<S> radiance = hit_environment(scene_, walk.ray.direction, previous.bounce);
        if (is_black(radiance)) return;
        const typename W::Record end = arrive(record, previous, transit_to_infinity());
        visitor_.emission(walk.beta * radiance * weighting_.hit_weight(end, k_inv_pi<S>));
        return;
      }
      record = arrive(record, previous, transit(previous, point->position));
      if (!visit(walk, record, *point, edges, previous)) return;
    }
  }

 private:
  /// How the walk left the vertex before: what `extend` needs once the segment's length is known.
  struct Step {
    bool is_delta = false;
    bool is_first = true;
    S m{};
    S d{};
    Vec3<S> position{0};
    LastBounce<S> bounce;
  };

  [[nodiscard]] static S transit(const Step& step, const Vec3<S>& position) noexcept {
    const Vec3<S> to_previous = step.position - position;
    return S(1) / glm::dot(to_previous, to_previous);
  }
  [[nodiscard]] S transit_to_infinity() const noexcept { return S(1) / sqr(scene_.emitters().scene_radius()); }
  [[nodiscard]] typename W::Record arrive(const typename W::Record& record, const Step& step, S t) const {
    if (step.is_first) return record;
    return step.is_delta ? weighting_.extend_delta(record) : weighting_.extend(record, step.m, step.d, t);
  }

  /// Handles vertex v_j on a surface; returns false when the subpath ends here.
  bool visit(WalkState<S>& walk, typename W::Record& record, const SurfacePoint<S>& point, unsigned& edges,
             Step& step) {
    const Vec3<S> wo = -walk.ray.direction;
    const Rgb<S> emitted = hit_emission(scene_, point, wo, step.bounce);
    if (!is_black(emitted)) {
      const S d_emitter = std::abs(glm::dot(wo, point.ng)) * k_inv_pi<S>;
      visitor_.emission(walk.beta * emitted * weighting_.hit_weight(record, d_emitter));
    }
    const auto hit = scene_.interaction(point, wo, walk.medium);
    if constexpr (Scene::k_has_subsurface) {
      if (const auto* below = subsurface_at(scene_, hit, wo)) {
        return visit_with_below(walk, record, hit, Submersion<Scene>(hit, *below, wo), edges, step);
      }
    }
    return visit(walk, record, hit, edges, step);
  }
  /// The same for what scatters there: a surface, a medium, or what is below a surface.
  template <class Hit>
  bool visit(WalkState<S>& walk, const typename W::Record& record, const Hit& hit, unsigned edges, Step& step) {
    if (edges == max_edges_ || !survives(walk, albedo(hit))) return false;
    const bool pruned = is_delta(hit) || !store_sensor(walk, record, hit, edges);
    if (!pruned) draw_hit(walk, record, hit);
    return leave(walk, record, hit, -walk.ray.direction, pruned, step);
  }
  /// Hands out the sensor at `hit`; false if it and all behind it carry nothing.
  template <class Hit>
  bool store_sensor(const WalkState<S>& walk, const typename W::Record& record, const Hit& hit, unsigned edges) {
    auto vertex = vertex_at<Scene>(hit, -walk.ray.direction, Walk::eye, walk.beta);
    vertex.edges = static_cast<std::uint16_t>(edges);
    if (!(vertex.alpha > S(0)) || weighting_.prune(record, sup_sensor_d(vertex))) return false;
    visitor_.sensor(Sensor<Scene, W>{vertex, record});
    return true;
  }

  /// Draws a light for the vertex, in place of the emitter hit of a walk that leaves it towards that light: where small
  /// lamps are near, only one walk in many hits them, with all of what the clamp left.
  template <class Hit>
  void draw_hit(const WalkState<S>& walk, const typename W::Record& record, const Hit& hit) {
    if (!weighting_.takes_hits()) return;
    const Vec3<S> wo = -walk.ray.direction;
    const std::optional<DrawnLight<Scene>> drawn = draw_light(scene_, hit, wo, stream_);
    if (!drawn || drawn->light.is_delta) return;  // no walk hits a light of one direction or place
    const DirectSample<S>& light = drawn->light;
    const PatternMaxima<S> patterns = pattern_maxima(hit, light.wi, wo, drawn->scatter.f);
    if (!(patterns.m > S(0)) || !(patterns.d > S(0))) return;
    const Vec3<S> to_light = light.position - anchor(hit).position;
    const S t = light.infinite ? transit_to_infinity() : S(1) / glm::dot(to_light, to_light);
    const S d_emitter = light.infinite ? k_inv_pi<S> : std::abs(glm::dot(light.wi, light.ng)) * k_inv_pi<S>;
    const S weight = weighting_.hit_weight(weighting_.extend(record, patterns.m, patterns.d, t), d_emitter);
    if (!(weight > S(0))) return;
    const typename Scene::Passed passed = scene_.visibility(drawn->shadow_ray(anchor(hit)), rays_);
    visitor_.emission(walk.beta * drawn->scattered_radiance * passed * weight);
  }

  /// A surface that also scatters below: sensors for both, then the walk takes one of the ways.
  template <class Hit>
  bool visit_with_below(WalkState<S>& walk, typename W::Record& record, const Hit& hit, const Submersion<Scene>& submersion,
                        unsigned& edges, Step& step) {
    if (edges == max_edges_ || !survives(walk, submersion.albedo() + albedo(hit))) return false;
    auto vertex = submersion.vertex(walk.beta);
    vertex.edges = static_cast<std::uint16_t>(edges);
    const bool pruned = weighting_.prune(record, submersion.own_pattern());
    if (!pruned) visitor_.sensor(Sensor<Scene, W>{vertex, record});
    const S probability = submersion.probability();
    const bool surface_pruned = is_delta(hit) || !store_sensor(walk, record, hit, edges);
    if (!surface_pruned) draw_hit(walk, record, hit);
    if (!(stream_.next() < probability)) {
      walk.beta /= S(1) - probability;
      return leave(walk, record, hit, -walk.ray.direction, surface_pruned, step);
    }
    if (pruned) return false;
    const auto passage = submersion.pass(scene_, stream_, rays_);
    if (!passage) return false;
    walk.beta *= passage->factor / probability;
    record = weighting_.extend(record, k_inv_pi<S>, submersion.own_pattern(), passage->transit);
    return visit(walk, record, passage->out, ++edges, step);
  }

  /// Russian roulette where the strength is below half that of the path's first sensor: going on costs less than the noise
  /// of raising survivors to the whole.
  bool survives(WalkState<S>& walk, const Rgb<S>& scattering) {
    const S strength = max_channel(walk.beta * scattering);
    if (!(strength > S(0))) return false;
    if (!(reference_strength_ > S(0))) {
      reference_strength_ = strength;
      return true;
    }
    const S survival = std::min(S(1), S(2) * strength / reference_strength_);
    if (survival < S(1)) {
      if (stream_.next() >= survival) return false;
      walk.beta /= survival;
    }
    return true;
  }

  template <class Hit>
  bool leave(WalkState<S>& walk, const typename W::Record& record, const Hit& hit, const Vec3<S>& wo, bool pruned,
             Step& step) {
    const std::optional<ScatterSample<S>> sample = sample_scatter<Scene>(hit, wo, Walk::eye, stream_);
    if (!sample) return false;
    step.is_first = false;
    step.position = anchor(hit).position;
    step.is_delta = sample->is_delta;
    step.bounce = {step.position, sample->pdf, weighting_.takes_hits() && !sample->is_delta};
    if (sample->is_delta) {
      if (weighting_.prune_delta(record)) return false;
    } else {
      if (pruned) return false;
      const PatternMaxima<S> patterns = pattern_maxima(hit, sample->direction, wo, sample->f);
      step.m = patterns.m;
      step.d = patterns.d;
      if (!(step.m > S(0)) || !(step.d > S(0))) return false;
    }
    continue_walk(scene_, walk, hit, *sample);
    return true;
  }

  const Scene& scene_;
  const W& weighting_;
  unsigned max_edges_;
  Stream& stream_;
  RayCounts& rays_;
  Visitor& visitor_;
  S reference_strength_ = S(0);
};

}  // namespace manylight
