// SPDX-License-Identifier: Apache-2.0
// Oracle: the pattern itself at random vectors of random boxes. Deterministic seed; no statistics.

#include "manylight/bounds/cube_map.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "manylight/bounds/sensor_map.hpp"
#include "manylight/scattering/lambertian.hpp"
#include "manylight/scattering/phong.hpp"

namespace manylight::cube_map_test {
namespace {

template <class S>
class CubeMaps : public ::testing::Test {
 public:
  std::mt19937_64 random{53};
  S uniform(S lo = 0, S hi = 1) {
    return lo + (hi - lo) * static_cast<S>(static_cast<double>(random() >> 11) * 0x1p-53);
  }
  Vec3<S> direction() {
    const S z = uniform(-1, 1);
    const S phi = uniform(0, S(2) * k_pi<S>);
    const S r = std::sqrt(S(1) - z * z);
    return glm::normalize(Vec3<S>(r * std::cos(phi), r * std::sin(phi), z));
  }
  /// Of any size, around a direction or the origin; some touch a coordinate plane, some are flat.
  Box<S> box(const Vec3<S>& axis) {
    Box<S> b;
    const S size = std::pow(S(10), uniform(-4, 0.5));
    const Vec3<S> center = uniform() < S(0.1) ? Vec3<S>(0) : axis;
    for (int i = 0; i < 3; ++i) {
      const S half = uniform() < S(0.1) ? S(0) : size * uniform();
      b.lo[i] = center[i] - half;
      b.hi[i] = center[i] + half;
      if (uniform() < S(0.1)) (uniform() < S(0.5) ? b.lo[i] : b.hi[i]) = S(0);
      if (b.lo[i] > b.hi[i]) std::swap(b.lo[i], b.hi[i]);
    }
    return b;
  }
  Vec3<S> member(const Box<S>& b) {
    Vec3<S> p;
    for (int i = 0; i < 3; ++i) {
      const S u = uniform() < S(0.3) ? (uniform() < S(0.5) ? S(0) : S(1)) : uniform();
      p[i] = b.lo[i] + (b.hi[i] - b.lo[i]) * u;
    }
    return p;
  }
};
using Scalars = ::testing::Types<float, double>;
TYPED_TEST_SUITE(CubeMaps, Scalars);

/// f |cos| of a material, in a frame of its own.
template <class M>
struct Pattern {
  using S = typename M::Scalar;
  M material;
  Frame<S> frame;
  Vec3<S> wo;

  CubeMap<S> map(std::uint32_t nodes) const {
    CubeMap<S> m;
    CubeMapBounds<> bounds;
    bounds.limits.nodes = nodes;
    build_sensor_map(bounds, material, frame, wo, S(1), m);
    return m;
  }
  S at(const Vec3<S>& wi) const {
    const Vec3<S> local = frame.to_local(wi);
    return max_channel(material.eval(local, frame.to_local(wo))) * std::abs(local.z);
  }
};
template <class M>
Pattern<M> random_pattern(CubeMaps<typename M::Scalar>& test, const M& material) {
  using S = typename M::Scalar;
  Pattern<M> p{material, Frame<S>(test.direction()), {}};
  p.wo = glm::normalize(p.frame.n + S(0.9) * test.direction());
  return p;
}

// Planted bugs seen to fail: the merged maximum taken from one map; a quotient by the wrong end of the range along the
// axis; groups collapsed to 0.9 of their maximum; cells enclosed by cones of half the width.
TYPED_TEST(CubeMaps, HoldForAllVectorsOfABox) {
  using S = TypeParam;
  int positive = 0;
  for (int round = 0; round < 60; ++round) {
    const auto glossy = random_pattern<Phong<S>>(*this, {Rgb<S>(S(0.5)), S(round)});
    const auto diffuse = random_pattern<Lambertian<S>>(*this, {Rgb<S>(S(0.8))});
    const CubeMap<S> a = glossy.map(64);
    const CubeMap<S> b = diffuse.map(64);
    CubeMap<S> both;
    both.merge(a, b, 40);
    ASSERT_LE(a.size(), 64u);
    ASSERT_LE(both.size(), 40u);
    for (int i = 0; i < 400; ++i) {
      const Vec3<S> lobe = glossy.frame.to_world(mirror(glossy.frame.to_local(glossy.wo)));
      const Box<S> box = this->box(i % 2 == 0 ? this->direction() : lobe);
      const S of_a = a.sup(box);
      const S of_b = b.sup(box);
      const S of_both = both.sup(box);
      ASSERT_GE(of_both, std::max(of_a, of_b)) << "merging never lowers a bound";
      ASSERT_LE(of_a, a.max());
      for (int k = 0; k < 20; ++k) {
        const Vec3<S> v = this->member(box);
        if (!(glm::length(v) > S(1e-6))) continue;
        const Vec3<S> wi = glm::normalize(v);
        const S rounding = S(64) * std::numeric_limits<S>::epsilon() * (S(1) + S(round));  // of wi on the lobe
        positive += glossy.at(wi) > S(0) ? 1 : 0;
        ASSERT_LE(glossy.at(wi), of_a * (S(1) + rounding) + std::numeric_limits<S>::epsilon()) << round << ' ' << i;
        ASSERT_LE(diffuse.at(wi), of_b * (S(1) + rounding) + std::numeric_limits<S>::epsilon()) << round << ' ' << i;
      }
    }
  }
  EXPECT_GT(positive, 50000);
}

// More nodes, tighter bounds: mean of bound over the mean of the largest values of 200 vectors. A map that never split
// would pass the test above.
TYPED_TEST(CubeMaps, TightenWithTheirSize) {
  using S = TypeParam;
  double slack[3] = {0, 0, 0};
  double values = 0;
  const std::uint32_t sizes[3] = {6, 64, 512};
  for (int round = 0; round < 40; ++round) {
    const auto glossy = random_pattern<Phong<S>>(*this, {Rgb<S>(S(0.5)), S(40)});
    const CubeMap<S> maps[3] = {glossy.map(sizes[0]), glossy.map(sizes[1]), glossy.map(sizes[2])};
    for (int i = 0; i < 50; ++i) {
      const Vec3<S> center = this->direction();
      const Box<S> box{center - S(0.05), center + S(0.05)};
      S most = S(0);
      for (int k = 0; k < 200; ++k) most = std::max(most, glossy.at(glm::normalize(this->member(box))));
      values += static_cast<double>(most);
      for (int m = 0; m < 3; ++m) slack[m] += static_cast<double>(maps[m].sup(box));
    }
  }
  for (int m = 0; m < 3; ++m) {
    ::testing::Test::RecordProperty("slack_with_" + std::to_string(sizes[m]) + "_nodes",
                                    std::to_string(slack[m] / values));
  }
  EXPECT_LT(slack[1], 0.5 * slack[0]);
  EXPECT_LT(slack[2], slack[1]);
  EXPECT_LT(slack[2], 1.6 * values) << slack[0] / values << ' ' << slack[1] / values << ' ' << slack[2] / values;
}

}  // namespace
}  // namespace manylight::cube_map_test
