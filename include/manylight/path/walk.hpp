// SPDX-License-Identifier: Apache-2.0
#pragma once

// One step of a random walk, shared by every integrator: which direction is drawn at a vertex and what the throughput
// becomes. Eye walks carry radiance throughput, light walks carry power; the two differ only in which direction is known
// and in the shading-normal factor of light walks (theory 1.1, 2.2, 2.3).

#include <cmath>
#include <optional>

#include "manylight/path/connect.hpp"

namespace manylight {

/// A walk between two vertices.
template <std::floating_point S>
struct WalkState {
  Ray<S> ray;          ///< unit direction
  Rgb<S> beta{1};      ///< cosine-free throughput at the next vertex
  Rgb<S> sigma_a{0};   ///< absorption of what the segment runs through, m^-1
};

/// A drawn direction with the factor by which the throughput changes.
template <std::floating_point S>
struct ScatterSample {
  Vec3<S> direction;  ///< world
  Rgb<S> f{0};        ///< BSDF of the pair of directions, sr^-1; 0 for delta
  Rgb<S> factor{0};   ///< beta of the next vertex / beta of this one
  S pdf = S(0);       ///< solid angle density, sr^-1 (delta: discrete probability)
  bool is_delta = false;
};

/// Draws the unknown direction at `hit` given the known one `w`. None if the draw fails or carries nothing.
template <class Scene, SampleStream Stream>
[[nodiscard]] std::optional<ScatterSample<typename Scene::Scalar>> sample_scatter(
    const Interaction<typename Scene::Scalar, typename Scene::Material>& hit, const Vec3<typename Scene::Scalar>& w,
    Walk walk, Stream& stream) {
  using S = typename Scene::Scalar;
  const S u_lobe = stream.next();
  const Vec2<S> u = stream.next_2d();
  const Vec3<S> w_local = hit.frame.to_local(w);
  if (!detail::sides_agree(w, w_local, hit.ng)) return std::nullopt;
  const auto drawn = hit.material.sample(w_local, walk, u_lobe, u);
  if (!drawn || !(drawn->pdf > S(0))) return std::nullopt;

  ScatterSample<S> sample;
  sample.direction = glm::normalize(hit.frame.to_world(drawn->direction));
  sample.pdf = drawn->pdf;
  sample.is_delta = drawn->is_delta;
  if (!detail::sides_agree(sample.direction, drawn->direction, hit.ng)) return std::nullopt;
  const bool from_eye = walk == Walk::eye;
  const S sampled_ns = std::abs(drawn->direction.z);
  if (sample.is_delta) {
    sample.factor = drawn->delta_weight;
  } else {
    sample.f = from_eye ? hit.material.eval(drawn->direction, w_local) : hit.material.eval(w_local, drawn->direction);
    sample.factor = sample.f * (sampled_ns / sample.pdf);
  }
  if (!from_eye) {
    // s = |wi.ns| f |wo.ng|: light walks see the shading normal with the known wi, the geometric one with the drawn wo.
    sample.factor *= std::abs(w_local.z / glm::dot(w, hit.ng)) *
                     (std::abs(glm::dot(sample.direction, hit.ng)) / sampled_ns);
  }
  if (!(max_channel(sample.factor) > S(0)) || !is_finite(sample.factor)) return std::nullopt;
  return sample;
}

/// Moves `walk` on from `hit` in the sampled direction.
template <class Scene>
void continue_walk(const Scene& scene, WalkState<typename Scene::Scalar>& walk,
                   const Interaction<typename Scene::Scalar, typename Scene::Material>& hit,
                   const ScatterSample<typename Scene::Scalar>& sample) {
  using S = typename Scene::Scalar;
  const SurfacePoint<S>& point = hit.point;
  if constexpr (Scene::ShaderType::k_may_absorb) {
    const S before = glm::dot(walk.ray.direction, point.ng);
    const S after = glm::dot(sample.direction, point.ng);
    if (before * after > S(0)) {  // passed through the surface
      walk.sigma_a = after < S(0) ? scene.shader(point.shape).interior_absorption() : Rgb<S>(0);
    }
  }
  walk.beta *= sample.factor;
  walk.ray = Ray<S>{offset_origin(point.position, point.error, point.ng, sample.direction), sample.direction};
}

/// Beer's law along the segment that ends at `point`.
template <class Scene>
void absorb(WalkState<typename Scene::Scalar>& walk, const SurfacePoint<typename Scene::Scalar>& point) {
  if constexpr (Scene::ShaderType::k_may_absorb) {
    if (is_black(walk.sigma_a)) return;
    const auto length = glm::length(point.position - walk.ray.origin);
    walk.beta *= Rgb<typename Scene::Scalar>(std::exp(-walk.sigma_a.x * length), std::exp(-walk.sigma_a.y * length),
                                             std::exp(-walk.sigma_a.z * length));
  }
}

}  // namespace manylight
