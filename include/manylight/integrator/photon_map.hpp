// SPDX-License-Identifier: Apache-2.0
#pragma once

// Photon mapping with final gather [Jensen 2001b, chapters 7 to 9]. Which part of the light at a vertex x of the eye
// walk is found how, x being the first that is not a Dirac lobe's:
//
//   light of an emitter at x      drawn lights and gather rays that hit emitters, by the balance heuristic
//   the same through Dirac lobes  map of caustics at x
//   all else                      gather rays from x; at their next vertex y the map of all photons
//
// Where the map cannot do it, y is treated as x is, with one gather ray: at glossy surfaces, and where y is nearer to x
// than the radius of its lookup, as in corners, whose blur would be seen. Gather rays follow Dirac lobes, behind which
// emitters do not count: that light is in the map of caustics of the vertex before.

#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "manylight/integrator/glossy.hpp"
#include "manylight/integrator/photon_map_light.hpp"
#include "manylight/integrator/pixel_samples.hpp"
#include "manylight/path/direct_light.hpp"

namespace manylight {

namespace detail {

/// Replaces the first draws of a stream by the i-th point of a randomly shifted lattice: every point alone is uniform.
template <SampleStream Stream>
class LatticeStream {
 public:
  using Scalar = typename Stream::Scalar;
  using S = Scalar;
  LatticeStream(Stream& rest, S shift, const Vec2<S>& shift_2d, unsigned i, unsigned count) noexcept : rest_(rest) {
    const S t = static_cast<S>(i) / static_cast<S>(count);
    first_ = wrap(shift + t);
    // The golden ratio's conjugate, in double: float would lose the last points of long lattices.
    first_2d_ = {wrap(shift_2d.x + t), wrap(shift_2d.y + static_cast<S>(std::fmod(0.6180339887498949 * i, 1.0)))};
  }
  [[nodiscard]] S next() noexcept { return take_ ? (take_ = false, first_) : rest_.next(); }
  [[nodiscard]] Vec2<S> next_2d() noexcept { return take_2d_ ? (take_2d_ = false, first_2d_) : rest_.next_2d(); }

 private:
  [[nodiscard]] static S wrap(S x) noexcept {
    x -= std::floor(x);
    return x < S(1) ? x : S(0);
  }
  Stream& rest_;
  S first_;
  Vec2<S> first_2d_;
  bool take_ = true;
  bool take_2d_ = true;
};

}  // namespace detail

template <class Scene>
class PhotonMapIntegrator {
  static_assert(!Scene::k_has_media,
                "manylight::PhotonMapIntegrator: photon mapping with final gather knows no participating media; a scene "
                "with media is rendered by PathIntegrator, BidirectionalPathIntegrator or ProgressivePhotonIntegrator");

 public:
  using S = typename Scene::Scalar;

  /// `maps`: by `prepare_photon_maps` with the same scene and config; they must outlive this. Throws ParameterError.
  PhotonMapIntegrator(const Scene& scene, const PhotonMapConfig& config, const PhotonMaps<S>& maps)
      : scene_(scene), config_(config), maps_(maps) {
    config.validate();
  }

  /// Estimate of the radiance along `ray`, W/m^2/sr.
  template <SampleStream Stream>
  [[nodiscard]] Rgb<S> radiance(const Ray<S>& ray, Stream& stream, RayCounts& rays) const {
    Estimate<Stream> estimate{stream, rays, Rgb<S>(0), {}};
    Branch branch;
    branch.walk.ray = ray;
    follow(branch, estimate);
    return estimate.sum;
  }

 private:
  /// What lies between a branch's next vertex and the last one that was not a Dirac lobe's.
  enum class Since : std::uint8_t { camera, scattering, dirac };
  struct Branch {
    WalkState<S> walk;
    unsigned edges = 1;     ///< of the next vertex
    bool may_split = true;  ///< one gather ray has not yet become many
    Since since = Since::camera;
    Vec3<S> from{0};        ///< where it scattered last
    S pdf = S(0);           ///< of the direction drawn there, sr^-1
    S light_share = S(1);   ///< lights drawn there per direction drawn there
  };
  template <class Stream>
  struct Estimate {
    Stream& stream;
    RayCounts& rays;
    Rgb<S> sum{0};
    NearestPhotons<S> scratch;
  };

