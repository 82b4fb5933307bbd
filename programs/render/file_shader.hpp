// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include "manylight/scattering/any_of.hpp"
#include "manylight/scattering/conductor.hpp"
#include "manylight/scattering/dielectric.hpp"
#include "manylight/scattering/lambertian.hpp"
#include "manylight/scattering/mixture.hpp"
#include "manylight/scattering/oren_nayar.hpp"
#include "manylight/scattering/phong.hpp"
#include "manylight/scattering/plastic.hpp"
#include "manylight/scattering/rough_dielectric.hpp"
#include "manylight/scattering/rough_plastic.hpp"
#include "manylight/scattering/ward.hpp"
#include "manylight/scene/bent_normal.hpp"
#include "manylight/scene/shader.hpp"
#include "render/file_subsurface.hpp"
#include "scene_file/scene_description.hpp"

/// From material descriptions to what surfaces are made of.
namespace manylight::render {

using scene_file::MaterialDescription;
using scene_file::MaterialKind;
using scene_file::Relief;

using PhongSurface = Mixture<Lambertian<float>, Phong<float>>;
using WardSurface = Mixture<Lambertian<float>, Ward<float>>;

/// Every material of a file that is not itself a mixture of others.
using PlainMaterial =
    AnyOf<Lambertian<float>, RoughPlastic<float>, RoughConductor<float>, Plastic<float>, Dielectric<float>,
          SmoothConductor<float>, ThinDielectric<float>, RoughDielectric<float>, OrenNayar<float>, PhongSurface,
          WardSurface>;
inline constexpr std::size_t k_max_blend = 4;
using Blend = Mixture<PlainMaterial, PlainMaterial, PlainMaterial, PlainMaterial>;
using BlendedMaterial =
    AnyOf<Lambertian<float>, RoughPlastic<float>, RoughConductor<float>, Plastic<float>, Dielectric<float>,
          SmoothConductor<float>, ThinDielectric<float>, RoughDielectric<float>, OrenNayar<float>, PhongSurface,
          WardSurface, Blend>;

/// Opaque diffuse surfaces: no gloss, opacity or absorption code is instantiated.
class DiffuseShader {
 public:
  using Material = Lambertian<float>;
  static constexpr bool k_may_be_transparent = false;
  static constexpr bool k_may_absorb = false;

  DiffuseShader(const MaterialDescription& description, const Rgb<float>& /*interior_absorption*/)
      : reflectance_(description.reflectance), is_two_sided_(description.is_two_sided) {}
  [[nodiscard]] static bool fits(const MaterialDescription& description);

  [[nodiscard]] Material material(const SurfacePoint<float>& point, bool) const noexcept {
    return {reflectance_.eval(point.uv)};
  }
  [[nodiscard]] bool is_two_sided() const noexcept { return is_two_sided_; }

 private:
  Texture<float> reflectance_;
  bool is_two_sided_;
};

/// One description with what it needs at every look-up made ready.
class PreparedMaterial {
 public:
  /// Throws ParameterError.
  explicit PreparedMaterial(const MaterialDescription& description);
  [[nodiscard]] PlainMaterial at(const Vec2<float>& uv) const noexcept;
  [[nodiscard]] const MaterialDescription& description() const noexcept { return description_; }

 private:
  MaterialDescription description_;
  std::shared_ptr<const RoughTransmittance<float>> coat_;
  Plastic<float> plastic_;
};

/// Any surface of a file. `M`: PlainMaterial, or BlendedMaterial where mixtures occur.
template <class M>
class SurfaceShaderOf {
 public:
  using Material = M;
  static constexpr bool k_may_be_transparent = true;
  static constexpr bool k_may_absorb = true;

  SurfaceShaderOf(const MaterialDescription& description, const Rgb<float>& interior_absorption);
  [[nodiscard]] static bool fits(const MaterialDescription& description);

  [[nodiscard]] M material(const SurfacePoint<float>& point, bool outside) const noexcept {
    if constexpr (std::same_as<M, BlendedMaterial>) {
      if (kind_ == MaterialKind::blend || kind_ == MaterialKind::mixture) return blend(point.uv);
    }
    const PreparedMaterial& side = parts_[kind_ == MaterialKind::two_faces && !outside ? 1 : 0];
    return side.at(point.uv).visit([](const auto& material) { return M(material); });
  }
  [[nodiscard]] Vec3<float> shading_normal(const SurfacePoint<float>& point) const noexcept {
    if (relief_ == Relief::none) return point.ns;
    if (relief_ == Relief::heights) return bumped_normal(point, relief_map_.gradient(point.uv) * relief_scale_);
    return mapped_normal(point, relief_map_.eval(point.uv) * 2.0F - Vec3<float>(1.0F));
  }
  [[nodiscard]] bool is_two_sided() const noexcept { return is_two_sided_; }
  [[nodiscard]] bool is_transparent() const noexcept { return opacity_.has_value(); }
  [[nodiscard]] float opacity(const SurfacePoint<float>& point) const noexcept {
    return std::clamp(luminance(opacity_->eval(point.uv)), 0.0F, 1.0F);
  }
  [[nodiscard]] const Rgb<float>& interior_absorption() const noexcept { return interior_absorption_; }

 private:
  [[nodiscard]] Blend blend(const Vec2<float>& uv) const noexcept;

  MaterialKind kind_;
  bool is_two_sided_;
  Relief relief_;
  Texture<float> relief_map_;
  float relief_scale_;
  std::optional<Texture<float>> opacity_;
  Rgb<float> interior_absorption_;
  std::vector<PreparedMaterial> parts_;
  std::vector<Texture<float>> weights_;
};

using SurfaceFileShader = SurfaceShaderOf<PlainMaterial>;
/// For scenes of everything but subsurface scattering.
using BlendedFileShader = SurfaceShaderOf<BlendedMaterial>;

/// Any surface of a file, and what scatters below it.
class FullFileShader : public SurfaceShaderOf<BlendedMaterial> {
 public:
  using Subsurface = FileSubsurface;

  FullFileShader(const MaterialDescription& description, const Rgb<float>& interior_absorption,
                 std::shared_ptr<const FileSubsurface> below)
      : SurfaceShaderOf(description, interior_absorption), below_(std::move(below)) {}
  [[nodiscard]] const FileSubsurface* subsurface() const noexcept { return below_.get(); }

 private:
  std::shared_ptr<const FileSubsurface> below_;
};

}  // namespace manylight::render
