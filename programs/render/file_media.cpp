// SPDX-License-Identifier: Apache-2.0
#include "render/file_media.hpp"

#include <optional>
#include <span>
#include <vector>

#include "manylight/core/error.hpp"

namespace manylight::render {

namespace {

using scene_file::MediumDescription;
using scene_file::PhaseKind;

[[nodiscard]] FilePhase phase_of(const MediumDescription& d) {
  if (d.phase == PhaseKind::henyey_greenstein) return HenyeyGreenstein<float>{d.g};
  return IsotropicPhase<float>{};
}

template <class Albedo>
[[nodiscard]] FileMedium grid_medium(const MediumDescription& d, const Albedo& albedo) {
  if (d.phase == PhaseKind::gaussian_fiber) {
    return FiberMedium<FileFibers, FileDensity, Albedo>(*d.density, std::span<const Vec3<float>>(d.axes), d.scale,
                                                        albedo, FileFibers(d.gamma));
  }
  return Heterogeneous<FilePhase, FileDensity, Albedo>(*d.density, d.scale, albedo, phase_of(d));
}

[[nodiscard]] FileMedium medium_of(const MediumDescription& d) {
  if (!d.density) {
    const Homogeneous<FilePhase> medium(d.sigma_a, d.sigma_s, phase_of(d));
    if (d.box) return BoxedMedium<Homogeneous<FilePhase>>(medium, *d.box);
    return medium;
  }
  return d.albedo_grid ? grid_medium(d, *d.albedo_grid) : grid_medium(d, d.albedo);
}

}  // namespace

FileMedia make_file_media(const scene_file::SceneDescription& description) {
  std::vector<FileMedium> media;
  for (const MediumDescription& d : description.media) {
    try {
      media.push_back(medium_of(d));
    } catch (const Error& error) {
      throw SceneError("medium '" + d.name + "': " + error.what());
    }
  }
  std::vector<std::optional<MediaSides>> boundaries;
  for (const scene_file::ShapeDescription& info : description.shape_infos) boundaries.push_back(info.media);
  return {std::move(media), std::move(boundaries), description.outside};
}

}  // namespace manylight::render