  template <class Stream>
  void follow(Branch branch, Estimate<Stream>& estimate) const {
    WalkState<S>& walk = branch.walk;
    for (;; ++branch.edges) {
      const Arrival<Scene> arrival = advance(scene_, walk, estimate.stream, estimate.rays);
      const Vec3<S> wo = -walk.ray.direction;
      if (!arrival.surface) {
        estimate.sum += walk.beta * environment(branch);
        return;
      }
      estimate.sum += walk.beta * emission(branch, *arrival.surface, wo);
      if (branch.edges == config_.max_edges) return;
      const auto hit = scene_.interaction(*arrival.surface, wo, walk.medium);
      bool only_dirac = is_delta(hit);
      if (!only_dirac) {
        only_dirac = look_up(branch, hit, wo, estimate);
        if (!only_dirac) {
          const bool splits = branch.may_split;
          branch.light_share = splits ? static_cast<S>(config_.light_samples) / static_cast<S>(config_.gather_rays) : S(1);
          direct(branch, hit, wo, splits ? config_.light_samples : 1u, estimate);
          caustics(branch, hit, wo, estimate);
          if (splits) return gather(branch, hit, wo, estimate);
        }
      }
      if (!step(branch, hit, wo, estimate.stream, only_dirac)) return;
    }
  }

  template <class Hit, class Stream>
  void gather(Branch branch, const Hit& hit, const Vec3<S>& wo, Estimate<Stream>& estimate) const {
    branch.may_split = false;
    const unsigned count = config_.gather_rays;
    branch.walk.beta /= static_cast<S>(count);
    const S shift = estimate.stream.next();
    const Vec2<S> shift_2d = estimate.stream.next_2d();
    for (unsigned i = 0; i < count; ++i) {
      Branch ray = branch;
      detail::LatticeStream<Stream> lattice(estimate.stream, shift, shift_2d, i, count);
      if (!step(ray, hit, wo, lattice, false)) continue;
      ++ray.edges;
      follow(ray, estimate);
    }
  }

  /// Draws the next direction; false where the branch ends.
  template <class Hit, class Stream>
  [[nodiscard]] bool step(Branch& branch, const Hit& hit, const Vec3<S>& wo, Stream& stream, bool only_dirac) const {
    const std::optional<ScatterSample<S>> sample = sample_scatter<Scene>(hit, wo, Walk::eye, stream);
    if (!sample || (only_dirac && !sample->is_delta)) return false;
    if (sample->is_delta) {
      if (branch.since != Since::camera) branch.since = Since::dirac;
    } else {
      branch.since = Since::scattering;
      branch.from = hit.point.position;
      branch.pdf = sample->pdf;
    }
    const S before = max_channel(branch.walk.beta);
    continue_walk(scene_, branch.walk, hit, *sample);
    if (branch.edges + 1 >= config_.roulette_edges) {
      // By the change of this step: a branch is one of many and its throughput small for that reason alone.
      const S survival = std::min(S(0.99), max_channel(branch.walk.beta) / before);
      if (!(stream.next() < survival)) return false;
      branch.walk.beta /= survival;
    }
    return true;
  }

  /// With n lights per direction, the balance heuristic weights a hit by pdf / (pdf + n pL) = (pdf / n) / (pdf / n + pL).
  [[nodiscard]] static LastBounce<S> last_bounce(const Branch& branch) noexcept {
    return {branch.from, branch.pdf / branch.light_share, branch.since != Since::camera};
  }
  [[nodiscard]] Rgb<S> emission(const Branch& branch, const SurfacePoint<S>& point, const Vec3<S>& wo) const {
    return branch.since == Since::dirac ? Rgb<S>(0) : hit_emission(scene_, point, wo, last_bounce(branch));
  }
  [[nodiscard]] Rgb<S> environment(const Branch& branch) const {
    return branch.since == Since::dirac ? Rgb<S>(0)
                                        : hit_environment(scene_, branch.walk.ray.direction, last_bounce(branch));
  }

  template <class Hit, class Stream>
  void direct(const Branch& branch, const Hit& hit, const Vec3<S>& wo, unsigned count, Estimate<Stream>& estimate) const {
    if (branch.edges + 1 > config_.max_edges) return;
    const S shift = estimate.stream.next();
    const Vec2<S> shift_2d = estimate.stream.next_2d();
    const Rgb<S> strength = branch.walk.beta / static_cast<S>(count);
    for (unsigned i = 0; i < count; ++i) {
      detail::LatticeStream<Stream> lattice(estimate.stream, shift, shift_2d, i, count);
      const auto drawn = draw_light(scene_, hit, wo, lattice, branch.light_share);
      if (!drawn) continue;
      estimate.sum += strength * drawn->scattered_radiance *
                      scene_.visibility(drawn->shadow_ray(anchor(hit)), estimate.rays);
    }
  }

