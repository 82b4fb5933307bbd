// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "manylight/path/bidirectional_connect.hpp"
#include "manylight/scattering/fresnel.hpp"

// The oracle of the recursive weights: of a whole path every strategy's density, each vertex' both ways, and the weights by
// walking from the strategy in question to both ends with the ratios of neighbouring ones [Veach 1997, section 10.2.1].

namespace manylight::test {

/// The light end of a path.
struct PathLight {
  EmitterKind kind{};
  Vec3<double> position{0};  ///< of lights at infinity the unit direction towards them
  Vec3<double> ng{0};
  double position_pdf = 0;   ///< f_0: per area, of point lights the selection, at infinity p(wo), selection included
  double direction_pdf = 0;  ///< of wo given the position over |wo . ng|; at infinity per area of the entry
  double direct_pdf = 0;     ///< p_dir: in place of f_0
};

/// An emissive shape, drawn or hit, seen from `reference`.
template <class SceneType>
[[nodiscard]] PathLight area_light(const SceneType& scene, const SurfacePoint<double>& point, bool two_sided,
                                   const Vec3<double>& reference) {
  PathLight light{EmitterKind::area, point.position, point.ng};
  light.direction_pdf = k_inv_pi<double> / (two_sided ? 2 : 1);
  light.position_pdf = scene.emitters().projected_pdf_emission(point) / light.direction_pdf;
  const Vec3<double> segment = point.position - reference;
  const double r2 = glm::dot(segment, segment);
  const Vec3<double> wi = segment / std::sqrt(r2);
  light.direct_pdf = scene.emitters().pdf_direct(reference, point, wi) * std::abs(glm::dot(wi, point.ng)) / r2;
  return light;
}
template <class SceneType>
[[nodiscard]] PathLight infinite_light(const SceneType& scene, EmitterKind kind, const Vec3<double>& wi, double pdf) {
  const double radius = scene.emitters().scene_radius();
  const bool has_walks = has_walks_from_infinity(scene);
  return {kind, wi, Vec3<double>(0), pdf, has_walks ? k_inv_pi<double> / (radius * radius) : 0, pdf};
}

/// A path z_0 ... z_n, z_n on the lens.
template <class SceneType>
class WholePath {
 public:
  using V = BidirectionalVertex<SceneType>;

  PathLight light;
  std::vector<const V*> vertices;     ///< z_1 ... z_{n-1}
  std::vector<bool> is_dirac;         ///< of these
  std::vector<Vec3<double>> directions;  ///< [i]: unit, from z_i to z_{i+1}
  std::vector<bool> is_below;           ///< [i]: that segment runs through an object; its direction is not used
  Vec3<double> lens{0};
  double film_density = 0;
  double light_paths = 0;

  [[nodiscard]] std::size_t length() const { return vertices.size() + 1; }

  /// Shares of the strategies s = 0 ... n, seen from strategy `s`, which must be allowed.
  [[nodiscard]] std::vector<double> weights(std::size_t s) const {
    const std::size_t n = length();
    std::vector<double> ratio(n + 1, 0.0);
    ratio[s] = 1;
    double r = 1;
    for (std::size_t j = s; j < n; ++j) ratio[j + 1] = (r *= step(j)) * times(j + 1) / times(s);
    r = 1;
    for (std::size_t j = s; j-- > 0;) ratio[j] = (r /= step(j)) * times(j) / times(s);
    double sum = 0;
    for (std::size_t j = 0; j <= n; ++j) {
      if (!is_allowed(j)) ratio[j] = 0;
      sum += ratio[j];
    }
    for (double& x : ratio) x /= sum;
    return ratio;
  }
  [[nodiscard]] bool is_allowed(std::size_t s) const {
    const std::size_t n = length();
    if (s == 0) return !is_delta(light.kind);
    if (n == 1) return false;
    if (s == 1) return !dirac(1);
    if (!has_light_walks() || dirac(s - 1)) return false;
    return s == n ? light_paths > 0 : !dirac(s);
  }

