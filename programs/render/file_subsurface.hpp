// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "manylight/scattering/any_falloff.hpp"
#include "manylight/scattering/dipole.hpp"
#include "manylight/scattering/falloff_profiles.hpp"
#include "manylight/scattering/subsurface.hpp"
#include "scene_file/scene_description.hpp"

/// From descriptions of subsurface scattering to what scenes are made of.
namespace manylight::render {

using FileFalloff = AnyFalloff<ExponentialFalloff<float>, GaussianFalloff<float>, BurleyFalloff<float>, DipoleFalloff<float>>;
using FileSubsurface = Subsurface<FileFalloff>;

/// Throws SceneError naming it.
[[nodiscard]] FileSubsurface make_file_subsurface(const scene_file::SubsurfaceDescription& description);

}  // namespace manylight::render
