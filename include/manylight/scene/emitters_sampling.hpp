// SPDX-License-Identifier: Apache-2.0
#pragma once

// Bodies of Emitters, one group per purpose. Include "manylight/scene/emitters.hpp".

#include "manylight/scene/emitters.hpp"

namespace manylight {

// ---- set-up ----

template <std::floating_point S>
void Emitters<S>::set_scene_sphere(const Box<S>& bounds) {
  if (bounds.is_empty()) return;
  center_ = bounds.center();
  const S radius = bounds.diagonal() / S(2);
  require(is_finite(center_) && std::isfinite(radius), "scene bounds", radius, "a finite box");
  // A single point has no radius; the margin covers the rounding of the corners.
  if (radius > S(0)) radius_ = radius * S(1.0001);
}

template <std::floating_point S>
void Emitters<S>::validate_points() {
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const std::string name = " of point light " + std::to_string(i);
    require(is_finite(points_[i].position), "position" + name, "not finite", "finite");
    const Rgb<S>& c = points_[i].intensity;
    require(is_valid_radiance(c), "intensity" + name, std::min(c.x, std::min(c.y, c.z)), "0 or positive, finite");
    PointEmitter<S>& light = points_[i];
    require(light.cutoff >= S(1e-4) && light.cutoff <= k_pi<S>, "cutoff" + name, light.cutoff, "1e-4 to pi");
    require(light.beam_width >= S(0) && light.beam_width <= light.cutoff, "beam width" + name, light.beam_width,
            "0 to the cutoff");
    const S length = glm::length(light.axis);
    require(length > S(0) && std::isfinite(length), "axis" + name, length, "a vector of positive finite length");
    light.axis /= length;
  }
}

template <std::floating_point S>
void Emitters<S>::validate_directionals() {
  for (std::size_t i = 0; i < directionals_.size(); ++i) {
    const std::string name = " of directional light " + std::to_string(i);
    const S length = glm::length(directionals_[i].direction);
    require(length > S(0) && std::isfinite(length), "direction" + name, length, "a vector of positive finite length");
    const Rgb<S>& c = directionals_[i].irradiance;
    require(is_valid_radiance(c), "irradiance" + name, std::min(c.x, std::min(c.y, c.z)), "0 or positive, finite");
    directionals_[i].direction /= length;
  }
}

template <std::floating_point S>
void Emitters<S>::build_table() {
  std::vector<double> weights;
  weights.reserve(count());
  Vec3<double> total(0);
  const auto add = [&](const Rgb<S>& flux) {
    weights.push_back(static_cast<double>(max_channel(flux)));
    total += Vec3<double>(flux);
  };
  for (std::uint32_t i = 0; i < shapes_.count(); ++i) add(shapes_.flux(i));
  for (const auto& point : points_) add(point.intensity * point.effective_solid_angle());
  const S cross_section = k_pi<S> * radius_ * radius_;
  for (const auto& directional : directionals_) add(directional.irradiance * cross_section);
  for (const auto& environment : environments_) add(environment.flux() * cross_section);
  table_ = AliasTable(weights);
  total_flux_ = Rgb<S>(total);
}

// ---- next event estimation ----

