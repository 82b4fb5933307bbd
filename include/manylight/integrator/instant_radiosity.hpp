// SPDX-License-Identifier: Apache-2.0
#pragma once

// Instant radiosity [Keller 1997] by brute force: every pair of a first-hit sensor and a virtual point light, weighted by
// the classical clamp. The oracle of the cut-based methods; cost per pixel = eye paths x VPLs pairs.

#include "manylight/integrator/many_light.hpp"

namespace manylight {

/// The sum over all pairs with any weighting; the light side comes from `prepare_lights` with the same config. Image in
/// W/m^2/sr.
template <class Scene, Camera C, Weighting W, Sampler Random, Executor Exec, class Progress = NoProgress>
[[nodiscard]] ManyLightImage<typename Scene::Scalar> render_all_pairs(
    const Scene& scene, const C& camera, const ReconstructionFilter<typename Scene::Scalar>& filter,
    const ManyLightConfig& config, const W& weighting, const LightSide<Scene>& lights, const Random& sampler,
    const Exec& executor, const Progress& progress = {}) {
  const auto make_sum = [&] {
    return BruteForceSum<Scene, W>(scene, weighting, lights.lights.vpls, config.max_edges);
  };
  return render_many_light(scene, camera, filter, config, weighting, make_sum, sampler, executor, progress);
}

/// Instant radiosity: `render_all_pairs` with the classical clamp.
template <class Scene, Camera C, Sampler Random, Executor Exec, class Progress = NoProgress>
[[nodiscard]] ManyLightImage<typename Scene::Scalar> render_instant_radiosity(
    const Scene& scene, const C& camera, const ReconstructionFilter<typename Scene::Scalar>& filter,
    const ManyLightConfig& config, const LightSide<Scene>& lights, const Random& sampler, const Exec& executor,
    const Progress& progress = {}) {
  const StandardWeighting<typename Scene::Scalar> weighting(lights.weights);
  return render_all_pairs(scene, camera, filter, config, weighting, lights, sampler, executor, progress);
}

}  // namespace manylight
