// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <glm/common.hpp>

#include "manylight/core/error.hpp"
#include "manylight/core/spectrum.hpp"
#include "manylight/core/vector.hpp"

namespace manylight {

/// Values of a bitmap, linear; row 0 is reached by v in [0, 1/height), column 0 by u in [0, 1/width).
template <std::floating_point S>
struct Texels {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<Rgb<S>> values;  ///< width * height, row by row
};

/// Lookup between texels, whose centres lie at (i + 1/2) / width. `nearest`: the texel that holds the point.
enum class TextureFilter : std::uint8_t { nearest, bilinear };

/// What lies outside of [0, 1): copies, the border texel, or copies mirrored in turn.
enum class TextureWrap : std::uint8_t { repeat, clamp, mirror };

/// Affine map of texture coordinates: (u, v) -> (xx u + xy v + x0, yx u + yy v + y0).
template <std::floating_point S>
struct UvTransform {
  S xx = S(1), xy = S(0), x0 = S(0);
  S yx = S(0), yy = S(1), y0 = S(0);

  [[nodiscard]] constexpr Vec2<S> operator()(const Vec2<S>& uv) const noexcept {
    return {xx * uv.x + xy * uv.y + x0, yx * uv.x + yy * uv.y + y0};
  }
};

/// A colour (or a parameter, in all three channels) over texture coordinates: a constant, a bitmap or a checkerboard.
/// Cheap to copy: bitmaps are shared. Immutable, so that threads may share it.
template <std::floating_point S>
class Texture {
 public:
  using Scalar = S;

  /// The same value everywhere.
  Texture(const Rgb<S>& value = Rgb<S>(0)) noexcept : first_(value), second_(value), mean_(value), maximum_(value) {}
  explicit Texture(S value) noexcept : Texture(Rgb<S>(value)) {}

  /// Throws ParameterError for no texels, or as many values as do not fit the sides.
  [[nodiscard]] static Texture bitmap(std::shared_ptr<const Texels<S>> texels,
                                      TextureFilter filter = TextureFilter::bilinear,
                                      TextureWrap wrap = TextureWrap::repeat, const UvTransform<S>& to_uv = {});

  /// Squares of side 1/2: `first` where both coordinates lie in the same half of their period, else `second`.
  [[nodiscard]] static Texture checkerboard(const Rgb<S>& first, const Rgb<S>& second,
                                            const UvTransform<S>& to_uv = {}) noexcept;

  /// The value at `uv`; a coordinate that is not finite counts as 0.
  [[nodiscard]] Rgb<S> eval(const Vec2<S>& uv) const noexcept;
  /// Derivatives of the value's luminance by u and v: of the bilinear surface between texels; 0 where the texture is
  /// constant by pieces.
  [[nodiscard]] Vec2<S> gradient(const Vec2<S>& uv) const noexcept;
  /// Average over one period, per channel.
  [[nodiscard]] const Rgb<S>& mean() const noexcept { return mean_; }
  /// Largest value per channel: no lookup is above it.
  [[nodiscard]] const Rgb<S>& maximum() const noexcept { return maximum_; }
  [[nodiscard]] bool is_constant() const noexcept { return kind_ == Kind::constant; }

 private:
  enum class Kind : std::uint8_t { constant, bitmap, checkerboard };

  /// Four neighbouring texels and where between them a point lies.
  struct Cell {
    Rgb<S> c00, c10, c01, c11;  ///< column, then row
    S s, t;                     ///< to the next column and row, [0, 1)
  };

  /// `uv` mapped, without what would overflow an integer.
  [[nodiscard]] Vec2<S> mapped(const Vec2<S>& uv) const noexcept;
  [[nodiscard]] Cell cell(const Vec2<S>& at) const noexcept;
  [[nodiscard]] Rgb<S> eval_bitmap(const Vec2<S>& at) const noexcept;
  [[nodiscard]] const Rgb<S>& texel(std::int64_t x, std::int64_t y) const noexcept;
  [[nodiscard]] static std::int64_t wrapped(std::int64_t i, std::int64_t n, TextureWrap wrap) noexcept;
  void summarise_bitmap();

