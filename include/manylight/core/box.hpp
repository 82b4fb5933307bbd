// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/common.hpp>

#include "manylight/core/vector.hpp"

namespace manylight {

/// Axis-aligned box, closed. Default-constructed it is empty (lo > hi) and the neutral element of `extend`.
template <std::floating_point S>
struct Box {
  Vec3<S> lo{k_infinity<S>};
  Vec3<S> hi{-k_infinity<S>};

  void extend(const Vec3<S>& p) noexcept {
    lo = glm::min(lo, p);
    hi = glm::max(hi, p);
  }
  void extend(const Box& other) noexcept {
    lo = glm::min(lo, other.lo);
    hi = glm::max(hi, other.hi);
  }
  [[nodiscard]] bool is_empty() const noexcept { return lo.x > hi.x || lo.y > hi.y || lo.z > hi.z; }
  [[nodiscard]] Vec3<S> center() const noexcept { return lo + (hi - lo) * S(0.5); }
  [[nodiscard]] Vec3<S> extent() const noexcept { return is_empty() ? Vec3<S>(0) : hi - lo; }
  [[nodiscard]] S diagonal() const noexcept { return glm::length(extent()); }
  [[nodiscard]] S half_area() const noexcept {
    const Vec3<S> e = extent();
    return e.x * e.y + e.y * e.z + e.z * e.x;
  }
  [[nodiscard]] bool contains(const Vec3<S>& p) const noexcept {
    return p.x >= lo.x && p.y >= lo.y && p.z >= lo.z && p.x <= hi.x && p.y <= hi.y && p.z <= hi.z;
  }
};

}  // namespace manylight
