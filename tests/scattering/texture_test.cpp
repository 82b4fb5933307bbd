// SPDX-License-Identifier: Apache-2.0
#include "manylight/scattering/texture.hpp"

#include <cmath>
#include <limits>
#include <memory>

#include <gtest/gtest.h>

namespace manylight::texture_test {
namespace {

template <class S>
class TextureTest : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(TextureTest, Scalars);

/// 3 x 2 texels, all different: value 10 * row + column in red, its square in green.
template <class S>
std::shared_ptr<const Texels<S>> numbered() {
  auto texels = std::make_shared<Texels<S>>();
  texels->width = 3;
  texels->height = 2;
  for (int row = 0; row < 2; ++row) {
    for (int column = 0; column < 3; ++column) {
      const S value = static_cast<S>(10 * row + column);
      texels->values.push_back({value, value * value, S(1)});
    }
  }
  return texels;
}

/// Plain definition of the wraps: walk from copy to copy.
int wrapped_index(int i, int n, TextureWrap wrap) {
  if (wrap == TextureWrap::clamp) return i < 0 ? 0 : i >= n ? n - 1 : i;
  bool mirrored = false;
  while (i < 0) i += n, mirrored = !mirrored;
  while (i >= n) i -= n, mirrored = !mirrored;
  return wrap == TextureWrap::mirror && mirrored ? n - 1 - i : i;
}

TYPED_TEST(TextureTest, ConstantIsTheSameEverywhere) {
  using S = TypeParam;
  const Texture<S> texture(Rgb<S>(S(0.1), S(0.2), S(0.3)));
  EXPECT_TRUE(texture.is_constant());
  EXPECT_EQ(texture.eval({S(-7), S(0.3)}), Rgb<S>(S(0.1), S(0.2), S(0.3)));
  EXPECT_EQ(texture.mean(), texture.eval({S(0), S(0)}));
  EXPECT_EQ(texture.maximum(), texture.mean());
}

// Oracle: the texel that holds the point, by index arithmetic. Planted bug that it caught: mirror without the -1.
TYPED_TEST(TextureTest, NearestFindsTheTexelInEveryWrap) {
  using S = TypeParam;
  for (const TextureWrap wrap : {TextureWrap::repeat, TextureWrap::clamp, TextureWrap::mirror}) {
    const auto texture = Texture<S>::bitmap(numbered<S>(), TextureFilter::nearest, wrap);
    for (int row = -5; row < 6; ++row) {
      for (int column = -8; column < 9; ++column) {
        const Vec2<S> center((static_cast<S>(column) + S(0.5)) / S(3), (static_cast<S>(row) + S(0.5)) / S(2));
        const int expected = 10 * wrapped_index(row, 2, wrap) + wrapped_index(column, 3, wrap);
        EXPECT_EQ(texture.eval(center).x, static_cast<S>(expected)) << row << ' ' << column;
      }
    }
  }
}

// Oracle: bilinear interpolation equals the texel at its centre and reproduces a linear ramp between centres.
// Planted bug that it caught: centres at i / width instead of (i + 1/2) / width.
TYPED_TEST(TextureTest, BilinearIsExactOnRamps) {
  using S = TypeParam;
  const auto texture = Texture<S>::bitmap(numbered<S>(), TextureFilter::bilinear, TextureWrap::clamp);
  const S tolerance = 32 * std::numeric_limits<S>::epsilon();  // a few roundings of values up to 12
  for (S t = 0; t <= S(1); t += S(0.125)) {
    const S u = (S(0.5) + S(2) * t) / S(3);  // from the first to the last centre
    EXPECT_NEAR(texture.eval({u, S(0.25)}).x, S(2) * t, 12 * tolerance);
    EXPECT_NEAR(texture.eval({u, S(0.5)}).x, S(2) * t + S(5), 12 * tolerance);
  }
  EXPECT_EQ(texture.eval({S(0), S(0)}).x, S(0)) << "clamped beyond the first centre";
}

TYPED_TEST(TextureTest, BilinearRepeatBlendsAcrossTheSeam) {
  using S = TypeParam;
  const auto texture = Texture<S>::bitmap(numbered<S>());
  const S seam = texture.eval({S(0), S(0.25)}).x;
  EXPECT_NEAR(seam, S(1), 64 * std::numeric_limits<S>::epsilon());  // (0 + 2) / 2, rounding of 1/3 steps
}

TYPED_TEST(TextureTest, MeanAndMaximumOfABitmap) {
  using S = TypeParam;
  const auto texture = Texture<S>::bitmap(numbered<S>());
  EXPECT_NEAR(texture.mean().x, S(6), 16 * std::numeric_limits<S>::epsilon());  // (0+1+2+10+11+12)/6
  EXPECT_EQ(texture.maximum(), Rgb<S>(S(12), S(144), S(1)));
  for (S u = S(-1); u < S(2); u += S(0.037)) {
    const Rgb<S> value = texture.eval({u, u * S(1.7)});
    for (int c = 0; c < 3; ++c) EXPECT_LE(value[c], texture.maximum()[c]);
  }
}

TYPED_TEST(TextureTest, CheckerboardAlternatesInHalves) {
  using S = TypeParam;
  const Rgb<S> first(S(0.2));
  const Rgb<S> second(S(0.4));
  const auto texture = Texture<S>::checkerboard(first, second);
  EXPECT_EQ(texture.eval({S(0.25), S(0.25)}), first);
  EXPECT_EQ(texture.eval({S(0.75), S(0.25)}), second);
  EXPECT_EQ(texture.eval({S(0.25), S(0.75)}), second);
  EXPECT_EQ(texture.eval({S(0.75), S(0.75)}), first);
  EXPECT_EQ(texture.eval({S(-0.25), S(0.25)}), second) << "left of 0 lies the right half of a square";
  EXPECT_NEAR(texture.mean().x, S(0.3), 4 * std::numeric_limits<S>::epsilon());
  EXPECT_FALSE(texture.is_constant());
}

TYPED_TEST(TextureTest, TransformAppliesBeforeTheLookup) {
  using S = TypeParam;
  const UvTransform<S> to_uv{S(2), S(0), S(0.5), S(0), S(3), S(0)};
  const auto moved = Texture<S>::bitmap(numbered<S>(), TextureFilter::nearest, TextureWrap::repeat, to_uv);
  const auto plain = Texture<S>::bitmap(numbered<S>(), TextureFilter::nearest, TextureWrap::repeat);
  for (S u = S(0.01); u < S(1); u += S(0.07)) {
    EXPECT_EQ(moved.eval({u, u / S(5)}), plain.eval({S(2) * u + S(0.5), S(3) * (u / S(5))}));
  }
}

TYPED_TEST(TextureTest, HugeAndUndefinedCoordinatesAreSafe) {
  using S = TypeParam;
  const S nan = std::numeric_limits<S>::quiet_NaN();
  const S huge = std::numeric_limits<S>::max();
  for (const auto& texture : {Texture<S>::bitmap(numbered<S>()), Texture<S>::checkerboard(Rgb<S>(0), Rgb<S>(1))}) {
    for (const S bad : {nan, huge, -huge, k_infinity<S>, S(1e9)}) {
      EXPECT_TRUE(is_finite(texture.eval({bad, S(0.5)})));
      EXPECT_TRUE(is_finite(texture.eval({S(0.5), bad})));
    }
  }
}

TYPED_TEST(TextureTest, RejectsBitmapsThatDoNotFit) {
  using S = TypeParam;
  EXPECT_THROW(static_cast<void>(Texture<S>::bitmap(nullptr)), ParameterError);
  auto texels = std::make_shared<Texels<S>>(*numbered<S>());
  texels->values.pop_back();
  EXPECT_THROW(static_cast<void>(Texture<S>::bitmap(texels)), ParameterError);
}

}  // namespace
}  // namespace manylight::texture_test
