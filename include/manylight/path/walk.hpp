// SPDX-License-Identifier: Apache-2.0
#pragma once

// One step of a random walk, shared by every integrator: which direction is drawn at a vertex and what the throughput
// becomes. Eye walks carry radiance throughput, light walks carry power; the two differ only in which direction is known
// and in the shading-normal factor of light walks (theory 1.1, 2.2, 2.3).

#include <algorithm>
#include <cmath>
#include <optional>

#include "manylight/path/connect.hpp"
#include "manylight/path/medium_walk.hpp"
#include "manylight/path/subsurface_walk.hpp"

namespace manylight {

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

template <class Scene, SampleStream Stream>
[[nodiscard]] std::optional<ScatterSample<typename Scene::Scalar>> sample_scatter(
    const MediumInteraction<Scene>& collision, const Vec3<typename Scene::Scalar>& w, Walk /*walk*/, Stream& stream) {
  using S = typename Scene::Scalar;
  const auto drawn = collision.phase.sample(w, stream.next_2d());
  if (!drawn || !(drawn->pdf > S(0))) return std::nullopt;
  ScatterSample<S> sample;
  sample.direction = drawn->direction;
  sample.pdf = drawn->pdf;
  sample.f = collision.sigma_s * collision.phase.eval(drawn->direction, w);
  sample.factor = sample.f / drawn->pdf;
  if (!(max_channel(sample.factor) > S(0)) || !is_finite(sample.factor)) return std::nullopt;
  return sample;
}

template <class Scene, SampleStream Stream>
[[nodiscard]] std::optional<ScatterSample<typename Scene::Scalar>> sample_scatter(
    const Surfacing<Scene>& out, const Vec3<typename Scene::Scalar>& /*w*/, Walk /*walk*/, Stream& stream) {
  using S = typename Scene::Scalar;
  const Vec3<S> local = warp::square_to_cosine_hemisphere(stream.next_2d());
  ScatterSample<S> sample;
  sample.direction = glm::normalize(Frame<S>(out.point.ng).to_world(local));
  sample.pdf = warp::cosine_hemisphere_pdf(local);
  if (!(sample.pdf > S(0))) return std::nullopt;
  sample.f = out.below->end_factor(local.z);
  sample.factor = sample.f / sample.pdf;
  if (!(max_channel(sample.factor) > S(0))) return std::nullopt;
  return sample;
}

/// Probability with which an eye walk of throughput `beta` goes on. Roulette by the throughput itself would save time, but
/// the survivors that meet a lamp are then noise: walks are cheap, and all but 1 % go on that carry more than 1/8. The cap
/// ends walks without absorption. The throughput grows by albedo / 0.99 per vertex, its square times the survival by
/// albedo^2 / 0.99: the variance is finite up to an albedo of sqrt(0.99) = 0.995.
template <std::floating_point S>
[[nodiscard]] S survival_by_throughput(const Rgb<S>& beta) noexcept {
  return std::min(S(0.99), S(8) * max_channel(beta));
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
  if constexpr (Scene::k_has_media) {
    walk.medium = glm::dot(sample.direction, hit.ng) > S(0) ? hit.media.front : hit.media.back;
  }
  walk.beta *= sample.factor;
  walk.ray = Ray<S>{offset_origin(point.position, point.error, point.ng, sample.direction), sample.direction};
}

template <class Scene>
void continue_walk(const Scene& /*scene*/, WalkState<typename Scene::Scalar>& walk, const MediumInteraction<Scene>& collision,
                   const ScatterSample<typename Scene::Scalar>& sample) {
  walk.beta *= sample.factor;
  walk.ray = {collision.position, sample.direction};
}

template <class Scene>
void continue_walk(const Scene& /*scene*/, WalkState<typename Scene::Scalar>& walk, const Surfacing<Scene>& out,
                   const ScatterSample<typename Scene::Scalar>& sample) {
  walk.medium = out.medium;
  walk.beta *= sample.factor;
  walk.ray = {offset_origin(out.point.position, out.point.error, out.point.ng, sample.direction), sample.direction};
}

/// Where a walk stands, as one end of a shadow ray.
template <std::floating_point S, Material M>
[[nodiscard]] Anchor<S> anchor(const Interaction<S, M>& hit) noexcept {
  return {hit.point.position, hit.point.error, hit.ng, hit.media};
}
template <class Scene>
[[nodiscard]] Anchor<typename Scene::Scalar> anchor(const MediumInteraction<Scene>& collision) noexcept {
  using S = typename Scene::Scalar;
  return {collision.position, S(0), Vec3<S>(0, 0, 1), {collision.medium, collision.medium}};
}

template <class Scene>
[[nodiscard]] Anchor<typename Scene::Scalar> anchor(const Surfacing<Scene>& out) noexcept {
  return {out.point.position, out.point.error, out.point.ng, {out.medium, out.medium}};
}

/// Whether every direction at the vertex is drawn by a Dirac lobe.
template <std::floating_point S, Material M>
[[nodiscard]] bool is_delta(const Interaction<S, M>& hit) noexcept {
  return hit.material.is_delta();
}
template <class Scene>
[[nodiscard]] bool is_delta(const MediumInteraction<Scene>& /*collision*/) noexcept {
  return false;
}

template <class Scene>
[[nodiscard]] bool is_delta(const Surfacing<Scene>& /*out*/) noexcept {
  return false;
}

/// How much the vertex scatters, what roulette goes by: the albedo's largest channel (1: Dirac lobes alone), or sigma_s.
template <std::floating_point S, Material M>
[[nodiscard]] Rgb<S> albedo(const Interaction<S, M>& hit) noexcept {
  return Rgb<S>(hit.material.is_delta() ? S(1) : max_channel(hit.material.albedo()));
}
template <class Scene>
[[nodiscard]] Rgb<typename Scene::Scalar> albedo(const MediumInteraction<Scene>& collision) noexcept {
  return collision.sigma_s;
}

template <class Scene>
[[nodiscard]] Rgb<typename Scene::Scalar> albedo(const Surfacing<Scene>& out) noexcept {
  return out.below->sqrt_rho();
}

/// Light from `wi` that goes on to `wo` in an eye walk: f |wi.ns|, sr^-1; in a medium sigma_s f_p, m^-1 sr^-1.
template <std::floating_point S>
struct Scattered {
  Rgb<S> value;
  Rgb<S> f;  ///< without the cosine
};
template <std::floating_point S, Material M>
[[nodiscard]] Scattered<S> scattered(const Interaction<S, M>& hit, const Vec3<S>& wi, const Vec3<S>& wo) noexcept {
  const Rgb<S> f = scatter(hit.material, hit.frame, hit.ng, wi, wo);
  return {f * std::abs(glm::dot(wi, hit.frame.n)), f};
}
template <class Scene>
[[nodiscard]] Scattered<typename Scene::Scalar> scattered(const MediumInteraction<Scene>& collision,
                                                          const Vec3<typename Scene::Scalar>& wi,
                                                          const Vec3<typename Scene::Scalar>& wo) noexcept {
  const auto value = collision.sigma_s * collision.phase.eval(wi, wo);
  return {value, value};
}

template <class Scene>
[[nodiscard]] Scattered<typename Scene::Scalar> scattered(const Surfacing<Scene>& out,
                                                          const Vec3<typename Scene::Scalar>& wi,
                                                          const Vec3<typename Scene::Scalar>& /*wo*/) noexcept {
  const auto value = out.below->end_factor(glm::dot(wi, out.point.ng));
  return {value, value};
}

/// Density of `wi` in an eye walk that knows `wo`, sr^-1.
template <std::floating_point S, Material M>
[[nodiscard]] S direction_pdf(const Interaction<S, M>& hit, const Vec3<S>& wi, const Vec3<S>& wo) noexcept {
  return hit.material.pdf(hit.frame.to_local(wo), hit.frame.to_local(wi), Walk::eye);
}
template <class Scene>
[[nodiscard]] auto direction_pdf(const MediumInteraction<Scene>& collision, const Vec3<typename Scene::Scalar>& wi,
                                 const Vec3<typename Scene::Scalar>& wo) noexcept {
  return collision.phase.pdf(wi, wo);
}

template <class Scene>
[[nodiscard]] auto direction_pdf(const Surfacing<Scene>& out, const Vec3<typename Scene::Scalar>& wi,
                                 const Vec3<typename Scene::Scalar>& /*wo*/) noexcept {
  using S = typename Scene::Scalar;
  return std::max(S(0), glm::dot(wi, out.point.ng)) * k_inv_pi<S>;
}

/// Largest channels of M and D of an eye vertex, sr^-1: what weights see.
template <std::floating_point S>
struct PatternMaxima {
  S m, d;
};
/// `f` of the directions, as in `scattered` and ScatterSample.
template <std::floating_point S, Material M>
[[nodiscard]] PatternMaxima<S> pattern_maxima(const Interaction<S, M>& hit, const Vec3<S>& wi, const Vec3<S>& wo,
                                              const Rgb<S>& f) noexcept {
  const S value = max_channel(f) / max_channel(hit.material.albedo());
  return {value * std::abs(glm::dot(wi, hit.frame.n)), value * std::abs(glm::dot(wo, hit.ng))};
}
template <class Scene>
[[nodiscard]] PatternMaxima<typename Scene::Scalar> pattern_maxima(const MediumInteraction<Scene>& collision,
                                                                   const Vec3<typename Scene::Scalar>& wi,
                                                                   const Vec3<typename Scene::Scalar>& wo,
                                                                   const Rgb<typename Scene::Scalar>& /*f*/) noexcept {
  return {collision.phase.eval(wi, wo), collision.phase.eval(wo, wi)};
}

template <class Scene>
[[nodiscard]] PatternMaxima<typename Scene::Scalar> pattern_maxima(const Surfacing<Scene>& out,
                                                                   const Vec3<typename Scene::Scalar>& wi,
                                                                   const Vec3<typename Scene::Scalar>& /*wo*/,
                                                                   const Rgb<typename Scene::Scalar>& /*f*/) noexcept {
  using S = typename Scene::Scalar;
  return {out.below->pattern(glm::dot(wi, out.point.ng)), k_inv_pi<S>};
}

/// The vertex where a walk stands, known from `w`, with the strength alpha |w.ns| / |w.ng| of a light walk (`Walk::light`)
/// or alpha of an eye walk, times the walk's throughput.
template <class Scene>
[[nodiscard]] VertexOf<Scene> vertex_at(const Interaction<typename Scene::Scalar, typename Scene::Material>& hit,
                                        const Vec3<typename Scene::Scalar>& w, Walk walk,
                                        const Rgb<typename Scene::Scalar>& beta) noexcept {
  auto v = surface_vertex<VertexOf<Scene>>(hit, w);
  v.strength = beta * v.alpha;
  if (walk == Walk::light) v.strength *= std::abs(glm::dot(w, hit.frame.n) / glm::dot(w, hit.ng));
  return v;
}
template <class Scene>
[[nodiscard]] VertexOf<Scene> vertex_at(const MediumInteraction<Scene>& collision, const Vec3<typename Scene::Scalar>& w,
                                        Walk /*walk*/, const Rgb<typename Scene::Scalar>& beta) noexcept {
  VertexOf<Scene> v;
  v.kind = VertexKind::medium;
  v.position = collision.position;
  v.w = w;
  v.alpha = typename Scene::Scalar(1);
  v.strength = beta * collision.sigma_s;
  v.phase = collision.phase;
  v.media = {collision.medium, collision.medium};
  return v;
}

template <class Scene>
[[nodiscard]] VertexOf<Scene> vertex_at(const Surfacing<Scene>& out, const Vec3<typename Scene::Scalar>& /*w*/,
                                        Walk /*walk*/, const Rgb<typename Scene::Scalar>& beta) noexcept {
  VertexOf<Scene> v;
  v.kind = VertexKind::subsurface_outer;
  v.position = out.point.position;
  v.error = out.point.error;
  v.ng = out.point.ng;
  v.alpha = typename Scene::Scalar(1);
  v.strength = beta * out.below->sqrt_rho();
  v.below = out.below;
  v.object = out.point.shape;
  if constexpr (Scene::k_has_media) v.media = {out.medium, out.medium};
  return v;
}

}  // namespace manylight
