// SPDX-License-Identifier: Apache-2.0
#ifdef MANYLIGHT_HAS_EMBREE
#include "manylight/geometry/embree.hpp"
#include "render/job_impl.hpp"

namespace manylight::render {
template JobResult run_job<MethodGroup::many_light, EmbreeGeometry, FullFileShader, FileMedia>(
    scene_file::SceneDescription&, const Options&);
template JobResult run_job<MethodGroup::bidirectional, EmbreeGeometry, FullFileShader, FileMedia>(
    scene_file::SceneDescription&, const Options&);
}  // namespace manylight::render
#endif
