// SPDX-License-Identifier: Apache-2.0
#include "manylight/geometry/bvh.hpp"
#include "render/job_impl.hpp"

namespace manylight::render {
template JobResult run_job<MethodGroup::any_scene, Bvh<float>, SurfaceFileShader, NoMedia>(
    scene_file::SceneDescription&, const Options&);
template JobResult run_job<MethodGroup::no_subsurface, Bvh<float>, SurfaceFileShader, NoMedia>(
    scene_file::SceneDescription&, const Options&);
}  // namespace manylight::render
