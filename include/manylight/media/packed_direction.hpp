// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "manylight/core/vector.hpp"

namespace manylight {

/// A unit vector in 3 bytes: octahedral map, 12 bits per coordinate, at most 0.06 degrees off [Cigolle 2014, Sec. 3].
class PackedDirection {
 public:
  PackedDirection() = default;
  /// `w` finite and not 0; its length does not matter.
  template <std::floating_point S>
  explicit PackedDirection(const Vec3<S>& w) noexcept {
    const Vec3<double> d(w);
    const double norm = std::abs(d.x) + std::abs(d.y) + std::abs(d.z);
    Vec2<double> p(d.x / norm, d.y / norm);
    if (d.z < 0) p = folded(p);
    const std::uint32_t x = quantized(p.x);
    const std::uint32_t y = quantized(p.y);
    bytes_ = {static_cast<std::uint8_t>(x & 0xFFU), static_cast<std::uint8_t>((x >> 8U) | ((y & 0xFU) << 4U)),
              static_cast<std::uint8_t>(y >> 4U)};
  }

  template <std::floating_point S>
  [[nodiscard]] Vec3<S> unpack() const noexcept {
    const std::uint32_t x = bytes_[0] | ((bytes_[1] & 0xFU) << 8U);
    const std::uint32_t y = (std::uint32_t{bytes_[1]} >> 4U) | (std::uint32_t{bytes_[2]} << 4U);
    Vec2<S> p(static_cast<S>(x) / S(2047) - S(1), static_cast<S>(y) / S(2047) - S(1));
    const S z = S(1) - std::abs(p.x) - std::abs(p.y);
    if (z < S(0)) p = folded(p);
    return glm::normalize(Vec3<S>(p.x, p.y, z));
  }

 private:
  /// The lower half of the sphere lies outside of the square of the upper one, and back.
  template <std::floating_point S>
  [[nodiscard]] static Vec2<S> folded(const Vec2<S>& p) noexcept {
    return {std::copysign(S(1) - std::abs(p.y), p.x), std::copysign(S(1) - std::abs(p.x), p.y)};
  }
  /// 0 to 4094, so that 0 has a code of its own, 2047: axes of the frame are exact.
  [[nodiscard]] static std::uint32_t quantized(double x) noexcept {
    return static_cast<std::uint32_t>(std::clamp(std::lround((x + 1.0) * 2047.0), 0L, 4094L));
  }

  std::array<std::uint8_t, 3> bytes_{0xFF, 0xF7, 0x7F};  // +z
};
static_assert(sizeof(PackedDirection) == 3);

}  // namespace manylight
