// SPDX-License-Identifier: Apache-2.0
#pragma once

// Progressive photon mapping in its probabilistic form [Knaus and Zwicker 2011]: independent passes, each with light
// paths of its own and one eye walk per pixel, which ends at its first vertex that is no mirror, smooth glass or glossy and
// sums the photons within a radius. The image is the mean over passes; the radius shrinks from pass to pass, so that
// variance and bias both vanish, at any number of passes in the same memory.
//
//   surface  r_i^2 = r_1^2 Gamma(i + alpha) / (Gamma(1 + alpha) Gamma(i + 1)),  r_{i+1}^2 = r_i^2 (i + alpha) / (i + 1)
//   medium   r_i^3 = the same of r_1^3, with an alpha of its own
//
// A pass has variance 1 / r^d and bias r^2. With r^d ~ i^(alpha - 1) the mean over I passes has variance ~ I^-alpha and
// bias ~ I^(2 (alpha - 1) / d); variance and squared bias fall alike for alpha = 2/3 on surfaces, 4/7 in media.

#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "manylight/integrator/glossy.hpp"
#include "manylight/integrator/pixel_samples.hpp"
#include "manylight/many_light/photon_trace.hpp"
#include "manylight/path/direct_light.hpp"
#include "manylight/path/transfer.hpp"

namespace manylight {

struct ProgressivePhotonConfig {
  std::size_t light_paths = 100'000;       ///< of one pass
  unsigned max_edges = k_unlimited_edges;  ///< longest path, segments
  unsigned roulette_edges = 4;             ///< roulette of eye walks from this segment on
  double initial_radius = 0;               ///< r_1 on surfaces, m; 0: that of the nearest photons of a pilot, per pixel
  unsigned initial_photons = 30;           ///< with `initial_radius` 0: how many of them
  double initial_medium_radius = 0;        ///< r_1 in media, m; 0: 1/50 of the radius of the scene's bounding sphere
  double alpha = 2.0 / 3;                  ///< radius law on surfaces, (0, 1)
  double medium_alpha = 4.0 / 7;           ///< radius law in media, (0, 1)
  /// Eye walks go on at vertices whose density of directions passes this, sr^-1: few photons lie in the directions of a
  /// narrow lobe. Infinity: none, all photons merge at the first vertex.
  double glossy_pdf = 1;

  /// Throws ParameterError.
  void validate() const {
    require(light_paths >= 1 && light_paths <= 0xFFFFFFFFu, "number of light paths", light_paths, "1 to 2^32 - 1");
    require(max_edges >= 1 && max_edges <= k_unlimited_edges, "maximum path length", max_edges, "1 to 65535 segments");
    require(initial_radius >= 0 && std::isfinite(initial_radius), "initial radius", initial_radius,
            "finite, at least 0 (0: by nearest photons)");
    require(initial_photons >= 2, "photons of the initial radius", initial_photons, "at least 2");
    require(initial_medium_radius >= 0 && std::isfinite(initial_medium_radius), "initial radius in media",
            initial_medium_radius, "finite, at least 0 (0: by the scene's size)");
    require(alpha > 0 && alpha < 1, "alpha", alpha, "above 0, below 1");
    require(medium_alpha > 0 && medium_alpha < 1, "alpha in media", medium_alpha, "above 0, below 1");
    require(glossy_pdf > 0, "limit of glossy directions", glossy_pdf, "above 0");
  }
};

/// r_i / r_1 of pass i = 1, 2, ...; `dimension` 2: surfaces, 3: media.
[[nodiscard]] inline double progressive_radius_factor(std::uint64_t pass, double alpha, int dimension) {
  const auto i = static_cast<double>(pass);
  return std::exp((std::lgamma(i + alpha) - std::lgamma(1 + alpha) - std::lgamma(i + 1)) / dimension);
}

/// Photons of one pass.
template <std::floating_point S>
struct ProgressivePhotonPass {
  PhotonMap<Photon<S>> surface;
  PhotonMap<Photon<S>> medium;
  S factor = S(1);         ///< r_i / r_1 on surfaces
  S medium_radius = S(0);  ///< m
};

template <class Scene>
class ProgressivePhotonIntegrator {
 public:
  using S = typename Scene::Scalar;

