// SPDX-License-Identifier: Apache-2.0
#include "render/file_subsurface.hpp"

#include "manylight/core/error.hpp"

namespace manylight::render {

namespace {

using scene_file::FalloffKind;
using scene_file::SubsurfaceDescription;

/// The diffusion length of the published fit is given by the mean free path and the albedo.
[[nodiscard]] BurleyFalloff<float> burley(const SubsurfaceDescription& d) {
  const auto of = [&](int c) { return BurleyProfile<float>::of(d.length[c], d.reflectance[c]); };
  return {of(0), of(1), of(2)};
}

[[nodiscard]] FileSubsurface subsurface_of(const SubsurfaceDescription& d) {
  FileSubsurface below;
  below.rho = d.reflectance;
  below.eta = d.ior;
  switch (d.kind) {
    case FalloffKind::exponential: below.falloff = ExponentialFalloff<float>(d.length); break;
    case FalloffKind::gaussian: below.falloff = GaussianFalloff<float>(d.length); break;
    case FalloffKind::burley: below.falloff = burley(d); break;
    case FalloffKind::dipole: {
      const DipoleFalloff<float> dipole(d.sigma_a, d.sigma_s, d.ior);
      below.falloff = dipole;
      below.rho = glm::min(dipole.reflectance(), Rgb<float>(1));
      break;
    }
  }
  below.validate();
  return below;
}

}  // namespace

FileSubsurface make_file_subsurface(const SubsurfaceDescription& description) {
  try {
    return subsurface_of(description);
  } catch (const Error& error) {
    throw SceneError("subsurface scattering '" + description.name + "': " + error.what());
  }
}

}  // namespace manylight::render
