// SPDX-License-Identifier: Apache-2.0
#pragma once

// The pair (VPS, VPL) of [Walter 2012, Eq. 3, 11-19]: contribution = w * S * M(wi) * T * D(wo) * I with
//   s(v, wi, wo) = |wi.ns| f |wo.ng|                         path scattering term of a surface
//   M(wi) = s / alpha_M,  alpha_M = alpha |wo.ng|            = |wi.ns| f / alpha        (sr^-1)
//   D(wo) = s / alpha_D,  alpha_D = alpha |wi.ns|            = f |wo.ng| / alpha        (sr^-1)
//   T = visibility / d^2                                     (m^-2), for lights at infinity 1 / R^2
// In a medium s = sigma_s(wo) f_p, alpha_M = sigma_s(wo), alpha_D = sigma_s(wi), so that M and D are the phase function
// given the known direction: for the other one, reciprocity of sigma_s f_p gives it as well. Visibility holds the
// transmittance, which is random: it stays out of the T of weights.
// alpha is the largest channel of the albedo, constant per vertex: it cancels in S M and D I and only shapes weights.
// Weights and bounds see the largest channel of M and D, so that every inequality holds per channel.

#include <cmath>

#include "manylight/path/vertex.hpp"

namespace manylight {

namespace detail {
/// The rule of sides (theory 1.1): the lobe is judged by ns, visibility by ng, and both must agree for each direction;
/// judging by ns alone leaks light through bent normals.
template <std::floating_point S>
[[nodiscard]] inline bool sides_agree(const Vec3<S>& w, const Vec3<S>& w_local, const Vec3<S>& ng) noexcept {
  return w_local.z * glm::dot(w, ng) > S(0);
}
}  // namespace detail

/// f of a surface vertex without cosines, sr^-1; 0 where the sides of ns and ng disagree.
template <std::floating_point S, Material M>
[[nodiscard]] inline Rgb<S> scatter(const M& material, const Frame<S>& frame, const Vec3<S>& ng, const Vec3<S>& wi,
                                    const Vec3<S>& wo) noexcept {
  const Vec3<S> wi_local = frame.to_local(wi);
  const Vec3<S> wo_local = frame.to_local(wo);
  if (!detail::sides_agree(wi, wi_local, ng) || !detail::sides_agree(wo, wo_local, ng)) return Rgb<S>(0);
  return material.eval(wi_local, wo_local);
}

namespace detail {
/// Pattern of an outer vertex towards `w` on the side of its normal, M or D: the cosine and what the interface lets through.
template <class V>
[[nodiscard]] inline typename V::Scalar outer_pattern(const V& v, const Vec3<typename V::Scalar>& w) noexcept {
  return v.below->pattern(glm::dot(w, v.ng));
}
}  // namespace detail

/// Both patterns of a VPS for the light-side direction `wi`.
template <std::floating_point S>
struct SensorPatterns {
  Rgb<S> m;  ///< M(wi), sr^-1 per channel
  S d;       ///< largest channel of the vertex's own D towards `wo`, sr^-1: weights of the segment before need it
};
template <AnyVertex V, std::floating_point S = typename V::Scalar>
[[nodiscard]] inline SensorPatterns<S> sensor_patterns(const V& v, const Vec3<S>& wi) noexcept {
  if constexpr (V::k_may_be_in_medium) {
    if (v.is_in_medium()) return {Rgb<S>(v.phase.eval(wi, v.w)), v.phase.eval(v.w, wi)};
  }
  if constexpr (V::k_may_be_subsurface) {
    if (v.is_outer()) return {Rgb<S>(detail::outer_pattern(v, wi)), k_inv_pi<S>};
  }
  const Rgb<S> f = scatter(v.material, v.shading.frame(), v.ng, wi, v.w) / v.alpha;
  return {f * std::abs(glm::dot(wi, v.shading.normal())), max_channel(f) * std::abs(glm::dot(v.w, v.ng))};
}

/// D of a surface vertex, as seen by a subpath that knows `wi`, towards `wo`, sr^-1 per channel.
template <AnyVertex V, std::floating_point S = typename V::Scalar>
[[nodiscard]] inline Rgb<S> surface_light_pattern(const V& v, const Vec3<S>& wi, const Vec3<S>& wo) noexcept {
  const Rgb<S> f = scatter(v.material, v.shading.frame(), v.ng, wi, wo);
  return f * (std::abs(glm::dot(wo, v.ng)) / v.alpha);
}

/// D of a VPL towards `wo`, sr^-1 per channel.
template <AnyVertex V, std::floating_point S = typename V::Scalar>
[[nodiscard]] inline Rgb<S> light_pattern(const V& v, const Vec3<S>& wo) noexcept {
  switch (v.kind) {
    case VertexKind::surface: return surface_light_pattern(v, v.w, wo);
    case VertexKind::medium:
      if constexpr (V::k_may_be_in_medium) return Rgb<S>(v.phase.eval(wo, v.w));
      break;
    case VertexKind::subsurface_outer:
      if constexpr (V::k_may_be_subsurface) return Rgb<S>(detail::outer_pattern(v, wo));
      break;
    case VertexKind::subsurface_inner: return Rgb<S>(k_inv_pi<S>);
    case VertexKind::area_emitter: return Rgb<S>(std::max(S(0), glm::dot(wo, v.ng)) * k_inv_pi<S>);
    case VertexKind::two_sided_area_emitter: return Rgb<S>(std::abs(glm::dot(wo, v.ng)) * k_inv_pi<S>);
    case VertexKind::point_emitter: return Rgb<S>(S(0.25) * k_inv_pi<S>);
    case VertexKind::spot_emitter: return Rgb<S>(S(0.25) * k_inv_pi<S> * spot_falloff(wo, v.ng, v.w.x, v.w.y));
    case VertexKind::infinite_emitter: return Rgb<S>(k_inv_pi<S>);
  }
  return Rgb<S>(0);
}

/// The factors of a pair without visibility.
template <std::floating_point S>
struct Pair {
  Vec3<S> wi;     ///< unit, from the VPS to the VPL
  Rgb<S> m;       ///< M(wi), sr^-1
  Rgb<S> d;       ///< D(-wi), sr^-1
  S t;            ///< 1/d^2 or 1/R^2, m^-2
  S sensor_d;     ///< the sensor's own D for `wi`, sr^-1

