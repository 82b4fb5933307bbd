// SPDX-License-Identifier: Apache-2.0
#include "manylight/core/alias_table.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "manylight/core/sampler.hpp"
#include "support/chi_square.hpp"

namespace manylight::test::alias_table_test {
namespace {

constexpr double k_level = 1e-4;  // false alarm of each chi-square, fixed seeds

std::vector<ExpectedCount> draw(const AliasTable& table, const std::vector<double>& weights, int count) {
  double total = 0;
  for (const double w : weights) total += w;
  std::vector<ExpectedCount> cells(weights.size());
  for (std::size_t i = 0; i < weights.size(); ++i) {
    cells[i] = {weights[i] / total * count, 0, "entry " + std::to_string(i)};
  }
  IndependentStream<double> stream(4, Stage::test, weights.size(), 0);
  for (int i = 0; i < count; ++i) {
    const double u = stream.next();
    cells[table.sample(widen_variate(u, stream.next()))].observed += 1;
  }
  return cells;
}

// Planted bug seen: alias and own entry exchanged.
TEST(AliasTable, DrawsEntriesByTheirWeights) {
  for (const std::vector<double>& weights : {std::vector<double>{1},
                                             {1, 1},
                                             {3, 1},
                                             {0, 1},
                                             {1, 0, 2, 0},
                                             {1e-3, 1, 5, 0, 2, 1e-2, 7},
                                             {1e30, 2e30, 5e30}}) {
    const AliasTable table(weights);
    const auto result = chi_square(draw(table, weights, 100'000));
    EXPECT_TRUE(result.passes(k_level)) << result.describe();  // fails outright for a drawn entry of weight 0
    double sum = 0;
    for (std::uint32_t i = 0; i < table.size(); ++i) sum += static_cast<double>(table.pmf(i));
    EXPECT_NEAR(sum, 1, 1e-6);  // float probabilities
  }
}

// Case 22: one strong entry, 100,000 weak ones with a total share of 1 %, every tenth 0.
TEST(AliasTable, KeepsWeakEntriesBesideAStrongOne) {
  std::vector<double> weights(100'001, 1e-5);
  weights[500] = 99;
  for (std::size_t i = 0; i < weights.size(); i += 10) {
    if (i != 500) weights[i] = 0;
  }
  const AliasTable table(weights);
  double weak = 0;
  for (std::uint32_t i = 0; i < table.size(); ++i) {
    EXPECT_EQ(table.pmf(i) > 0, weights[i] > 0);
    if (i != 500) weak += static_cast<double>(table.pmf(i));
  }
  EXPECT_NEAR(weak, 0.9 / 99.9, 1e-6);  // float probabilities
  const auto result = chi_square(draw(table, weights, 1'000'000));
  EXPECT_TRUE(result.passes(k_level)) << result.describe();
}

// A float variate has 24 bits; among 2^20 entries 4 would be left for the threshold. Weights repeat with period 7, the
// draws are counted by residue. Planted bug seen: widen_variate returns u.
TEST(AliasTable, FloatVariatesSufficeForAMillionEntries) {
  std::vector<double> weights(1u << 20);
  const double pattern[7] = {0.05, 1, 0.3, 2.11, 0.07, 0.61, 1.9};
  std::vector<ExpectedCount> cells(7);
  double total = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) total += weights[i] = pattern[i % 7];
  const AliasTable table(weights);
  constexpr int k_count = 2'000'000;
  for (std::size_t i = 0; i < weights.size(); ++i) cells[i % 7].expected += weights[i] / total * k_count;
  IndependentStream<float> stream(4, Stage::test, 0, 0);
  for (int i = 0; i < k_count; ++i) {
    const float u = stream.next();
    cells[table.sample(widen_variate(u, stream.next())) % 7].observed += 1;
  }
  const auto result = chi_square(cells);
  EXPECT_TRUE(result.passes(k_level)) << result.describe();
}

TEST(AliasTable, ExtremeVariatesStayInRange) {
  const std::vector<double> weights{0, 2, 1, 0};
  const AliasTable table(weights);
  for (const double u : {0.0, 0.25, 0.5, 0.75, 1 - 0x1p-53}) EXPECT_GT(weights[table.sample(u)], 0) << u;
  EXPECT_LT(widen_variate(1.0F - 0x1p-24F, 0.99999994F), 1.0);
  EXPECT_LT(widen_variate(1.0 - 0x1p-53, 1 - 0x1p-53), 1.0);
  EXPECT_EQ(widen_variate(0.5F, 0.0F), 0.5);
}

TEST(AliasTable, NothingToDrawIsEmpty) {
  EXPECT_TRUE(AliasTable().empty());
  EXPECT_TRUE(AliasTable(std::vector<double>{}).empty());
  EXPECT_TRUE(AliasTable(std::vector<double>{0, 0}).empty());
}

TEST(AliasTable, RejectsBadWeightsByName) {
  for (const double bad : {-1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    try {
      const AliasTable table(std::vector<double>{1, bad});
      FAIL() << bad;
    } catch (const ParameterError& error) {
      EXPECT_NE(std::string(error.what()).find("weight 1"), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace manylight::test::alias_table_test
