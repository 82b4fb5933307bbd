// SPDX-License-Identifier: Apache-2.0
// What is missing of random paths, and why, against the rules as they are defined (weight_oracle.hpp): O-35 of the
// theory.

#include <gtest/gtest.h>

#include <array>

#include "manylight/path/four_constraints.hpp"
#include "manylight/path/kollig_keller.hpp"
#include "manylight/path/missing_energy.hpp"
#include "path/weight_oracle.hpp"

namespace manylight::missing_energy_test {
namespace {

using namespace test;  // NOLINT: the oracle's own names

/// Follows the path as a walk does.
template <class W>
MissingShare missing_of(const W& weighting, const Path& p) {
  PathShares<W> shares(weighting);
  for (std::size_t j = 1; j < p.length(); ++j) {
    if (p.dirac[j]) {
      shares.leave_delta();
    } else {
      shares.leave(p.m[j], p.d[j], p.t[j]);
    }
  }
  return shares.missing(p.d[p.length()], p.exact_light);
}

/// Theory, section 4, with all of the path at hand. Segments with a Dirac end count as `dirac` whatever mu says.
LedgerEntry four_entry(const Path& p, const WeightingConfig<double>& c) {
  const std::vector<double> w = weights(p, c);
  LedgerEntry last = LedgerEntry::other;
  const auto after = [&] {
    if (last == LedgerEntry::clamp) return LedgerEntry::variance_after_clamp;
    if (last == LedgerEntry::diffuse_light) return LedgerEntry::variance_after_diffuse_light;
    return last == LedgerEntry::dirac ? LedgerEntry::variance_after_dirac : LedgerEntry::variance_first;
  };
  double sum = 0;
  for (std::size_t j = 1; j < p.length(); ++j) {
    if (!connects(p, j)) {
      last = LedgerEntry::dirac;
      continue;
    }
    const double clamp = clamp_of(p, c, j);
    const double diffuse = diffuse_of(p, c, j);
    const double variance = mu(p, c, j) - sum;
    if (variance <= std::min(clamp, diffuse) && variance < 1 - sum) return after();
    if (std::min(clamp, diffuse) < 1 - sum) last = clamp <= diffuse ? LedgerEntry::clamp : LedgerEntry::diffuse_light;
    sum += w[j];
  }
  const bool hits = !p.exact_light && c.hits == EmitterHits::all && !all_dirac_before(p, p.length());
  // The hit takes all that is left but for mu.
  return hits && sum + hit_weight(p, c) < 1 ? after() : last;
}

struct Draw {
  WeightingConfig<double> config;
  Path path;
};
Draw draw(Random& random, int n) {
  Draw out{random.config(), random.path(1 + static_cast<std::size_t>(random.uniform() * 7), n % 2 == 0 ? 0.0 : 0.25)};
  out.path.exact_light = n % 3 == 0;
  if (n % 5 == 0) out.config.hits = EmitterHits::after_dirac;
  return out;
}

// O-35. Planted bugs seen to fail: the last generator left out; the hit left out; the hit counted for exact lights;
// settle(m) for settle(d); the record of the vertex in place of the one before.
TEST(PathShares, MissingIsOneMinusTheSumOfAllGenerators) {
  Random random{std::mt19937_64(41)};
  int some = 0;
  for (int n = 0; n < 20000; ++n) {
    const Draw drawn = draw(random, n);
    const WeightingConfig<double>& config = drawn.config;
    const Path& path = drawn.path;
    const bool exact = path.exact_light;
    const bool seen = all_dirac_before(path, path.length());
    const auto hit = [&](double rest) {
      return exact ? 0.0 : seen ? 1.0 : config.hits == EmitterHits::all ? rest : 0.0;
    };
    const auto check = [&](const auto& weighting, const std::vector<double>& w, double hit_share) {
      const MissingShare missing = missing_of(weighting, path);
      ASSERT_NEAR(missing.share, std::max(0.0, 1 - sum_of(w) - hit_share), 1e-12) << "path " << n;  // rounding
      ASSERT_GE(missing.share, 0.0);
      some += missing.share > 1e-3 && missing.share < 0.999 ? 1 : 0;
    };
    const std::vector<double> four = weights(path, config);
    check(FourConstraints<double>(config), four, exact ? 0.0 : hit_weight(path, config));
    const std::vector<double> residual = residual_weights(path, config);
    check(ResidualWeighting<double>(config), residual, hit(1 - sum_of(residual)));
    const std::vector<double> sticks = stick_breaking_weights(path, config);
    check(KolligKeller<double>(config), sticks, hit(1 - sum_of(sticks)));
    check(StandardWeighting<double>(config), first_vertex_weights(path, config), hit(0.0));
  }
  EXPECT_GT(some, 10000);
}

// Planted bugs seen to fail: `last` set by energy-bound segments; `first` in every name of V;
// the hit's constraint not asked.
TEST(PathShares, EntryIsTheConstraintThatHeldTheEnergyBack) {
  Random random{std::mt19937_64(42)};
  std::array<int, k_ledger_entries> counts{};
  for (int n = 0; n < 40000; ++n) {
    const auto [config, path] = draw(random, n);
    const MissingShare missing = missing_of(FourConstraints<double>(config), path);
    if (missing.share < 1e-9) continue;  // nothing to name
    ASSERT_EQ(name(missing.entry), name(four_entry(path, config))) << "path " << n;
    ++counts[static_cast<std::size_t>(missing.entry)];
  }
  for (const LedgerEntry e :
       {LedgerEntry::clamp, LedgerEntry::diffuse_light, LedgerEntry::dirac, LedgerEntry::variance_after_clamp,
        LedgerEntry::variance_after_diffuse_light, LedgerEntry::variance_after_dirac}) {
    EXPECT_GT(counts[static_cast<std::size_t>(e)], 50) << name(e);
  }
}

// The classical weighting has one generator: what it leaves is its constraint's, and what it cannot make for a mirror
// at one of its ends is the mirror's.
TEST(PathShares, ClassicalClampNamesItsOneGenerator) {
  const StandardWeighting<double> weighting(WeightingConfig<double>{1e-3});
  Path path;
  for (int j = 0; j < 5; ++j) path.add(0.3, 0.3, 1);
  EXPECT_EQ(missing_of(weighting, path).entry, LedgerEntry::clamp);
  EXPECT_NEAR(missing_of(weighting, path).share, 1 - 1e-3 / 0.09, 1e-15);
  path.d[2] = 1e4;
  EXPECT_EQ(missing_of(weighting, path).entry, LedgerEntry::clamp);
  path.t[1] = 1e-9;
  EXPECT_EQ(missing_of(weighting, path).entry, LedgerEntry::diffuse_light);
  EXPECT_NEAR(missing_of(weighting, path).share, 1 - 1e-4, 1e-15);
  path.m[2] = path.d[2] = k_inf;
  path.dirac[2] = true;
  EXPECT_EQ(missing_of(weighting, path).entry, LedgerEntry::dirac);
  EXPECT_EQ(missing_of(weighting, path).share, 1.0);
}

}  // namespace
}  // namespace manylight::missing_energy_test
