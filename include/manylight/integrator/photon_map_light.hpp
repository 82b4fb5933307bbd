// SPDX-License-Identifier: Apache-2.0
#pragma once

// The light side of photon mapping: maps of all photons, of caustics, and of irradiance.

#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "manylight/many_light/irradiance_map.hpp"
#include "manylight/many_light/photon_trace.hpp"
#include "manylight/path/transfer.hpp"

namespace manylight {

struct PhotonMapConfig {
  std::size_t light_paths = 200'000;       ///< of the map of all photons
  std::size_t caustic_paths = 1'000'000;   ///< of the map of caustics; traced only if the light paths leave caustics
  unsigned max_edges = k_unlimited_edges;  ///< longest path, segments
  unsigned roulette_edges = 4;             ///< roulette of eye walks from this segment on
  unsigned neighbours = 50;                ///< photons of a lookup, the one that gives the radius included
  double max_radius = 0;          ///< of a lookup, m; 0: 1/10 of the radius of the scene's bounding sphere
  double max_caustic_radius = 0;  ///< of a lookup of caustics, m; 0: 1/100 of it
  unsigned gather_rays = 2;    ///< per camera sample: more camera samples lessen all noise, more gather rays only theirs
  unsigned light_samples = 4;  ///< per camera sample
  /// Gather rays go on from vertices whose density of directions passes this, sr^-1, as photons would be too few for
  /// them.
  double glossy_pdf = 1;
  unsigned irradiance_stride = 4;  ///< irradiance is found at every n-th photon, for Lambertian surfaces; 0: nowhere
  PhotonKernel kernel = PhotonKernel::constant;

  /// Throws ParameterError.
  void validate() const {
    require(light_paths >= 1 && light_paths <= 0xFFFFFFFFu, "number of light paths", light_paths, "1 to 2^32 - 1");
    require(caustic_paths >= 1 && caustic_paths <= 0xFFFFFFFFu, "number of caustic paths", caustic_paths,
            "1 to 2^32 - 1");
    require(max_edges >= 1 && max_edges <= k_unlimited_edges, "maximum path length", max_edges, "1 to 65535 segments");
    require(neighbours >= 2, "number of neighbours", neighbours, "at least 2");
    require(max_radius >= 0 && std::isfinite(max_radius), "maximum radius", max_radius, "finite, at least 0");
    require(max_caustic_radius >= 0 && std::isfinite(max_caustic_radius), "maximum radius of caustics",
            max_caustic_radius, "finite, at least 0");
    require(gather_rays >= 1 && gather_rays <= 65536, "number of gather rays", gather_rays, "1 to 65536");
    require(light_samples >= 1 && light_samples <= 65536, "number of light samples", light_samples, "1 to 65536");
    require(glossy_pdf > 0, "limit of glossy directions", glossy_pdf, "above 0");
  }
};

template <std::floating_point S>
struct PhotonMaps {
  PhotonMap<Photon<S>> global;    ///< all photons
  PhotonMap<Photon<S>> caustics;  ///< those that Dirac lobes alone have led to, of light paths of their own
  PhotonMap<IrradianceSample<S>> irradiance;
  S max_radius = S(0);          ///< m
  S max_caustic_radius = S(0);  ///< m
  RayCounts rays;
};

/// Traces the photons and finds irradiance where they are. Throws ParameterError.
template <class Scene, Sampler Random, Executor Exec>
[[nodiscard]] PhotonMaps<typename Scene::Scalar> prepare_photon_maps(const Scene& scene, const PhotonMapConfig& config,
                                                                     const Random& sampler, const Exec& executor) {
  using S = typename Scene::Scalar;
  config.validate();
  PhotonMaps<S> maps;
  const S scene_radius = scene.emitters().scene_radius();
  maps.max_radius = config.max_radius > 0 ? static_cast<S>(config.max_radius) : scene_radius / S(10);
  maps.max_caustic_radius =
      config.max_caustic_radius > 0 ? static_cast<S>(config.max_caustic_radius) : scene_radius / S(100);
  auto global = trace_photons(scene, PhotonPaths{config.light_paths, config.max_edges}, 0, sampler, executor, maps.rays);
  bool has_caustics = false;
  for (const Photon<S>& photon : global.surface) has_caustics = has_caustics || photon.is_caustic;
  maps.global = PhotonMap<Photon<S>>(std::move(global.surface));
  if (has_caustics) {
    auto caustics = trace_photons(scene, PhotonPaths{config.caustic_paths, config.max_edges, true}, 1, sampler, executor,
                                  maps.rays);
    maps.caustics = PhotonMap<Photon<S>>(std::move(caustics.surface));
  }
  if (config.irradiance_stride > 0 && config.max_edges >= 3) {
    const IrradianceConfig<S> lookup{config.neighbours, config.irradiance_stride, config.max_edges - 2, maps.max_radius,
                                     config.kernel};
    maps.irradiance = irradiance_map(scene, maps.global, lookup, executor, maps.rays);
  }
  return maps;
}

}  // namespace manylight
