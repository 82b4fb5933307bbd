// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <concepts>

#include "manylight/bounds/automatic.hpp"
#include "manylight/bounds/cube_map.hpp"
#include "manylight/core/frame.hpp"

namespace manylight {

/// Bounds by `B`, and cube-maps of them for the clusters of a gather tree. Tighter than profiles for lobes that are not
/// round and for clusters of different materials, and dearer: some hundred bounds of the material per sensor instead of
/// ten.
template <class B = AutomaticBounds>
struct CubeMapBounds {
  B base{};
  CubeMapLimits limits{};

  [[nodiscard]] static constexpr bool makes_maps() noexcept { return true; }
  template <Material M, class Wi, class Wo>
  [[nodiscard]] PatternSup<typename M::Scalar> sup(const M& m, const Wi& wi, const Wo& wo) const noexcept {
    return base.sup(m, wi, wo);
  }
};

/// A policy that may make maps.
template <class B>
concept MapsPatterns = requires(const B& bounds) {
  { bounds.makes_maps() } -> std::same_as<bool>;
  { bounds.limits } -> std::convertible_to<CubeMapLimits>;
};

/// Map over world directions wi of `factor` f |wi.z|, sr^-1, of a surface with the shading frame `frame`, for the world
/// direction `wo`.
template <std::floating_point S, Material M, MapsPatterns B>
void build_sensor_map(const B& bounds, const M& m, const Frame<S>& frame, const Vec3<S>& wo, S factor,
                      CubeMap<S>& map) {
  const Vec3<S> local_wo = frame.to_local(wo);
  const auto bound = [&](const DirectionSet<S>& cell) {
    const DirectionCone<S>& c = cell.cone;
    const DirectionSet<S> local({glm::normalize(frame.to_local(c.axis)), c.cos_half, c.sin_half});
    const S sup = bounds.sup(m, local, local_wo).eval_cos;
    return factor > S(0) ? sup * factor : S(0);  // the bound may be infinite
  };
  const auto value = [&](const Vec3<S>& wi) {
    const Vec3<S> local = frame.to_local(wi);
    return max_channel(m.eval(local, local_wo)) * std::abs(local.z) * factor;
  };
  map.build(bound, value, bounds.limits);
}

}  // namespace manylight