  [[nodiscard]] bool is_zero() const noexcept { return max_channel(m) * max_channel(d) <= S(0); }
};

namespace detail {
/// Two inner vertices of an object [Walter 2012, Eq. 21-25]: M = D = 1 / pi, T = pi g(d), no visibility. The colour of g is
/// put into M, so that T is that of its largest channel.
template <class V>
[[nodiscard]] inline Pair<typename V::Scalar> connect_below(const V& sensor, const V& light) noexcept {
  using S = typename V::Scalar;
  Pair<S> pair{};
  const Rgb<S> transit = sensor.below->transit(glm::length(light.position - sensor.position));
  pair.t = max_channel(transit);
  if (!(pair.t > S(0))) return pair;
  pair.m = transit * (k_inv_pi<S> / pair.t);
  pair.d = Rgb<S>(k_inv_pi<S>);
  pair.sensor_d = outer_pattern(sensor, sensor.w);
  return pair;
}
}  // namespace detail

/// Evaluates M, D and T (visibility 1) of a pair. `scene_radius`, m: that of the scene's bounding sphere, the unit of
/// lights at infinity (theory 2.5). Coincident vertices give m = d = 0: such a pair carries nothing.
template <AnyVertex V, std::floating_point S = typename V::Scalar>
[[nodiscard]] inline Pair<S> connect(const V& sensor, const V& light, S scene_radius) noexcept {
  Pair<S> pair{};
  if constexpr (V::k_has_channels) {
    if (sensor.channel() != light.channel()) return pair;
  }
  if constexpr (V::k_may_be_subsurface) {
    if (sensor.is_inner()) return detail::connect_below(sensor, light);
  }
  if (light.is_infinite()) {
    pair.wi = light.position;
    pair.t = S(1) / sqr(scene_radius);
  } else {
    const Vec3<S> to_light = light.position - sensor.position;
    const S squared_distance = glm::dot(to_light, to_light);
    if (!(squared_distance > std::numeric_limits<S>::min())) return pair;
    pair.wi = to_light / std::sqrt(squared_distance);
    pair.t = S(1) / squared_distance;
  }
  const SensorPatterns<S> patterns = sensor_patterns(sensor, pair.wi);
  if (is_black(patterns.m)) return pair;
  pair.m = patterns.m;
  pair.sensor_d = patterns.d;
  pair.d = light_pattern(light, -pair.wi);
  return pair;
}

/// The shadow ray of a pair; `seed` draws the transmittance of media.
template <class Scene>
[[nodiscard]] typename Scene::ShadowRay shadow_ray(const VertexOf<Scene>& sensor, const VertexOf<Scene>& light,
                                                   std::uint64_t seed = 0) {
  if constexpr (requires { typename Scene::InstantType; }) {
    return {shadow_ray<typename Scene::InstantType>(sensor, light, seed), sensor.instant};
  } else {
    return light.is_infinite() ? Scene::shadow_ray(sensor.anchor(), light.position, seed)
                               : Scene::shadow_ray(sensor.anchor(), light.anchor(), seed);
  }
}

}  // namespace manylight
