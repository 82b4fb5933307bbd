// SPDX-License-Identifier: Apache-2.0
#include "render/file_shader.hpp"

#include <array>
#include <cmath>
#include <map>
#include <mutex>
#include <tuple>

#include "manylight/core/error.hpp"

namespace manylight::render {

namespace {

/// Rougher than this lobes are connected; files that ask for less get it (as the peers do).
constexpr float k_min_alpha = 1e-4F;

[[nodiscard]] bool is_compound(MaterialKind kind) {
  return kind == MaterialKind::blend || kind == MaterialKind::mixture || kind == MaterialKind::two_faces;
}

[[nodiscard]] float relative_ior(const MaterialDescription& d) { return d.interior_ior / d.exterior_ior; }

[[nodiscard]] CoatedBase coated_base(const MaterialDescription& d) {
  return d.is_nonlinear ? CoatedBase::nonlinear : CoatedBase::linear;
}

/// Tables of rough coats, one per (distribution, alpha, index): several materials of a file share them.
[[nodiscard]] std::shared_ptr<const RoughTransmittance<float>> coat_of(const MaterialDescription& d) {
  using Key = std::tuple<MicrofacetType, float, float, InternalReflectance>;
  static std::mutex mutex;
  static std::map<Key, std::weak_ptr<const RoughTransmittance<float>>> tables;
  const float alpha = std::max(d.alpha_u.mean().x, k_min_alpha);
  const std::lock_guard lock(mutex);
  auto& entry = tables[{d.distribution, alpha, relative_ior(d), d.internal_reflectance}];
  auto table = entry.lock();
  if (!table) {
    table = std::make_shared<const RoughTransmittance<float>>(d.distribution, alpha, relative_ior(d),
                                                              d.internal_reflectance);
    entry = table;
  }
  return table;
}

[[nodiscard]] Rgb<float> unit_range(const Rgb<float>& c) { return glm::clamp(c, Rgb<float>(0), Rgb<float>(1)); }

[[nodiscard]] float roughness(const Texture<float>& texture, const Vec2<float>& uv) {
  return std::max(texture.eval(uv).x, k_min_alpha);
}

}  // namespace

bool DiffuseShader::fits(const MaterialDescription& d) {
  return d.kind == MaterialKind::diffuse && !d.opacity && d.relief == Relief::none;
}

PreparedMaterial::PreparedMaterial(const MaterialDescription& description) : description_(description) {
  const MaterialDescription& d = description_;
  if (is_compound(d.kind)) {
    throw ParameterError("material '" + d.name + "'", "a mixture or two-faced material inside another",
                         "plain materials inside mixtures and two-faced materials");
  }
  if (d.kind == MaterialKind::rough_plastic) coat_ = coat_of(d);
  if (d.kind == MaterialKind::plastic) {
    plastic_ = Plastic<float>(d.reflectance.mean(), d.specular_reflectance.mean(), relative_ior(d), coated_base(d));
  }
}

PlainMaterial PreparedMaterial::at(const Vec2<float>& uv) const noexcept {
  const MaterialDescription& d = description_;
  switch (d.kind) {
    case MaterialKind::rough_diffuse:
      return OrenNayar<float>{unit_range(d.reflectance.eval(uv)), d.alpha_u.eval(uv).x};
    case MaterialKind::phong:
      return PhongSurface({{unit_range(d.reflectance.eval(uv))}, 1.0F},
                          {{unit_range(d.specular_reflectance.eval(uv)), d.exponent.eval(uv).x}, 1.0F});
    case MaterialKind::ward:
      return WardSurface({{unit_range(d.reflectance.eval(uv))}, 1.0F},
                         {{unit_range(d.specular_reflectance.eval(uv)), roughness(d.alpha_u, uv),
                           roughness(d.alpha_v, uv), d.ward_variant},
                          1.0F});
    case MaterialKind::conductor: return SmoothConductor<float>{d.eta, d.k, unit_range(d.specular_reflectance.eval(uv))};
    case MaterialKind::rough_conductor:
      return RoughConductor<float>{d.distribution, roughness(d.alpha_u, uv), roughness(d.alpha_v, uv), d.eta, d.k,
                                   unit_range(d.specular_reflectance.eval(uv))};
    case MaterialKind::plastic: {
      Plastic<float> plastic = plastic_;
      plastic.diffuse = unit_range(d.reflectance.eval(uv));
      plastic.specular = unit_range(d.specular_reflectance.eval(uv));
      return plastic;
    }
    case MaterialKind::rough_plastic:
      return RoughPlastic<float>{coat_.get(), unit_range(d.reflectance.eval(uv)),
                                 unit_range(d.specular_reflectance.eval(uv)), coated_base(d)};
    case MaterialKind::dielectric:
      return Dielectric<float>{relative_ior(d), unit_range(d.specular_reflectance.eval(uv)),
                               unit_range(d.specular_transmittance.eval(uv))};
    case MaterialKind::thin_dielectric:
      return ThinDielectric<float>{relative_ior(d), unit_range(d.specular_reflectance.eval(uv)),
                                   unit_range(d.specular_transmittance.eval(uv))};
    case MaterialKind::rough_dielectric:
      return RoughDielectric<float>{relative_ior(d),
                                    d.distribution,
                                    roughness(d.alpha_u, uv),
                                    roughness(d.alpha_v, uv),
                                    unit_range(d.specular_reflectance.eval(uv)),
                                    unit_range(d.specular_transmittance.eval(uv))};
    case MaterialKind::diffuse:
    case MaterialKind::mixture:
    case MaterialKind::blend:
    case MaterialKind::two_faces: break;
  }
  return Lambertian<float>{unit_range(d.reflectance.eval(uv))};
}

template <class M>
SurfaceShaderOf<M>::SurfaceShaderOf(const MaterialDescription& d, const Rgb<float>& interior_absorption)
    : kind_(d.kind),
      is_two_sided_(d.is_two_sided || d.kind == MaterialKind::two_faces),
      relief_(d.relief),
      relief_map_(d.relief_map),
      relief_scale_(d.relief_scale),
      opacity_(d.opacity),
      interior_absorption_(interior_absorption),
      weights_(d.weights) {
  if (!is_compound(kind_)) {
    parts_.emplace_back(d);
    return;
  }
  if (d.nested.empty() || d.nested.size() > k_max_blend) {
    throw ParameterError("number of materials mixed by '" + d.name + "'", d.nested.size(), "1 to 4");
  }
  for (const MaterialDescription& part : d.nested) {
    if (part.relief != Relief::none) {
      throw ParameterError("material '" + part.name + "'", "a bump or normal map inside a mixture or two-faced material",
                           "around it");
    }
    parts_.emplace_back(part);
  }
}

template <class M>
bool SurfaceShaderOf<M>::fits(const MaterialDescription& d) {
  return std::same_as<M, BlendedMaterial> || (d.kind != MaterialKind::blend && d.kind != MaterialKind::mixture);
}

template <class M>
Blend SurfaceShaderOf<M>::blend(const Vec2<float>& uv) const noexcept {
  std::array<WeightedLobe<PlainMaterial>, k_max_blend> lobes;
  for (WeightedLobe<PlainMaterial>& lobe : lobes) lobe = {Lambertian<float>{Rgb<float>(0)}, 0.0F};
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const std::size_t texture = kind_ == MaterialKind::blend ? 0 : i;
    const float weight = std::clamp(weights_[texture].eval(uv).x, 0.0F, 1.0F);
    lobes[i] = {parts_[i].at(uv), kind_ == MaterialKind::blend && i == 0 ? 1.0F - weight : weight};
  }
  return Blend(lobes[0], lobes[1], lobes[2], lobes[3]);
}

template class SurfaceShaderOf<PlainMaterial>;
template class SurfaceShaderOf<BlendedMaterial>;

}  // namespace manylight::render
