// SPDX-License-Identifier: Apache-2.0
// Top-level <emitter> elements.
#include "image_io/image_io.hpp"
#include "scene_file/context.hpp"

namespace manylight::scene_file {

namespace {

Vec3<float> along_z(const glm::mat4& to_world) { return glm::mat3(to_world) * Vec3<float>(0, 0, 1); }

void add_point(Context& context, Properties& p) {
  const auto position = p.vector("position");
  const glm::mat4 to_world = take_transform(p, "to_world");
  const Rgb<float> intensity = take_color(context, p, "intensity", SpectrumRole::emission, Rgb<float>(1));
  context.scene.emitters.points.push_back({position.value_or(Vec3<float>(to_world[3])), intensity});
}

void add_spot(Context& context, Properties& p) {
  const glm::mat4 to_world = take_transform(p, "to_world");
  PointEmitter<float> light;
  light.position = Vec3<float>(to_world[3]);
  light.axis = along_z(to_world);
  light.intensity = take_color(context, p, "intensity", SpectrumRole::emission, Rgb<float>(1));
  const double cutoff = p.number("cutoff_angle", 20.0);
  const double beam_width = p.number("beam_width", 0.75 * cutoff);
  if (!(cutoff > 0 && cutoff < 180))
    fail(p.element(), "cutoff_angle is out of range, allowed: above 0 to below 180 degrees");
  if (!(beam_width >= 0 && beam_width <= cutoff)) {
    fail(p.element(), "beam_width is out of range, allowed: 0 to the cutoff_angle");
  }
  light.cutoff = static_cast<float>(cutoff * k_pi<double> / 180);
  light.beam_width = std::min(static_cast<float>(beam_width * k_pi<double> / 180), light.cutoff);
  if (p.take("texture") != nullptr) fail(p.element(), "a texture on a spot light is not supported");
  context.scene.emitters.points.push_back(light);
}

void add_directional(Context& context, Properties& p) {
  const auto direction = p.vector("direction");
  const glm::mat4 to_world = take_transform(p, "to_world");
  const Rgb<float> irradiance = take_color(context, p, "irradiance", SpectrumRole::emission, Rgb<float>(1));
  const Vec3<float> w = direction.value_or(along_z(to_world));
  if (!(glm::dot(w, w) > 0)) fail(p.element(), "direction is 0, allowed: any other");
  context.scene.emitters.directionals.push_back({glm::normalize(w), irradiance});
}

void add_environment_map(Context& context, Properties& p) {
  const auto name = p.text("filename");
  if (!name) fail(p.element(), "needs a filename");
  const std::filesystem::path path = context.document.resolve(p.element(), *name);
  EnvironmentEmitter<float> environment;
  environment.to_world = glm::mat3(take_transform(p, "to_world"));
  environment.radiance = Rgb<float>(static_cast<float>(p.positive("scale", 1.0)));
  environment.image = std::make_shared<const Image<float>>(image_io::read_image(path));
  p.ignore({"gamma", "cache"});
  context.scene.emitters.environments.push_back(std::move(environment));
}

}  // namespace

void add_emitter(Context& context, const Element& element) {
  const std::string& type = element.get("type");
  Properties p(element, context.names);
  if (type == "point") {
    add_point(context, p);
  } else if (type == "spot") {
    add_spot(context, p);
  } else if (type == "directional") {
    add_directional(context, p);
  } else if (type == "constant") {
    EnvironmentEmitter<float> environment;
    environment.radiance = take_color(context, p, "radiance", SpectrumRole::emission, Rgb<float>(1));
    context.scene.emitters.environments.push_back(environment);
  } else if (type == "envmap") {
    add_environment_map(context, p);
  } else {
    fail(element,
         "unknown emitter; supported are point, spot, directional, constant and envmap, and area inside a <shape>");
  }
  take_emitter_medium(context, p);
  p.ignore({"sampling_weight"});
  p.finish();
}

}  // namespace manylight::scene_file
