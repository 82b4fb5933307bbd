// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "manylight/core/error.hpp"
#include "manylight/core/sampler.hpp"
#include "manylight/geometry/concepts.hpp"
#include "manylight/geometry/offset.hpp"
#include "manylight/geometry/surface_point.hpp"
#include "manylight/scene/emitters.hpp"
#include "manylight/scene/interaction.hpp"
#include "manylight/scene/scene_media.hpp"
#include "manylight/scene/shader.hpp"

namespace manylight {

/// The composition: geometry backend, what surfaces are made of, and what emits. World frame, metres. A scene knows at
/// compile time which effects exist: with a Lambertian shader no gloss, opacity or absorption code is instantiated.
template <class G, class Shader, class Media = NoMedia, class Motion = Still>
class Scene {
  static_assert(Geometry<G>,
                "manylight::Scene: the first argument must model Geometry: Scalar, closest_hit, any_hit, all_hits, "
                "any_hit_batch, bounds, shapes");
  static_assert(SurfaceShader<Shader>,
                "manylight::Scene: the second argument must model SurfaceShader: Material (eval, sample, pdf, albedo, "
                "is_delta), material(), is_two_sided(), k_may_be_transparent, k_may_absorb");

 public:
  using Scalar = typename G::Scalar;
  using Material = typename Shader::Material;
  using GeometryType = G;
  using ShaderType = Shader;
  using Phase = typename Media::Phase;
  using MotionType = Motion;
  using Subsurface = typename detail::SubsurfaceOf<Shader>::Type;
  static constexpr bool k_has_media = Media::k_exist;
  static constexpr bool k_moves = Motion::k_moves;
  static constexpr bool k_has_subsurface = !std::is_same_v<Subsurface, NoSubsurface>;
  using ShadowRay = std::conditional_t<k_has_media, MediumRay<Scalar>, Ray<Scalar>>;
  /// Part of light that passes a segment: one number, or one per channel if there are media.
  using Passed = std::conditional_t<k_has_media, Rgb<Scalar>, Scalar>;

  /// `shader_of_shape[id]` indexes `shaders`. `world`: a box around all that light from infinity may reach, if it is more
  /// than the shapes': all instants of a motion need the same. Throws SceneError when the sizes or indices do not fit.
  Scene(G geometry, std::vector<Shader> shaders, std::vector<std::uint32_t> shader_of_shape,
        EmitterList<Scalar> emitters, Media media = {}, const std::optional<Box<Scalar>>& world = {});

  [[nodiscard]] const G& geometry() const noexcept { return geometry_; }
  [[nodiscard]] const Emitters<Scalar>& emitters() const noexcept { return emitters_; }
  [[nodiscard]] const Shader& shader(std::uint32_t shape) const noexcept { return shaders_[shader_of_shape_[shape]]; }
  [[nodiscard]] const Media& media() const noexcept { return media_; }
  /// Whether any surface lets light through an opacity mask: then shadow rays must look at what blocks them.
  [[nodiscard]] bool has_transparency() const noexcept { return has_transparency_; }

  /// First surface met by `ray`; a transparent one (opacity mask) is passed with probability 1 - opacity, decided by
  /// variates of `stream`.
  template <SampleStream Stream>
  [[nodiscard]] std::optional<SurfacePoint<Scalar>> intersect(Ray<Scalar> ray, Stream& stream, RayCounts& rays) const;

  /// Scattering at `point` for the known unit direction `w` (away from the surface), which lies in `medium`.
  [[nodiscard]] Interaction<Scalar, Material> interaction(const SurfacePoint<Scalar>& point, const Vec3<Scalar>& w,
                                                          MediumId medium = k_vacuum) const;

  /// The segment from one point to another, or along a unit direction towards infinity, as a shadow ray: ends set off
  /// from their surfaces.
  template <class End>
  [[nodiscard]] static ShadowRay shadow_ray(const Anchor<Scalar>& from, const End& to,
                                            [[maybe_unused]] std::uint64_t seed = 0) noexcept {
    const Ray<Scalar> ray = segment(from, to);
    if constexpr (k_has_media) {
      return {ray, glm::dot(ray.direction, from.ng) > Scalar(0) ? from.media.front : from.media.back, seed};
    } else {
      return ray;
    }
  }
  /// Part of light that passes `ray`: 0 or 1, or the product of (1 - opacity); in media times their transmittance, of
  /// which it is an unbiased estimate.
  [[nodiscard]] Passed visibility(const ShadowRay& ray, RayCounts& rays) const;
  /// The same for many at once, by the backend's batches. `passed` is as long as `segments`.
  void visibility(std::span<const ShadowRay> segments, std::span<Passed> passed, RayCounts& rays) const;

