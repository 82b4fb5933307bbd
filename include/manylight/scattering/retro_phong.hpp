// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "manylight/scattering/phong.hpp"

namespace manylight {

/// Lobe back to where the light came from, as of road signs: f = specular (n + 2) / (2 pi) max(0, wi . wo)^n. Mirroring
/// wi about the normal turns it into a modified Phong lobe and keeps wi.z, so that its albedo is the same: `specular`
/// at normal incidence for every n, less towards grazing angles. Reciprocal. A hard case for bounds that follow the
/// mirror direction. [Lafortune 1997]
template <std::floating_point S>
struct RetroPhong {
  using Scalar = S;
  static constexpr bool k_isotropic = true;  ///< vertices need no tangent
  Rgb<S> specular{S(0.5)};                   ///< albedo at normal incidence per channel, [0, 1]
  S exponent = S(50);                        ///< n >= 0; the larger, the sharper

  /// Throws ParameterError.
  void validate() const {
    check::reflectance("RetroPhong specular", specular);
    check::non_negative("RetroPhong exponent", exponent);
  }

  /// Of vectors the BSDF; of direction sets the range of its values over them.
  template <LocalDirection<S> Wi, LocalDirection<S> Wo>
  [[nodiscard]] auto eval(const Wi& wi, const Wo& wo) const noexcept {
    return phong().eval(mirror(wi), wo);
  }
  /// Times |wi.z|, which mirroring keeps.
  template <LocalDirection<S> Wi, LocalDirection<S> Wo>
  [[nodiscard]] auto eval_cos(const Wi& wi, const Wo& wo) const noexcept {
    return phong().eval_cos(mirror(wi), wo);
  }

  [[nodiscard]] std::optional<DirectionSample<S>> sample(const Vec3<S>& known, Walk walk, S u_lobe,
                                                         const Vec2<S>& u) const noexcept {
    std::optional<DirectionSample<S>> drawn = phong().sample(known, walk, u_lobe, u);
    if (drawn) drawn->direction = mirror(drawn->direction);
    return drawn;
  }
  [[nodiscard]] S pdf(const Vec3<S>& known, const Vec3<S>& sampled, Walk walk) const noexcept {
    return phong().pdf(known, mirror(sampled), walk);
  }

  [[nodiscard]] Rgb<S> albedo() const noexcept { return specular; }
  [[nodiscard]] static constexpr bool is_delta() noexcept { return false; }

 private:
  [[nodiscard]] Phong<S> phong() const noexcept { return {specular, exponent}; }
};

static_assert(SetEvaluable<RetroPhong<float>> && SetEvaluable<RetroPhong<double>>);

}  // namespace manylight
