// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "integrator/builders.hpp"
#include "manylight/geometry/bvh.hpp"
#include "manylight/scattering/any_of.hpp"
#include "manylight/scattering/conductor.hpp"
#include "manylight/scattering/dielectric.hpp"
#include "manylight/scattering/lambertian.hpp"

// Scene types that many tests render: compiled once, in common_scenes_instances.cpp.

namespace manylight::test {

template <class G>
using DiffuseScene = Scene<G, UniformShader<Lambertian<typename G::Scalar>>>;
/// Diffuse, mirror or smooth glass.
template <std::floating_point S>
using SmoothMaterial = AnyOf<Lambertian<S>, Mirror<S>, Dielectric<S>>;
template <class G>
using SmoothScene = Scene<G, UniformShader<SmoothMaterial<typename G::Scalar>>>;

#define MANYLIGHT_TEST_RENDER(SCENE)                                                             \
  template Film render<SCENE, SerialExecutor>(Method, const SCENE&, const AnyCamera<SCENE::Scalar>&, \
                                                      const Settings&, const SerialExecutor&)
extern MANYLIGHT_TEST_RENDER(DiffuseScene<Bvh<float>>);
extern MANYLIGHT_TEST_RENDER(DiffuseScene<Bvh<double>>);
extern MANYLIGHT_TEST_RENDER(SmoothScene<Bvh<float>>);
extern MANYLIGHT_TEST_RENDER(SmoothScene<Bvh<double>>);

}  // namespace manylight::test
