// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "manylight/path/walk.hpp"

namespace manylight::detail {

/// Whether the density of directions at `hit` passes `limit` (sr^-1) in one of the directions where lobes peak:
/// mirrored, back and straight on. A function of the vertex alone, so that methods may treat glossy vertices in their
/// own way.
template <class Hit, std::floating_point S>
[[nodiscard]] bool is_glossy(const Hit& hit, const Vec3<S>& wo, S limit) noexcept {
  const Vec3<S> mirrored = hit.frame.n * (S(2) * glm::dot(wo, hit.frame.n)) - wo;
  return direction_pdf(hit, mirrored, wo) > limit || direction_pdf(hit, wo, wo) > limit ||
         direction_pdf(hit, -wo, wo) > limit;
}

}  // namespace manylight::detail
