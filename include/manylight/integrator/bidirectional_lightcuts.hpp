// SPDX-License-Identifier: Apache-2.0
#pragma once

// Bidirectional lightcuts [Walter, Khungurn, Bala 2012]: recursive virtual point sensors, the four weight constraints, and
// one cut per pixel through the product of its gather tree and the light tree.
//
//   for each pixel                                                   here
//     trace eye paths; store a VPS at each vertex not pruned           EyeSubpath, FourConstraints::prune
//     build the gather tree                                            GatherTree::build
//     refine the cut until every cluster's bound < 2 % of the total    CutSum
//     sum w S M T D I over representatives                             unoccluded_transfer, visibility
//
// Departures: the corrected pruning rule and Eq. 20 (theory sheet, 3.6 and 2.2); emitters that the eye path hits take the
// energy that the constraints leave (3.8, EmitterHits); the floor of lightcuts.hpp.

#include "manylight/integrator/lightcuts.hpp"
#include "manylight/path/four_constraints.hpp"

namespace manylight {

/// Renders `scene`; the light side comes from `prepare_lights` with the same config, `tree` is built over its VPLs. Image
/// in W/m^2/sr.
template <class Scene, Camera C, Sampler Random, Executor Exec, class Progress = NoProgress,
          PatternBounds<typename Scene::Material> B = AutomaticBounds>
[[nodiscard]] ManyLightImage<typename Scene::Scalar> render_bidirectional_lightcuts(
    const Scene& scene, const C& camera, const ReconstructionFilter<typename Scene::Scalar>& filter,
    const ManyLightConfig& config, const LightSide<Scene>& lights, const LightTree<Scene>& tree, const Random& sampler,
    const Exec& executor, const Progress& progress = {}, const B& bounds = {}) {
  const FourConstraints<typename Scene::Scalar> weighting(lights.weights);
  return render_by_cuts(scene, camera, filter, config, weighting, lights, tree, sampler, executor, progress,
                        bounds);
}

}  // namespace manylight
