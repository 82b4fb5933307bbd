// SPDX-License-Identifier: Apache-2.0
// What moves while the shutter is open.
#include "scene_file/motion.hpp"

#include <algorithm>

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>

#include "manylight/geometry/transform.hpp"
#include "scene_file/context.hpp"

namespace manylight::scene_file {

namespace {

/// translation * rotation * scale; a mirroring is part of the scale.
struct Parts {
  glm::vec3 translation;
  glm::quat rotation;
  glm::vec3 scale;
};
Parts parts_of(const glm::mat4& m) {
  glm::mat3 linear(m);
  Parts parts{glm::vec3(m[3]), {}, {glm::length(linear[0]), glm::length(linear[1]), glm::length(linear[2])}};
  if (glm::determinant(linear) < 0) parts.scale.x = -parts.scale.x;
  for (int axis = 0; axis < 3; ++axis) linear[axis] /= parts.scale[axis];
  parts.rotation = glm::quat_cast(linear);
  return parts;
}

bool is_sheared(const glm::mat4& m) {
  const glm::vec3 x = glm::normalize(glm::vec3(m[0]));
  const glm::vec3 y = glm::normalize(glm::vec3(m[1]));
  const glm::vec3 z = glm::normalize(glm::vec3(m[2]));
  constexpr float k_tolerance = 1e-3F;  // files hold rotations with few digits
  return std::max({std::abs(glm::dot(x, y)), std::abs(glm::dot(y, z)), std::abs(glm::dot(z, x))}) > k_tolerance;
}

TriangleMesh<float> between(const TriangleMesh<float>& a, const TriangleMesh<float>& b, float t) {
  TriangleMesh<float> mesh = a;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    mesh.positions[i] = a.positions[i] * (1 - t) + b.positions[i] * t;
  }
  for (std::size_t i = 0; i < mesh.normals.size(); ++i) {
    const Vec3<float> n = a.normals[i] * (1 - t) + b.normals[i] * t;
    if (glm::dot(n, n) > 0) mesh.normals[i] = glm::normalize(n);
  }
  return mesh;
}

}  // namespace

glm::mat4 Keyframes::at(float time) const {
  const auto after = std::upper_bound(frames.begin(), frames.end(), time,
                                      [](float t, const std::pair<float, glm::mat4>& frame) { return t < frame.first; });
  if (after == frames.begin()) return frames.front().second;
  if (after == frames.end()) return frames.back().second;
  const auto& [t0, m0] = *(after - 1);
  const auto& [t1, m1] = *after;
  const float t = (time - t0) / (t1 - t0);
  const Parts a = parts_of(m0);
  const Parts b = parts_of(m1);
  const glm::mat4 moved = glm::translate(glm::mat4(1), glm::mix(a.translation, b.translation, t)) *
                          glm::mat4_cast(glm::slerp(a.rotation, b.rotation, t));
  return glm::scale(moved, glm::mix(a.scale, b.scale, t));
}

Keyframes take_keyframes(Properties& properties, std::string_view name) {
  const Element* child = properties.take(name);
  if (child == nullptr) return {{{0.0F, glm::mat4(1.0F)}}};
  if (child->tag != "animation") return {{{0.0F, invertible_transform(*child)}}};
  Keyframes motion;
  for (const auto& key : child->children) {
    const auto time = static_cast<float>(parse_number(*key, key->get("time")));
    if (!motion.frames.empty() && !(time > motion.frames.back().first)) fail(*key, "time must be above the one before");
    motion.frames.emplace_back(time, invertible_transform(*key));
  }
  if (motion.frames.empty()) fail(*child, "needs at least one <transform time=...>");
  for (const auto& [time, matrix] : motion.frames) {
    if (motion.moves() && is_sheared(matrix)) fail(*child, "has a sheared transform, allowed in motion: none");
  }
  return motion;
}

SceneDescription at_time(const SceneDescription& scene, float time) {
  SceneDescription now = scene;
  if (scene.camera.motion.moves()) now.camera.to_world = scene.camera.motion.at(time);
  const Shutter& shutter = scene.shutter;
  const float share = shutter.close > shutter.open ? (time - shutter.open) / (shutter.close - shutter.open) : 0.0F;
  for (const ShapeMotion& motion : scene.motions) {
    const glm::mat4 to_world = motion.to_world.at(time);
    const auto meshes = static_cast<std::uint32_t>(now.shapes.meshes.size());
    const auto spheres = static_cast<std::uint32_t>(now.shapes.spheres.size());
    if (const auto* mesh = std::get_if<TriangleMesh<float>>(&motion.local)) {
      now.shapes.meshes[motion.shape] =
          transform(motion.closing ? between(*mesh, *motion.closing, share) : *mesh, to_world);
    } else if (const auto* sphere = std::get_if<Sphere<float>>(&motion.local)) {
      now.shapes.spheres[motion.shape - meshes] = transform(*sphere, to_world);
    } else {
      now.shapes.disks[motion.shape - meshes - spheres] = transform(std::get<Disk<float>>(motion.local), to_world);
    }
  }
  return now;
}

}  // namespace manylight::scene_file