  ProgressivePhotonIntegrator(const Scene& scene, const ProgressivePhotonConfig& config)
      : scene_(scene), config_(config) {
    config.validate();
  }
  [[nodiscard]] const ProgressivePhotonConfig& config() const noexcept { return config_; }

  /// Traces the photons of pass i = 0, 1, ...
  template <Sampler Random, Executor Exec>
  [[nodiscard]] ProgressivePhotonPass<S> trace_pass(std::uint32_t i, const Random& sampler, const Exec& executor,
                                                    RayCounts& rays) const {
    PhotonSet<S> photons =
        trace_photons(scene_, PhotonPaths{config_.light_paths, config_.max_edges}, i, sampler, executor, rays);
    ProgressivePhotonPass<S> pass;
    pass.surface = PhotonMap<Photon<S>>(std::move(photons.surface));
    pass.factor = static_cast<S>(progressive_radius_factor(i + 1ull, config_.alpha, 2));
    if constexpr (Scene::k_has_media) {
      pass.medium = PhotonMap<Photon<S>>(std::move(photons.medium));
      pass.medium_radius = initial_medium_radius() *
                           static_cast<S>(progressive_radius_factor(i + 1ull, config_.medium_alpha, 3));
    }
    return pass;
  }

  /// Estimate of the radiance along `ray` by the photons of one pass, W/m^2/sr; `initial_radius`: r_1 on surfaces, m.
  template <SampleStream Stream>
  [[nodiscard]] Rgb<S> radiance(const Ray<S>& ray, const ProgressivePhotonPass<S>& pass, S initial_radius,
                                Stream& stream, RayCounts& rays) const {
    Rgb<S> merged(0);
    const auto on_surface = [&](const auto& hit, const Vec3<S>& wo, const Rgb<S>& beta, unsigned edges, bool all) {
      merged += beta * merge(hit, wo, pass, initial_radius * pass.factor, config_.max_edges - edges, all);
    };
    const auto in_medium = [&](const auto& collision, const Vec3<S>& wo, const Rgb<S>& beta, unsigned edges) {
      merged += beta * merge_in_medium(collision, wo, pass, config_.max_edges - edges);
    };
    const Rgb<S> emitted = walk(ray, stream, rays, on_surface, in_medium);
    return emitted + merged;
  }

  /// r_1 at the last surface where an eye walk merges: where the nearest photons of `pilot` end, at most 1/10 of the
  /// scene's radius, which is also that of walks which merge nowhere.
  template <SampleStream Stream>
  [[nodiscard]] S nearest_radius(const Ray<S>& ray, const PhotonMap<Photon<S>>& pilot, NearestPhotons<S>& scratch,
                                 Stream& stream, RayCounts& rays) const {
    const S largest = scene_.emitters().scene_radius() / S(10);
    S radius = largest;
    const auto on_surface = [&](const auto& hit, const Vec3<S>&, const Rgb<S>&, unsigned, bool) {
      pilot.find_nearest(PhotonDisc<S>{hit.point.position, hit.ng}, config_.initial_photons, largest, scratch);
      if (scratch.size() == config_.initial_photons) radius = std::sqrt(scratch.front().first);
    };
    (void)walk(ray, stream, rays, on_surface, [](const auto&, const Vec3<S>&, const Rgb<S>&, unsigned) {});
    return radius > S(0) ? radius : largest;
  }

