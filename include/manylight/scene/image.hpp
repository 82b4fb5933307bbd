// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "manylight/core/config.hpp"
#include "manylight/core/error.hpp"
#include "manylight/core/spectrum.hpp"

namespace manylight {

/// Longest side of an image, pixels: 16 bits are what the common file formats and 32-bit pixel ids can hold.
inline constexpr std::size_t k_max_image_side = 65'535;

/// Row-major RGB image, linear; row 0 is the top, pixel (0, 0) the top-left one.
template <std::floating_point S>
struct Image {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<Rgb<S>> pixels;  ///< width * height values, row by row

  Image() = default;
  /// An image of one colour. Throws ParameterError unless both sides lie in [1, k_max_image_side].
  Image(std::size_t w, std::size_t h, const Rgb<S>& fill = Rgb<S>(0))
      : width(checked_side("image width", w)), height(checked_side("image height", h)), pixels(w * h, fill) {}
  /// Takes over `values`. Throws ParameterError unless the sides are allowed and there are w * h values.
  Image(std::size_t w, std::size_t h, std::vector<Rgb<S>> values)
      : width(checked_side("image width", w)), height(checked_side("image height", h)), pixels(std::move(values)) {
    require(pixels.size() == w * h, "number of pixel values", pixels.size(),
            "width * height = " + std::to_string(w * h));
  }

  [[nodiscard]] bool empty() const noexcept { return pixels.empty(); }
  [[nodiscard]] std::size_t index(std::uint32_t x, std::uint32_t y) const noexcept {
    MANYLIGHT_ASSERT(x < width && y < height);
    return static_cast<std::size_t>(y) * width + x;
  }
  [[nodiscard]] const Rgb<S>& at(std::uint32_t x, std::uint32_t y) const noexcept { return pixels[index(x, y)]; }
  [[nodiscard]] Rgb<S>& at(std::uint32_t x, std::uint32_t y) noexcept { return pixels[index(x, y)]; }

 private:
  static std::uint32_t checked_side(const char* element, std::size_t side) {
    require(side >= 1 && side <= k_max_image_side, element, side, "1 to 65535 pixels");
    return static_cast<std::uint32_t>(side);
  }
};

}  // namespace manylight
