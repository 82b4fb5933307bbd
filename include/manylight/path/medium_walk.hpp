// SPDX-License-Identifier: Apache-2.0
#pragma once

// Walks through participating media: free flights between surfaces [Walter 2012, Eq. 15, 16; theory 2.4]. With A the
// throughput and tau the transmittance, a flight that ends at a collision multiplies A by tau / density per metre, one that
// gets to a surface by tau / probability; sigma_s comes in when the collision scatters.

#include <cmath>
#include <optional>

#include "manylight/scene/scene.hpp"

namespace manylight {

/// A walk between two vertices.
template <std::floating_point S>
struct WalkState {
  Ray<S> ray;         ///< unit direction
  Rgb<S> beta{1};     ///< cosine-free throughput at the next vertex
  Rgb<S> sigma_a{0};  ///< absorption of the dielectric that the segment runs through, m^-1
  MediumId medium = k_vacuum;
};

/// A point of a medium where a walk collided, seen from the known direction.
template <class Scene>
struct MediumInteraction {
  using S = typename Scene::Scalar;
  Vec3<S> position;
  MediumId medium;
  typename Scene::Phase phase;
  Rgb<S> sigma_s;  ///< for the known direction, m^-1
};

/// The medium at the origin of `ray`: that on the near side of the first boundary along it.
template <class Scene>
[[nodiscard]] MediumId medium_at(const Scene& scene, Ray<typename Scene::Scalar> ray, RayCounts& rays) {
  if constexpr (!Scene::k_has_media) {
    return k_vacuum;
  } else {
    if (!scene.media().has_boundaries()) return scene.media().outside();
    for (;;) {
      ++rays.closest;
      const auto hit = scene.geometry().closest_hit(ray);
      if (!hit) return scene.media().outside();
      const auto point = surface_point(scene.geometry().shapes(), ray, *hit);
      if (scene.media().is_boundary(point.shape)) return scene.media().behind(point, -ray.direction, k_vacuum);
      ray = Scene::beyond(ray, point);
    }
  }
}

/// Beer's law over `length` (m) of what a dielectric shape holds.
template <class Scene>
void absorb(WalkState<typename Scene::Scalar>& walk, typename Scene::Scalar length) {
  if constexpr (Scene::ShaderType::k_may_absorb) {
    if (is_black(walk.sigma_a)) return;
    walk.beta *= Rgb<typename Scene::Scalar>(std::exp(-walk.sigma_a.x * length), std::exp(-walk.sigma_a.y * length),
                                             std::exp(-walk.sigma_a.z * length));
  }
}

/// What a walk comes to: a surface, or neither: it has left the scene.
template <class Scene>
struct Arrival {
  std::optional<SurfacePoint<typename Scene::Scalar>> surface;
};
/// With media, a collision may come before the surface.
template <class Scene>
  requires Scene::k_has_media
struct Arrival<Scene> {
  std::optional<SurfacePoint<typename Scene::Scalar>> surface;
  std::optional<MediumInteraction<Scene>> collision;
};

/// Draws where `walk` comes next and updates its throughput; transparent surfaces are passed by chance, with the change of
/// medium if they are boundaries.
template <class Scene, SampleStream Stream>
[[nodiscard]] Arrival<Scene> advance(const Scene& scene, WalkState<typename Scene::Scalar>& walk, Stream& stream,
                                     RayCounts& rays) {
  using S = typename Scene::Scalar;
  Arrival<Scene> arrival;
  if constexpr (!Scene::k_has_media) {
    arrival.surface = scene.intersect(walk.ray, stream, rays);
    if (arrival.surface) absorb<Scene>(walk, glm::length(arrival.surface->position - walk.ray.origin));
    return arrival;
  } else {
    for (;;) {
      ++rays.closest;
      const auto hit = scene.geometry().closest_hit(walk.ray);
      const S distance = hit ? hit->t : k_infinity<S>;
      if (walk.medium != k_vacuum) {
        const auto& medium = scene.media().medium(walk.medium);
        const auto flight = medium.sample(walk.ray, distance, stream);
        walk.beta *= flight.weight;
        if (flight.scattered) {
          absorb<Scene>(walk, flight.t);
          const Vec3<S> position = walk.ray.origin + walk.ray.direction * flight.t;
          arrival.collision = MediumInteraction<Scene>{position, walk.medium, medium.phase(position),
                                               medium.sigma_s(position, -walk.ray.direction)};
          return arrival;
        }
      }
      if (!hit) return arrival;
      absorb<Scene>(walk, distance);
      const SurfacePoint<S> point = surface_point(scene.geometry().shapes(), walk.ray, *hit);
      if constexpr (Scene::ShaderType::k_may_be_transparent) {
        const auto& surface = scene.shader(point.shape);
        if (surface.is_transparent() && stream.next() >= surface.opacity(point)) {
          walk.medium = scene.media().behind(point, walk.ray.direction, walk.medium);
          walk.ray = Scene::beyond(walk.ray, point);
          continue;
        }
      }
      arrival.surface = point;
      return arrival;
    }
  }
}

}  // namespace manylight
