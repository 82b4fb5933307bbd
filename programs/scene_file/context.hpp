// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "manylight/scattering/texture.hpp"
#include "scene_file/load_scene.hpp"
#include "scene_file/properties.hpp"
#include "scene_file/transforms.hpp"

namespace manylight::scene_file {

/// What all parsers of one file share.
struct Context {
  const Document& document;
  Names names;
  const LoadOptions& options;
  SceneDescription scene;
  std::map<const Element*, std::uint32_t> material_of;  ///< <bsdf> elements met before -> index in scene.materials
  std::map<std::string, std::shared_ptr<const Texels<float>>> bitmaps;  ///< by path and decoding
  int parsed_materials = 0;
  std::optional<std::uint32_t> default_material;  ///< of shapes without a <bsdf>
  std::optional<std::uint32_t> null_material;     ///< of such shapes with something inside
  std::map<const Element*, MediumId> medium_of;   ///< <medium> elements met before
  std::vector<std::pair<const Element*, MediumId>> emitter_media;
  std::vector<std::string> without_exterior;  ///< shapes that name an interior medium only

  Context(const Document& d, const LoadOptions& o) : document(d), names(d.root), options(o) {}
};

/// What a spectrum is for: a ratio (reflectance), power that is sent out, which is weighted differently, or a plain
/// number such as a roughness.
enum class SpectrumRole { ratio, emission, parameter };

/// Colour of an <rgb>, <srgb>, <spectrum> or <float>, not negative. Throws SceneFileError.
[[nodiscard]] Rgb<float> parse_color(const Context& context, const Element& element, SpectrumRole role);
/// The colour called `name`, or `otherwise`.
[[nodiscard]] Rgb<float> take_color(const Context& context, Properties& properties, const char* name, SpectrumRole role,
                                    const Rgb<float>& otherwise);
/// A <texture>. Throws SceneFileError.
[[nodiscard]] Texture<float> parse_texture(Context& context, const Element& element, SpectrumRole role);
/// A colour or <texture>. `largest`: upper end of the allowed range of constants.
[[nodiscard]] std::optional<Texture<float>> take_texture(Context& context, Properties& properties, const char* name,
                                                         SpectrumRole role, double largest);
/// Index of the material of a <bsdf>, parsed when first met.
[[nodiscard]] std::uint32_t material_index(Context& context, const Element& element);
/// Number of a <medium>, parsed when first met. Throws SceneFileError.
[[nodiscard]] MediumId medium_id(Context& context, const Element& element);
/// The <medium> around an emitter, which must be there anyhow: where the emitter stands decides.
void take_emitter_medium(Context& context, Properties& properties);
/// Once all elements are read: what is outside of everything, and whether media are needed at all.
void settle_media(Context& context);
/// Adds the shape of a <shape>, with its material and emitter.
void add_shape(Context& context, const Element& element);
/// Adds the light of a top-level <emitter>.
void add_emitter(Context& context, const Element& element);
/// What scatters below a surface, of a <subsurface>.
[[nodiscard]] SubsurfaceDescription parse_subsurface(Context& context, const Element& element);
/// The <transform> or <animation> called `name`, or rest at the identity. Throws SceneFileError.
[[nodiscard]] Keyframes take_keyframes(Properties& properties, std::string_view name);
/// Reads a <sensor> into the scene's camera and filter.
void read_sensor(Context& context, const Element& element);

}  // namespace manylight::scene_file