 private:
  /// Follows the eye walk to where it merges with all photons; returns what it finds of lights themselves. A glossy vertex
  /// on its way shares its light out as in photon mapping with final gather: that of emitters to drawn lights and to hits
  /// by the walk, by the balance heuristic; the same through Dirac lobes to merging with the photons that these have led
  /// to; all else to the rest of the walk.
  template <SampleStream Stream, class OnSurface, class InMedium>
  [[nodiscard]] Rgb<S> walk(const Ray<S>& ray, Stream& stream, RayCounts& rays, const OnSurface& on_surface,
                            const InMedium& in_medium) const {
    Rgb<S> emitted(0);
    WalkState<S> walk{ray, Rgb<S>(1), Rgb<S>(0), medium_at(scene_, ray, rays)};
    LastBounce<S> glossy;           // at the last such vertex
    bool only_dirac_since = false;  // light from here is in the caustics of that vertex
    for (unsigned edges = 1;; ++edges) {
      const Arrival<Scene> arrival = advance(scene_, walk, stream, rays);
      const Vec3<S> wo = -walk.ray.direction;
      if constexpr (Scene::k_has_media) {
        if (arrival.collision) {
          in_medium(*arrival.collision, wo, walk.beta, edges);
          return emitted;
        }
      }
      if (!only_dirac_since) {
        emitted += walk.beta * (arrival.surface ? hit_emission(scene_, *arrival.surface, wo, glossy)
                                                : hit_environment(scene_, walk.ray.direction, glossy));
      }
      if (!arrival.surface) return emitted;
      if (edges == config_.max_edges) return emitted;
      const auto hit = scene_.interaction(*arrival.surface, wo, walk.medium);
      const bool goes_on = is_glossy(hit, wo);
      if (!is_delta(hit)) on_surface(hit, wo, walk.beta, edges, !goes_on);
      if (goes_on) emitted += walk.beta * direct(hit, wo, stream, rays);
      const std::optional<ScatterSample<S>> sample = sample_scatter<Scene>(hit, wo, Walk::eye, stream);
      // Behind a vertex that merges with all photons, Dirac lobes alone are left.
      if (!sample || (!goes_on && !sample->is_delta)) return emitted;
      only_dirac_since = sample->is_delta && glossy.is_weighted;
      if (!sample->is_delta) glossy = {hit.point.position, sample->pdf, true};
      continue_walk(scene_, walk, hit, *sample);
      if (edges + 1 >= config_.roulette_edges) {
        const S survival = survival_by_throughput(walk.beta);
        if (!(stream.next() < survival)) return emitted;
        walk.beta /= survival;
      }
    }
  }

  template <class Hit, SampleStream Stream>
  [[nodiscard]] Rgb<S> direct(const Hit& hit, const Vec3<S>& wo, Stream& stream, RayCounts& rays) const {
    const auto drawn = draw_light(scene_, hit, wo, stream);
    if (!drawn) return Rgb<S>(0);
    return drawn->scattered_radiance * scene_.visibility(drawn->shadow_ray(anchor(hit)), rays);
  }
  template <class Hit>
  [[nodiscard]] bool is_glossy(const Hit& hit, const Vec3<S>& wo) const noexcept {
    return config_.glossy_pdf < std::numeric_limits<double>::infinity() &&
           detail::is_glossy(hit, wo, static_cast<S>(config_.glossy_pdf));
  }

  /// Sum of f power over the photons in the disc, or those of caustics, per area.
  template <class Hit>
  [[nodiscard]] Rgb<S> merge(const Hit& hit, const Vec3<S>& wo, const ProgressivePhotonPass<S>& pass, S radius,
                             unsigned max_photon_edges, bool all) const {
    Rgb<S> sum(0);
    pass.surface.for_each_within(PhotonDisc<S>{hit.point.position, hit.ng}, radius, [&](const Photon<S>& photon, S) {
      if (photon.edges <= max_photon_edges && (all || photon.is_caustic)) {
        sum += scattered(hit, photon.wi, wo).f * photon.power;
      }
    });
    return sum * kernel_value(PhotonKernel::constant, S(0), radius * radius);
  }
  /// Sum of f_p power over the photons in the ball, per volume.
  template <class Collision>
  [[nodiscard]] Rgb<S> merge_in_medium(const Collision& collision, const Vec3<S>& wo,
                                       const ProgressivePhotonPass<S>& pass, unsigned max_photon_edges) const {
    Rgb<S> sum(0);
    const S radius = pass.medium_radius;
    pass.medium.for_each_within(PhotonBall<S>{collision.position}, radius, [&](const Photon<S>& photon, S) {
      // The power holds sigma_s(wi), for which the phase function of the known wi is the one.
      if (photon.edges <= max_photon_edges) sum += photon.power * collision.phase.eval(wo, photon.wi);
    });
    return sum * (S(0.75) * k_inv_pi<S> / (radius * radius * radius));
  }
  [[nodiscard]] S initial_medium_radius() const noexcept {
    return config_.initial_medium_radius > 0 ? static_cast<S>(config_.initial_medium_radius)
                                             : scene_.emitters().scene_radius() / S(50);
  }

