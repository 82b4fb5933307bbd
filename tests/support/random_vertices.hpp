// SPDX-License-Identifier: Apache-2.0
#pragma once

// Random sensors and lights for tests of trees and cuts: all kinds, bent shading normals, diffuse to sharp gloss.

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "manylight/geometry/bvh.hpp"
#include "manylight/path/eye_subpath.hpp"
#include "manylight/scattering/any_of.hpp"
#include "manylight/scattering/conductor.hpp"
#include "manylight/scattering/lambertian.hpp"
#include "manylight/scattering/mixture.hpp"
#include "manylight/scattering/phong.hpp"
#include "manylight/scattering/ward.hpp"

namespace manylight::test {

template <std::floating_point S>
using DiffusePhong = Mixture<Lambertian<S>, Phong<S>>;
template <std::floating_point S>
using DiffuseWard = Mixture<Lambertian<S>, Ward<S>>;
template <std::floating_point S>
using MixedMaterial = AnyOf<Lambertian<S>, DiffusePhong<S>, DiffuseWard<S>, RoughConductor<S>, Mirror<S>>;
template <std::floating_point S>
using MixedScene = Scene<Bvh<S>, UniformShader<MixedMaterial<S>>>;

/// Which materials are drawn.
enum class Gloss { none, some };

template <std::floating_point S>
class RandomVertices {
 public:
  using SceneType = MixedScene<S>;
  using VertexType = VertexOf<SceneType>;

  explicit RandomVertices(std::uint64_t seed) : random_(seed) {}

  S uniform(double lo = 0, double hi = 1) {
    return static_cast<S>(std::uniform_real_distribution<double>(lo, hi)(random_));
  }
  S log_uniform(double lo, double hi) { return static_cast<S>(lo * std::pow(hi / lo, static_cast<double>(uniform()))); }
  bool chance(double p) { return static_cast<double>(uniform()) < p; }
  Rgb<S> color(double lo, double hi) { return {uniform(lo, hi), uniform(lo, hi), uniform(lo, hi)}; }
  Vec3<S> direction() {
    const S z = uniform(-1, 1);
    const S phi = uniform(0, 2 * k_pi<double>);
    const S r = safe_sqrt(S(1) - z * z);
    return {r * std::cos(phi), r * std::sin(phi), z};
  }
  Vec3<S> point(const Vec3<S>& center, double half) {
    return center + Vec3<S>(uniform(-half, half), uniform(-half, half), uniform(-half, half));
  }
  /// Random direction on the positive side of both normals.
  Vec3<S> above(const Vec3<S>& a, const Vec3<S>& b) {
    for (;;) {
      const Vec3<S> w = direction();
      if (glm::dot(w, a) > S(0.01) && glm::dot(w, b) > S(0.01)) return w;
    }
  }

  MixedMaterial<S> material(Gloss gloss) {
    const Rgb<S> diffuse = color(0.1, 0.5);
    const double kind = gloss == Gloss::none ? 0.0 : static_cast<double>(uniform());
    if (kind < 0.3) return Lambertian<S>{diffuse};
    if (kind < 0.55) {
      return DiffusePhong<S>({Lambertian<S>{diffuse}, S(1)}, {Phong<S>{color(0.1, 0.5), log_uniform(1, 2000)}, S(1)});
    }
    if (kind < 0.8) {
      return DiffuseWard<S>({Lambertian<S>{diffuse}, S(1)},
                            {Ward<S>{color(0.1, 0.4), log_uniform(0.02, 0.8), log_uniform(0.02, 0.8)}, S(1)});
    }
    RoughConductor<S> metal;
    metal.distribution = chance(0.5) ? MicrofacetType::ggx : MicrofacetType::beckmann;
    metal.alpha_u = log_uniform(0.02, 0.8);
    metal.alpha_v = log_uniform(0.02, 0.8);
    metal.eta = Rgb<S>(S(0.2), S(0.9), S(1.1));
    metal.k = Rgb<S>(S(3.9), S(2.4), S(2.2));
    return metal;
  }

  VertexType surface(const Vec3<S>& position, const Vec3<S>& ng, Gloss gloss) {
    VertexType v;
    v.position = position;
    v.error = S(1e-6);
    v.ng = ng;
    const Vec3<S> ns = chance(0.5) ? ng : glm::normalize(ng + direction() * S(0.4));
    v.shading = detail::ShadingFrame<S, false>(Frame<S>(ns, direction()));
    v.material = material(gloss);
    v.alpha = max_channel(v.material.albedo());
    v.w = above(ng, ns);
    v.edges = static_cast<std::uint16_t>(1);
    return v;
  }

  /// Every kind of light; `kinds` are the admitted ones.
  VertexType light(const Vec3<S>& position, const Vec3<S>& ng, Gloss gloss, const std::vector<VertexKind>& kinds) {
    const VertexKind kind = kinds[static_cast<std::size_t>(uniform(0, static_cast<double>(kinds.size()) - 1e-6))];
    VertexType v;
    if (kind == VertexKind::surface) {
      v = surface(position, ng, gloss);
    } else {
      v.position = kind == VertexKind::infinite_emitter ? ng : position;
      v.ng = kind == VertexKind::point_emitter || kind == VertexKind::infinite_emitter ? Vec3<S>(0) : ng;
    }
    v.kind = kind;
    if (kind == VertexKind::spot_emitter) {
      const S cutoff = log_uniform(0.02, 3.1);
      v.w = {chance(0.2) ? cutoff : uniform(0, static_cast<double>(cutoff)), cutoff, S(0)};
    }
    v.exact = kind == VertexKind::point_emitter || kind == VertexKind::spot_emitter ||
              (kind == VertexKind::infinite_emitter && chance(0.5));
    v.strength = color(0.05, 1) * log_uniform(0.1, 10);
    return v;
  }

  template <class W>
  Sensor<SceneType, W> sensor(const W& weighting, const Vec3<S>& position, const Vec3<S>& ng, Gloss gloss) {
    Sensor<SceneType, W> s{surface(position, ng, gloss), weighting.start()};
    s.vertex.strength = color(0.05, 1) * log_uniform(0.1, 10);
    const int bounces = static_cast<int>(uniform(0, 3.999)) - 1;
    for (int i = 0; i < bounces; ++i) {
      // Sharp bounces in a row keep the limit of directionality off, so that used-up energy is what limits the rest.
      const S m = chance(0.6) ? log_uniform(400, 4000) : log_uniform(0.01, 400);
      s.record = chance(0.15) ? weighting.extend_delta(s.record)
                              : weighting.extend(s.record, m, log_uniform(0.01, 3000), log_uniform(1e-6, 1e3));
    }
    return s;
  }

 private:
  std::mt19937_64 random_;
};

}  // namespace manylight::test
