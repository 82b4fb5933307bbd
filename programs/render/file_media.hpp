// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "manylight/media/any_medium.hpp"
#include "manylight/media/boxed_medium.hpp"
#include "manylight/media/fiber_medium.hpp"
#include "manylight/media/heterogeneous.hpp"
#include "manylight/media/homogeneous.hpp"
#include "manylight/scattering/any_phase.hpp"
#include "manylight/scattering/gaussian_fiber.hpp"
#include "manylight/scattering/henyey_greenstein.hpp"
#include "manylight/scattering/isotropic_phase.hpp"
#include "manylight/scene/scene_media.hpp"
#include "scene_file/scene_description.hpp"

/// From descriptions of media to those that scenes are made of. Three kinds of scene are instantiated: diffuse
/// surfaces, plain surfaces, and everything; media belong to the last.
namespace manylight::render {

using FilePhase = AnyPhase<IsotropicPhase<float>, HenyeyGreenstein<float>, GaussianFiber<float>>;

/// Makes the phase functions of one fiber medium, which share a table.
class FileFibers {
 public:
  /// `gamma`: 0.01 to 10. Throws ParameterError.
  explicit FileFibers(float gamma) : table_(std::make_shared<const GaussianFiberTable<float>>(gamma)) {}
  /// Not after the last copy of these is gone.
  [[nodiscard]] GaussianFiber<float> operator()(const Vec3<float>& axis) const noexcept { return {*table_, axis}; }
  [[nodiscard]] float max_projected_area() const noexcept { return table_->sigma(1.0F); }

 private:
  std::shared_ptr<const GaussianFiberTable<float>> table_;
};

using FileDensity = GridVolume<float>;
using FileAlbedo = GridVolume<float, Rgb<float>>;

/// Any medium of a file.
using FileMedium =
    AnyMediumWith<FilePhase, Homogeneous<FilePhase>, BoxedMedium<Homogeneous<FilePhase>>,
                  Heterogeneous<FilePhase, FileDensity>, Heterogeneous<FilePhase, FileDensity, FileAlbedo>,
                  FiberMedium<FileFibers, FileDensity>, FiberMedium<FileFibers, FileDensity, FileAlbedo>>;
using FileMedia = SceneMedia<FileMedium>;

/// Throws SceneError naming the medium, as where rays through a grid would take more than 1e6 steps.
[[nodiscard]] FileMedia make_file_media(const scene_file::SceneDescription& description);

}  // namespace manylight::render
