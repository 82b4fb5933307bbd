// SPDX-License-Identifier: Apache-2.0
#pragma once

// Light found twice: drawn for a vertex of an eye walk, and hit by the walk's next direction. The balance heuristic
// weights both, all densities per solid angle at the vertex [Veach 1997, section 9.2]:
//
//   light drawn      w = pL / (pL + pB)      pL = sample_direct's density (selection included)
//   emitter hit      w = pB / (pB + pL)      pB = the material's density

#include <cstdint>
#include <optional>

#include "manylight/path/walk.hpp"

namespace manylight {

/// A light drawn for a vertex where light scatters.
template <class Scene>
struct DrawnLight {
  using S = typename Scene::Scalar;
  DirectSample<S> light;
  Scattered<S> scatter;
  Rgb<S> scattered_radiance{0};  ///< towards wo if nothing is in between, weighted and over the density, W/m^2/sr
  std::uint64_t seed = 0;        ///< of the transmittance

  [[nodiscard]] typename Scene::ShadowRay shadow_ray(const Anchor<S>& here) const noexcept {
    return light.infinite ? Scene::shadow_ray(here, light.wi, seed)
                          : Scene::shadow_ray(here, Anchor<S>{light.position, light.error, light.ng}, seed);
  }
};

/// None if it would send nothing to `wo`, W/m^2/sr. `light_share`: lights drawn at the vertex per direction drawn there.
template <class Scene, class Hit, SampleStream Stream>
[[nodiscard]] std::optional<DrawnLight<Scene>> draw_light(const Scene& scene, const Hit& hit,
                                                          const Vec3<typename Scene::Scalar>& wo, Stream& stream,
                                                          typename Scene::Scalar light_share = 1) {
  using S = typename Scene::Scalar;
  const S u_select = stream.next();
  const auto light = scene.emitters().sample_direct(anchor(hit).position, u_select, stream.next_2d());
  if (!light || is_black(light->radiance)) return std::nullopt;
  const Scattered<S> scatter = scattered(hit, light->wi, wo);
  if (is_black(scatter.value)) return std::nullopt;
  const S drawn = light_share * light->pdf;
  const S share = light->is_delta ? S(1) : drawn / (drawn + direction_pdf(hit, light->wi, wo));
  std::uint64_t seed = 0;
  if constexpr (Scene::k_has_media) seed = random_bits(stream);
  return DrawnLight<Scene>{*light, scatter, scatter.value * light->radiance * (share / light->pdf), seed};
}

/// Where a walk's last direction was drawn, for the weight of emitters that it hits.
template <std::floating_point S>
struct LastBounce {
  Vec3<S> position{0};
  S pdf = S(0);
  bool is_weighted = false;  ///< false: seen directly or through Dirac vertices, no light was drawn for it
};

/// Emitted radiance of the point that the walk has hit towards `wo`, weighted, W/m^2/sr.
template <class Scene, std::floating_point S>
[[nodiscard]] Rgb<S> hit_emission(const Scene& scene, const SurfacePoint<S>& point, const Vec3<S>& wo,
                                  const LastBounce<S>& bounce) {
  const Rgb<S> radiance = scene.emitters().emitted(point, wo);
  if (!bounce.is_weighted || is_black(radiance)) return radiance;
  return radiance * (bounce.pdf / (bounce.pdf + scene.emitters().pdf_direct(bounce.position, point, -wo)));
}

/// The same of the environment, for a walk that has left the scene.
template <class Scene, std::floating_point S>
[[nodiscard]] Rgb<S> hit_environment(const Scene& scene, const Vec3<S>& direction, const LastBounce<S>& bounce) {
  const EnvironmentLight<S> light = scene.emitters().environment_light(direction);
  if (!bounce.is_weighted || is_black(light.radiance)) return light.radiance;
  return light.radiance * (bounce.pdf / (bounce.pdf + light.pdf));
}

}  // namespace manylight
