// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "manylight/core/alias_table.hpp"
#include "manylight/core/box.hpp"
#include "manylight/scene/emissive_shapes.hpp"
#include "manylight/scene/emitter_samples.hpp"
#include "manylight/scene/environment.hpp"

namespace manylight {

/// All light sources of a scene, ready for sampling. Self-contained: keeps no reference to the shapes. Immutable,
/// callable from several threads; no member throws but the constructor.
///
/// One alias table over all emissive primitives (triangles, spheres, disks, points, directionals, environments) selects
/// by flux, O(1) and independent of the point to be lit. That is right for light subpaths; for next event estimation it
/// is a baseline that starves a weak light nearby in favour of a strong one far away.
template <std::floating_point S>
class Emitters {
 public:
  using Scalar = S;
  Emitters() = default;

  /// `scene_bounds`: box of everything that can receive light; light from infinity enters through its bounding sphere.
  /// Throws ParameterError naming the emitter and the value for anything negative, not finite or missing.
  Emitters(const EmitterList<S>& list, const Shapes<S>& shapes, const Box<S>& scene_bounds)
      : shapes_(list.areas, shapes), points_(list.points), directionals_(list.directionals) {
    for (const auto& environment : list.environments) environments_.emplace_back(environment);
    set_scene_sphere(scene_bounds);
    validate_points();
    validate_directionals();
    build_table();
  }

  // ---- what is emitted ----

  [[nodiscard]] bool is_emitter(std::uint32_t shape) const noexcept { return shapes_.is_emitter(shape); }
  /// Radiance leaving a surface point towards the unit vector `wo`, W m^-2 sr^-1; black for shapes that do not emit and
  /// on the inner side of one-sided emitters.
  [[nodiscard]] Rgb<S> emitted(const SurfacePoint<S>& p, const Vec3<S>& wo) const noexcept {
    return shapes_.emitted(p, wo);
  }
  /// What arrives from the unit direction `w` (towards the light) where no surface is hit, the sum of all environments,
  /// and the density with which `sample_direct` draws that direction. Directional lights are not in it.
  [[nodiscard]] EnvironmentLight<S> environment_light(const Vec3<S>& w) const noexcept {
    EnvironmentLight<S> sum;
    for (std::uint32_t i = 0; i < environments_.size(); ++i) {
      const EnvironmentLight<S> light = environments_[i].light(w);
      sum.radiance += light.radiance;
      if (!empty()) sum.pdf += static_cast<S>(table_.pmf(first_environment() + i)) * light.pdf;
    }
    return sum;
  }
  /// Its radiance alone, W m^-2 sr^-1.
  [[nodiscard]] Rgb<S> environment(const Vec3<S>& w) const noexcept { return environment_light(w).radiance; }

  // ---- next event estimation ----

  /// Draws a light for the point `reference`. None if the draw faces away or nothing emits: it contributes 0 then.
  [[nodiscard]] std::optional<DirectSample<S>> sample_direct(const Vec3<S>& reference, S u_select,
                                                             const Vec2<S>& u) const noexcept {
    if (empty()) return std::nullopt;
    const std::uint32_t emitter = table_.sample(widen_variate(u_select, u.x));
    auto sample = direct(locate(emitter), reference, u);
    if (sample) sample->emitter = emitter;
    return sample;
  }
  /// Density with which `sample_direct` draws the point `light` of an emissive shape, seen along the unit vector `wi`,
  /// at `reference`: per solid angle, selection included, sr^-1.
  [[nodiscard]] S pdf_direct(const Vec3<S>& reference, const SurfacePoint<S>& light, const Vec3<S>& wi) const noexcept {
    if (empty() || !is_emitter(light.shape)) return S(0);
    const std::uint32_t primitive = shapes_.primitive_of(light);
    const S pmf = static_cast<S>(table_.pmf(primitive));
    if (const auto cone = shapes_.cone(primitive, reference)) return pmf * cone->pdf();
    return pmf * area_to_solid_angle(primitive, light.position - reference, std::abs(glm::dot(light.ng, wi)));
  }
  /// The same for light that arrives from the unit direction `wi` at infinity, sr^-1.
  [[nodiscard]] S pdf_direct_environment(const Vec3<S>& wi) const noexcept { return environment_light(wi).pdf; }

