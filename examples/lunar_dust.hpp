// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "manylight/manylight.hpp"

using namespace manylight;

/// f = w / (4 pi (cos_i + cos_o)): single isotropic scattering in an opaque layer of dust.
struct LunarDust {
  using Scalar = float;
  static constexpr bool k_isotropic = true;  // vertices store a normal instead of a frame
  Rgb<float> single_albedo{0.9F};            ///< w, what one grain scatters of the light it meets, [0, 1]

  /// Of two vectors a colour, of sets of directions a range of colours: one text for both.
  template <LocalDirection<float> Wi, LocalDirection<float> Wo>
  [[nodiscard]] auto eval(const Wi& wi, const Wo& wo) const noexcept {
    return when(wi.z > 0 && wo.z > 0,
                [&] { return single_albedo * (k_inv_pi<float> / (4.0F * (max0(wi.z) + max0(wo.z)))); });
  }
  [[nodiscard]] std::optional<DirectionSample<float>> sample(const Vec3<float>& known, Walk, float,
                                                             const Vec2<float>& u) const noexcept {
    if (!(known.z > 0)) return std::nullopt;
    const Vec3<float> w = warp::square_to_cosine_hemisphere(u);
    return DirectionSample<float>{w, warp::cosine_hemisphere_pdf(w), false, Rgb<float>(0)};
  }
  [[nodiscard]] float pdf(const Vec3<float>& known, const Vec3<float>& sampled, Walk) const noexcept {
    return known.z > 0 ? warp::cosine_hemisphere_pdf(sampled) : 0;
  }
  /// At normal incidence the integral of f cos_i is w (1 - log 2) / 2.
  [[nodiscard]] Rgb<float> albedo() const noexcept { return single_albedo * 0.15342641F; }
  [[nodiscard]] static constexpr bool is_delta() noexcept { return false; }
};
