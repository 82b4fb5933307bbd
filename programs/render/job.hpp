// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>

#include "manylight/scene/image.hpp"
#include "render/file_media.hpp"
#include "render/file_shader.hpp"
#include "render/options.hpp"
#include "render/statistics.hpp"
#include "scene_file/scene_description.hpp"

namespace manylight::render {

/// What a rendering hands back.
struct JobResult {
  Image<float> image;                         ///< W/m^2/sr
  std::map<std::string, Image<float>> aovs;   ///< by name
  std::map<std::string, Image<float>> strategies;  ///< of bidirectional path tracing, by name
  Statistics statistics;
};

/// Methods that are instantiated together for a kind of scene.
enum class MethodGroup {
  many_light,     ///< path, vpl, ir, lightcuts, bdlc
  bidirectional,  ///< bdpt
  photons,        ///< pppm, photonmap: scenes whose shaders know no subsurface scattering
};
[[nodiscard]] constexpr MethodGroup group_of(Method method) noexcept {
  if (method == Method::bdpt) return MethodGroup::bidirectional;
  return method == Method::pppm || method == Method::photonmap ? MethodGroup::photons : MethodGroup::many_light;
}

/// Renders `description` (whose shapes are moved from) as the options say, by a method of the given group, on the given
/// backend, with surfaces of the given shader and the given media; instantiated in the files job_*.cpp, so that they
/// compile side by side. Throws what Setup throws.
template <MethodGroup group, class Geometry, class Shader, class Media>
[[nodiscard]] JobResult run_job(scene_file::SceneDescription& description, const Options& options);

}  // namespace manylight::render