  // ---- light subpaths ----

  /// Starts a light subpath; none if nothing emits. The three variates may be stratified independently.
  [[nodiscard]] std::optional<EmissionSample<S>> sample_emission(S u_select, const Vec2<S>& u_position,
                                                                 const Vec2<S>& u_direction) const noexcept {
    if (empty()) return std::nullopt;
    const Slot slot = locate(table_.sample(widen_variate(u_select, u_position.x)));
    switch (slot.kind) {
      case EmitterKind::area:
        return emission_area(slot, u_position, u_direction);
      case EmitterKind::point:
        return emission_point(slot, u_direction);
      case EmitterKind::directional:
        return emission_directional(slot, u_position);
      case EmitterKind::environment:
        break;
    }
    return emission_environment(slot, u_position, u_direction);
  }

  /// EmissionSample::projected_pdf of a light subpath that starts at that point of an emissive shape.
  [[nodiscard]] S projected_pdf_emission(const SurfacePoint<S>& light) const noexcept {
    if (empty() || !is_emitter(light.shape)) return S(0);
    return projected_pdf_area(shapes_.primitive_of(light));
  }
  /// The same of one that comes from the unit direction `wi` at infinity.
  [[nodiscard]] S projected_pdf_emission_environment(const Vec3<S>& wi) const noexcept {
    return pdf_direct_environment(wi) * entry_pdf();
  }
  /// The same of one that starts where `light` was drawn.
  [[nodiscard]] S projected_pdf_emission(const DirectSample<S>& light) const noexcept {
    switch (light.kind) {
      case EmitterKind::area:
        return projected_pdf_area(light.emitter);
      case EmitterKind::point:
        return light.pdf * points_[light.emitter - shapes_.count()].pdf_direction();
      case EmitterKind::directional:
      case EmitterKind::environment:
        break;
    }
    return light.pdf * entry_pdf();
  }

  // ---- facts ----

  [[nodiscard]] const std::vector<PointEmitter<S>>& points() const noexcept { return points_; }
  [[nodiscard]] const std::vector<DirectionalEmitter<S>>& directionals() const noexcept { return directionals_; }

  /// True if no light can be sampled: there are no emitters, or all are black.
  [[nodiscard]] bool empty() const noexcept { return table_.empty(); }
  /// Emissive primitives: triangles, spheres, disks, points, directionals, environments.
  [[nodiscard]] std::uint32_t count() const noexcept {
    return first_environment() + static_cast<std::uint32_t>(environments_.size());
  }
  /// Flux that all emitters together send out, W; of light from infinity what enters the scene's bounding sphere:
  /// pi R^2 times the integral of radiance, or the irradiance. Estimated for textured emitters (EmissiveShapes::flux).
  [[nodiscard]] const Rgb<S>& total_flux() const noexcept { return total_flux_; }
  /// Bounding sphere of the scene, m; the radius is always positive.
  [[nodiscard]] S scene_radius() const noexcept { return radius_; }
  [[nodiscard]] const Vec3<S>& scene_center() const noexcept { return center_; }
  /// Memory per emissive primitive, all tables included except environment images, bytes.
  [[nodiscard]] double bytes_per_primitive() const noexcept {
    const std::size_t points = points_.capacity() * sizeof(PointEmitter<S>);
    const std::size_t directionals = directionals_.capacity() * sizeof(DirectionalEmitter<S>);
    const std::size_t all = shapes_.bytes() + points + directionals + table_.bytes();
    return count() == 0 ? 0.0 : static_cast<double>(all) / count();
  }
  /// Probability with which both kinds of sampling select a primitive, 0 <= i < count().
  [[nodiscard]] S selection_probability(std::uint32_t i) const noexcept {
    return empty() ? S(0) : static_cast<S>(table_.pmf(i));
  }

 private:
  /// A row of the table: `index` counts within the kind.
  struct Slot {
    EmitterKind kind;
    std::uint32_t index;
    S pmf;
  };

