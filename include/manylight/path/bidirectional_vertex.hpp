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
/// What scatters below the surface that a vertex is on, whether the walk goes there or not.
template <class Scene, bool Exists>
struct VertexBelow {
  using S = typename Scene::Scalar;
  const typename Scene::Subsurface* scattering = nullptr;
  Vec3<S> outward{0};      ///< the object's geometric normal
  S passage_pdf = S(0);    ///< of an outer vertex: see passage_pdf, to where the walk went in, m^-2
};
template <class Scene>
struct VertexBelow<Scene, false> {};
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
  [[no_unique_address]] detail::VertexBelow<Scene, Scene::k_has_subsurface> below{};  ///< of surfaces
};

/// A light or an eye walk, its vertices in the order in which they were met; where a surface scatters below, too, two in
/// one place: its own, then the inner one.
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
  /// Segments up to the last vertex.
  [[nodiscard]] unsigned edges() const noexcept { return vertices.empty() ? 0 : vertices.back().vertex.edges; }
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

/// The same for going below a surface, and for coming out of one, of `below`; `cosine` as in probability_below.
template <class Below, std::floating_point S = typename Below::Scalar>
[[nodiscard]] inline S survival_into(const Below& below, S cosine) noexcept {
  return std::clamp(below.alpha() * k_pi<S> * below.pattern(cosine) / cosine, S(0), S(0.99));
}
template <class Below, std::floating_point S = typename Below::Scalar>
[[nodiscard]] inline S survival_out(const Below& below) noexcept {
  return std::min(below.alpha(), S(0.99));
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

namespace detail {
/// Share of the walks from `known` that go below.
template <class Scene, std::floating_point S = typename Scene::Scalar>
[[nodiscard]] S share_below(const BidirectionalVertex<Scene>& v, const Vec3<S>& known) noexcept {
  if (v.below.scattering == nullptr) return S(0);
  const S cosine = glm::dot(known, v.below.outward);
  if (!(cosine > S(0))) return S(0);
  return probability_below(*v.below.scattering, v.vertex.material, v.vertex.shading.frame().to_local(known), cosine);
}
/// How many of them get there.
template <class Scene, std::floating_point S = typename Scene::Scalar>
[[nodiscard]] S pdf_into(const BidirectionalVertex<Scene>& v, const Vec3<S>& known) noexcept {
  const S share = share_below(v, known);
  return share > S(0) ? share * survival_into(*v.below.scattering, glm::dot(known, v.below.outward)) : S(0);
}
/// Of walks that come out, towards `w`, sr^-1.
template <class Scene, std::floating_point S = typename Scene::Scalar>
[[nodiscard]] S pdf_out(const BidirectionalVertex<Scene>& v, const Vec3<S>& w) noexcept {
  const S cosine = std::max(S(0), glm::dot(w, v.below.outward));
  return survival_out(*v.below.scattering) * cosine * k_inv_pi<S>;
}
}  // namespace detail

/// Density with which the walk `walk` goes on from its vertex `v` along `w` (unit), roulette and the choice between an
/// object's surface and its inside included, sr^-1. Of inner vertices: probability of going through the object, whatever
/// `w`; times passage_pdf it is the density per area there.
template <class Scene, std::floating_point S = typename Scene::Scalar>
[[nodiscard]] S onward_pdf(const BidirectionalVertex<Scene>& v, const Vec3<S>& w, Walk walk) noexcept {
  if constexpr (Scene::k_has_subsurface) {
    if (v.vertex.is_inner()) return detail::pdf_into(v, v.vertex.w);
    if (v.vertex.is_outer()) return detail::pdf_out(v, w);
    return (S(1) - detail::share_below(v, v.vertex.w)) * walk_pdf(v.vertex, v.vertex.w, w, walk);
  }
  return walk_pdf(v.vertex, v.vertex.w, w, walk);
}

/// Density with which the other walk, `other`, that comes to `v` from `w` goes on to where this one came from, sr^-1; of
/// outer vertices, where that is through the object, m^-2. Of inner ones the other walk comes from inside, whatever `w`.
template <class Scene, std::floating_point S = typename Scene::Scalar>
[[nodiscard]] S return_pdf(const BidirectionalVertex<Scene>& v, const Vec3<S>& w, Walk other) noexcept {
  if constexpr (Scene::k_has_subsurface) {
    if (v.vertex.is_inner()) return detail::pdf_out(v, v.vertex.w);
    if (v.vertex.is_outer()) return detail::pdf_into(v, w) * v.below.passage_pdf;
    return (S(1) - detail::share_below(v, w)) * walk_pdf(v.vertex, w, v.vertex.w, other);
  }
  return walk_pdf(v.vertex, w, v.vertex.w, other);
}

}  // namespace manylight
