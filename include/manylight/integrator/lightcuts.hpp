// SPDX-License-Identifier: Apache-2.0
#pragma once

// Lightcuts [Walter 2005] and multidimensional lightcuts [Walter 2006]: the sum over all pairs of a pixel's sensors (over
// its area and the lens) and all virtual point lights (direct, indirect and environment light in one list), by one cut per
// pixel through the product of gather tree and light tree. What the sum means is the weighting's choice:
//
//   weighting            sensors                    estimates
//   StandardWeighting    first ordinary vertex      what instant_radiosity.hpp sums by brute force
//   FourConstraints      recursive                  bidirectional_lightcuts.hpp
//   KolligKeller, ResidualWeighting                 the same without bias
//
// Departure: a floor of 1 % of L_a under the relative error threshold.

#include "manylight/integrator/many_light.hpp"

namespace manylight {

/// Part of L_a below which errors do not matter: without it black pixels always refine to the maximum cut.
inline constexpr double k_perceptual_floor = 0.01;

/// Renders `scene` with any weighting; the light side comes from `prepare_lights` with the same config, `tree` is built
/// over its VPLs. Image in W/m^2/sr.
template <class Scene, Camera C, Weighting W, Sampler Random, Executor Exec, class Progress = NoProgress,
          PatternBounds<typename Scene::Material> B = AutomaticBounds>
[[nodiscard]] ManyLightImage<typename Scene::Scalar> render_by_cuts(
    const Scene& scene, const C& camera, const ReconstructionFilter<typename Scene::Scalar>& filter,
    const ManyLightConfig& config, const W& weighting, const LightSide<Scene>& lights, const LightTree<Scene>& tree,
    const Random& sampler, const Exec& executor, const Progress& progress = {}, const B& bounds = {}) {
  const CutConfig cut{config.threshold, config.max_cut, k_perceptual_floor * lights.adaptation_luminance};
  const auto make_sum = [&] { return CutSum<Scene, W, B>(scene, weighting, tree, config.max_edges, cut, bounds); };
  return render_many_light(scene, camera, filter, config, weighting, make_sum, sampler, executor, progress);
}

/// Multidimensional lightcuts: `render_by_cuts` with the classical clamp.
template <class Scene, Camera C, Sampler Random, Executor Exec, class Progress = NoProgress,
          PatternBounds<typename Scene::Material> B = AutomaticBounds>
[[nodiscard]] ManyLightImage<typename Scene::Scalar> render_lightcuts(
    const Scene& scene, const C& camera, const ReconstructionFilter<typename Scene::Scalar>& filter,
    const ManyLightConfig& config, const LightSide<Scene>& lights, const LightTree<Scene>& tree, const Random& sampler,
    const Exec& executor, const Progress& progress = {}, const B& bounds = {}) {
  const StandardWeighting<typename Scene::Scalar> weighting(lights.weights);
  return render_by_cuts(scene, camera, filter, config, weighting, lights, tree, sampler, executor, progress,
                        bounds);
}

}  // namespace manylight