template <std::floating_point S>
std::optional<DirectSample<S>> Emitters<S>::direct_area(const Slot& slot, const Vec3<S>& reference,
                                                        const Vec2<S>& u) const noexcept {
  EmitterPoint<S> point{};
  Vec3<S> wi;
  S pdf;
  if (const auto cone = shapes_.cone(slot.index, reference)) {
    const auto direction = cone->sample(u);
    point = shapes_.point_on_sphere(slot.index, direction.normal);
    wi = direction.wi;
    pdf = cone->pdf();
  } else {
    point = shapes_.sample_area(slot.index, u);
    const Vec3<S> segment = point.position - reference;
    const S distance = glm::length(segment);
    if (!(distance > S(0))) return std::nullopt;
    wi = segment / distance;
    pdf = area_to_solid_angle(slot.index, segment, std::abs(glm::dot(point.ng, wi)));
  }
  if (!(pdf > S(0)) || !shapes_.emits_towards(shapes_.two_sided(slot.index), -glm::dot(point.ng, wi))) {
    return std::nullopt;
  }
  DirectSample<S> sample;
  sample.wi = wi;
  sample.distance = glm::length(point.position - reference);
  sample.radiance = shapes_.radiance(slot.index, point.uv);
  sample.pdf = slot.pmf * pdf;
  sample.kind = EmitterKind::area;
  sample.position = point.position;
  sample.error = point.error;
  sample.ng = point.ng;
  sample.shape = shapes_.shape_of(slot.index);
  sample.primitive = shapes_.index_in_shape(slot.index);
  return sample;
}

template <std::floating_point S>
std::optional<DirectSample<S>> Emitters<S>::direct_point(const Slot& slot, const Vec3<S>& reference) const noexcept {
  const PointEmitter<S>& light = points_[slot.index];
  const Vec3<S> segment = light.position - reference;
  const S distance = glm::length(segment);
  const Vec3<S> wi = segment / distance;
  const Rgb<S> irradiance = light.intensity_towards(-wi) / (distance * distance);
  if (!(distance > S(0)) || !is_finite(irradiance) || is_black(irradiance)) return std::nullopt;
  DirectSample<S> sample;
  sample.wi = wi;
  sample.distance = distance;
  sample.radiance = irradiance;
  sample.pdf = slot.pmf;
  sample.kind = EmitterKind::point;
  sample.is_delta = true;
  sample.position = light.position;
  return sample;
}

template <std::floating_point S>
std::optional<DirectSample<S>> Emitters<S>::direct_directional(const Slot& slot) const noexcept {
  const DirectionalEmitter<S>& light = directionals_[slot.index];
  DirectSample<S> sample;
  sample.wi = -light.direction;
  sample.distance = k_infinity<S>;
  sample.radiance = light.irradiance;
  sample.pdf = slot.pmf;
  sample.kind = EmitterKind::directional;
  sample.is_delta = true;
  sample.infinite = true;
  return sample;
}

/// Whichever environment drew the direction, the radiance and the density are those of all of them together: the same
/// pair that a ray which escapes the scene sees.
template <std::floating_point S>
std::optional<DirectSample<S>> Emitters<S>::direct_environment(const Slot& slot, const Vec2<S>& u) const noexcept {
  DirectSample<S> sample;
  sample.wi = environments_[slot.index].sample(u);
  const EnvironmentLight<S> light = environment_light(sample.wi);
  sample.pdf = light.pdf;
  // Rounding may carry a direction over the border into a black cell.
  if (!(sample.pdf > S(0))) return std::nullopt;
  sample.distance = k_infinity<S>;
  sample.radiance = light.radiance;
  sample.kind = EmitterKind::environment;
  sample.infinite = true;
  return sample;
}

// ---- light subpaths ----

template <std::floating_point S>
Vec3<S> Emitters<S>::entry_point(const Vec3<S>& wo, const Vec2<S>& u) const noexcept {
  const Vec2<S> disk = warp::square_to_disk(u) * radius_;
  const Frame<S> frame(-wo);
  return center_ + frame.s * disk.x + frame.t * disk.y - wo * radius_;
}

