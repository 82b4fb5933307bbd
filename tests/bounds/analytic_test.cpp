// SPDX-License-Identifier: Apache-2.0
// Closed forms against what is known of them. Their search for violations is in falsify_test.cpp.

#include "manylight/bounds/analytic.hpp"

#include <gtest/gtest.h>

#include <string>

#include "manylight/scattering/rough_dielectric.hpp"
#include "scattering/material_list.hpp"

namespace manylight::analytic_test {
namespace {

using Set = DirectionSet<double>;
const Vec3<double> k_wo = glm::normalize(Vec3<double>(0.6, 0.2, 0.775));

// Ward at (.6, .2, .775) with alpha (.1, .3): 1 / (4 c_o pi alpha_u alpha_v) = 3.42447; the maximum found by sampling is
// 3.42433. Planted bug seen to fail: 1 / (8 c_o).
TEST(AnalyticBounds, WardPeakEqualsTheOracle) {
  const Ward<double> ward{Rgb<double>(1), 0.1, 0.3};
  EXPECT_NEAR(AnalyticBounds{}.sup(ward, Set(), k_wo).eval_cos, 3.42447, 2e-3);  // wo rounded to 3 digits
  EXPECT_NEAR(AutomaticBounds{}.sup(ward, Set(), k_wo).eval_cos, 3.42447, 2e-3);
}

TEST(AnalyticBounds, MaterialsWithoutAFormGetTheAutomaticOne) {
  const OrenNayar<double> rough{Rgb<double>(0.5), 0.4};
  EXPECT_EQ(AnalyticBounds{}.sup(rough, Set(), k_wo).eval, AutomaticBounds{}.sup(rough, Set(), k_wo).eval);
}

TEST(AnalyticBounds, MixturesAreSumsAndAlternativesAreTheirOwn) {
  const Lambertian<double> diffuse{Rgb<double>(0.5, 0.2, 0.1)};
  const Ward<double> ward{Rgb<double>(0.3, 0.2, 0.4), 0.1, 0.2};
  const Set set(Vec3<double>(0, 0, 1), 0.3);
  const auto of = [&](const auto& m) { return AnalyticBounds{}.sup(m, set, k_wo).eval_cos; };
  const Mixture<Lambertian<double>, Ward<double>> both({diffuse, 0.7}, {ward, 0.2});
  EXPECT_DOUBLE_EQ(of(both), 0.7 * of(diffuse) + 0.2 * of(ward));
  EXPECT_EQ(of(AnyOf<Lambertian<double>, Ward<double>>(ward)), of(ward));
}

TEST(Bounds, DeltaMaterialsAndBlackSidesHaveZero) {
  const auto expect_none = [](const auto& material, const Vec3<double>& wo) {
    EXPECT_EQ(AutomaticBounds{}.sup(material, Set(), wo).eval, 0.0);
    EXPECT_EQ(AnalyticBounds{}.sup(material, Set(), wo).eval_cos, 0.0);
    EXPECT_EQ(AutomaticBounds{}.sup(material, wo, Set()).eval, 0.0);
  };
  expect_none(Mirror<double>{}, k_wo);
  expect_none(SmoothConductor<double>{}, k_wo);
  expect_none(Dielectric<double>{}, k_wo);
  expect_none(ThinDielectric<double>{}, k_wo);
  expect_none(Lambertian<double>{}, -k_wo);
  expect_none(Ward<double>{}, -k_wo);
}

// Of every material that does not scatter through: cuts look at one side of it only. Planted bug seen to fail: mirror
// images of sets without what is known of their z.
TEST(Bounds, NothingComesThroughOpaqueMaterials) {
  test::for_each_material<double>([](const std::string& name, const auto& material) {
    const double below = AutomaticBounds{}.sup(material, Set::hemisphere(false), k_wo).eval;
    EXPECT_EQ(below, 0.0) << name;
    EXPECT_GT(AutomaticBounds{}.sup(material, Set::hemisphere(true), k_wo).eval, 0.0) << name;
  });
  EXPECT_GT(AutomaticBounds{}.sup(RoughDielectric<double>{}, Set::hemisphere(false), k_wo).eval, 0.0);
}

}  // namespace
}  // namespace manylight::analytic_test
