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
#include "manylight/core/frame.hpp"
#include "manylight/core/sampler.hpp"
#include "manylight/geometry/concepts.hpp"
#include "manylight/geometry/offset.hpp"
#include "manylight/geometry/surface_point.hpp"
#include "manylight/scene/emitters.hpp"
#include "manylight/scene/shader.hpp"

namespace manylight {

/// Rays traced, by kind; summed over tiles in a fixed order.
struct RayCounts {
  std::uint64_t closest = 0;
  std::uint64_t shadow = 0;

  RayCounts& operator+=(const RayCounts& other) noexcept {
    closest += other.closest;
    shadow += other.shadow;
    return *this;
  }
};

/// A surface point with its scattering, turned to the side of the known direction `w` where the shader is two-sided.
template <std::floating_point S, class M>
struct Interaction {
  SurfacePoint<S> point;
  Vec3<S> ng;  ///< geometric normal, oriented
  Frame<S> frame;  ///< shading frame, oriented
  M material;
};

/// One end of a shadow ray: a point, the error bound of its coordinates (m) and its geometric normal.
template <std::floating_point S>
struct Anchor {
  Vec3<S> position;
  S error;
  Vec3<S> ng;
};

/// The composition: geometry backend, what surfaces are made of, and what emits. World frame, metres. A scene knows at
/// compile time which effects exist: with a Lambertian shader no gloss, opacity or absorption code is instantiated.
template <class G, class Shader>
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

  /// `shader_of_shape[id]` indexes `shaders`. Throws SceneError when the sizes or indices do not fit.
  Scene(G geometry, std::vector<Shader> shaders, std::vector<std::uint32_t> shader_of_shape,
        EmitterList<Scalar> emitters);

  [[nodiscard]] const G& geometry() const noexcept { return geometry_; }
  [[nodiscard]] const Emitters<Scalar>& emitters() const noexcept { return emitters_; }
  [[nodiscard]] const Shader& shader(std::uint32_t shape) const noexcept { return shaders_[shader_of_shape_[shape]]; }
  /// Whether any surface lets light through an opacity mask: then shadow rays must look at what blocks them.
  [[nodiscard]] bool has_transparency() const noexcept { return has_transparency_; }

  /// First surface met by `ray`; a transparent one (opacity mask) is passed with probability 1 - opacity, decided by
  /// variates of `stream`.
  template <SampleStream Stream>
  [[nodiscard]] std::optional<SurfacePoint<Scalar>> intersect(Ray<Scalar> ray, Stream& stream, RayCounts& rays) const;

  /// Scattering at `point` for the known unit direction `w` (away from the surface).
  [[nodiscard]] Interaction<Scalar, Material> interaction(const SurfacePoint<Scalar>& point,
                                                          const Vec3<Scalar>& w) const;

  /// Part of light that passes the segment between two points: 0 or 1, or the product of (1 - opacity).
  [[nodiscard]] Scalar visibility(const Anchor<Scalar>& from, const Anchor<Scalar>& to, RayCounts& rays) const;
  /// The same towards infinity along the unit `direction`.
  [[nodiscard]] Scalar visibility(const Anchor<Scalar>& from, const Vec3<Scalar>& direction, RayCounts& rays) const;
  /// The same for many segments at once, by the backend's batches. `passed` is as long as `segments`.
  void visibility(std::span<const Ray<Scalar>> segments, std::span<Scalar> passed, RayCounts& rays) const;

  /// The segment between two points, and from one towards infinity, as shadow rays: ends set off from their surfaces.
  [[nodiscard]] static Ray<Scalar> shadow_ray(const Anchor<Scalar>& from, const Anchor<Scalar>& to) noexcept {
    return segment_ray(from.position, from.error, from.ng, to.position, to.error, to.ng);
  }
  [[nodiscard]] static Ray<Scalar> shadow_ray(const Anchor<Scalar>& from, const Vec3<Scalar>& direction) noexcept {
    return {offset_origin(from.position, from.error, from.ng, direction), direction, Scalar(0), k_infinity<Scalar>};
  }

 private:
  [[nodiscard]] Scalar transparency_of_blocked(Ray<Scalar> ray) const;
  [[nodiscard]] Ray<Scalar> beyond(const Ray<Scalar>& ray, const SurfacePoint<Scalar>& point) const;

