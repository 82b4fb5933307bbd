// SPDX-License-Identifier: Apache-2.0
// <sensor> elements: camera, film and filter.
#include <cmath>

#include "scene_file/context.hpp"

namespace manylight::scene_file {

namespace {

void read_filter(Context& context, const Element& element) {
  Properties p(element, context.names);
  const std::string& type = element.get("type");
  if (type == "box") {
    if (p.positive("radius", 0.5) != 0.5) fail(element, "a box filter has radius 0.5; others are not supported");
    context.scene.filter = ReconstructionFilter<float>::box();
  } else if (type == "tent") {
    context.scene.filter = ReconstructionFilter<float>::tent(static_cast<float>(p.positive("radius", 1.0)));
  } else if (type == "gaussian") {
    context.scene.filter = ReconstructionFilter<float>::gaussian(static_cast<float>(p.positive("stddev", 0.5)));
  } else {
    fail(element, "unknown filter; supported are box, tent and gaussian");
  }
  p.finish();
}

std::uint32_t take_extent(Properties& p, const char* name, std::uint32_t otherwise) {
  const auto pixels = p.integer(name);
  if (!pixels) return otherwise;
  if (*pixels < 1 || *pixels > 32768) {
    fail(p.element(), std::string(name) + " is " + std::to_string(*pixels) + ", allowed: 1 to 32768 pixels");
  }
  return static_cast<std::uint32_t>(*pixels);
}

void read_film(Context& context, const Element& element) {
  Properties p(element, context.names);
  const std::string& type = element.get("type");
  if (type != "hdrfilm" && type != "ldrfilm" && type != "mfilm") {
    fail(element, "unknown film; supported are hdrfilm and ldrfilm");
  }
  CameraDescription& camera = context.scene.camera;
  camera.width = take_extent(p, "width", camera.width);
  camera.height = take_extent(p, "height", camera.height);
  for (const Properties::Item* filter : p.take_all("rfilter")) read_filter(context, *filter->element);
  p.ignore({"file_format", "pixel_format", "component_format", "gamma", "exposure", "banner", "high_quality_edges",
            "attach_log", "tonemap_method", "key", "burn", "sample_border"});
  p.finish();
}

FovAxis take_axis(Properties& p) {
  const std::string name = p.text("fov_axis").value_or("x");
  if (name == "x") return FovAxis::x;
  if (name == "y") return FovAxis::y;
  if (name == "diagonal") return FovAxis::diagonal;
  if (name == "smaller") return FovAxis::smaller;
  if (name == "larger") return FovAxis::larger;
  fail(p.element(), "unknown fov_axis '" + name + "'; supported are x, y, diagonal, smaller and larger");
}

/// "50mm" or "50": focal length on 36 x 24 mm film, whose diagonal the angle spans. [Mitsuba's default]
double take_focal_length(Properties& p) {
  std::string text = p.text("focal_length").value_or("50mm");
  if (text.size() > 2 && text.compare(text.size() - 2, 2, "mm") == 0) text.resize(text.size() - 2);
  const double length = parse_number(p.element(), text);
  if (!(length > 0)) fail(p.element(), "focal_length is '" + text + "', allowed: above 0 mm");
  return length;
}

void take_field_of_view(Properties& p, CameraDescription& camera) {
  const auto fov = p.number("fov");
  if (!fov) {
    camera.fov_axis = FovAxis::diagonal;
    camera.fov_degrees =
        static_cast<float>(std::atan(std::hypot(36.0, 24.0) / (2.0 * take_focal_length(p))) * 360.0 / k_pi<double>);
    p.ignore({"fov_axis"});
    return;
  }
  camera.fov_axis = take_axis(p);
  camera.fov_degrees = static_cast<float>(*fov);
  if (!(*fov > 0 && *fov < 180)) fail(p.element(), "fov is out of range, allowed: above 0, below 180 degrees");
}

}  // namespace

void read_sensor(Context& context, const Element& element) {
  const std::string& type = element.get("type");
  if (type != "perspective" && type != "thinlens")
    fail(element, "unknown sensor; supported are perspective and thinlens");
  Properties p(element, context.names);
  CameraDescription& camera = context.scene.camera;
  Keyframes motion = take_keyframes(p, "to_world");
  take_field_of_view(p, camera);
  const double focus = p.positive("focus_distance", 1.0);
  if (type == "thinlens") {
    camera.aperture_radius = static_cast<float>(p.positive("aperture_radius", 0.1));
    camera.focus_distance = static_cast<float>(focus);
  }
  for (const Properties::Item* film : p.take_all("film")) read_film(context, *film->element);
  const auto media = p.take_all("medium");
  if (media.size() > 1) fail(*media[1]->place, "is the second medium around the camera");
  if (!media.empty()) context.scene.outside = medium_id(context, *media.front()->element);
  p.ignore_tags({"sampler"});
  Shutter& shutter = context.scene.shutter;
  shutter.open = static_cast<float>(p.number("shutter_open", 0.0));
  shutter.close = static_cast<float>(p.number("shutter_close", shutter.open));
  if (shutter.close < shutter.open) fail(element, "shutter_close is before shutter_open");
  camera.to_world = motion.at(shutter.open);
  if (motion.moves()) camera.motion = std::move(motion);
  p.ignore({"near_clip", "far_clip"});
  p.finish();
}

float horizontal_fov_degrees(const CameraDescription& camera) {
  const double aspect = static_cast<double>(camera.width) / camera.height;
  const double half = std::tan(static_cast<double>(camera.fov_degrees) * k_pi<double> / 360.0);
  double half_x = half;
  switch (camera.fov_axis) {
    case FovAxis::x:
      break;
    case FovAxis::y:
      half_x = half * aspect;
      break;
    case FovAxis::diagonal:
      half_x = half * aspect / std::sqrt(1.0 + aspect * aspect);
      break;
    case FovAxis::smaller:
      half_x = aspect > 1.0 ? half * aspect : half;
      break;
    case FovAxis::larger:
      half_x = aspect > 1.0 ? half : half * aspect;
      break;
  }
  return static_cast<float>(std::atan(half_x) * 360.0 / k_pi<double>);
}

}  // namespace manylight::scene_file