  [[nodiscard]] std::uint32_t first_directional() const noexcept {
    return shapes_.count() + static_cast<std::uint32_t>(points_.size());
  }
  [[nodiscard]] std::uint32_t first_environment() const noexcept {
    return first_directional() + static_cast<std::uint32_t>(directionals_.size());
  }
  [[nodiscard]] Slot locate(std::uint32_t i) const noexcept {
    const S pmf = static_cast<S>(table_.pmf(i));
    if (i < shapes_.count()) return {EmitterKind::area, i, pmf};
    if (i < first_directional()) return {EmitterKind::point, i - shapes_.count(), pmf};
    if (i < first_environment()) return {EmitterKind::directional, i - first_directional(), pmf};
    return {EmitterKind::environment, i - first_environment(), pmf};
  }

  void set_scene_sphere(const Box<S>& bounds);
  void validate_points();
  void validate_directionals();
  void build_table();

  /// 1 / area as a density per solid angle: d^2 / (A cos); 0 where it would overflow.
  [[nodiscard]] S area_to_solid_angle(std::uint32_t primitive, const Vec3<S>& segment, S cosine) const noexcept {
    const S pdf = glm::dot(segment, segment) / (cosine * shapes_.area(primitive));
    return std::isfinite(pdf) ? pdf : S(0);
  }

  [[nodiscard]] std::optional<DirectSample<S>> direct(const Slot& slot, const Vec3<S>& reference,
                                                      const Vec2<S>& u) const noexcept {
    switch (slot.kind) {
      case EmitterKind::area:
        return direct_area(slot, reference, u);
      case EmitterKind::point:
        return direct_point(slot, reference);
      case EmitterKind::directional:
        return direct_directional(slot);
      case EmitterKind::environment:
        break;
    }
    return direct_environment(slot, u);
  }
  [[nodiscard]] S projected_pdf_area(std::uint32_t primitive) const noexcept {
    const S sides = shapes_.two_sided(primitive) ? S(2) : S(1);
    return static_cast<S>(table_.pmf(primitive)) * k_inv_pi<S> / (shapes_.area(primitive) * sides);
  }
  /// Of the points where light from infinity enters, m^-2.
  [[nodiscard]] S entry_pdf() const noexcept { return k_inv_pi<S> / (radius_ * radius_); }

  [[nodiscard]] std::optional<DirectSample<S>> direct_area(const Slot& slot, const Vec3<S>& reference,
                                                           const Vec2<S>& u) const noexcept;
  [[nodiscard]] std::optional<DirectSample<S>> direct_point(const Slot& slot, const Vec3<S>& reference) const noexcept;
  [[nodiscard]] std::optional<DirectSample<S>> direct_directional(const Slot& slot) const noexcept;
  [[nodiscard]] std::optional<DirectSample<S>> direct_environment(const Slot& slot, const Vec2<S>& u) const noexcept;
  [[nodiscard]] EmissionSample<S> emission_area(const Slot& slot, const Vec2<S>& u_position,
                                                Vec2<S> u_direction) const noexcept;
  [[nodiscard]] EmissionSample<S> emission_point(const Slot& slot, const Vec2<S>& u_direction) const noexcept;
  [[nodiscard]] EmissionSample<S> emission_directional(const Slot& slot, const Vec2<S>& u_position) const noexcept;
  [[nodiscard]] std::optional<EmissionSample<S>> emission_environment(const Slot& slot, const Vec2<S>& u_position,
                                                                      const Vec2<S>& u_direction) const noexcept;
  /// Start of a ray travelling along `wo` into the scene: uniform on the disk of the bounding sphere's radius.
  [[nodiscard]] Vec3<S> entry_point(const Vec3<S>& wo, const Vec2<S>& u) const noexcept;

  EmissiveShapes<S> shapes_;
  std::vector<PointEmitter<S>> points_;
  std::vector<DirectionalEmitter<S>> directionals_;
  std::vector<Environment<S>> environments_;
  AliasTable table_;
  Rgb<S> total_flux_{0};
  Vec3<S> center_{0};
  S radius_ = S(1);
};

}  // namespace manylight

#include "manylight/scene/emitters_sampling.hpp"
