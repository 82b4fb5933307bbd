// SPDX-License-Identifier: Apache-2.0
#pragma once

// Path tracing with next event estimation, the reference of all other methods [Kajiya 1986; Veach 1997, section 9.2].
// Each bounce draws one light and one direction; both find the same light, weighted by the balance heuristic
// (path/direct_light.hpp).
//
// Roulette multiplies the throughput only; it needs no place in the weights, which sum to one for any split of the light.

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "manylight/integrator/pixel_samples.hpp"
#include "manylight/path/direct_light.hpp"
#include "manylight/path/transfer.hpp"

namespace manylight {

struct PathConfig {
  unsigned max_edges = k_unlimited_edges;  ///< longest path, segments: 1 sees emitters only, 2 adds direct light
  unsigned roulette_edges = 4;             ///< roulette from this segment on
  /// Light that a Dirac lobe lets straight through, as through a thin pane, adds no segment to `max_edges`.
  bool straight_is_free = false;

  /// Throws ParameterError.
  void validate() const { require(max_edges >= 1, "maximum path length", max_edges, "at least 1 segment"); }
};

template <class Scene>
class PathIntegrator {
 public:
  using S = typename Scene::Scalar;

  PathIntegrator(const Scene& scene, const PathConfig& config) : scene_(scene), config_(config) { config.validate(); }

  /// Estimate of the radiance along `ray`, W/m^2/sr.
  template <SampleStream Stream>
  [[nodiscard]] Rgb<S> radiance(const Ray<S>& ray, Stream& stream, RayCounts& rays) const {
    Sum sum;
    trace(ray, stream, rays, sum);
    return sum.radiance;
  }

  /// The walk behind `radiance`, whose parts go to `visitor` in path order; radiances are already multiplied by the walk's
  /// throughput and their share, W/m^2/sr, often 0:
  ///  - `arrive(position)`: the walk has reached its next vertex;
  ///  - `emission(radiance, point, wo)`: the path that ends on an emitter at that vertex;
  ///  - `environment(radiance)`: the path that leaves the scene;
  ///  - `direct(radiance, hit, wo, light, f)`: the path that ends at a light drawn for that vertex, an Interaction or a
  ///    MediumInteraction, f the BSDF, sr^-1, or sigma_s f_p;
  ///  - `leave(hit, wo, sample)`: the walk goes on from that vertex;
  ///  - `pass_below(m, d, t, position)`: it goes through an object to its next vertex, with the M and D of the one it stood
  ///    at (sr^-1) and the segment's T (m^-2).
  template <SampleStream Stream, class Visitor>
  void trace(const Ray<S>& ray, Stream& stream, RayCounts& rays, Visitor& visitor) const;

 private:
  using Bounce = LastBounce<S>;
  struct Sum {
    Rgb<S> radiance{0};
    void arrive(const Vec3<S>&) const noexcept {}
    void emission(const Rgb<S>& part, const SurfacePoint<S>&, const Vec3<S>&) noexcept { radiance += part; }
    void environment(const Rgb<S>& part) noexcept { radiance += part; }
    template <class Hit>
    void direct(const Rgb<S>& part, const Hit&, const Vec3<S>&, const DirectSample<S>&, const Rgb<S>&) noexcept {
      radiance += part;
    }
    template <class Hit>
    void leave(const Hit&, const Vec3<S>&, const ScatterSample<S>&) const noexcept {}
    void pass_below(S, S, S, const Vec3<S>&) const noexcept {}
  };