  /// The rest of `ray` behind `point`, with the same end.
  [[nodiscard]] static Ray<Scalar> beyond(const Ray<Scalar>& ray, const SurfacePoint<Scalar>& point) noexcept;

 private:
  [[nodiscard]] static Ray<Scalar> segment(const Anchor<Scalar>& from, const Anchor<Scalar>& to) noexcept {
    return segment_ray(from.position, from.error, from.ng, to.position, to.error, to.ng);
  }
  [[nodiscard]] static Ray<Scalar> segment(const Anchor<Scalar>& from, const Vec3<Scalar>& direction) noexcept {
    return {offset_origin(from.position, from.error, from.ng, direction), direction, Scalar(0), k_infinity<Scalar>};
  }
  [[nodiscard]] Scalar transparency_of_blocked(Ray<Scalar> ray) const;
  [[nodiscard]] Passed transmitted(const MediumRay<Scalar>& segment) const;

  G geometry_;
  std::vector<Shader> shaders_;
  std::vector<std::uint32_t> shader_of_shape_;
  Emitters<Scalar> emitters_;
  bool has_transparency_ = false;
  [[no_unique_address]] Media media_;
};

template <class G, class Shader, class Media, class Motion>
Scene<G, Shader, Media, Motion>::Scene(G geometry, std::vector<Shader> shaders,
                                       std::vector<std::uint32_t> shader_of_shape, EmitterList<Scalar> emitters,
                                       Media media, const std::optional<Box<Scalar>>& world)
    : geometry_(std::move(geometry)),
      shaders_(std::move(shaders)),
      shader_of_shape_(std::move(shader_of_shape)),
      emitters_(std::move(emitters), geometry_.shapes(), world.value_or(geometry_.bounds())),
      media_(std::move(media)) {
  const std::size_t shape_count = geometry_.shapes().size();
  if (shader_of_shape_.size() != shape_count) {
    throw SceneError("shader_of_shape has " + std::to_string(shader_of_shape_.size()) + " entries, allowed: one per shape, " +
                     std::to_string(shape_count));
  }
  for (std::size_t id = 0; id < shape_count; ++id) {
    if (shader_of_shape_[id] >= shaders_.size()) {
      throw SceneError("shader_of_shape[" + std::to_string(id) + "] is " + std::to_string(shader_of_shape_[id]) +
                       ", allowed: below the number of shaders, " + std::to_string(shaders_.size()));
    }
  }
  if constexpr (Shader::k_may_be_transparent) {
    for (const Shader& s : shaders_) has_transparency_ = has_transparency_ || s.is_transparent();
  }
}

template <class G, class Shader, class Media, class Motion>
template <SampleStream Stream>
std::optional<SurfacePoint<typename G::Scalar>> Scene<G, Shader, Media, Motion>::intersect(
    Ray<Scalar> ray, Stream& stream, RayCounts& rays) const {
  for (;;) {
    ++rays.closest;
    const std::optional<Hit<Scalar>> hit = geometry_.closest_hit(ray);
    if (!hit) return std::nullopt;
    const SurfacePoint<Scalar> point = surface_point(geometry_.shapes(), ray, *hit);
    if constexpr (Shader::k_may_be_transparent) {
      const Shader& surface = shader(point.shape);
      if (surface.is_transparent() && stream.next() >= surface.opacity(point)) {
        ray = beyond(ray, point);
        continue;
      }
    }
    return point;
  }
}

template <class G, class Shader, class Media, class Motion>
Interaction<typename G::Scalar, typename Shader::Material> Scene<G, Shader, Media, Motion>::interaction(
    const SurfacePoint<Scalar>& point, const Vec3<Scalar>& w, [[maybe_unused]] MediumId medium) const {
  const Shader& surface = shader(point.shape);
  const bool outside = glm::dot(point.ng, w) >= Scalar(0);
  const Scalar side = !outside && surface.is_two_sided() ? Scalar(-1) : Scalar(1);
  Vec3<Scalar> ns = point.ns;
  if constexpr (requires { surface.shading_normal(point); }) ns = surface.shading_normal(point);
  Interaction<Scalar, Material> hit{point, point.ng * side, Frame<Scalar>(ns * side, point.dpdu),
                                    surface.material(point, outside)};
  if constexpr (k_has_media) {
    hit.media = media_.sides(point, medium);
    if (side < Scalar(0)) std::swap(hit.media.front, hit.media.back);
  }
  return hit;
}

template <class G, class Shader, class Media, class Motion>
auto Scene<G, Shader, Media, Motion>::visibility(const ShadowRay& ray, RayCounts& rays) const -> Passed {
  ++rays.shadow;
  if constexpr (k_has_media) {
    return transmitted(ray);
  } else {
    return geometry_.any_hit(ray) ? transparency_of_blocked(ray) : Scalar(1);
  }
}

template <class G, class Shader, class Media, class Motion>
void Scene<G, Shader, Media, Motion>::visibility(std::span<const ShadowRay> segments, std::span<Passed> passed,
                                                 RayCounts& rays) const {
  MANYLIGHT_ASSERT(segments.size() == passed.size());
  rays.shadow += segments.size();
  if constexpr (k_has_media) {
    for (std::size_t i = 0; i < segments.size(); ++i) passed[i] = transmitted(segments[i]);
  } else {
    constexpr std::size_t k_chunk = 256;
    std::array<std::uint8_t, k_chunk> blocked;
    for (std::size_t begin = 0; begin < segments.size(); begin += k_chunk) {
      const std::size_t count = std::min(k_chunk, segments.size() - begin);
      geometry_.any_hit_batch(segments.subspan(begin, count), std::span(blocked.data(), count));
      for (std::size_t i = 0; i < count; ++i) {
        passed[begin + i] = blocked[i] != 0 ? transparency_of_blocked(segments[begin + i]) : Scalar(1);
      }
    }
  }
}

/// What passes a segment that meets some surface: the product of (1 - opacity) over all that it meets.
template <class G, class Shader, class Media, class Motion>
typename G::Scalar Scene<G, Shader, Media, Motion>::transparency_of_blocked([[maybe_unused]] Ray<Scalar> ray) const {
  if constexpr (!Shader::k_may_be_transparent) {
    return Scalar(0);
  } else {
    if (!has_transparency_) return Scalar(0);
    Scalar passed = Scalar(1);
    for (;;) {
      const std::optional<Hit<Scalar>> hit = geometry_.closest_hit(ray);
      if (!hit) return passed;
      const SurfacePoint<Scalar> point = surface_point(geometry_.shapes(), ray, *hit);
      const Shader& surface = shader(point.shape);
      passed *= surface.is_transparent() ? Scalar(1) - surface.opacity(point) : Scalar(0);
      if (passed <= Scalar(0)) return Scalar(0);
      ray = beyond(ray, point);
    }
  }
}

template <class G, class Shader, class Media, class Motion>
Ray<typename G::Scalar> Scene<G, Shader, Media, Motion>::beyond(const Ray<Scalar>& ray,
                                                                const SurfacePoint<Scalar>& point) noexcept {
  Ray<Scalar> rest = ray;
  rest.origin = offset_origin(point.position, point.error, point.ng, ray.direction);
  const Scalar travelled =
      glm::dot(rest.origin - ray.origin, ray.direction) / glm::dot(ray.direction, ray.direction);
  rest.t_max = ray.t_max - travelled;
  return rest;
}

/// What passes a segment through media and boundaries. First all surfaces, which may stop everything, then the media.
template <class G, class Shader, class Media, class Motion>
auto Scene<G, Shader, Media, Motion>::transmitted(const MediumRay<Scalar>& segment) const -> Passed {
  struct Piece {
    Ray<Scalar> ray;
    MediumId medium;
  };
  constexpr std::size_t k_pieces = 16;
  std::array<Piece, k_pieces> pieces;
  std::size_t count = 0;
  Rgb<Scalar> passed(1);
  IndependentStream<Scalar> stream = IndependentSampler<Scalar>{segment.seed}.stream(Stage::transmittance, 0);
  const auto through_pieces = [&] {
    for (std::size_t i = 0; i < count; ++i) {
      Ray<Scalar> ray = pieces[i].ray;
      const Scalar length = glm::length(ray.direction);
      ray.direction /= length;
      passed *= media_.medium(pieces[i].medium).transmittance(ray, ray.t_max * length, stream);
    }
    count = 0;
  };
  Piece piece{segment.ray, segment.medium};
  if (!has_transparency_) {
    if (geometry_.any_hit(piece.ray)) return Rgb<Scalar>(0);
    if (piece.medium != k_vacuum) pieces[count++] = piece;
    through_pieces();
    return passed;
  }
  for (;;) {
    const std::optional<Hit<Scalar>> hit = geometry_.closest_hit(piece.ray);
    if (piece.medium != k_vacuum) {
      if (count == k_pieces) through_pieces();
      pieces[count++] = piece;
      if (hit) pieces[count - 1].ray.t_max = hit->t;
    }
    if (!hit) break;
    const SurfacePoint<Scalar> point = surface_point(geometry_.shapes(), piece.ray, *hit);
    Scalar open = Scalar(0);
    if constexpr (Shader::k_may_be_transparent) {
      const Shader& surface = shader(point.shape);
      if (surface.is_transparent()) open = Scalar(1) - surface.opacity(point);
    }
    passed *= open;
    if (!(open > Scalar(0))) return Rgb<Scalar>(0);
    piece = {beyond(piece.ray, point), media_.behind(point, piece.ray.direction, piece.medium)};
  }
  through_pieces();
  return passed;
}

}  // namespace manylight
