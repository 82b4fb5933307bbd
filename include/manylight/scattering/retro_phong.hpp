// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "manylight/core/direction_set.hpp"
#include "manylight/core/frame.hpp"
#include "manylight/core/rgb_interval.hpp"
#include "manylight/scattering/local_geometry.hpp"
#include "manylight/scattering/validation.hpp"

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
  template <LocalDirection<S> Wi = Vec3<S>, LocalDirection<S> Wo = Vec3<S>>
  [[nodiscard]] auto eval(const Wi& wi, const Wo& wo) const noexcept {
    return when(wi.z > S(0) && wo.z > S(0), [&] { return specular * (peak() * lobe(dot(wi, wo))); });
  }

  /// The cosine to the lobe's axis has the density (n + 1) cos^n on [0, 1]: cos = (1 - u)^(1 / (n + 1)), by inversion.
  /// Draws below the surface are rejected, so that the pdf integrates to less than 1 towards grazing angles.
  [[nodiscard]] std::optional<DirectionSample<S>> sample(const Vec3<S>& known, Walk walk, S /*u_lobe*/,
                                                         const Vec2<S>& u) const noexcept {
    if (known.z <= S(0)) return std::nullopt;
    // sin^2 = 1 - cos^2 from the logarithm, which keeps its digits where cos is near 1 (sharp lobes).
    const S log_cos = std::log1p(-u.x) / (exponent + S(1));
    const S cosine = std::exp(log_cos);
    const S sine = safe_sqrt(-std::expm1(S(2) * log_cos));
    const S phi = S(2) * k_pi<S> * u.y;
    const Vec3<S> around_axis{sine * std::cos(phi), sine * std::sin(phi), cosine};
    const Vec3<S> w = glm::normalize(Frame<S>(known).to_world(around_axis));
    const S density = pdf(known, w, walk);
    if (!(density > S(0))) return std::nullopt;
    return DirectionSample<S>{w, density, false, Rgb<S>(0)};
  }

  [[nodiscard]] S pdf(const Vec3<S>& known, const Vec3<S>& sampled, Walk) const noexcept {
    if (!local::both_above(known, sampled)) return S(0);
    return (exponent + S(1)) / (S(2) * k_pi<S>)*lobe(glm::dot(known, sampled));
  }

  [[nodiscard]] Rgb<S> albedo() const noexcept { return specular; }
  [[nodiscard]] static constexpr bool is_delta() noexcept { return false; }

 private:
  [[nodiscard]] S peak() const noexcept { return (exponent + S(2)) / (S(2) * k_pi<S>); }
  /// max(0, c)^n; an exponent of 0 still ends the lobe at 90 degrees from its axis. Rounding must not lift c above 1.
  template <class Cosine>
  [[nodiscard]] Cosine lobe(const Cosine& c) const noexcept {
    return when(c > S(0), [&] { return manylight::pow(manylight::min(c, S(1)), exponent); });
  }
};

static_assert(SetEvaluable<RetroPhong<float>> && SetEvaluable<RetroPhong<double>>);

}  // namespace manylight