  template <class Hit, class Stream>
  void caustics(const Branch& branch, const Hit& hit, const Vec3<S>& wo, Estimate<Stream>& estimate) const {
    if (maps_.caustics.size() == 0) return;
    Rgb<S> sum(0);
    estimate_by_nearest(maps_.caustics, PhotonDisc<S>{hit.point.position, hit.ng}, config_.neighbours,
                        maps_.max_caustic_radius, config_.kernel, estimate.scratch, [&](const Photon<S>& photon, S weight) {
                          if (branch.edges + photon.edges > config_.max_edges) return;
                          sum += scattered(hit, photon.wi, wo).f * photon.power * weight;
                        });
    estimate.sum += branch.walk.beta * sum;
  }

  /// Adds what the map of all photons says of the vertex; false if it must not be asked.
  template <class Hit, class Stream>
  [[nodiscard]] bool look_up(const Branch& branch, const Hit& hit, const Vec3<S>& wo, Estimate<Stream>& estimate) const {
    if (branch.since == Since::camera) return false;
    const Vec3<S> to_last = branch.from - hit.point.position;
    const S squared_distance = glm::dot(to_last, to_last);
    // Its irradiance counts paths of two segments to here.
    const bool by_irradiance = maps_.irradiance.size() > 0 &&
                               (branch.edges == 2 || config_.max_edges == k_unlimited_edges);
    if (by_irradiance && is_lambertian(hit.material)) {
      const PhotonDisc<S> disc{hit.point.position, hit.ng, false};
      maps_.irradiance.find_nearest(disc, 1, maps_.max_radius, estimate.scratch);
      if (!estimate.scratch.empty()) {
        const IrradianceSample<S>& nearest = maps_.irradiance[estimate.scratch.front().second];
        if (squared_distance < sqr(nearest.radius)) return false;
        estimate.sum += branch.walk.beta * scattered(hit, hit.frame.n, wo).f * nearest.irradiance;
        return true;
      }
    }
    if (detail::is_glossy(hit, wo, static_cast<S>(config_.glossy_pdf))) return false;
    Rgb<S> sum(0);
    const S radius = estimate_by_nearest(maps_.global, PhotonDisc<S>{hit.point.position, hit.ng}, config_.neighbours,
                                         maps_.max_radius, config_.kernel, estimate.scratch,
                                         [&](const Photon<S>& photon, S weight) {
                                           if (branch.edges + photon.edges > config_.max_edges) return;
                                           sum += scattered(hit, photon.wi, wo).f * photon.power * weight;
                                         });
    if (squared_distance < sqr(radius)) return false;
    estimate.sum += branch.walk.beta * sum;
    return true;
  }

  const Scene& scene_;
  PhotonMapConfig config_;
  const PhotonMaps<S>& maps_;
};

/// Sums samples [first, first + count) of every pixel of `window` into `sums` (row by row, W/m^2/sr): call it with
/// consecutive ranges to refine an image, which keeps the error of the maps; the split into ranges does not change it.
/// Throws ParameterError unless the window lies in the film and `sums` has a place for each of its pixels.
template <class Scene, Camera C, Sampler Random, Executor Exec, class Progress = NoProgress>
PathStatistics accumulate_photon_map_samples(const PhotonMapIntegrator<Scene>& integrator, const C& camera,
                                             const ReconstructionFilter<typename Scene::Scalar>& filter,
                                             const Window& window, const Random& sampler, std::uint32_t first,
                                             std::uint32_t count, std::vector<Rgb<double>>& sums, const Exec& executor,
                                             const Progress& progress = {}) {
  using S = typename Scene::Scalar;
  const auto radiance = [&](const Ray<S>& ray, std::size_t, std::uint32_t, auto& stream, RayCounts& rays) {
    return integrator.radiance(ray, stream, rays);
  };
  return detail::accumulate_samples<S>(camera, 1, filter, window, sampler, first, count, sums, radiance, executor, progress);
}

}  // namespace manylight
