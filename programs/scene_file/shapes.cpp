// SPDX-License-Identifier: Apache-2.0
// <shape> elements.
#include "manylight/geometry/mesh_builders.hpp"
#include "manylight/geometry/transform.hpp"
#include "manylight/geometry/validate.hpp"
#include "manylight/geometry/vertex_normals.hpp"
#include "scene_file/context.hpp"
#include "scene_file/mesh_files.hpp"

namespace manylight::scene_file {

namespace {

const char* const k_supported =
    "unknown shape; supported are obj, ply, gltf, serialized, rectangle, cube, sphere and disk";

std::filesystem::path take_file(Context& context, Properties& p, const char* property) {
  const auto name = p.text(property);
  if (!name) fail(p.element(), std::string("needs a ") + property);
  return context.document.resolve(p.element(), *name);
}

/// Normals as the file or its options want them. The peer computes smooth normals for meshes that bring none.
void set_normals(Properties& p, TriangleMesh<float>& mesh) {
  const bool face_normals = p.flag("face_normals", false);
  const auto max_angle = p.number("max_smooth_angle");
  if (max_angle && !(*max_angle >= 0 && *max_angle <= 180)) {
    fail(p.element(), "max_smooth_angle is out of range, allowed: 0 to 180 degrees");
  }
  if (face_normals) {
    mesh.normals.clear();
  } else if (max_angle) {
    compute_smooth_normals(mesh, static_cast<float>(*max_angle));
  } else if (mesh.normals.empty()) {
    compute_vertex_normals(mesh);
  }
}

TriangleMesh<float> read_mesh(Properties& p, const std::string& type, const std::filesystem::path& path) {
  TriangleMesh<float> mesh;
  if (type == "serialized") {
    mesh = read_serialized(path, p.integer("shape_index").value_or(0));
  } else {
    const bool flips = p.flag("flip_tex_coords", type != "ply");
    mesh = type == "obj" ? read_obj(path, flips) : type == "ply" ? read_ply(path, flips) : read_gltf(path, flips);
  }
  validate(mesh, path.string());
  return mesh;
}

/// In its own frame. `closing`: the file of a mesh that deforms, as it is when the shutter closes.
TriangleMesh<float> mesh_of(Context& context, Properties& p, const std::string& type,
                            std::optional<TriangleMesh<float>>& closing) {
  if (type == "rectangle") return rectangle_mesh<float>(glm::mat4(1));
  if (type == "cube") return cube_mesh<float>(glm::mat4(1));
  const std::filesystem::path path = take_file(context, p, "filename");
  const auto read = [&](const std::filesystem::path& file) { return read_mesh(p, type, file); };
  TriangleMesh<float> mesh = read(path);
  if (p.text("closing_filename")) {
    closing = read(take_file(context, p, "closing_filename"));
    if (closing->positions.size() != mesh.positions.size() || closing->triangles != mesh.triangles) {
      fail(p.element(), "closing_filename has other triangles than filename, allowed: the same, of moved vertices");
    }
    set_normals(p, *closing);
  }
  set_normals(p, mesh);
  return mesh;
}
/// What is on the two sides; none of a shape that is no boundary.
std::optional<MediaSides> take_media(Context& context, Properties& p, const std::string& name) {
  const Element* interior = p.take("interior");
  const Element* exterior = p.take("exterior");
  if (interior == nullptr && exterior == nullptr) return std::nullopt;
  if (exterior == nullptr) context.without_exterior.push_back(name);
  MediaSides sides;
  if (exterior != nullptr) sides.front = medium_id(context, *exterior);
  if (interior != nullptr) sides.back = medium_id(context, *interior);
  return sides;
}

/// `is_index_matched`: what a shape without a <bsdf> is, null instead of grey.
std::uint32_t take_material(Context& context, Properties& p, bool is_index_matched) {
  const auto bsdfs = p.take_all("bsdf");
  if (bsdfs.size() > 1) fail(*bsdfs[1]->place, "is the second material of this shape");
  if (!bsdfs.empty()) return material_index(context, *bsdfs.front()->element);
  std::optional<std::uint32_t>& material = is_index_matched ? context.null_material : context.default_material;
  if (!material) {
    material = static_cast<std::uint32_t>(context.scene.materials.size());
    MaterialDescription& added = context.scene.materials.emplace_back();
    added.name = is_index_matched ? "null" : "default";
    if (is_index_matched) added.opacity = Texture<float>(0.0F);
  }
  return *material;
}

/// Whether there is one.
bool take_area_emitter(Context& context, Properties& p, std::uint32_t shape) {
  const auto emitters = p.take_all("emitter");
  if (emitters.size() > 1) fail(*emitters[1]->place, "is the second emitter of this shape");
  if (emitters.empty()) return false;
  const Element& element = *emitters.front()->element;
  if (element.get("type") != "area") fail(element, "unknown emitter of a shape; supported is area");
  Properties e(element, context.names);
  auto radiance = take_texture(context, e, "radiance", SpectrumRole::emission, 3e38);
  if (!radiance) radiance = take_texture(context, e, "intensity", SpectrumRole::emission, 3e38);
  take_emitter_medium(context, e);
  e.ignore({"sampling_weight"});
  e.finish();
  context.scene.emitters.areas.push_back({shape, radiance.value_or(Texture<float>(1.0F)), false});
  return true;
}

void add_geometry(Context& context, Properties& p) {
  const Element& element = p.element();
  const std::string& type = element.get("type");
  const Keyframes motion = take_keyframes(p, "to_world");
  const glm::mat4 to_world = motion.at(context.scene.shutter.open);
  const bool flips = p.flag("flip_normals", false);
  Shapes<float>& shapes = context.scene.shapes;
  ShapeMotion moving;
  if (type == "sphere") {
    Sphere<float> sphere;
    sphere.center = p.vector("center").value_or(Vec3<float>(0));
    sphere.radius = static_cast<float>(p.positive("radius", 1.0));
    sphere.flip_normals = flips;
    moving.local = sphere;
    shapes.spheres.push_back(transform(sphere, to_world));
    validate(shapes.spheres.back(), element.describe());
  } else if (type == "disk") {
    Disk<float> disk;
    if (flips) disk.normal = -disk.normal;
    moving.local = disk;
    shapes.disks.push_back(transform(disk, to_world));
    validate(shapes.disks.back(), element.describe());
  } else if (type == "obj" || type == "ply" || type == "gltf" || type == "serialized" || type == "rectangle" ||
             type == "cube") {
    TriangleMesh<float> mesh = mesh_of(context, p, type, moving.closing);
    mesh.flip_normals = mesh.flip_normals != flips;
    if (motion.moves() || moving.closing) moving.local = mesh;
    shapes.meshes.push_back(transform(std::move(mesh), to_world));
  } else {
    fail(element, k_supported);
  }
  if (motion.moves() || moving.closing) {
    moving.shape = static_cast<std::uint32_t>(context.scene.shape_infos.size());
    moving.to_world = motion;
    context.scene.motions.push_back(std::move(moving));
  }
}

}  // namespace

void add_shape(Context& context, const Element& element) {
  Properties p(element, context.names);
  try {
    add_geometry(context, p);
  } catch (const GeometryError& error) {
    fail(element, error.what());
  }
  // Ids count meshes, spheres, disks; infos are kept in file order and sorted at the end (see sort_shapes).
  ShapeDescription info;
  info.name = element.has("id") ? element.get("id") : element.describe();
  info.media = take_media(context, p, info.name);
  const bool emits = take_area_emitter(context, p, static_cast<std::uint32_t>(context.scene.shape_infos.size()));
  const auto subsurfaces = p.take_all("subsurface");
  if (subsurfaces.size() > 1) fail(*subsurfaces[1]->place, "is the second subsurface scattering of this shape");
  if (!subsurfaces.empty()) {
    info.subsurface = static_cast<std::uint32_t>(context.scene.subsurfaces.size());
    context.scene.subsurfaces.push_back(parse_subsurface(context, *subsurfaces.front()->element));
  }
  info.material = take_material(context, p, info.media && info.media->back != k_vacuum && !emits);
  context.scene.shape_infos.push_back(std::move(info));
  p.finish();
}

}  // namespace manylight::scene_file