  Kind kind_ = Kind::constant;
  TextureFilter filter_ = TextureFilter::bilinear;
  TextureWrap wrap_ = TextureWrap::repeat;
  UvTransform<S> to_uv_;
  Rgb<S> first_;
  Rgb<S> second_;
  Rgb<S> mean_;
  Rgb<S> maximum_;
  std::shared_ptr<const Texels<S>> texels_;
};

template <std::floating_point S>
Texture<S> Texture<S>::bitmap(std::shared_ptr<const Texels<S>> texels, TextureFilter filter, TextureWrap wrap,
                              const UvTransform<S>& to_uv) {
  const std::size_t area = texels ? std::size_t{texels->width} * texels->height : 0;
  require(area > 0, "number of texels", area, "1 or more");
  require(texels->values.size() == area, "number of texel values", texels->values.size(),
          "width * height = " + std::to_string(area));
  Texture result;
  result.kind_ = Kind::bitmap;
  result.filter_ = filter;
  result.wrap_ = wrap;
  result.to_uv_ = to_uv;
  result.texels_ = std::move(texels);
  result.summarise_bitmap();
  return result;
}

template <std::floating_point S>
Texture<S> Texture<S>::checkerboard(const Rgb<S>& first, const Rgb<S>& second, const UvTransform<S>& to_uv) noexcept {
  Texture result(first);
  result.kind_ = Kind::checkerboard;
  result.second_ = second;
  result.to_uv_ = to_uv;
  result.mean_ = (first + second) * S(0.5);
  result.maximum_ = glm::max(first, second);
  return result;
}

template <std::floating_point S>
void Texture<S>::summarise_bitmap() {
  glm::vec<3, double, glm::defaultp> sum(0.0);
  Rgb<S> maximum = texels_->values.front();
  for (const Rgb<S>& value : texels_->values) {
    sum += glm::vec<3, double, glm::defaultp>(value);
    maximum = glm::max(maximum, value);
  }
  mean_ = Rgb<S>(sum / static_cast<double>(texels_->values.size()));
  maximum_ = maximum;
}

template <std::floating_point S>
Rgb<S> Texture<S>::eval(const Vec2<S>& uv) const noexcept {
  if (kind_ == Kind::constant) return first_;
  const Vec2<S> at = mapped(uv);
  if (kind_ == Kind::bitmap) return eval_bitmap(at);
  const bool right = at.x - std::floor(at.x) >= S(0.5);
  const bool upper = at.y - std::floor(at.y) >= S(0.5);
  return right == upper ? first_ : second_;
}

template <std::floating_point S>
Vec2<S> Texture<S>::gradient(const Vec2<S>& uv) const noexcept {
  if (kind_ != Kind::bitmap || filter_ == TextureFilter::nearest) return Vec2<S>(S(0));
  const Cell c = cell(mapped(uv));
  const S along_x = luminance((c.c10 - c.c00) * (S(1) - c.t) + (c.c11 - c.c01) * c.t) * static_cast<S>(texels_->width);
  const S along_y = luminance((c.c01 - c.c00) * (S(1) - c.s) + (c.c11 - c.c10) * c.s) * static_cast<S>(texels_->height);
  return {along_x * to_uv_.xx + along_y * to_uv_.yx, along_x * to_uv_.xy + along_y * to_uv_.yy};
}

template <std::floating_point S>
Vec2<S> Texture<S>::mapped(const Vec2<S>& uv) const noexcept {
  Vec2<S> at = to_uv_(uv);
  // Beyond 2^30 no fraction of a period is left in float; such a coordinate (or NaN) must not overflow an integer.
  if (!(std::abs(at.x) < S(1 << 30))) at.x = S(0);
  if (!(std::abs(at.y) < S(1 << 30))) at.y = S(0);
  return at;
}

template <std::floating_point S>
typename Texture<S>::Cell Texture<S>::cell(const Vec2<S>& at) const noexcept {
  const S x = at.x * static_cast<S>(texels_->width) - S(0.5);
  const S y = at.y * static_cast<S>(texels_->height) - S(0.5);
  const S x_floor = std::floor(x);
  const S y_floor = std::floor(y);
  const auto column = static_cast<std::int64_t>(x_floor);
  const auto row = static_cast<std::int64_t>(y_floor);
  return {texel(column, row),
          texel(column + 1, row),
          texel(column, row + 1),
          texel(column + 1, row + 1),
          x - x_floor,
          y - y_floor};
}

template <std::floating_point S>
Rgb<S> Texture<S>::eval_bitmap(const Vec2<S>& at) const noexcept {
  if (filter_ == TextureFilter::nearest) {
    return texel(static_cast<std::int64_t>(std::floor(at.x * static_cast<S>(texels_->width))),
                 static_cast<std::int64_t>(std::floor(at.y * static_cast<S>(texels_->height))));
  }
  const Cell c = cell(at);
  const Rgb<S> low = c.c00 * (S(1) - c.s) + c.c10 * c.s;
  const Rgb<S> high = c.c01 * (S(1) - c.s) + c.c11 * c.s;
  return glm::min(low * (S(1) - c.t) + high * c.t, maximum_);  // rounding must not lift a weighted mean above its terms
}

template <std::floating_point S>
const Rgb<S>& Texture<S>::texel(std::int64_t x, std::int64_t y) const noexcept {
  const auto column = static_cast<std::size_t>(wrapped(x, texels_->width, wrap_));
  const auto row = static_cast<std::size_t>(wrapped(y, texels_->height, wrap_));
  return texels_->values[row * texels_->width + column];
}

template <std::floating_point S>
std::int64_t Texture<S>::wrapped(std::int64_t i, std::int64_t n, TextureWrap wrap) noexcept {
  if (i >= 0 && i < n) return i;
  if (wrap == TextureWrap::clamp) return i < 0 ? 0 : n - 1;
  const std::int64_t period = wrap == TextureWrap::mirror ? 2 * n : n;
  const std::int64_t inside = ((i % period) + period) % period;
  return inside < n ? inside : period - 1 - inside;
}

}  // namespace manylight
