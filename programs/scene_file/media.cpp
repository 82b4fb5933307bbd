// SPDX-License-Identifier: Apache-2.0
// <medium> elements, and which medium is where.
#include <algorithm>
#include <limits>
#include <sstream>
#include <utility>

#include "manylight/media/homogeneous.hpp"
#include "manylight/scattering/isotropic_phase.hpp"
#include "scene_file/volumes.hpp"

namespace manylight::scene_file {

namespace {

/// A number inside of [lo, hi]. Throws SceneFileError.
float ranged(const Element& element, const std::string& name, double value, double lo, double hi) {
  if (value >= lo && value <= hi) return static_cast<float>(value);
  std::ostringstream reason;
  reason << name << " is " << value << ", allowed: " << lo << " to " << hi;
  fail(element, reason.str());
}

void take_phase(Context& context, Properties& medium, MediumDescription& d) {
  const auto phases = medium.take_all("phase");
  if (phases.size() > 1) fail(*phases[1]->place, "is the second phase function of this medium");
  if (phases.empty()) return;
  const Element& element = *phases.front()->element;
  const std::string& type = element.get("type");
  Properties p(element, context.names);
  if (type == "hg") {
    d.phase = PhaseKind::henyey_greenstein;
    d.g = ranged(element, "g", p.number("g", 0.8), -0.999, 0.999);
  } else if (type == "microflake") {
    d.phase = PhaseKind::gaussian_fiber;
    const auto deviation = p.number("stddev");
    if (!deviation) fail(element, "needs stddev");
    d.gamma = ranged(element, "stddev", *deviation, 0.01, 10.0);
  } else if (type != "isotropic") {
    fail(element, "unknown phase function; supported are isotropic, hg and microflake");
  }
  p.finish();
}

Rgb<float> checked_albedo(const Context& context, const Volume& volume) {
  const Rgb<float> albedo = constant_color(context, volume);
  if (max_channel(albedo) > 1.0F) {
    fail(*volume.value, "'" + volume.value->get("value") + "' is out of range, allowed: 0 to 1");
  }
  return albedo;
}

void set_coefficients(const Element& element, MediumDescription& d, const Rgb<float>& sigma_a,
                      const Rgb<float>& sigma_s, float scale) {
  d.sigma_a = sigma_a * scale;
  d.sigma_s = sigma_s * scale;
  try {
    static_cast<void>(Homogeneous<IsotropicPhase<float>>(d.sigma_a, d.sigma_s));
  } catch (const ParameterError& error) {
    fail(element, std::string(error.what()) + " (m^-1)");
  }
}

/// sigma_a and sigma_s, or sigma_t and albedo; the latter have defaults since version 2.
void parse_homogeneous(Context& context, Properties& p, MediumDescription& d) {
  const Element& element = p.element();
  if (p.take("material") != nullptr) fail(element, "materials by name are not supported");
  const auto sigma_a = take_volume(context, p, "sigma_a");
  const auto sigma_s = take_volume(context, p, "sigma_s");
  const auto sigma_t = take_volume(context, p, "sigma_t");
  const auto albedo = take_volume(context, p, "albedo");
  const auto scale = static_cast<float>(p.positive("scale", 1.0));
  const char* const wanted = "needs either sigma_a and sigma_s, or sigma_t and albedo";
  const auto color = [&](const std::optional<Volume>& v, float otherwise) {
    return v ? constant_color(context, *v) : Rgb<float>(otherwise);
  };
  if (sigma_a || sigma_s) {
    if (sigma_t || albedo) fail(element, wanted);
    set_coefficients(element, d, color(sigma_a, 0.0F), color(sigma_s, 0.0F), scale);
  } else {
    if (context.document.major_version < 2 && (!sigma_t || !albedo)) fail(element, wanted);
    const Rgb<float> extinction = color(sigma_t, 1.0F);
    const Rgb<float> scattered = albedo ? checked_albedo(context, *albedo) : Rgb<float>(0.75F);
    set_coefficients(element, d, extinction * (Rgb<float>(1) - scattered), extinction * scattered, scale);
  }
  if (d.phase == PhaseKind::gaussian_fiber) fail(element, "fibers need a heterogeneous medium with an orientation");
}

void parse_fibers(const std::optional<Volume>& axes, const Element& element, const Volume& density,
                  MediumDescription& d) {
  if (d.phase == PhaseKind::gaussian_fiber) {
    if (!axes) fail(element, "needs an orientation for its microflake phase function");
    d.axes = fiber_axes(*axes, density);
  } else if (axes) {
    fail(*axes->element, "an orientation needs a microflake phase function");
  }
}

void parse_heterogeneous(Context& context, Properties& p, MediumDescription& d) {
  const Element& element = p.element();
  auto density = take_volume(context, p, "density");
  auto sigma_t = take_volume(context, p, "sigma_t");  // the name since version 2
  if (density && sigma_t) fail(*sigma_t->element, "is given beside a density");
  if (!density) density = std::move(sigma_t);
  const auto albedo = take_volume(context, p, "albedo");
  const auto axes = take_volume(context, p, "orientation");
  d.scale = static_cast<float>(p.positive("scale", 1.0));
  if (!density) fail(element, "needs a density");
  if (!albedo && context.document.major_version < 2) fail(element, "needs an albedo");
  const bool has_albedo_grid = albedo && albedo->grid;
  if (!has_albedo_grid) d.albedo = albedo ? checked_albedo(context, *albedo) : Rgb<float>(0.75F);
  if (density->grid) {
    d.density = density_grid(*density);
    if (has_albedo_grid) d.albedo_grid = albedo_grid(*albedo);
    parse_fibers(axes, element, *density, d);
    return;
  }
  if (has_albedo_grid || axes || d.phase == PhaseKind::gaussian_fiber) {
    fail(*density->element, "one density for all places is supported only with one albedo and without fibers");
  }
  const Rgb<float> extinction = constant_color(context, *density);
  set_coefficients(element, d, extinction * (Rgb<float>(1) - d.albedo), extinction * d.albedo, d.scale);
  // Since version 2 a constant fills the unit cube under its transform here, and all space in homogeneous media.
  if (context.document.major_version >= 2) d.box = density->placement.to_world;
}

MediumDescription parse_medium(Context& context, const Element& element) {
  MediumDescription d;
  d.name = element.has("id") ? element.get("id") : element.describe();
  const std::string& type = element.get("type");
  Properties p(element, context.names);
  take_phase(context, p, d);
  if (type == "homogeneous") {
    parse_homogeneous(context, p, d);
  } else if (type == "heterogeneous") {
    parse_heterogeneous(context, p, d);
  } else {
    fail(element, "unknown medium; supported are homogeneous and heterogeneous");
  }
  p.ignore({"method", "strategy", "step_size", "majorant_resolution_factor", "sample_emitters", "use_emitter_sampling",
            "has_spectral_extinction"});
  p.finish();
  return d;
}

/// A dielectric that holds nothing but an absorber, in vacuum: the surface alone can carry that.
bool is_absorbing_dielectric(const SceneDescription& scene, const ShapeDescription& shape) {
  if (shape.media->front != k_vacuum || shape.media->back == k_vacuum) return false;
  const MediumDescription& medium = scene.media[std::size_t{shape.media->back} - 1];
  const MaterialKind kind = scene.materials[shape.material].kind;
  const bool is_dielectric = kind == MaterialKind::dielectric || kind == MaterialKind::thin_dielectric ||
                             kind == MaterialKind::rough_dielectric;
  return is_dielectric && !medium.density && !medium.box && is_black(medium.sigma_s);
}

/// A camera in the medium of a shape's inside stands in the shape, unless that medium is on both sides; then what is
/// outside of everything is not known to be other than vacuum.
void settle_outside(SceneDescription& scene) {
  const MediumId camera = scene.outside;
  for (const ShapeDescription& shape : scene.shape_infos) {
    if (shape.media && shape.media->back == camera && shape.media->front != camera) scene.outside = k_vacuum;
  }
}

bool is_somewhere(const SceneDescription& scene, MediumId medium) {
  return scene.outside == medium ||
         std::any_of(scene.shape_infos.begin(), scene.shape_infos.end(), [&](const ShapeDescription& shape) {
           return shape.media && (shape.media->front == medium || shape.media->back == medium);
         });
}

}  // namespace

MediumId medium_id(Context& context, const Element& element) {
  if (element.tag != "medium") fail(element, "wrong kind of element, expected <medium>");
  const auto found = context.medium_of.find(&element);
  if (found != context.medium_of.end()) return found->second;
  std::vector<MediumDescription>& media = context.scene.media;
  if (media.size() >= std::numeric_limits<MediumId>::max()) fail(element, "is one medium too many, allowed: 65535");
  media.push_back(parse_medium(context, element));
  return context.medium_of[&element] = static_cast<MediumId>(media.size());
}

void take_emitter_medium(Context& context, Properties& p) {
  for (const Properties::Item* item : p.take_all("medium")) {
    context.emitter_media.emplace_back(item->place, medium_id(context, *item->element));
  }
}

void settle_media(Context& context) {
  SceneDescription& scene = context.scene;
  settle_outside(scene);
  for (const auto& [place, medium] : context.emitter_media) {
    if (!is_somewhere(scene, medium)) fail(*place, "is a medium that fills nothing: no shape and no camera names it");
  }
  const auto needs_no_media = [&](const ShapeDescription& shape) {
    return !shape.media || is_absorbing_dielectric(scene, shape);
  };
  const bool is_free =
      scene.outside == k_vacuum && std::all_of(scene.shape_infos.begin(), scene.shape_infos.end(), needs_no_media);
  if (is_free) {
    for (ShapeDescription& shape : scene.shape_infos) {
      if (!shape.media) continue;
      shape.interior_absorption = scene.media[std::size_t{shape.media->back} - 1].sigma_a;
      shape.media.reset();
    }
    scene.media.clear();
  } else if (scene.outside != k_vacuum) {
    for (const std::string& name : context.without_exterior) {
      scene.warnings.push_back("vacuum lies outside of " + name +
                               ", which names no exterior, though the camera is in a medium");
    }
  }
}

}  // namespace manylight::scene_file