  const Scene& scene_;
  ProgressivePhotonConfig config_;
};

/// r_1 of every pixel of `window`, row by row, m. Pilot light paths and eye walks have random numbers of their own: a
/// radius that depended on the photons it counts would bias the image.
template <class Scene, Camera C, Sampler Random, Executor Exec>
[[nodiscard]] std::vector<typename Scene::Scalar> initial_photon_radii(
    const ProgressivePhotonIntegrator<Scene>& integrator, const C& camera,
    const ReconstructionFilter<typename Scene::Scalar>& filter, const Window& window, const Random& sampler,
    const Exec& executor, RayCounts& rays) {
  using S = typename Scene::Scalar;
  window.validate(camera.width(), camera.height());
  std::vector<S> radii(window.pixel_count(), static_cast<S>(integrator.config().initial_radius));
  if (integrator.config().initial_radius > 0) return radii;
  // No pass has this number.
  const auto pilot = integrator.trace_pass(0xFFFFFFFFu, sampler, executor, rays);
  const auto render_tile = [&](const Window& tile) {
    RayCounts tile_rays;
    NearestPhotons<S> scratch;
    for (std::uint32_t y = tile.y0; y < tile.y1; ++y) {
      for (std::uint32_t x = tile.x0; x < tile.x1; ++x) {
        auto stream = sampler.stream(Stage::pilot, film_index(camera, x, y), 0);
        const Ray<S> ray = camera_ray(camera, filter, x, y, stream);
        radii[window.index(x, y)] = integrator.nearest_radius(ray, pilot.surface, scratch, stream, tile_rays);
      }
    }
    return tile_rays;
  };
  for (const RayCounts& tile : for_each_tile(window, executor, render_tile, NoProgress{})) rays += tile;
  return radii;
}

/// Adds the passes [first, first + count) of every pixel of `window` to `sums` (row by row, W/m^2/sr), which divided by
/// the number of passes is the image: call it with consecutive ranges to refine it; neither the split into ranges nor
/// the executor changes a bit. `radii`: by `initial_photon_radii`. Throws ParameterError unless the window lies in the
/// film, `sums` and `radii` have a place for each of its pixels, and every radius is above 0.
template <class Scene, Camera C, Sampler Random, Executor Exec, class Progress = NoProgress>
PathStatistics accumulate_photon_passes(const ProgressivePhotonIntegrator<Scene>& integrator, const C& camera,
                                        const ReconstructionFilter<typename Scene::Scalar>& filter,
                                        const Window& window, const std::vector<typename Scene::Scalar>& radii,
                                        const Random& sampler, std::uint32_t first, std::uint32_t count,
                                        std::vector<Rgb<double>>& sums, const Exec& executor,
                                        const Progress& progress = {}) {
  using S = typename Scene::Scalar;
  require(radii.size() == window.pixel_count(), "number of radii", radii.size(),
          "one per pixel of the window: " + std::to_string(window.pixel_count()));
  for (const S radius : radii) require(radius > S(0) && std::isfinite(radius), "initial radius", radius, "above 0");
  PathStatistics total;
  for (std::uint32_t i = first; i < first + count; ++i) {
    const auto pass = integrator.trace_pass(i, sampler, executor, total.rays);
    const auto radiance = [&](const Ray<S>& ray, std::size_t pixel, std::uint32_t, auto& stream, RayCounts& rays) {
      return integrator.radiance(ray, pass, radii[pixel], stream, rays);
    };
    total += detail::accumulate_samples<S>(camera, 1, filter, window, sampler, i, 1, sums, radiance, executor, progress);
  }
  return total;
}

}  // namespace manylight
