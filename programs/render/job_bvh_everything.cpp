// SPDX-License-Identifier: Apache-2.0
#include "manylight/geometry/bvh.hpp"
#include "render/job_impl.hpp"

namespace manylight::render {
template JobResult run_job<MethodGroup::many_light, Bvh<float>, FullFileShader, FileMedia>(
    scene_file::SceneDescription&, const Options&);
template JobResult run_job<MethodGroup::bidirectional, Bvh<float>, FullFileShader, FileMedia>(
    scene_file::SceneDescription&, const Options&);
}  // namespace manylight::render
