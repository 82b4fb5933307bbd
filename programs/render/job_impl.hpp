// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/render_aovs.hpp"
#include "render/render_bidirectional.hpp"
#include "render/render_many_light.hpp"
#include "render/render_path.hpp"
#include "render/render_photons.hpp"

namespace manylight::render {

template <MethodGroup group, class Geometry, class Shader, class Media>
JobResult run_job(scene_file::SceneDescription& description, const Options& options) {
  const Stopwatch clock;
  const Setup<Geometry, Shader, Media> setup(description, options);
  JobResult result;
  result.statistics.set_seconds("build", clock.seconds());
  render_aovs(setup, result);
  if constexpr (group == MethodGroup::bidirectional) {
    render_bidirectional(setup, result);
  } else if constexpr (group == MethodGroup::photons) {
    if (options.method == Method::pppm) {
      render_progressive_photons(setup, result);
    } else if constexpr (!Media::k_exist) {
      render_photon_map(setup, result);
    } else {
      throw ParameterError("--method photonmap", "for a scene with media or motion or mixed materials", "any other");
    }
  } else if (options.method == Method::path) {
    render_path(setup, result);
  } else {
    ManyLightJob<Geometry, Shader, Media>(setup, result).run();
  }
  return result;
}

}  // namespace manylight::render
