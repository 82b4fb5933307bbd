// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "manylight/bounds/falsify.hpp"
#include "scattering/material_list.hpp"

namespace manylight::test {

/// Searches all materials of the list, `configurations` each, for values above their bounds.
template <std::floating_point S, class B>
void expect_no_violation(const B& bounds, const char* policy, std::uint32_t configurations,
                         const FalsifySearch& search) {
  for_each_material<S>([&](const std::string& name, const auto& material) {
    const auto report = falsify_bounds(material, bounds, configurations, search);
    EXPECT_EQ(report.refuted, 0U) << policy << ", " << name << ": " << report.worst.value << " > "
                                  << report.worst.bound << " at " << report.worst.at.x << ' ' << report.worst.at.y
                                  << ' ' << report.worst.at.z << ", known " << report.worst_known.x << ' '
                                  << report.worst_known.y << ' ' << report.worst_known.z;
    EXPECT_EQ(report.configurations, configurations);
    EXPECT_GT(report.mean_value, 0) << name;
  });
}

}  // namespace manylight::test
