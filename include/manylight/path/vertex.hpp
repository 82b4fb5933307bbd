// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <type_traits>

#include "manylight/core/frame.hpp"
#include "manylight/core/spectrum.hpp"
#include "manylight/scattering/concepts.hpp"
#include "manylight/scene/scene.hpp"

namespace manylight {

namespace detail {
/// The shading frame that a vertex stores; of an isotropic material the normal alone, from which any frame is as good.
template <std::floating_point S, bool Isotropic>
class ShadingFrame {
 public:
  ShadingFrame() = default;
  explicit ShadingFrame(const Frame<S>& frame) noexcept : n_(frame.n), s_(frame.s) {}
  [[nodiscard]] Frame<S> frame() const noexcept {
    Frame<S> f;
    f.n = n_;
    f.s = s_;
    f.t = glm::cross(n_, s_);
    return f;
  }
  [[nodiscard]] const Vec3<S>& normal() const noexcept { return n_; }

 private:
  Vec3<S> n_{0, 0, 1};
  Vec3<S> s_{1, 0, 0};
};

template <std::floating_point S>
class ShadingFrame<S, true> {
 public:
  ShadingFrame() = default;
  explicit ShadingFrame(const Frame<S>& frame) noexcept : n_(frame.n) {}
  [[nodiscard]] Frame<S> frame() const noexcept { return Frame<S>(n_); }
  [[nodiscard]] const Vec3<S>& normal() const noexcept { return n_; }

 private:
  Vec3<S> n_{0, 0, 1};
};
}  // namespace detail

namespace detail {
/// What only vertices of scenes with media carry.
template <class Phase>
struct VertexMedium {
  Phase phase{};       ///< of a vertex in a medium
  MediaSides media{};  ///< around it; front on the side of the vertex's `ng`
};
template <>
struct VertexMedium<NoPhase> {};
/// What only vertices of scenes with subsurface scattering carry.
template <class Subsurface>
struct VertexSubsurface {
  const Subsurface* below = nullptr;
  std::uint32_t object = 0;  ///< the shape
};
template <>
struct VertexSubsurface<NoSubsurface> {};
/// What only vertices of scenes in motion carry.
template <class Motion>
struct VertexInstant {
  std::uint16_t instant = 0;
};
template <>
struct VertexInstant<Still> {};
}  // namespace detail

/// What a vertex scatters or emits like.
enum class VertexKind : std::uint8_t {
  surface,         ///< a Material
  medium,          ///< a PhaseFunction
  subsurface_outer,  ///< where light enters or leaves an object: Lambertian on the side of `ng`, connected to all others
  subsurface_inner,  ///< the same place seen from inside: connected through the object to its inner vertices alone
  area_emitter,    ///< Lambertian emission on the side of ng
  two_sided_area_emitter,  ///< Lambertian emission on both sides
  point_emitter,   ///< isotropic emission
  spot_emitter,    ///< within a cone around `ng`: `w` holds its beam width and cutoff (rad), see `spot_falloff`
  infinite_emitter ///< environment or directional: `position` is the unit direction towards the light
};

/// The one vertex of the toolkit: at the end of an eye subpath a virtual point sensor (VPS), at the end of a light
/// subpath a virtual point light (VPL). All directions are unit, world frame, and point away from the vertex.
template <std::floating_point S, Material M, class Phase = NoPhase, class Subsurface = NoSubsurface, class Motion = Still>
struct Vertex : detail::VertexMedium<Phase>, detail::VertexSubsurface<Subsurface>, detail::VertexInstant<Motion> {
  using Scalar = S;
  static constexpr bool k_may_be_in_medium = !std::is_same_v<Phase, NoPhase>;
  static constexpr bool k_may_be_subsurface = !std::is_same_v<Subsurface, NoSubsurface>;
  static constexpr bool k_moves = Motion::k_moves;
  static constexpr bool k_has_channels = k_may_be_subsurface || k_moves;
  Vec3<S> position{0};
  S error = S(0);         ///< bound of the absolute error of `position`, m
  Vec3<S> ng{0, 0, 1};    ///< geometric normal, on the side of `w` for two-sided surfaces
  Vec3<S> w{0, 0, 1};     ///< known direction: `wo` (to the previous eye vertex) of a VPS, `wi` of a VPL on a surface
  detail::ShadingFrame<S, k_is_isotropic<M>> shading;
  M material{};
  S alpha = S(0);         ///< normaliser of the pattern: largest channel of the material's albedo; else 1
  Rgb<S> strength{0};     ///< S of a VPS (1: radiance per radiance), I of a VPL (W)
  std::uint16_t edges = 0;  ///< segments between this vertex and the camera (VPS) or the emitter (VPL)
  VertexKind kind = VertexKind::surface;
  bool exact = false;  ///< emission without noise that no other technique can reach (point, directional): not clamped

  [[nodiscard]] bool is_infinite() const noexcept { return kind == VertexKind::infinite_emitter; }
  [[nodiscard]] bool is_in_medium() const noexcept { return k_may_be_in_medium && kind == VertexKind::medium; }
  [[nodiscard]] bool is_outer() const noexcept { return k_may_be_subsurface && kind == VertexKind::subsurface_outer; }
  [[nodiscard]] bool is_inner() const noexcept { return k_may_be_subsurface && kind == VertexKind::subsurface_inner; }
  /// The normal that the pattern's cosine is taken with.
  [[nodiscard]] const Vec3<S>& pattern_normal() const noexcept { return is_outer() ? ng : shading.normal(); }
  /// Only vertices of the same channel are connected: those of one instant, and of them the inner ones of one object.
  [[nodiscard]] std::uint64_t channel() const noexcept {
    std::uint64_t channel = 0;
    if constexpr (k_moves) channel = std::uint64_t{this->instant} << 33;
    if constexpr (k_may_be_subsurface) {
      if (is_inner()) channel += std::uint64_t{this->object} + 1;
    }
    return channel;
  }
  [[nodiscard]] Anchor<S> anchor() const noexcept {
    Anchor<S> a{position, error, ng};
    if constexpr (k_may_be_in_medium) a.media = this->media;
    return a;
  }
};

template <class V>
inline constexpr bool k_is_vertex = false;
template <std::floating_point S, Material M, class... Effects>
inline constexpr bool k_is_vertex<Vertex<S, M, Effects...>> = true;
template <class V>
concept AnyVertex = k_is_vertex<V>;

template <class Scene>
using VertexOf = Vertex<typename Scene::Scalar, typename Scene::Material, typename Scene::Phase,
                       typename Scene::Subsurface, typename Scene::MotionType>;

/// A surface vertex at `hit` with the known direction `w`; strength and edges are left to the caller.
template <AnyVertex V, std::floating_point S, Material M>
[[nodiscard]] V surface_vertex(const Interaction<S, M>& hit, const Vec3<S>& w) noexcept {
  V v;
  v.position = hit.point.position;
  v.error = hit.point.error;
  v.ng = hit.ng;
  v.w = w;
  v.shading = detail::ShadingFrame<S, k_is_isotropic<M>>(hit.frame);
  v.material = hit.material;
  v.alpha = max_channel(hit.material.albedo());
  if constexpr (V::k_may_be_in_medium) v.media = hit.media;
  return v;
}

}  // namespace manylight
