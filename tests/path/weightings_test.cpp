// SPDX-License-Identifier: Apache-2.0
// What every weighting promises, on random paths against the rules as they are defined (weight_oracle.hpp).

#include <gtest/gtest.h>

#include <array>
#include <type_traits>

#include "manylight/path/four_constraints.hpp"
#include "manylight/path/kollig_keller.hpp"
#include "path/weight_oracle.hpp"

namespace manylight::weightings_test {
namespace {

using namespace test;  // NOLINT: the oracle's own names

/// A weighting with its oracle: weights and the weight of a hit.
struct Standard {
  using W = StandardWeighting<double>;
  static std::vector<double> slow(const Path& p, const WeightingConfig<double>& c) {
    return first_vertex_weights(p, c);
  }
  static double slow_hit(const Path& p, const WeightingConfig<double>&) {
    return all_dirac_before(p, p.length()) ? 1 : 0;
  }
  static constexpr bool k_is_unbiased = false;
};
struct Four {
  using W = FourConstraints<double>;
  static std::vector<double> slow(const Path& p, const WeightingConfig<double>& c) { return weights(p, c); }
  static double slow_hit(const Path& p, const WeightingConfig<double>& c) { return hit_weight(p, c); }
  static constexpr bool k_is_unbiased = false;
};
/// 1 - sum of the weights, or nothing where only hits after mirrors count.
double rest_of(const Path& p, const WeightingConfig<double>& c, const std::vector<double>& w) {
  if (all_dirac_before(p, p.length())) return 1;
  return c.hits == EmitterHits::all ? 1 - sum_of(w) : 0;
}
struct Residual {
  using W = ResidualWeighting<double>;
  static std::vector<double> slow(const Path& p, const WeightingConfig<double>& c) { return residual_weights(p, c); }
  static double slow_hit(const Path& p, const WeightingConfig<double>& c) { return rest_of(p, c, slow(p, c)); }
  static constexpr bool k_is_unbiased = true;
};
struct StickBreaking {
  using W = KolligKeller<double>;
  static std::vector<double> slow(const Path& p, const WeightingConfig<double>& c) {
    return stick_breaking_weights(p, c);
  }
  static double slow_hit(const Path& p, const WeightingConfig<double>& c) { return rest_of(p, c, slow(p, c)); }
  static constexpr bool k_is_unbiased = true;
};

/// Random configurations and paths: half of them without mirrors, a third ending on an exact light, some without
/// limits.
struct Draw {
  WeightingConfig<double> config;
  Path path;
};
Draw draw(Random& random, int n) {
  Draw out{random.config(), random.path(2 + static_cast<std::size_t>(random.uniform() * 6), n % 2 == 0 ? 0.0 : 0.25)};
  out.path.exact_light = n % 3 == 0;
  if (n % 7 == 0) out.config.hits = EmitterHits::after_dirac;
  if (n % 11 == 0) out.config.c_d = out.config.c_v = k_inf;
  return out;
}

template <class T>
class Weightings : public ::testing::Test {};
using All = ::testing::Types<Standard, Four, Residual, StickBreaking>;
TYPED_TEST_SUITE(Weightings, All);

// O-18. Planted bugs seen to fail: KolligKeller's `left` without the last factor; its product with the light's pattern
// in place of the vertex' own; ResidualWeighting with c_m = inf instead of c_v = inf; a hit weight without
// `only_dirac`.
TYPED_TEST(Weightings, ConstantSizeRecordsEqualTheFullRecursion) {
  Random random{std::mt19937_64(31)};
  int partial = 0;
  for (int n = 0; n < 20000; ++n) {
    const auto [config, path] = draw(random, n);
    const typename TypeParam::W weighting(config);
    const std::vector<double> expected = TypeParam::slow(path, config);
    for (std::size_t k = 1; k < path.length(); ++k) {
      if (!connects(path, k)) continue;
      const double fast = weighting.weight(record_at(weighting, path, k), pair_at(path, k));
      ASSERT_NEAR(fast, expected[k], 1e-12) << "path " << n << " generator " << k;  // same formulas, other order
      partial += expected[k] > 0 && expected[k] < 1 ? 1 : 0;
    }
    const std::size_t l = path.length();
    const double hit = weighting.hit_weight(record_at(weighting, path, l), path.d[l]);
    if (!path.exact_light) {
      ASSERT_NEAR(hit, TypeParam::slow_hit(path, config), 1e-12) << "path " << n;
    }
  }
  EXPECT_GT(partial, 3000);
}

// No path is counted more than once; by unbiased rules with emitter hits exactly once.
TYPED_TEST(Weightings, SumToAtMostOneAndToOneWithoutBias) {
  Random random{std::mt19937_64(32)};
  for (int n = 0; n < 20000; ++n) {
    const auto [config, path] = draw(random, n);
    const typename TypeParam::W weighting(config);
    double sum = 0;
    for (std::size_t k = 1; k < path.length(); ++k) {
      if (!connects(path, k)) continue;
      const double w = weighting.weight(record_at(weighting, path, k), pair_at(path, k));
      ASSERT_GE(w, 0.0);
      sum += w;
    }
    ASSERT_LE(sum, 1 + 1e-12);  // rounding of the sum
    if (path.exact_light) continue;
    const std::size_t l = path.length();
    sum += weighting.hit_weight(record_at(weighting, path, l), path.d[l]);
    ASSERT_LE(sum, 1 + 1e-12);
    if (TypeParam::k_is_unbiased && config.hits == EmitterHits::all) {
      ASSERT_NEAR(sum, 1.0, 1e-12);
    }
  }
}

// The binding constraint is the one whose removal would let the weight grow, by the definitions of the four. Planted
// bugs seen to fail: clamp and diffuse limit exchanged; variance asked before energy.
TYPED_TEST(Weightings, BindingConstraintIsTheSmallest) {
  Random random{std::mt19937_64(33)};
  std::array<int, 4> counts{};
  for (int n = 0; n < 20000; ++n) {
    const auto [config, path] = draw(random, n);
    const typename TypeParam::W weighting(config);
    const std::vector<double> w = TypeParam::slow(path, config);
    double sum = 0;
    for (std::size_t k = 1; k < path.length(); sum += w[k], ++k) {
      if (!connects(path, k)) continue;
      const Constraint binding = weighting.binding(record_at(weighting, path, k), pair_at(path, k));
      ++counts[static_cast<std::size_t>(binding)];
      const double clamp = clamp_of(path, config, k);
      const double diffuse = diffuse_of(path, config, k);
      const double rounding = 1e-12;
      const bool no_generator = std::is_same_v<TypeParam, Standard> && !all_dirac_before(path, k);
      if (no_generator) {
        ASSERT_EQ(binding, Constraint::energy);
      } else if (binding == Constraint::energy) {
        ASSERT_NEAR(w[k], 1 - sum, rounding) << "path " << n << " generator " << k;
      } else if (binding == Constraint::variance) {
        ASSERT_LE(mu(path, config, k) - sum, w[k] + rounding);
        ASSERT_LT(mu(path, config, k), 1.0);
      } else if (std::is_same_v<TypeParam, StickBreaking>) {
        ASSERT_LE(binding == Constraint::clamp ? clamp : diffuse, (binding == Constraint::clamp ? diffuse : clamp));
        ASSERT_LT(w[k], 1 - sum);
      } else {
        ASSERT_NEAR(binding == Constraint::clamp ? clamp : diffuse, w[k], rounding)
            << "path " << n << " generator " << k;
      }
    }
  }
  for (const Constraint c : {Constraint::energy, Constraint::clamp, Constraint::diffuse_light}) {
    EXPECT_GT(counts[static_cast<std::size_t>(c)], 1000) << static_cast<int>(c);
  }
  EXPECT_EQ(counts[static_cast<std::size_t>(Constraint::variance)] > 1000, (std::is_same_v<TypeParam, Four>));
}

// After a pruned vertex every weight is 0, whatever follows, and so is that of a hit. Planted bug seen to fail:
// KolligKeller pruning by c_d alone.
TYPED_TEST(Weightings, NoPrunedVertexHasWeight) {
  Random random{std::mt19937_64(34)};
  int pruned = 0;
  for (int n = 0; n < 20000; ++n) {
    const auto [config, path] = draw(random, n);
    const typename TypeParam::W weighting(config);
    const std::size_t j = 1 + static_cast<std::size_t>(random.uniform() * static_cast<double>(path.length() - 1));
    const auto record = record_at(weighting, path, j);
    const double d_sup = path.d[j] * (1 + random.uniform());
    if (path.dirac[j] ? !weighting.prune_delta(record) : !weighting.prune(record, d_sup)) continue;
    ++pruned;
    const std::vector<double> w = TypeParam::slow(path, config);
    for (std::size_t k = j; k < path.length(); ++k) ASSERT_LE(w[k], 1e-12) << "path " << n << " generator " << k;
    if (!path.exact_light) {
      ASSERT_LE(TypeParam::slow_hit(path, config), 1e-12) << "path " << n;
    }
  }
  EXPECT_GT(pruned, 300);
}

// The converse where it is meant to hold: if every D_k up to d_sup leaves nothing, the vertex is pruned. Scan over D.
TYPED_TEST(Weightings, WhatIsUsedUpIsPruned) {
  if constexpr (TypeParam::k_is_unbiased) {
    Random random{std::mt19937_64(35)};
    int pruned = 0;
    for (int n = 0; n < 5000; ++n) {
      auto [config, path] = draw(random, 2 * n);
      config.hits = EmitterHits::all;
      path.exact_light = false;
      const typename TypeParam::W weighting(config);
      const std::size_t l = path.length();
      const double d_sup = path.d[l];
      double left = 0;
      for (int i = 0; i <= 60; ++i) {
        path.d[l] = d_sup * std::pow(10.0, -0.1 * i);
        left = std::max(left, TypeParam::slow_hit(path, config));  // what all generators before v_l leave
      }
      if (left > 0 && left < 1e-12) continue;  // rounding decides
      pruned += left > 0 ? 0 : 1;
      ASSERT_EQ(weighting.prune(record_at(weighting, path, l), d_sup), !(left > 0)) << "path " << n;
    }
    EXPECT_GT(pruned, 200);
  }
}

// O-39 for every rule. Planted bug seen to fail: KolligKeller with factor = left and remaining = left.
TYPED_TEST(Weightings, SensorLimitIsNeverExceeded) {
  Random random{std::mt19937_64(36)};
  for (int n = 0; n < 40000; ++n) {
    const auto [config, path] = draw(random, n);
    const typename TypeParam::W weighting(config);
    const std::size_t k = path.length() - 1;
    if (!connects(path, k)) continue;
    const auto record = record_at(weighting, path, k);
    const SensorLimit<double> limit = weighting.limit(record);
    const double w = weighting.weight(record, pair_at(path, k));
    const double value = w * path.m[k] * path.d[k + 1];
    const double pattern = limit.factor * std::min(path.m[k], limit.cap);
    const double top = weighting.light_limit();
    const double light = path.d[k + 1] < top ? limit.remaining * path.d[k + 1] : top;
    ASSERT_LE(value, pattern * light * (1 + 1e-12)) << "path " << n;  // rounding
    if (!path.exact_light) {
      ASSERT_LE(value * path.t[k], weighting.clamp() * (1 + 1e-12)) << "path " << n;
    }
    ASSERT_LE(w * path.d[k + 1], top * (1 + 1e-12)) << "path " << n;
  }
}

// Limits that are off, and patterns and transits beyond the range of numbers, give 0 or 1 and never NaN. Planted bug
// seen to fail: x < limit, or x <= limit, for !(x > limit).
TYPED_TEST(Weightings, InfinitiesGiveNumbers) {
  const std::vector<double> values{0.0, 5e-324, 0.3, 1e300, k_inf};
  for (const double c_clamp : {1e-3, k_inf}) {
    for (const double c_d : {1.0, k_inf}) {
      const typename TypeParam::W weighting(WeightingConfig<double>{c_clamp, c_d, c_d});
      for (const double x : values) {
        for (const double y : values) {
          const auto record = weighting.extend(weighting.start(), 0.3, 0.2, x);
          const double w = weighting.weight(record, {0.3, 0.2, y, 0.3, false});
          ASSERT_TRUE(w >= 0 && w <= 1) << c_clamp << ' ' << c_d << ' ' << x << ' ' << y << ": " << w;
          const double first = weighting.weight(weighting.start(), {0.3, 0.2, x, y, false});
          ASSERT_TRUE(first >= 0 && first <= 1) << c_clamp << ' ' << c_d << ' ' << x << ' ' << y << ": " << first;
          if (c_clamp == k_inf && c_d == k_inf) {
            ASSERT_EQ(first, 1.0);
          }
          const double hit = weighting.hit_weight(record, y);
          ASSERT_TRUE(hit >= 0 && hit <= 1);
          (void)weighting.prune(record, y);
        }
      }
    }
  }
}

// Theory 3.9: the paper's product in place of the variance constraint never binds next to the energy constraint.
TEST(ResidualWeighting, EqualsTheReadingWithTheProduct) {
  Random random{std::mt19937_64(37)};
  for (int n = 0; n < 20000; ++n) {
    const auto [config, path] = draw(random, n);
    const std::vector<double> plain = residual_weights(path, config);
    const std::vector<double> product = residual_weights(path, config, true);
    for (std::size_t k = 1; k < path.length(); ++k)
      ASSERT_NEAR(plain[k], product[k], 1e-12) << "path " << n;  // rounding
  }
}

// Theory 3.9: the sum telescopes, and stick breaking gives later generators more than the residual rule.
TEST(KolligKeller, SumIsOneMinusTheProduct) {
  Random random{std::mt19937_64(38)};
  for (int n = 0; n < 20000; ++n) {
    const auto [config, path] = draw(random, n);
    const KolligKeller<double> weighting(config);
    double sum = 0;
    double left = 1;
    double residual = 0;
    const std::vector<double> other = residual_weights(path, config);
    for (std::size_t k = 1; k < path.length(); ++k) {
      residual += other[k];
      if (!connects(path, k)) continue;
      sum += weighting.weight(record_at(weighting, path, k), pair_at(path, k));
      left *= 1 - std::min(clamp_of(path, config, k), diffuse_of(path, config, k));
      ASSERT_NEAR(sum, 1 - left, 1e-12) << "path " << n;
      ASSERT_LE(sum, residual + 1e-12) << "path " << n;
    }
  }
}

// A full weighting gives the first ordinary vertex everything, at any distance and for any pattern.
TEST(FullWeighting, FirstOrdinaryVertexTakesAll) {
  const FullWeighting<double> weighting;
  Random random{std::mt19937_64(39)};
  for (int n = 0; n < 2000; ++n) {
    const Path path = random.path(6, 0.4);
    for (std::size_t k = 1; k < path.length(); ++k) {
      if (!connects(path, k)) continue;
      const double w = weighting.weight(record_at(weighting, path, k), pair_at(path, k));
      ASSERT_EQ(w, all_dirac_before(path, k) ? 1.0 : 0.0);
    }
  }
}

}  // namespace
}  // namespace manylight::weightings_test
