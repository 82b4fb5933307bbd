// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <concepts>
#include <limits>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace manylight {

/// Vectors are GLM's, templated on the scalar: images are rendered in float, oracles in double.
template <std::floating_point S>
using Vec2 = glm::vec<2, S, glm::defaultp>;
template <std::floating_point S>
using Vec3 = glm::vec<3, S, glm::defaultp>;

template <std::floating_point S>
inline constexpr S k_pi = S(3.14159265358979323846L);
template <std::floating_point S>
inline constexpr S k_inv_pi = S(0.318309886183790671538L);
template <std::floating_point S>
inline constexpr S k_infinity = std::numeric_limits<S>::infinity();

template <std::floating_point S>
[[nodiscard]] constexpr S sqr(S x) noexcept {
  return x * x;
}

/// sqrt that maps the small negative values of rounding to 0.
template <std::floating_point S>
[[nodiscard]] inline S safe_sqrt(S x) noexcept {
  return x > S(0) ? std::sqrt(x) : S(0);
}

template <std::floating_point S>
[[nodiscard]] inline bool is_finite(const Vec3<S>& v) noexcept {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

}  // namespace manylight
