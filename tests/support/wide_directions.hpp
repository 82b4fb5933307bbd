// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <random>

#include "manylight/core/direction_cone.hpp"

// Random directions in long double, against which code in single and double precision is judged.

namespace manylight::test {

using Wide = long double;
using WideVec = glm::vec<3, long double, glm::defaultp>;

class WideRandom {
 public:
  explicit WideRandom(std::uint64_t seed) : random_(seed) {}

  Wide uniform(Wide lo = 0, Wide hi = 1) { return lo + (hi - lo) * std::uniform_real_distribution<double>()(random_); }
  /// At `angle` from the unit `axis`, random azimuth.
  WideVec around(const WideVec& axis, Wide angle) {
    const WideVec other = std::abs(axis.x) < 0.5L ? WideVec(1, 0, 0) : WideVec(0, 1, 0);
    const WideVec s = glm::normalize(glm::cross(axis, other));
    const WideVec t = glm::cross(axis, s);
    const Wide phi = uniform(0, 2 * 3.14159265358979323846L);
    return axis * std::cos(angle) + (s * std::cos(phi) + t * std::sin(phi)) * std::sin(angle);
  }
  /// A direction of the cone, on its rim half of the time (where bounds are tight).
  template <class S>
  WideVec inside(const DirectionCone<S>& c) {
    const Wide half = std::atan2(Wide(c.sin_half), Wide(c.cos_half));
    return around(glm::normalize(WideVec(c.axis)), uniform() < 0.5L ? half : half * uniform());
  }

 private:
  std::mt19937_64 random_;
};

[[nodiscard]] inline Wide wide_angle(const WideVec& a, const WideVec& b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

}  // namespace manylight::test