template <std::floating_point S>
EmissionSample<S> Emitters<S>::emission_area(const Slot& slot, const Vec2<S>& u_position,
                                             Vec2<S> u_direction) const noexcept {
  const EmitterPoint<S> point = shapes_.sample_area(slot.index, u_position);
  const bool two_sided = shapes_.two_sided(slot.index);
  const bool inner = two_sided && u_direction.x >= S(0.5);
  if (two_sided) u_direction.x = u_direction.x * S(2) - (inner ? S(1) : S(0));
  const Vec3<S> local = warp::square_to_cosine_hemisphere(u_direction);
  const S sides = two_sided ? S(2) : S(1);
  EmissionSample<S> sample;
  sample.kind = EmitterKind::area;
  sample.position = point.position;
  sample.error = point.error;
  sample.ng = point.ng;
  sample.wo = Frame<S>(inner ? -point.ng : point.ng).to_world(local);
  sample.radiance = shapes_.radiance(slot.index, point.uv);
  sample.pdf_position = slot.pmf / shapes_.area(slot.index);
  sample.pdf_direction = warp::cosine_hemisphere_pdf(local) / sides;
  sample.intensity = sample.radiance * (k_pi<S> / sample.pdf_position);
  sample.beta = sample.intensity * sides;  // |wo . ng| / p(wo) = pi * sides
  sample.uv = point.uv;
  sample.shape = shapes_.shape_of(slot.index);
  sample.primitive = shapes_.index_in_shape(slot.index);
  sample.two_sided = two_sided;
  return sample;
}

template <std::floating_point S>
EmissionSample<S> Emitters<S>::emission_point(const Slot& slot, const Vec2<S>& u_direction) const noexcept {
  const PointEmitter<S>& light = points_[slot.index];
  EmissionSample<S> sample;
  sample.kind = EmitterKind::point;
  sample.position = light.position;
  if (light.is_spot()) {
    // 1 - cos(cutoff) = 2 sin^2(cutoff / 2): narrow cones keep their width.
    const S rise = S(2) * sqr(std::sin(light.cutoff / S(2)));
    const S height = u_direction.x * rise;  // 1 - cos
    const S radius = safe_sqrt(height * (S(2) - height));
    const S phi = S(2) * k_pi<S> * u_direction.y;
    sample.wo = glm::normalize(
        Frame<S>(light.axis).to_world({radius * std::cos(phi), radius * std::sin(phi), S(1) - height}));
  } else {
    sample.wo = warp::square_to_sphere(u_direction);
  }
  sample.pdf_direction = light.pdf_direction();
  sample.radiance = light.intensity_towards(sample.wo);
  sample.pdf_position = slot.pmf;
  sample.intensity = light.intensity * (S(4) * k_pi<S> / slot.pmf);
  sample.beta = sample.radiance / (slot.pmf * sample.pdf_direction);
  return sample;
}

template <std::floating_point S>
EmissionSample<S> Emitters<S>::emission_directional(const Slot& slot, const Vec2<S>& u_position) const noexcept {
  const DirectionalEmitter<S>& light = directionals_[slot.index];
  EmissionSample<S> sample;
  sample.kind = EmitterKind::directional;
  sample.position = entry_point(light.direction, u_position);
  sample.wo = light.direction;
  sample.radiance = light.irradiance;
  sample.pdf_position = entry_pdf();
  sample.pdf_direction = slot.pmf;
  sample.intensity = light.irradiance / (sample.pdf_position * slot.pmf);
  sample.beta = sample.intensity;
  return sample;
}

template <std::floating_point S>
std::optional<EmissionSample<S>> Emitters<S>::emission_environment(const Slot& slot, const Vec2<S>& u_position,
                                                                   const Vec2<S>& u_direction) const noexcept {
  const Vec3<S> to_light = environments_[slot.index].sample(u_direction);
  EmissionSample<S> sample;
  sample.kind = EmitterKind::environment;
  sample.wo = -to_light;
  const EnvironmentLight<S> light = environment_light(to_light);
  sample.pdf_direction = light.pdf;
  if (!(sample.pdf_direction > S(0))) return std::nullopt;
  sample.position = entry_point(sample.wo, u_position);
  sample.radiance = light.radiance;
  sample.pdf_position = entry_pdf();
  sample.intensity = sample.radiance / (sample.pdf_position * sample.pdf_direction);
  sample.beta = sample.intensity;
  return sample;
}

}  // namespace manylight
