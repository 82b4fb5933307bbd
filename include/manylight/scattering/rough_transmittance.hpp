// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "manylight/scattering/fresnel.hpp"
#include "manylight/scattering/gauss_legendre.hpp"
#include "manylight/scattering/microfacet.hpp"

namespace manylight {

/// What counts as reflected back down at the inside of a rough interface.
enum class InternalReflectance {
  /// All that is not transmitted, light that the facets mask included: the coat then conserves energy for a white base.
  not_transmitted,
  /// The singly reflected light alone, averaged with equal weights over the table's nodes: the definition of version 3
  /// of the Mitsuba renderer, for comparison with its pictures (darker by about 2 % than the integral).
  singly_reflected_nodes,
};

/// Transmittance of a rough dielectric interface as a function of the cosine, tabulated at set-up, immutable and shared
/// by all closures of one (distribution, alpha, eta). About 0.6 KiB.
template <std::floating_point S>
class RoughTransmittance {
 public:
  static constexpr std::size_t k_nodes = 64;        ///< of the table, equidistant in the cosine
  static constexpr std::size_t k_rule_points = 48;  ///< of the quadrature, in each of two variates

  /// `eta` = index inside / index outside, not 1. Throws ParameterError. Takes tens of milliseconds.
  RoughTransmittance(MicrofacetType type, S alpha, S eta,
                     InternalReflectance definition = InternalReflectance::not_transmitted)
      : facets_{type, alpha, alpha}, eta_(eta) {
    check::roughness("RoughTransmittance alpha", alpha);
    check::relative_ior("RoughTransmittance eta", eta);
    const std::vector<QuadratureNode> rule = gauss_legendre(k_rule_points);
    for (std::size_t i = 0; i < k_nodes; ++i) nodes_[i] = static_cast<S>(transmitted(node_cosine(i), rule));
    mean_ = integrate_mean();
    max_ = *std::max_element(nodes_.begin(), nodes_.end());
    // Reciprocity of the interface: eta^2 times the mean transmittance from inside is the mean from outside.
    reflectance_inside_ =
        definition == InternalReflectance::not_transmitted ? S(1) - mean_ / (eta * eta) : mean_reflected_inside();
  }

  [[nodiscard]] MicrofacetDistribution<S> facets() const noexcept { return facets_; }
  [[nodiscard]] S eta() const noexcept { return eta_; }
  /// Share of the light from the outside direction of that cosine that enters, by linear interpolation, [0, 1].
  [[nodiscard]] S at(S cosine) const noexcept {
    const S x = std::clamp(cosine, S(0), S(1)) * static_cast<S>(k_nodes - 1);
    const std::size_t i = std::min(static_cast<std::size_t>(x), k_nodes - 2);
    const S t = x - static_cast<S>(i);
    return (S(1) - t) * nodes_[i] + t * nodes_[i + 1];
  }
  /// Range over cosines: of a linear interpolant, from the values at the ends and the nodes between.
  [[nodiscard]] Interval<S> at(const Interval<S>& cosine) const noexcept {
    const auto [least_end, most_end] = std::minmax({at(cosine.lo), at(cosine.hi)});
    const S last = static_cast<S>(k_nodes - 1);
    const std::size_t first = static_cast<std::size_t>(std::ceil(std::clamp(cosine.lo, S(0), S(1)) * last));
    const std::size_t beyond = static_cast<std::size_t>(std::clamp(cosine.hi, S(0), S(1)) * last) + 1;
    S least = least_end;
    S most = most_end;
    for (std::size_t i = first; i < beyond; ++i) {
      least = std::min(least, nodes_[i]);
      most = std::max(most, nodes_[i]);
    }
    return widen(Interval<S>(least, most), S(4) * std::numeric_limits<S>::epsilon());
  }
  /// 2 int_0^1 at(mu) mu dmu, the hemispherical transmittance from outside.
  [[nodiscard]] S mean() const noexcept { return mean_; }
  /// The largest of all `at`.
  [[nodiscard]] S max() const noexcept { return max_; }
  /// Hemispherical reflectance met from inside, by the chosen definition.
  [[nodiscard]] S reflectance_inside() const noexcept { return reflectance_inside_; }

