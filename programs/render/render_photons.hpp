// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "manylight/integrator/photon_map.hpp"
#include "manylight/integrator/progressive_photon_mapping.hpp"
#include "render/passes.hpp"
#include "render/setup.hpp"

namespace manylight::render {

/// The one instant of what stands still. Throws ParameterError if something moves.
template <class Geometry, class Shader, class Media>
[[nodiscard]] const auto& still_scene(const Setup<Geometry, Shader, Media>& setup) {
  require(instant_count(setup.scene) == 1, "--method " + std::string(method_name(setup.options.method)),
          "for a scene in motion", "path, bdpt, vpl, ir, lightcuts or bdlc");
  return at_instant(setup.scene, 0);
}

/// What remains once all samples are in `sums`.
inline void report_photons(const PassLoop& loop, const PathStatistics& statistics, const Stopwatch& clock,
                           JobResult& result) {
  result.statistics.add_rays(statistics.rays);
  result.statistics.set_seconds("pixels", clock.seconds());
  result.statistics.set_samples(loop.done(), statistics.invalid);
  result.statistics.set_interrupted(loop.is_interrupted());
}

/// Method `pppm`: a sample is a pass with photons of its own.
template <class Geometry, class Shader, class Media>
void render_progressive_photons(const Setup<Geometry, Shader, Media>& setup, JobResult& result) {
  const Options& options = setup.options;
  const Stopwatch clock;
  ProgressivePhotonConfig config;
  config.light_paths = options.photon_paths;
  config.max_edges = setup.max_edges;
  const auto& scene = still_scene(setup);
  const auto& camera = at_instant(setup.camera, 0);
  const ProgressivePhotonIntegrator integrator(scene, config);
  PathStatistics statistics;
  const auto radii = initial_photon_radii(integrator, camera, setup.filter, setup.window, setup.sampler, setup.executor,
                                          statistics.rays);
  std::vector<Rgb<double>> sums(setup.window.pixel_count(), Rgb<double>(0));
  PassLoop loop(options, options.spp, SampleUnit::sample);
  const auto image = [&] { return mean_image(setup.window, sums, loop.done()); };
  while (const std::uint32_t count = loop.next()) {
    statistics += accumulate_photon_passes(integrator, camera, setup.filter, setup.window, radii, setup.sampler,
                                           loop.done(), count, sums, setup.executor, std::ref(loop));
    loop.finish(count, image);
  }
  result.image = image();
  report_photons(loop, statistics, clock, result);
}

/// Method `photonmap`.
template <class Geometry, class Shader>
void render_photon_map(const Setup<Geometry, Shader, NoMedia>& setup, JobResult& result) {
  const Options& options = setup.options;
  Stopwatch clock;
  PhotonMapConfig config;
  config.light_paths = options.photon_paths;
  config.caustic_paths = 5 * options.photon_paths;
  config.gather_rays = options.gather_rays;
  config.light_samples = options.light_samples;
  config.max_edges = setup.max_edges;
  const PhotonMaps<float> maps = prepare_photon_maps(setup.scene, config, setup.sampler, setup.executor);
  result.statistics.set_seconds("vpls", clock.seconds());
  clock = Stopwatch();
  const PhotonMapIntegrator integrator(setup.scene, config, maps);
  PathStatistics statistics;
  statistics.rays = maps.rays;
  std::vector<Rgb<double>> sums(setup.window.pixel_count(), Rgb<double>(0));
  PassLoop loop(options, options.spp, SampleUnit::sample);
  const auto image = [&] { return mean_image(setup.window, sums, loop.done()); };
  while (const std::uint32_t count = loop.next()) {
    statistics += accumulate_photon_map_samples(integrator, setup.camera, setup.filter, setup.window, setup.sampler,
                                                loop.done(), count, sums, setup.executor, std::ref(loop));
    loop.finish(count, image);
  }
  result.image = image();
  report_photons(loop, statistics, clock, result);
}

}  // namespace manylight::render
