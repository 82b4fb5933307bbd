// SPDX-License-Identifier: Apache-2.0
// Stability case 3: a light on, or next to, the sensor. Oracle: the product written out in long double, whose exponent
// does not overflow here, against the largest float.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "manylight/path/four_constraints.hpp"
#include "manylight/path/transfer.hpp"
#include "support/random_vertices.hpp"

namespace manylight::transfer_test {
namespace {

using S = float;
using test::Gloss;
using TestScene = test::MixedScene<S>;

constexpr long double k_largest = std::numeric_limits<S>::max();

long double widest(const Rgb<S>& c) { return static_cast<long double>(max_channel(c)); }

/// Pairs at `distance`, both sides facing each other, under the weighting W with the clamp `c_clamp`.
template <class W>
void check_pairs(float distance, float c_clamp) {
  test::RandomVertices<S> random(31);
  const W weighting(WeightingConfig<S>{c_clamp, 1, 1, 100});
  for (int n = 0; n < 2000; ++n) {
    const Vec3<S> axis = random.direction();
    Sensor<TestScene, W> sensor{random.surface(Vec3<S>(0), axis, Gloss::some), weighting.start()};
    sensor.vertex.strength = random.color(0.1, 1);
    auto light = random.surface(axis * distance, -axis, Gloss::some);
    light.strength = random.color(10, 100);
    light.exact = random.chance(0.3);
    const Transfer<S> transfer = unoccluded_transfer<TestScene>(weighting, sensor, light, S(1), 100);
    ASSERT_TRUE(is_valid_radiance(transfer.value));
    const Rgb<S> contribution = sensor.vertex.strength * transfer.value * light.strength;
    ASSERT_TRUE(is_finite(contribution * S(1e12))) << "a pixel is a sum of many";
    const Pair<S> pair = connect(sensor.vertex, light, S(1));
    const long double m_t_d = widest(pair.m) * static_cast<long double>(pair.t) * widest(pair.d);
    if (m_t_d > 2 * k_largest) {  // 2: rounding decides at the border itself
      ASSERT_EQ(widest(transfer.value), 0) << "what overflows carries nothing";
    }
    if (!light.exact) {
      ASSERT_LE(widest(transfer.value), static_cast<long double>(c_clamp) * 1.00001L);  // rounding of a product
    }
    if (distance >= 1e-12F && m_t_d > 0 && !pair.is_zero()) {
      // Far from overflow nothing is lost: S <= 1, I <= 100, and 2^40 of them stay below 3e38 for M T D < 1e24.
      const bool counts = m_t_d < 1e24L;
      if (counts) {
        ASSERT_TRUE(transfer.is_valid);
      }
      if (counts && c_clamp == k_infinity<S> && widest(pair.d) <= 1) {
        ASSERT_GT(widest(transfer.value), 0);
      }
    }
  }
}

// Distances: coincident, square below the smallest float, products M T D around the largest one, and far from it.
// Planted bugs seen to fail: what overflows set to the clamp (exact lights then carry C_clamp); S and I left out of the
// test for a finite product.
TEST(Transfer, CoincidentAndNearlyCoincidentPairsAreFinite) {
  for (const float distance : {0.0F, 1e-25F, 1.1e-19F, 1e-18F, 1e-17F, 1e-12F, 1e-6F}) {
    for (const float c_clamp : {1.0F, k_infinity<S>}) {
      check_pairs<StandardWeighting<S>>(distance, c_clamp);
      check_pairs<FourConstraints<S>>(distance, c_clamp);
    }
  }
}

}  // namespace
}  // namespace manylight::transfer_test
