// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/mat4x4.hpp>

#include "manylight/scattering/texture.hpp"
#include "scene_file/properties.hpp"

namespace manylight::scene_file {

/// The matrix of a <transform>: its steps apply in the order of the file. Throws SceneFileError.
[[nodiscard]] glm::mat4 parse_transform(const Element& element);

/// The same, which must have an inverse.
[[nodiscard]] glm::mat4 invertible_transform(const Element& element);

/// The transform called `name`, or the identity.
[[nodiscard]] glm::mat4 take_transform(Properties& properties, std::string_view name);

/// The plane part of a texture's transform, identity if there is none.
[[nodiscard]] UvTransform<float> take_uv_transform(Properties& properties);

}  // namespace manylight::scene_file