  G geometry_;
  std::vector<Shader> shaders_;
  std::vector<std::uint32_t> shader_of_shape_;
  Emitters<Scalar> emitters_;
  bool has_transparency_ = false;
};

template <class G, class Shader>
Scene<G, Shader>::Scene(G geometry, std::vector<Shader> shaders, std::vector<std::uint32_t> shader_of_shape,
                        EmitterList<Scalar> emitters)
    : geometry_(std::move(geometry)),
      shaders_(std::move(shaders)),
      shader_of_shape_(std::move(shader_of_shape)),
      emitters_(std::move(emitters), geometry_.shapes(), geometry_.bounds()) {
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

template <class G, class Shader>
template <SampleStream Stream>
std::optional<SurfacePoint<typename G::Scalar>> Scene<G, Shader>::intersect(Ray<Scalar> ray, Stream& stream,
                                                                             RayCounts& rays) const {
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

template <class G, class Shader>
Interaction<typename G::Scalar, typename Shader::Material> Scene<G, Shader>::interaction(
    const SurfacePoint<Scalar>& point, const Vec3<Scalar>& w) const {
  const Shader& surface = shader(point.shape);
  const bool outside = glm::dot(point.ng, w) >= Scalar(0);
  const Scalar side = !outside && surface.is_two_sided() ? Scalar(-1) : Scalar(1);
  Vec3<Scalar> ns = point.ns;
  if constexpr (requires { surface.shading_normal(point); }) ns = surface.shading_normal(point);
  return {point, point.ng * side, Frame<Scalar>(ns * side, point.dpdu), surface.material(point, outside)};
}

template <class G, class Shader>
typename G::Scalar Scene<G, Shader>::visibility(const Anchor<Scalar>& from, const Anchor<Scalar>& to,
                                                RayCounts& rays) const {
  ++rays.shadow;
  const Ray<Scalar> ray = shadow_ray(from, to);
  return geometry_.any_hit(ray) ? transparency_of_blocked(ray) : Scalar(1);
}

template <class G, class Shader>
typename G::Scalar Scene<G, Shader>::visibility(const Anchor<Scalar>& from, const Vec3<Scalar>& direction,
                                                RayCounts& rays) const {
  ++rays.shadow;
  const Ray<Scalar> ray = shadow_ray(from, direction);
  return geometry_.any_hit(ray) ? transparency_of_blocked(ray) : Scalar(1);
}

template <class G, class Shader>
void Scene<G, Shader>::visibility(std::span<const Ray<Scalar>> segments, std::span<Scalar> passed,
                                  RayCounts& rays) const {
  MANYLIGHT_ASSERT(segments.size() == passed.size());
  constexpr std::size_t k_chunk = 256;
  std::array<std::uint8_t, k_chunk> blocked;
  rays.shadow += segments.size();
  for (std::size_t begin = 0; begin < segments.size(); begin += k_chunk) {
    const std::size_t count = std::min(k_chunk, segments.size() - begin);
    geometry_.any_hit_batch(segments.subspan(begin, count), std::span(blocked.data(), count));
    for (std::size_t i = 0; i < count; ++i) {
      passed[begin + i] = blocked[i] != 0 ? transparency_of_blocked(segments[begin + i]) : Scalar(1);
    }
  }
}

/// What passes a segment that meets some surface: the product of (1 - opacity) over all that it meets.
template <class G, class Shader>
typename G::Scalar Scene<G, Shader>::transparency_of_blocked([[maybe_unused]] Ray<Scalar> ray) const {
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

/// The rest of `ray` behind `point`, with the same end.
template <class G, class Shader>
Ray<typename G::Scalar> Scene<G, Shader>::beyond(const Ray<Scalar>& ray, const SurfacePoint<Scalar>& point) const {
  Ray<Scalar> rest = ray;
  rest.origin = offset_origin(point.position, point.error, point.ng, ray.direction);
  const Scalar travelled =
      glm::dot(rest.origin - ray.origin, ray.direction) / glm::dot(ray.direction, ray.direction);
  rest.t_max = ray.t_max - travelled;
  return rest;
}

}  // namespace manylight