 private:
  using Double = MicrofacetDistribution<double>;

  [[nodiscard]] Double facets_in_double() const noexcept {
    return {facets_.type, static_cast<double>(facets_.alpha_u), static_cast<double>(facets_.alpha_v)};
  }
  [[nodiscard]] static double node_cosine(std::size_t i) noexcept {
    return std::max(1e-6, static_cast<double>(i) / static_cast<double>(k_nodes - 1));
  }

  /// Mean of `value(normal)` over the normals visible from `w`: the sampling square by a product rule, whose points
  /// crowd at the edges of the square, where the sampling puts the steep facets.
  template <class Value>
  [[nodiscard]] static double mean_over_visible(const Double& facets, const Vec3<double>& w,
                                                const std::vector<QuadratureNode>& rule, const Value& value) {
    double sum = 0;
    for (const QuadratureNode& a : rule) {
      for (const QuadratureNode& b : rule) {
        sum += a.weight * b.weight * value(facets.sample_visible(w, Vec2<double>(a.x, b.x)));
      }
    }
    return sum;
  }

  /// int T: the refracted direction must not be masked on its side. [Walter 2007, Eq. 21, with visible normals]
  [[nodiscard]] double transmitted(double cosine, const std::vector<QuadratureNode>& rule) const {
    const Double facets = facets_in_double();
    const double eta = static_cast<double>(eta_);
    const Vec3<double> w(std::sqrt(1.0 - cosine * cosine), 0.0, cosine);
    return mean_over_visible(facets, w, rule, [&](const Vec3<double>& m) {
      const double c = glm::dot(w, m);
      const DielectricInterface<double> surface = fresnel_dielectric(c, eta);
      const Vec3<double> refracted = m * (c * surface.eta_ratio + surface.cos_t) - w * surface.eta_ratio;
      return refracted.z < 0.0 && c > 0.0 ? (1.0 - surface.reflectance) * facets.masking(refracted) : 0.0;
    });
  }

  /// Exact for the interpolant: int of a linear function times mu over each interval.
  [[nodiscard]] S integrate_mean() const noexcept {
    const double h = 1.0 / static_cast<double>(k_nodes - 1);
    double sum = 0;
    for (std::size_t i = 0; i + 1 < k_nodes; ++i) {
      const double a = static_cast<double>(i) * h;
      const double t0 = static_cast<double>(nodes_[i]);
      const double t1 = static_cast<double>(nodes_[i + 1]);
      sum += h * (a * 0.5 * (t0 + t1) + h * (t0 / 6.0 + t1 / 3.0));
    }
    return static_cast<S>(2.0 * sum);
  }

  [[nodiscard]] S mean_reflected_inside() const {
    const std::vector<QuadratureNode> rule = gauss_legendre(k_rule_points);
    const Double facets = facets_in_double();
    const double eta = 1.0 / static_cast<double>(eta_);
    double sum = 0;
    for (std::size_t i = 0; i < k_nodes; ++i) {
      const double cosine = node_cosine(i);
      const Vec3<double> w(std::sqrt(1.0 - cosine * cosine), 0.0, cosine);
      sum += cosine * mean_over_visible(facets, w, rule, [&](const Vec3<double>& m) {
               const Vec3<double> reflected = local::mirror(w, m);
               if (reflected.z <= 0.0) return 0.0;
               return fresnel_dielectric(glm::dot(w, m), eta).reflectance * facets.masking(reflected);
             });
    }
    return static_cast<S>(2.0 * sum / static_cast<double>(k_nodes));
  }

  MicrofacetDistribution<S> facets_;
  S eta_;
  std::array<S, k_nodes> nodes_{};
  S mean_ = S(0);
  S max_ = S(0);
  S reflectance_inside_ = S(0);
};

}  // namespace manylight
