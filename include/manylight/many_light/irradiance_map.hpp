// SPDX-License-Identifier: Apache-2.0
#pragma once

// Irradiance found once, at photons, for all lookups that come near them [Christensen 1999]. As it is found only once,
// edges may cost something there: the part of the disc that has photons at all is measured by rays.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <type_traits>
#include <utility>
#include <vector>

#include "manylight/core/executor.hpp"
#include "manylight/many_light/photon_map.hpp"
#include "manylight/path/walk.hpp"
#include "manylight/scattering/lambertian.hpp"

namespace manylight {

/// Irradiance at the place of a photon.
template <std::floating_point S>
struct IrradianceSample {
  using Scalar = S;
  Vec3<S> position{0};
  Vec3<S> ng{0, 0, 1};
  Rgb<S> irradiance{0};  ///< W/m^2
  S radius = S(0);       ///< of its estimate, m
};

template <std::floating_point S>
struct IrradianceConfig {
  std::size_t neighbours = 50;         ///< at least 2
  std::size_t stride = 4;              ///< one sample per this many photons
  unsigned max_photon_edges = 0xFFFFu; ///< photons with more segments behind them do not count
  S max_radius = k_infinity<S>;        ///< m
  PhotonKernel kernel = PhotonKernel::constant;
};

/// Whether a material is Lambertian: then irradiance tells all that it reflects.
template <Material M>
[[nodiscard]] bool is_lambertian(const M& material) noexcept {
  if constexpr (std::is_same_v<M, Lambertian<typename M::Scalar>>) {
    return true;
  } else if constexpr (requires { material.visit([](const auto&) { return true; }); }) {
    return material.visit([](const auto& part) { return is_lambertian(part); });
  } else {
    return false;
  }
}

namespace detail {

/// Finds the irradiance at photons of one map. One thread's: it has scratch memory.
template <class Scene>
class IrradianceEstimator {
 public:
  using S = typename Scene::Scalar;

  IrradianceEstimator(const Scene& scene, const PhotonMap<Photon<S>>& map, const IrradianceConfig<S>& config,
                      RayCounts& rays)
      : scene_(scene), map_(map), config_(config), rays_(rays) {}

  /// The photon counts as its own neighbour: to a point between photons, the one next to it is a neighbour as well.
  [[nodiscard]] IrradianceSample<S> at(const Photon<S>& here) {
    neighbours_.clear();
    Vec3<S> sum_of_offsets(0);
    IrradianceSample<S> sample{here.position, here.ng};
    sample.radius = estimate_by_nearest(map_, PhotonDisc<S>{here.position, here.ng, false}, config_.neighbours,
                                        config_.max_radius, config_.kernel, scratch_, [&](const Photon<S>& p, S weight) {
                                          neighbours_.emplace_back(&p, weight);
                                          sum_of_offsets += p.position - here.position;
                                        });
    // Evenly spread photons have their centroid within this of the centre but for 1 in exp(4): each of its two
    // coordinates has the standard deviation r / (2 sqrt(n)). In half a disc it lies at 0.42 r.
    const auto count = static_cast<S>(neighbours_.size());
    const bool may_be_at_edge = glm::dot(sum_of_offsets, sum_of_offsets) > S(2) * count * sqr(sample.radius);
    const S covered = may_be_at_edge ? covered_part(here, sample.radius) : S(1);
    for (const auto& [photon, weight] : neighbours_) {
      if (photon->edges > config_.max_photon_edges) continue;
      if (may_be_at_edge && !is_seen(here, photon->position - here.position, sample.radius)) continue;
      sample.irradiance += photon->power * (weight / covered);
    }
    return sample;
  }

 private:
  /// Height over the surface at which photons are looked for, of the radius: the slab's.
  static constexpr S k_height = S(0.1);

  [[nodiscard]] bool is_seen(const Photon<S>& here, const Vec3<S>& offset, S radius) {
    if (!(glm::dot(offset, offset) > sqr(S(0.01) * radius))) return true;
    ++rays_.shadow;
    return !scene_.geometry().any_hit({here.position + here.ng * (k_height * radius), offset, S(0), S(1)});
  }
  /// Integral of the kernel over that part of the disc which is seen from its centre and reflects light in a way that
  /// leaves photons, by probes at 64 points of a spiral. At least 1/8: the estimate of a sliver.
  [[nodiscard]] S covered_part(const Photon<S>& here, S radius) {
    constexpr int k_probes = 64;
    const Frame<S> frame(here.ng);
    S sum = S(0), all = S(0);
    for (int i = 0; i < k_probes; ++i) {
      const S share = (static_cast<S>(i) + S(0.5)) / S(k_probes);
      const S angle = S(2.399963229728653) * static_cast<S>(i);  // the golden angle
      const S distance = radius * std::sqrt(share);
      const Vec3<S> offset = (frame.s * std::cos(angle) + frame.t * std::sin(angle)) * distance;
      const S weight = kernel_value(config_.kernel, sqr(distance), sqr(radius));
      all += weight;
      if (is_seen(here, offset, radius) && has_photons(here, offset, radius)) sum += weight;
    }
    return std::max(S(0.125), sum / all);
  }
  [[nodiscard]] bool has_photons(const Photon<S>& here, const Vec3<S>& offset, S radius) {
    ++rays_.closest;
    const S height = k_height * radius;
    const Ray<S> ray{here.position + here.ng * height + offset, -here.ng, S(0), S(2) * height};
    const auto hit = scene_.geometry().closest_hit(ray);
    if (!hit) return false;
    const auto point = surface_point(scene_.geometry().shapes(), ray, *hit);
    const auto there = scene_.interaction(point, here.ng);
    return glm::dot(there.ng, here.ng) > S(0.5) && !there.material.is_delta() && max_channel(there.material.albedo()) > S(0);
  }

  const Scene& scene_;
  const PhotonMap<Photon<S>>& map_;
  const IrradianceConfig<S>& config_;
  RayCounts& rays_;
  NearestPhotons<S> scratch_;
  std::vector<std::pair<const Photon<S>*, S>> neighbours_;
};

}  // namespace detail

/// Irradiance at every `stride`-th photon.
template <class Scene, std::floating_point S, Executor Exec>
[[nodiscard]] PhotonMap<IrradianceSample<S>> irradiance_map(const Scene& scene, const PhotonMap<Photon<S>>& map,
                                                            const IrradianceConfig<S>& config, const Exec& executor,
                                                            RayCounts& rays) {
  std::vector<IrradianceSample<S>> samples((map.size() + config.stride - 1) / config.stride);
  constexpr std::size_t k_per_batch = 256;
  std::vector<RayCounts> counts((samples.size() + k_per_batch - 1) / k_per_batch);
  executor.for_each_index(counts.size(), [&](std::size_t b) {
    detail::IrradianceEstimator<Scene> estimator(scene, map, config, counts[b]);
    const std::size_t end = std::min(samples.size(), (b + 1) * k_per_batch);
    for (std::size_t i = b * k_per_batch; i < end; ++i) samples[i] = estimator.at(map[i * config.stride]);
  });
  for (const RayCounts& batch : counts) rays += batch;
  return PhotonMap<IrradianceSample<S>>(std::move(samples));
}

}  // namespace manylight
