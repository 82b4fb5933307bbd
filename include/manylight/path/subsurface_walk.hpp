// SPDX-License-Identifier: Apache-2.0
#pragma once

// Walks below surfaces [Walter 2012, Eq. 21-26]. Where a walk enters or leaves an object it stands on an inner vertex, goes
// through the object by random lines and stands on an outer vertex, Lambertian to the outside:
//   A_inner = beta / |cos|,   s = sqrt(rho) |cos| Ft / pi,   A_outer = A_inner s tau / p,   S_outer = A_outer sqrt(rho)
// with beta the cosine-free throughput, the same in both directions of tracing. Both count as vertices.

#include <cmath>
#include <optional>

#include "manylight/core/warp.hpp"
#include "manylight/path/medium_walk.hpp"
#include "manylight/path/random_lines.hpp"
#include "manylight/path/vertex.hpp"

namespace manylight {

/// The object that `hit` is on, if it scatters below the surface and is met from outside.
template <class Scene>
[[nodiscard]] const typename Scene::Subsurface* subsurface_at(
    const Scene& scene, const Interaction<typename Scene::Scalar, typename Scene::Material>& hit,
    const Vec3<typename Scene::Scalar>& w) noexcept {
  const bool outside = glm::dot(w, hit.point.ng) > typename Scene::Scalar(0);
  return outside ? scene.shader(hit.point.shape).subsurface() : nullptr;
}

/// Lines that a walk draws: one point on average.
inline constexpr unsigned k_passage_lines = 2;

/// Expected number of places per area, m^-2, at the distance `d` (m) that a walk finds on its way through an object; both
/// ways alike.
template <class Below, std::floating_point S = typename Below::Scalar>
[[nodiscard]] S passage_pdf(const Below& below, S d) noexcept {
  return static_cast<S>(k_passage_lines) * below.falloff.line_pdf(d);
}

/// Share of walks from the direction `known` (local; `cosine` with the outward geometric normal, positive) that go below
/// rather than on by the surface's own material.
template <class Below, Material M, std::floating_point S = typename Below::Scalar>
[[nodiscard]] S probability_below(const Below& below, const M& material, const Vec3<S>& known, S cosine) noexcept {
  const S into = max_channel(below.rho) * (k_pi<S> * below.pattern(cosine) / cosine);
  const bool scatters = max_channel(material.albedo()) > S(0) || material.is_delta();
  const S on = scatters ? sampling_weight(material, known) : S(0);
  return into > S(0) ? into / (into + on) : S(0);
}

/// Where a walk comes out of an object: an outer vertex.
template <class Scene>
struct Surfacing {
  SurfacePoint<typename Scene::Scalar> point;
  const typename Scene::Subsurface* below;
  MediumId medium;  ///< outside
};

/// Where a walk goes into an object: an inner vertex, on the surface from the direction `w`.
template <class Scene>
class Submersion {
 public:
  using S = typename Scene::Scalar;
  using Hit = Interaction<S, typename Scene::Material>;

  Submersion(const Hit& hit, const typename Scene::Subsurface& below, const Vec3<S>& w) noexcept
      : hit_(hit), below_(below), w_(w), cosine_(glm::dot(w, hit.point.ng)), pattern_(below.pattern(cosine_)) {}

  /// sqrt(rho) Ft: alpha of the vertex over its cosine.
  [[nodiscard]] Rgb<S> albedo() const noexcept { return below_.sqrt_rho() * (k_pi<S> * pattern_ / cosine_); }
  /// M to the inside is 1 / pi; this is the vertex's own D to where the walk came from, sr^-1.
  [[nodiscard]] S own_pattern() const noexcept { return pattern_; }

  [[nodiscard]] VertexOf<Scene> vertex(const Rgb<S>& beta) const noexcept {
    VertexOf<Scene> v;
    v.kind = VertexKind::subsurface_inner;
    v.position = hit_.point.position;
    v.error = hit_.point.error;
    v.ng = hit_.point.ng;
    v.w = w_;
    v.alpha = S(1);
    v.strength = beta * albedo();
    v.below = &below_;
    v.object = hit_.point.shape;
    return v;
  }

  /// Share of walks that go below rather than on by the surface's own material.
  [[nodiscard]] S probability() const noexcept {
    return probability_below(below_, hit_.material, hit_.frame.to_local(w_), cosine_);
  }

  /// Goes through the object. Of several places one is drawn, times their number. None if there is none.
  struct Passage {
    Surfacing<Scene> out;
    Rgb<S> factor;  ///< A_outer / beta
    S transit;      ///< T^w = tau, its largest channel, m^-2
  };
  template <SampleStream Stream>
  [[nodiscard]] std::optional<Passage> pass(const Scene& scene, Stream& stream, RayCounts& rays) const {
    const SurfacePoint<S>& here = hit_.point;
    std::optional<SurfacePoint<S>> chosen;
    S chosen_pdf = S(0);
    unsigned found = 0;
    rays.closest += k_passage_lines;
    random_lines(scene.geometry(), here.shape, here.position, below_.falloff, k_passage_lines, stream,
                 [&](const SurfacePoint<S>& point, S pdf_area) {
                   ++found;
                   if (found > 1 && !(stream.next() * static_cast<S>(found) < S(1))) return;
                   chosen = point;
                   chosen_pdf = pdf_area;
                 });
    if (!chosen) return std::nullopt;
    const Rgb<S> transit = below_.transit(glm::length(chosen->position - here.position));
    const Rgb<S> factor = albedo() * transit * (k_inv_pi<S> * static_cast<S>(found) / chosen_pdf);
    if (!(max_channel(factor) > S(0)) || !is_finite(factor)) return std::nullopt;
    MediumId outside = k_vacuum;
    if constexpr (Scene::k_has_media) outside = hit_.media.front;
    return Passage{{*chosen, &below_, outside}, factor, max_channel(transit)};
  }

 private:
  const Hit& hit_;
  const typename Scene::Subsurface& below_;
  Vec3<S> w_;
  S cosine_;
  S pattern_;
};

}  // namespace manylight
