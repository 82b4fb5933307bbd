// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>

#include "manylight/bounds/analytic.hpp"
#include "manylight/bounds/falsify_phase.hpp"
#include "scattering/phase_list.hpp"

namespace manylight::test {

inline constexpr PhaseSets k_all_phase_sets[] = {PhaseSets::sampled, PhaseSets::known, PhaseSets::both};

/// The lower of both policies: what refutes neither does not refute this.
struct LowerOfBoth {
  template <class P, class W, class V>
  [[nodiscard]] typename P::Scalar sup_phase(const P& p, const W& sampled, const V& known) const {
    return std::min(AutomaticBounds{}.sup_phase(p, sampled, known), AnalyticBounds{}.sup_phase(p, sampled, known));
  }
};

/// Searches all phase functions of the list, sets in either place and in both, for values above their bounds.
template <std::floating_point S>
void expect_no_phase_violation(std::uint32_t configurations, const FalsifySearch& search) {
  for_each_phase<S>([&](const std::string& name, const auto& phase) {
    for (const PhaseSets sets : k_all_phase_sets) {
      const auto report = falsify_phase(phase, LowerOfBoth{}, sets, configurations, search);
      EXPECT_EQ(report.refuted, 0U) << name << ", sets " << static_cast<int>(sets) << ": " << report.worst.value
                                    << " > " << report.worst.bound << " at " << report.worst.at.x << ' '
                                    << report.worst.at.y << ' ' << report.worst.at.z << ", known "
                                    << report.worst_known.x << ' ' << report.worst_known.y << ' '
                                    << report.worst_known.z;
      EXPECT_EQ(report.configurations, configurations);
      EXPECT_EQ(report.infinite, 0U) << name;
      EXPECT_GT(report.mean_value, 0) << name;
    }
  });
}

}  // namespace manylight::test