 private:
  [[nodiscard]] bool has_light_walks() const { return light.direction_pdf > 0; }
  [[nodiscard]] bool dirac(std::size_t i) const { return is_dirac[i - 1]; }
  [[nodiscard]] double times(std::size_t s) const { return s == length() && s > 1 ? light_paths : 1; }
  [[nodiscard]] Vec3<double> position(std::size_t i) const {
    return i == 0 ? light.position : i == length() ? lens : vertices[i - 1]->vertex.position;
  }
  /// From a density per solid angle at z_from to one at z_to.
  [[nodiscard]] double geometry(std::size_t from, std::size_t to) const {
    if (is_below[std::min(from, to)]) return 1;
    const Vec3<double>& w = directions[std::min(from, to)];
    const double cosine = to == 0 ? (light.kind == EmitterKind::area ? std::abs(glm::dot(w, light.ng)) : 1)
                          : vertices[to - 1]->vertex.is_in_medium() ? 1
                                                                    : std::abs(glm::dot(w, vertices[to - 1]->vertex.ng));
    if (is_infinite(light.kind) && (from == 0 || to == 0)) return cosine;
    const Vec3<double> segment = position(to) - position(from);
    return cosine / glm::dot(segment, segment);
  }
  /// Towards z_{i+1} with `Walk::light`, else towards z_{i-1}.
  [[nodiscard]] double walk_density(std::size_t i, Walk walk) const {
    if (dirac(i)) return 1;
    const bool from_light = walk == Walk::light;
    const std::size_t before = from_light ? i - 1 : i, behind = from_light ? i : i - 1;
    const Vec3<double> known = from_light ? -directions[before] : directions[before];
    const Vec3<double> sampled = from_light ? directions[behind] : -directions[behind];
    if constexpr (SceneType::k_has_subsurface) {
      if (is_below[before] || is_below[behind]) return density_below(i, known, sampled, before, behind);
      return (1 - share_below(i, known)) * surface_density(i, known, sampled, walk);
    }
    return surface_density(i, known, sampled, walk);
  }
  /// Share of walks from `known` that go below: by what either way scatters.
  [[nodiscard]] double share_below(std::size_t i, const Vec3<double>& known) const {
    const V& v = *vertices[i - 1];
    const auto* below = v.below.scattering;
    if (below == nullptr || glm::dot(known, v.below.outward) <= 0) return 0;
    const double into = below->rho.x * passes(i, known);
    const double on = sampling_weight(v.vertex.material, v.vertex.shading.frame().to_local(known));
    return into / (into + on);
  }
  /// Ft; all objects are grey.
  [[nodiscard]] double passes(std::size_t i, const Vec3<double>& w) const {
    const V& v = *vertices[i - 1];
    return 1 - reflectance_dielectric(glm::dot(w, v.below.outward), v.below.scattering->eta);
  }
  [[nodiscard]] double density_below(std::size_t i, const Vec3<double>& known, const Vec3<double>& sampled,
                                     std::size_t before, std::size_t behind) const {
    const V& v = *vertices[i - 1];
    const auto& below = *v.below.scattering;
    const double root = std::sqrt(below.rho.x);
    if (is_below[before]) return std::min(0.99, root) * glm::dot(sampled, v.below.outward) * k_inv_pi<double>;
    const double d = glm::length(position(behind + 1) - position(behind));
    return share_below(i, known) * std::min(0.99, root * passes(i, known)) * below.falloff.eval(d).x;
  }
  [[nodiscard]] double surface_density(std::size_t i, const Vec3<double>& known, const Vec3<double>& sampled,
                                       Walk walk) const {
    const auto& v = vertices[i - 1]->vertex;
    if constexpr (SceneType::k_has_media) {
      if (v.is_in_medium()) return v.phase.pdf(sampled, known);
    }
    const Frame<double> frame = v.shading.frame();
    const double q = std::min(0.99, sampling_weight(v.material, frame.to_local(known)));
    return q * v.material.pdf(frame.to_local(known), frame.to_local(sampled), walk);
  }
  [[nodiscard]] double f(std::size_t i) const {
    if (i == 0) return light.position_pdf;
    if (i > 1) {
      return walk_density(i - 1, Walk::light) * geometry(i - 1, i);
    }
    const double cosine = light.kind == EmitterKind::area ? std::abs(glm::dot(directions[0], light.ng)) : 1;
    return light.direction_pdf * cosine * geometry(0, 1);
  }
  [[nodiscard]] double b(std::size_t i) const {
    if (i == 0 && is_delta(light.kind)) return 1;  // cancels: nothing is compared with s = 0
    if (i + 1 == length()) return film_density * geometry(i + 1, i);
    return walk_density(i + 1, Walk::eye) * geometry(i + 1, i);
  }
  /// p_{j+1} / p_j without the numbers of samples; s = 1 has p_dir for f_0.
  [[nodiscard]] double step(std::size_t j) const {
    if (j == 0) return light.direct_pdf / b(0);
    return (j == 1 ? light.position_pdf / light.direct_pdf : 1) * f(j) / b(j);
  }
};

}  // namespace manylight::test
