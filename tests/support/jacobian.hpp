// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "manylight/core/vector.hpp"

namespace manylight::test {

/// The density that a sampling map [0,1)^2 -> sphere has at `u` by the change of variables, 1 / |dw/du x dw/dv|, from
/// central differences of step `h` (truncation error of order h^2). None if a neighbour is no direction.
/// `map`: Vec2<double> -> optional<Vec3<double>>.
template <class Map>
[[nodiscard]] std::optional<double> density_by_jacobian(const Map& map, const Vec2<double>& u, double h) {
  const auto left = map(u - Vec2<double>(h, 0));
  const auto right = map(u + Vec2<double>(h, 0));
  const auto below = map(u - Vec2<double>(0, h));
  const auto above = map(u + Vec2<double>(0, h));
  if (!left || !right || !below || !above) return std::nullopt;
  const double area = glm::length(glm::cross(*right - *left, *above - *below)) / (4.0 * h * h);
  if (!(area > 0.0)) return std::nullopt;
  return 1.0 / area;
}

/// Is `u` clear of the concentric disk map's creases (its two diagonals and axes), where it is not differentiable?
[[nodiscard]] inline bool clear_of_creases(const Vec2<double>& u, double margin = 0.02) {
  const double x = std::abs(2.0 * u.x - 1.0);
  const double y = std::abs(2.0 * u.y - 1.0);
  return std::abs(x - y) > margin && std::min(x, y) > margin && std::max(x, y) < 1.0 - margin;
}

}  // namespace manylight::test
