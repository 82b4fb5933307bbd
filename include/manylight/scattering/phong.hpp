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

/// Modified Phong lobe, f = specular (n + 2) / (2 pi) max(0, r . wi)^n, r the mirror image of wo. Its albedo is
/// `specular` at normal incidence for every n and falls towards grazing angles, where the lobe dips below the surface.
/// Reciprocal.
/// [Lafortune and Willems 1994, "Using the modified Phong reflectance model"]
template <std::floating_point S>
struct Phong {
  using Scalar = S;
  static constexpr bool k_isotropic = true;  ///< vertices need no tangent
  Rgb<S> specular{S(0.5)};                   ///< albedo at normal incidence per channel, [0, 1]
  S exponent = S(50);                        ///< n >= 0; the larger, the sharper

  /// Throws ParameterError.
  void validate() const {
    check::reflectance("Phong specular", specular);
    check::non_negative("Phong exponent", exponent);
  }

  /// Of vectors the BSDF; of direction sets the range of its values over them.
  template <LocalDirection<S> Wi = Vec3<S>, LocalDirection<S> Wo = Vec3<S>>
  [[nodiscard]] auto eval(const Wi& wi, const Wo& wo) const noexcept {
    return when(wi.z > S(0) && wo.z > S(0), [&] { return specular * (peak() * lobe(dot(mirror(wo), wi))); });
  }

  /// The BSDF times |wi.z|. The two do not peak together: delta away from the mirror image, at the angle theta from the
  /// normal, the cosine is at most cos(max(0, theta - delta)), and cos^n(delta) cos(theta - delta) rises up to
  /// n tan(delta) = tan(theta - delta), then falls.
  template <LocalDirection<S> Wi = Vec3<S>, LocalDirection<S> Wo = Vec3<S>>
  [[nodiscard]] auto eval_cos(const Wi& wi, const Wo& wo) const noexcept {
    if constexpr (std::is_same_v<PatternScalar<Wi, Wo, S>, S>) {
      return eval(wi, wo) * std::abs(wi.z);
    } else {
      return when(wi.z > S(0) && wo.z > S(0), [&] {
        const Interval<S> cos_delta = min(Interval<S>(dot(mirror(wo), wi)), S(1));
        const Interval<S> product = lobe(cos_delta) * max0(Interval<S>(wi.z));
        const auto both = [&] { return Interval<S>(S(0), sup_lobe_cos(cos_delta, Interval<S>(wo.z).hi)); };
        return specular * (peak() * refine(product, both));
      });
    }
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
    const Vec3<S> w = glm::normalize(Frame<S>(local::mirror(known)).to_world(around_axis));
    const S density = pdf(known, w, walk);
    if (!(density > S(0))) return std::nullopt;
    return DirectionSample<S>{w, density, false, Rgb<S>(0)};
  }

  [[nodiscard]] S pdf(const Vec3<S>& known, const Vec3<S>& sampled, Walk) const noexcept {
    if (!local::both_above(known, sampled)) return S(0);
    return (exponent + S(1)) / (S(2) * k_pi<S>)*lobe(glm::dot(local::mirror(known), sampled));
  }

  [[nodiscard]] Rgb<S> albedo() const noexcept { return specular; }
  [[nodiscard]] static constexpr bool is_delta() noexcept { return false; }

 private:
  /// Supremum of cos^n(delta) cos(max(0, theta - delta)); both terms fall with theta, whose least cosine does not
  /// count.
  [[nodiscard]] S sup_lobe_cos(const Interval<S>& cos_delta, S max_cos_theta) const noexcept {
    if (!(cos_delta.hi > S(0))) return S(0);
    const S cosine = std::min(max_cos_theta, S(1));
    if (cos_delta.hi <= cosine) return k_infinity<S>;  // the cosine may be 1
    const auto sine_of = [](S c) { return safe_sqrt((S(1) - c) * (S(1) + c)); };
    const S sine = sine_of(cosine);
    // n T t^2 + (n + 1) t - T = 0 for t = tan(delta), T = tan(theta).
    const S b = (exponent + S(1)) * cosine / sine;
    const S t = S(2) / (b + std::sqrt(b * b + S(4) * exponent));
    const S u = std::clamp(S(1) / std::sqrt(S(1) + t * t), std::max(cos_delta.lo, S(0)), cos_delta.hi);
    // Next to 1, cosines that are off by a few epsilon belong to other angles: u^n as computed may be that much larger.
    const S epsilon = std::numeric_limits<S>::epsilon();
    const S margin = (S(16) + S(8) * exponent / u) * epsilon;
    if (!(margin < S(0.1))) return k_infinity<S>;
    return detail::up_from_tiny(std::pow(u, exponent) * std::min(u * cosine + sine_of(u) * sine, S(1)), margin);
  }
  [[nodiscard]] S peak() const noexcept { return (exponent + S(2)) / (S(2) * k_pi<S>); }
  /// max(0, c)^n; an exponent of 0 still ends the lobe at 90 degrees from its axis. Rounding must not lift c above 1.
  template <class Cosine>
  [[nodiscard]] Cosine lobe(const Cosine& c) const noexcept {
    return when(c > S(0), [&] { return manylight::pow(manylight::min(c, S(1)), exponent); });
  }
};

static_assert(SetEvaluable<Phong<float>> && SetEvaluable<Phong<double>>);

}  // namespace manylight
