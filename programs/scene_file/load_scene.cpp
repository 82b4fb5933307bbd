// SPDX-License-Identifier: Apache-2.0
#include "scene_file/load_scene.hpp"

#include <algorithm>
#include <array>

#include "scene_file/context.hpp"

namespace manylight::scene_file {

namespace {

constexpr std::array k_integrators{"path",    "volpath",      "volpath_simple", "volpathmis", "direct", "bdpt",
                                   "ptracer", "photonmapper", "moment",         "prb",        "pssmlt", "mlt"};

/// Only the longest path matters here: what integrates is chosen on the command line.
void read_integrator(Context& context, const Element& element) {
  const std::string& type = element.get("type");
  if (std::find(k_integrators.begin(), k_integrators.end(), type) == k_integrators.end()) {
    std::vector<std::string> names(k_integrators.begin(), k_integrators.end());
    fail(element, "unknown integrator; known are " + listed(names));
  }
  Properties p(element, context.names);
  for (const Properties::Item* nested : p.take_all("integrator")) read_integrator(context, *nested->element);
  if (type == "direct") context.scene.max_depth = 2;
  if (const auto depth = p.integer("max_depth")) {
    if (*depth < -1 || *depth == 0) {
      fail(element, "max_depth is " + std::to_string(*depth) + ", allowed: -1 or at least 1 edge");
    }
    context.scene.max_depth = *depth;
  }
  if (p.flag("hide_emitters", false)) fail(element, "hide_emitters is not supported");
  p.ignore({"rr_depth", "strict_normals", "version", "emitter_samples", "bsdf_samples", "shading_samples",
            "light_image", "sample_direct"});
  p.finish();
}

void read_children(Context& context, const Element& root) {
  Properties p(root, context.names);
  for (const Properties::Item* item : p.take_all("integrator")) read_integrator(context, *item->element);
  const auto sensors = p.take_all("sensor");
  if (sensors.empty()) fail(root, "has no camera: a <sensor> is needed");
  if (sensors.size() > 1) fail(*sensors[1]->element, "is the second camera; one is supported");
  read_sensor(context, *sensors.front()->element);
  for (const Properties::Item* item : p.take_all("bsdf")) static_cast<void>(material_index(context, *item->element));
  for (const Properties::Item* item : p.take_all("medium")) static_cast<void>(medium_id(context, *item->element));
  for (const Properties::Item* item : p.take_all("emitter")) add_emitter(context, *item->element);
  for (const Properties::Item* item : p.take_all("shape")) add_shape(context, *item->element);
  settle_media(context);
  p.ignore_tags({"texture", "volume", "phase", "alias"});  // they count where they are referred to
  p.finish();
}

/// Shape ids count all meshes, then all spheres, then all disks, while `shape_infos` and the emitters count in file
/// order: brings the latter into the former.
void sort_shapes(SceneDescription& scene, const std::vector<int>& kinds) {
  std::vector<std::uint32_t> order(kinds.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return kinds[a] < kinds[b]; });
  std::vector<ShapeDescription> sorted;
  std::vector<std::uint32_t> id_of(order.size());
  for (std::uint32_t id = 0; id < order.size(); ++id) {
    id_of[order[id]] = id;
    sorted.push_back(std::move(scene.shape_infos[order[id]]));
  }
  scene.shape_infos = std::move(sorted);
  for (AreaEmitter<float>& emitter : scene.emitters.areas) emitter.shape = id_of[emitter.shape];
  for (ShapeMotion& motion : scene.motions) motion.shape = id_of[motion.shape];
}

}  // namespace

SceneDescription load_scene(const std::filesystem::path& path, const LoadOptions& options) {
  const Document document = read_document(path, Definitions(options.defines.begin(), options.defines.end()));
  Context context(document, options);
  read_children(context, document.root);
  std::vector<int> kinds;
  for (const auto& child : document.root.children) {
    if (child->tag != "shape") continue;
    const std::string& type = child->get("type");
    kinds.push_back(type == "sphere" ? 1 : type == "disk" ? 2 : 0);
  }
  sort_shapes(context.scene, kinds);
  const SceneDescription& scene = context.scene;
  if (scene.shapes.size() == 0) fail(document.root, "has no shapes");
  if (scene.emitters.size() == 0) fail(document.root, "has no emitters");
  return std::move(context.scene);
}

}  // namespace manylight::scene_file
