// SPDX-License-Identifier: Apache-2.0
#pragma once

// Densities with which light walks of bidirectional path tracing start.

#include "manylight/scene/scene.hpp"

namespace manylight {

/// Whether light walks from infinity are made: not if a medium without end is outside of all boundaries, for then there is
/// no place where they could start.
template <class Scene>
[[nodiscard]] bool has_walks_from_infinity(const Scene& scene) noexcept {
  if constexpr (Scene::k_has_media) return scene.media().outside() == k_vacuum;
  return true;
}

/// EmissionSample::projected_pdf of light walks from the direction `wi` at infinity; of `light` where it was drawn. 0 if
/// there are none.
template <class Scene>
[[nodiscard]] typename Scene::Scalar walk_start_pdf(const Scene& scene, const Vec3<typename Scene::Scalar>& wi) noexcept {
  using S = typename Scene::Scalar;
  return has_walks_from_infinity(scene) ? scene.emitters().projected_pdf_emission_environment(wi) : S(0);
}
template <class Scene>
[[nodiscard]] typename Scene::Scalar walk_start_pdf(const Scene& scene,
                                                    const DirectSample<typename Scene::Scalar>& light) noexcept {
  using S = typename Scene::Scalar;
  return light.infinite && !has_walks_from_infinity(scene) ? S(0) : scene.emitters().projected_pdf_emission(light);
}

/// Density with which `sample_direct` draws the start of a light walk for the point `reference`, sr^-1; of point lights
/// times the squared distance, of directional ones the selection alone.
template <class Scene>
[[nodiscard]] typename Scene::Scalar start_pdf_direct(const Scene& scene,
                                                      const EmissionSample<typename Scene::Scalar>& start,
                                                      const Vec3<typename Scene::Scalar>& reference) noexcept {
  using S = typename Scene::Scalar;
  if (is_infinite(start.kind)) return start.pdf_direction;
  const Vec3<S> segment = start.position - reference;
  if (start.kind == EmitterKind::point) return start.pdf_position * glm::dot(segment, segment);
  SurfacePoint<S> point{};
  point.position = start.position;
  point.ng = start.ng;
  point.shape = start.shape;
  point.primitive = start.primitive;
  return scene.emitters().pdf_direct(reference, point, glm::normalize(segment));
}

}  // namespace manylight
