// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "manylight/core/direction_set.hpp"
#include "manylight/core/rgb_interval.hpp"
#include "manylight/core/warp.hpp"
#include "manylight/scattering/concepts.hpp"
#include "manylight/scattering/validation.hpp"

namespace manylight {

/// Diffuse reflection, f = albedo / pi on the side of the normal.
template <std::floating_point S>
struct Lambertian {
  using Scalar = S;
  static constexpr bool k_isotropic = true;  ///< vertices need no tangent
  Rgb<S> reflectance{S(0.5)};                ///< albedo per channel, [0, 1]

  /// Throws ParameterError.
  void validate() const { check::reflectance("Lambertian reflectance", reflectance); }

  /// Of vectors the BSDF; of direction sets the range of its values over them.
  template <LocalDirection<S> Wi = Vec3<S>, LocalDirection<S> Wo = Vec3<S>>
  [[nodiscard]] auto eval(const Wi& wi, const Wo& wo) const noexcept {
    const PatternScalar<Wi, Wo, S> inv_pi = k_inv_pi<S>;
    return when(wi.z > S(0) && wo.z > S(0), [&] { return reflectance * inv_pi; });
  }
  [[nodiscard]] std::optional<DirectionSample<S>> sample(const Vec3<S>& known, Walk, S /*u_lobe*/,
                                                         const Vec2<S>& u) const noexcept {
    if (known.z <= S(0)) return std::nullopt;
    const Vec3<S> w = warp::square_to_cosine_hemisphere(u);
    return DirectionSample<S>{w, warp::cosine_hemisphere_pdf(w), false, Rgb<S>(0)};
  }
  [[nodiscard]] S pdf(const Vec3<S>& known, const Vec3<S>& sampled, Walk) const noexcept {
    return known.z > S(0) ? warp::cosine_hemisphere_pdf(sampled) : S(0);
  }
  [[nodiscard]] Rgb<S> albedo() const noexcept { return reflectance; }
  [[nodiscard]] static constexpr bool is_delta() noexcept { return false; }
};

static_assert(SetEvaluable<Lambertian<float>> && SetEvaluable<Lambertian<double>>);

}  // namespace manylight