  template <class Hit, SampleStream Stream, class Visitor>
  [[nodiscard]] bool bounce_at(const Hit& hit, WalkState<S>& walk, unsigned& edges, Bounce& bounce, Stream& stream,
                               RayCounts& rays, Visitor& visitor) const;
  template <class Hit, SampleStream Stream, class Visitor>
  [[nodiscard]] bool scatter_at(const Hit& hit, WalkState<S>& walk, unsigned& edges, Bounce& bounce, Stream& stream,
                                Visitor& visitor) const;
  template <class Hit, SampleStream Stream, class Visitor>
  [[nodiscard]] bool bounce_with_below(const Hit& hit, const Submersion<Scene>& submersion, WalkState<S>& walk,
                                       unsigned& edges, Bounce& bounce, Stream& stream, RayCounts& rays,
                                       Visitor& visitor) const;
  template <class Hit, SampleStream Stream, class Visitor>
  void direct(const Rgb<S>& beta, const Hit& hit, const Vec3<S>& wo, Stream& stream, RayCounts& rays,
              Visitor& visitor) const;

  const Scene& scene_;
  PathConfig config_;
};

template <class Scene>
template <SampleStream Stream, class Visitor>
void PathIntegrator<Scene>::trace(const Ray<S>& ray, Stream& stream, RayCounts& rays, Visitor& visitor) const {
  WalkState<S> walk{ray, Rgb<S>(1), Rgb<S>(0), medium_at(scene_, ray, rays)};
  Bounce bounce;
  for (unsigned edges = 1; edges <= config_.max_edges; ++edges) {
    const Arrival<Scene> arrival = advance(scene_, walk, stream, rays);
    if constexpr (Scene::k_has_media) {
      if (arrival.collision) {
        visitor.arrive(arrival.collision->position);
        if (edges == config_.max_edges) break;
        if (!bounce_at(*arrival.collision, walk, edges, bounce, stream, rays, visitor)) break;
        continue;
      }
    }
    if (!arrival.surface) return visitor.environment(walk.beta * hit_environment(scene_, walk.ray.direction, bounce));
    const SurfacePoint<S>& point = *arrival.surface;
    visitor.arrive(point.position);
    const Vec3<S> wo = -walk.ray.direction;
    visitor.emission(walk.beta * hit_emission(scene_, point, wo, bounce), point, wo);
    const bool is_last = edges == config_.max_edges;
    if (is_last && !config_.straight_is_free) break;
    const auto hit = scene_.interaction(point, wo, walk.medium);
    if (is_last && !is_delta(hit)) break;
    if constexpr (Scene::k_has_subsurface) {
      if (const auto* below = subsurface_at(scene_, hit, wo)) {
        const Submersion<Scene> submersion(hit, *below, wo);
        if (!bounce_with_below(hit, submersion, walk, edges, bounce, stream, rays, visitor)) break;
        continue;
      }
    }
    if (!bounce_at(hit, walk, edges, bounce, stream, rays, visitor)) break;
  }
}

/// A surface that also scatters below: the walk takes one of the ways. Below, the path's next vertex is where it comes out.
template <class Scene>
template <class Hit, SampleStream Stream, class Visitor>
bool PathIntegrator<Scene>::bounce_with_below(const Hit& hit, const Submersion<Scene>& submersion, WalkState<S>& walk,
                                              unsigned& edges, Bounce& bounce, Stream& stream, RayCounts& rays,
                                              Visitor& visitor) const {
  const S probability = submersion.probability();
  const Vec3<S> wo = -walk.ray.direction;
  if (!is_delta(hit)) direct(walk.beta, hit, wo, stream, rays, visitor);
  if (!(stream.next() < probability)) {
    walk.beta /= S(1) - probability;
    return scatter_at(hit, walk, edges, bounce, stream, visitor);
  }
  const auto passage = submersion.pass(scene_, stream, rays);
  if (!passage) return false;
  visitor.pass_below(k_inv_pi<S>, submersion.own_pattern(), passage->transit, passage->out.point.position);
  walk.beta *= passage->factor / probability;
  return ++edges < config_.max_edges && bounce_at(passage->out, walk, edges, bounce, stream, rays, visitor);
}

/// Light drawn for the vertex, then the next direction; false where the walk ends.
template <class Scene>
template <class Hit, SampleStream Stream, class Visitor>
bool PathIntegrator<Scene>::bounce_at(const Hit& hit, WalkState<S>& walk, unsigned& edges, Bounce& bounce, Stream& stream,
                                      RayCounts& rays, Visitor& visitor) const {
  if (!is_delta(hit)) direct(walk.beta, hit, -walk.ray.direction, stream, rays, visitor);
  return scatter_at(hit, walk, edges, bounce, stream, visitor);
}

template <class Scene>
template <class Hit, SampleStream Stream, class Visitor>
bool PathIntegrator<Scene>::scatter_at(const Hit& hit, WalkState<S>& walk, unsigned& edges, Bounce& bounce,
                                       Stream& stream, Visitor& visitor) const {
  const Vec3<S> wo = -walk.ray.direction;
  const std::optional<ScatterSample<S>> sample = sample_scatter<Scene>(hit, wo, Walk::eye, stream);
  if (!sample) return false;
  if (!sample->is_delta) bounce = {anchor(hit).position, sample->pdf, true};
  else bounce.is_weighted = false;
  constexpr S k_straight = S(1) - S(16) * std::numeric_limits<S>::epsilon();  // two unit vectors, opposite but for rounding
  const bool is_free = config_.straight_is_free && sample->is_delta && glm::dot(sample->direction, wo) < -k_straight;
  if (edges == config_.max_edges && !is_free) return false;
  visitor.leave(hit, wo, *sample);
  continue_walk(scene_, walk, hit, *sample);
  if (edges + 1 >= config_.roulette_edges) {
    const S survival = survival_by_throughput(walk.beta);
    if (!(stream.next() < survival)) return false;
    walk.beta /= survival;
  }
  if (is_free) --edges;
  return true;
}

template <class Scene>
template <class Hit, SampleStream Stream, class Visitor>
void PathIntegrator<Scene>::direct(const Rgb<S>& beta, const Hit& hit, const Vec3<S>& wo, Stream& stream,
                                   RayCounts& rays, Visitor& visitor) const {
  const std::optional<DrawnLight<Scene>> drawn = draw_light(scene_, hit, wo, stream);
  if (!drawn) return;
  const Rgb<S> arriving = drawn->scattered_radiance * scene_.visibility(drawn->shadow_ray(anchor(hit)), rays);
  visitor.direct(beta * arriving, hit, wo, drawn->light, drawn->scatter.f);
}

/// Of a scene in motion: one per instant.
template <class S>
class PathIntegrator<Instants<S>> {
 public:
  PathIntegrator(const Instants<S>& scenes, const PathConfig& config) {
    for (std::uint32_t i = 0; i < scenes.instants(); ++i) integrators_.emplace_back(scenes.at(i), config);
  }
  [[nodiscard]] std::uint32_t instants() const noexcept { return static_cast<std::uint32_t>(integrators_.size()); }
  [[nodiscard]] const PathIntegrator<S>& at(std::uint32_t instant) const noexcept { return integrators_[instant]; }

 private:
  std::vector<PathIntegrator<S>> integrators_;
};

/// Sums samples [first, first + count) of every pixel of `window` into `sums` (row by row, W/m^2/sr): call it with
/// consecutive ranges to refine an image; the split into ranges does not change it. Throws ParameterError unless the
/// window lies in the film and `sums` has a place for each of its pixels.
template <class Scene, Camera C, Sampler Random, Executor Exec, class Progress = NoProgress>
PathStatistics accumulate_path_samples(const PathIntegrator<Scene>& integrator, const C& camera,
                                       const ReconstructionFilter<typename Scene::Scalar>& filter, const Window& window,
                                       const Random& sampler, std::uint32_t first, std::uint32_t count,
                                       std::vector<Rgb<double>>& sums, const Exec& executor,
                                       const Progress& progress = {}) {
  using S = typename Scene::Scalar;
  const auto radiance = [&](const Ray<S>& ray, std::size_t, std::uint32_t instant, auto& stream, RayCounts& rays) {
    return at_instant(integrator, instant).radiance(ray, stream, rays);
  };
  return detail::accumulate_samples<S>(camera, instant_count(integrator), filter, window, sampler, first, count, sums,
                                       radiance, executor, progress);
}

}  // namespace manylight
