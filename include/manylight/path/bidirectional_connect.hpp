// SPDX-License-Identifier: Apache-2.0
#pragma once

// Strategies of bidirectional path tracing that connect: a drawn light with an eye vertex (s = 1), two vertices, and a light
// vertex with the lens (t = 1). What does not depend on the shadow ray comes first, that comes last.

#include <cmath>
#include <optional>

#include "manylight/path/bidirectional_walk.hpp"
#include "manylight/scene/concepts.hpp"

namespace manylight {

/// What one strategy finds of a path.
template <std::floating_point S>
struct PathContribution {
  Rgb<S> value{0};   ///< contribution / density of the strategy alone, W/m^2/sr
  S weight = S(0);   ///< its share
};

namespace detail {
/// Beer's law along `w` (unit) over `length`, m, in the dielectric shape there.
template <class Scene>
[[nodiscard]] Rgb<typename Scene::Scalar> unabsorbed(const BidirectionalVertex<Scene>& v,
                                                     const Vec3<typename Scene::Scalar>& w,
                                                     typename Scene::Scalar length) noexcept {
  using S = typename Scene::Scalar;
  if constexpr (Scene::ShaderType::k_may_absorb) {
    const bool passes = !v.vertex.is_in_medium() && glm::dot(w, v.vertex.ng) * glm::dot(v.vertex.w, v.vertex.ng) < S(0);
    const Rgb<S>& sigma_a = passes ? v.absorption.beyond : v.absorption.here;
    if (!is_black(sigma_a)) return glm::exp(-sigma_a * length);
  }
  return Rgb<S>(1);
}

template <class Scene, SampleStream Stream>
[[nodiscard]] std::uint64_t transmittance_seed(Stream& stream) {
  if constexpr (Scene::k_has_media) return random_bits(stream);
  return 0;
}
}  // namespace detail

/// s = 1: draws a light for `eye`. None if it carries nothing.
template <class Scene, SampleStream Stream>
[[nodiscard]] std::optional<PathContribution<typename Scene::Scalar>> connect_with_drawn_light(
    const Scene& scene, const BidirectionalVertex<Scene>& eye, Stream& stream, RayCounts& rays) {
  using S = typename Scene::Scalar;
  const VertexOf<Scene>& v = eye.vertex;
  if (v.is_inner()) return std::nullopt;
  const S u_select = stream.next();
  const auto light = scene.emitters().sample_direct(v.position, u_select, stream.next_2d());
  const std::uint64_t seed = detail::transmittance_seed<Scene>(stream);
  if (!light || is_black(light->radiance) || !(v.alpha > S(0))) return std::nullopt;
  const Rgb<S> m = sensor_patterns(v, light->wi).m;
  if (is_black(m)) return std::nullopt;

  PathContribution<S> found;
  const S direct_pdf = light->kind == EmitterKind::point ? light->pdf * sqr(light->distance) : light->pdf;
  found.weight = weight_of_direct(light->is_delta ? S(0) : onward_pdf(eye, light->wi, Walk::eye), direct_pdf,
                                  walk_start_pdf(scene, *light), density_cosine(v, light->wi),
                                  eye.weights.sum(return_pdf(eye, light->wi, Walk::light)));
  found.value = v.strength * m * light->radiance / light->pdf;
  if (!light->infinite) found.value *= detail::unabsorbed(eye, light->wi, light->distance);
  const typename Scene::ShadowRay ray =
      light->infinite ? Scene::shadow_ray(v.anchor(), light->wi, seed)
                      : Scene::shadow_ray(v.anchor(), Anchor<S>{light->position, light->error, light->ng}, seed);
  found.value *= scene.visibility(ray, rays);
  return found;
}

/// s >= 2, t >= 2; inner vertices of an object are connected through it.
template <class Scene, SampleStream Stream>
[[nodiscard]] std::optional<PathContribution<typename Scene::Scalar>> connect_vertices(
    const Scene& scene, const BidirectionalVertex<Scene>& eye, const BidirectionalVertex<Scene>& light, Stream& stream,
    RayCounts& rays) {
  using S = typename Scene::Scalar;
  const VertexOf<Scene>& e = eye.vertex;
  const VertexOf<Scene>& l = light.vertex;
  const std::uint64_t seed = detail::transmittance_seed<Scene>(stream);
  if (!(e.alpha > S(0) && l.alpha > S(0))) return std::nullopt;
  const Pair<S> pair = connect(e, l, scene.emitters().scene_radius());
  if (pair.is_zero()) return std::nullopt;

  PathContribution<S> found;
  found.value = e.strength * pair.m * pair.d * l.strength * pair.t;
  const S to_light = onward_pdf(eye, pair.wi, Walk::eye);
  const S to_eye = onward_pdf(light, -pair.wi, Walk::light);
  const S light_sum = light.weights.sum(return_pdf(light, -pair.wi, Walk::eye));
  const S eye_sum = eye.weights.sum(return_pdf(eye, pair.wi, Walk::light));
  if constexpr (Scene::k_has_subsurface) {
    if (e.is_inner()) {  // through the object, which nothing shadows
      const S density = passage_pdf(*e.below, glm::length(l.position - e.position));
      found.weight = weight_of_connection(to_light * density, light_sum, to_eye * density, eye_sum);
      return found;
    }
  }
  found.weight = weight_of_connection(to_light * density_cosine(l, pair.wi) * pair.t, light_sum,
                                      to_eye * density_cosine(e, pair.wi) * pair.t, eye_sum);
  found.value *= detail::unabsorbed(eye, pair.wi, S(1) / std::sqrt(pair.t));
  found.value *= scene.visibility(shadow_ray<Scene>(e, l, seed), rays);
  return found;
}

/// t = 1: a path that is found wherever on the film it may be.
template <std::floating_point S>
struct LensContribution : PathContribution<S> {
  Vec2<S> film{0};  ///< pixels
};

/// t = 1. The value is per pixel of film and for one light walk per image: it has to be divided by their number,
/// `light_paths`.
template <class Scene, LensCamera C, SampleStream Stream>
[[nodiscard]] std::optional<LensContribution<typename Scene::Scalar>> connect_with_lens(
    const Scene& scene, const C& camera, const BidirectionalVertex<Scene>& light, typename Scene::Scalar light_paths,
    Stream& stream, RayCounts& rays) {
  using S = typename Scene::Scalar;
  const VertexOf<Scene>& l = light.vertex;
  if (l.is_inner()) return std::nullopt;
  const std::optional<LensSample<S>> lens = camera.project(l.position, stream.next_2d());
  const std::uint64_t seed = detail::transmittance_seed<Scene>(stream);
  if (!lens || !(l.alpha > S(0))) return std::nullopt;
  const Vec3<S> segment = lens->position - l.position;
  const S squared_distance = glm::dot(segment, segment);
  if (!(squared_distance > std::numeric_limits<S>::min())) return std::nullopt;
  const S distance = std::sqrt(squared_distance);
  const Vec3<S> wo = segment / distance;
  const Rgb<S> d = light_pattern(l, wo);
  if (is_black(d)) return std::nullopt;

  LensContribution<S> found;
  found.film = lens->film;
  const S density = lens->film_density / squared_distance;
  found.weight = weight_of_lens(density * density_cosine(l, wo), light_paths,
                                light.weights.sum(return_pdf(light, wo, Walk::eye)));
  found.value = l.strength * d * (density / light_paths);
  found.value *= detail::unabsorbed(light, wo, distance);
  found.value *= scene.visibility(Scene::shadow_ray(l.anchor(), Anchor<S>{lens->position, S(0), Vec3<S>(0)}, seed), rays);
  return found;
}

}  // namespace manylight
