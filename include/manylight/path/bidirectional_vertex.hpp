// SPDX-License-Identifier: Apache-2.0
#pragma once

// Vertices of bidirectional path tracing: those of the toolkit, with the densities of both walks.

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "manylight/path/bidirectional_weights.hpp"
#include "manylight/path/vertex.hpp"
#include "manylight/path/walk.hpp"

namespace manylight {

namespace detail {
/// What the shapes on the two sides of a vertex absorb, m^-1 (SurfaceShader::interior_absorption).
template <std::floating_point S, bool Exists>
struct VertexAbsorption {
  Rgb<S> here{0};    ///< on the side of the known direction
  Rgb<S> beyond{0};  ///< on the other one
};
template <std::floating_point S>
struct VertexAbsorption<S, false> {};
}  // namespace detail

/// A vertex of a light or an eye walk.
template <class Scene>
struct BidirectionalVertex {
  using S = typename Scene::Scalar;
  VertexOf<Scene> vertex;     ///< its `w` is the direction back along the walk; `edges` counts from the walk's start
  PartialWeights<S> weights;  ///< on arrival
  bool is_delta = false;      ///< all its lobes are Dirac's: never connected
  bool left_by_dirac = false; ///< how the walk went on
  Rgb<S> emission{0};         ///< eye walks: what the path contributes that ends here on a light, W/m^2/sr, unweighted
  S emission_weight = S(0);
  [[no_unique_address]] detail::VertexAbsorption<S, Scene::ShaderType::k_may_absorb> absorption{};
};

/// A light or an eye walk, its vertices in the order in which they were met.
template <class Scene>
struct Subpath {
  using S = typename Scene::Scalar;
  std::vector<BidirectionalVertex<Scene>> vertices;
  std::optional<EmissionSample<S>> start;  ///< of a light walk
  Vec3<S> last_direction{0};               ///< of an eye walk that left the scene
  Rgb<S> environment{0};                   ///< what it found there, W/m^2/sr, unweighted
  S environment_weight = S(0);

  void clear() noexcept {
    vertices.clear();
    start.reset();
    environment = Rgb<S>(0);
  }
};

/// |w . ng|, in a medium 1: turns a density per solid angle times squared distance into one per area or volume.
template <AnyVertex V, std::floating_point S = typename V::Scalar>
[[nodiscard]] inline S density_cosine(const V& v, const Vec3<S>& w) noexcept {
  return v.is_in_medium() ? S(1) : std::abs(glm::dot(w, v.ng));
}

/// Probability with which a walk that knows the local direction `known` goes on: what the surface scatters. Being a function
/// of the vertex, it belongs to the densities of both walks.
template <Material M, std::floating_point S = typename M::Scalar>
[[nodiscard]] inline S survival(const M& material, const Vec3<S>& known) noexcept {
  // Without absorption walks still have to end: the throughput's square grows by 1 / 0.99 per vertex.
  return std::clamp(sampling_weight(material, known), S(0), S(0.99));
}

/// Density per solid angle with which a walk that knows `known` goes on along `sampled`, roulette included, sr^-1. Of
/// vertices in media roulette is left out, in both walks: the coefficients depend on the direction.
template <AnyVertex V, std::floating_point S = typename V::Scalar>
[[nodiscard]] inline S walk_pdf(const V& v, const Vec3<S>& known, const Vec3<S>& sampled, Walk walk) noexcept {
  if constexpr (V::k_may_be_in_medium) {
    if (v.is_in_medium()) return v.phase.pdf(sampled, known);
  }
  const Frame<S> frame = v.shading.frame();
  const Vec3<S> known_local = frame.to_local(known);
  return survival(v.material, known_local) * v.material.pdf(known_local, frame.to_local(sampled), walk);
}

}  // namespace manylight
