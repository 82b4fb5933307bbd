// SPDX-License-Identifier: Apache-2.0
// Sums and choices of materials against their parts.
#include "manylight/scattering/mixture.hpp"

#include <gtest/gtest.h>

#include "manylight/core/sampler.hpp"
#include "scattering/material_list.hpp"
#include "support/quadrature.hpp"
#include "support/z_test.hpp"

namespace manylight::test::mixture_test {
namespace {

using Diffuse = Lambertian<double>;
using Gloss = Phong<double>;
using Sheet = Mirror<double>;

TEST(Mixture, EvaluatesTheWeightedSum) {
  const Diffuse diffuse{Rgb<double>(0.3, 0.2, 0.1)};
  const Gloss gloss{Rgb<double>(0.5), 20};
  const Mixture<Diffuse, Gloss> both({diffuse, 0.25}, {gloss, 0.75});
  const Vec3<double> wi = at_degrees(30, 0.2);
  const Vec3<double> wo = at_degrees(40, 3.0);
  const Rgb<double> expected = 0.25 * diffuse.eval(wi, wo) + 0.75 * gloss.eval(wi, wo);
  EXPECT_NEAR(both.eval(wi, wo).x, expected.x, 5e-15);  // contraction to FMA: 20 ulps of the 20th power
  EXPECT_NEAR(both.eval(wi, wo).z, expected.z, 5e-15);
  EXPECT_NEAR(both.albedo().y, 0.25 * 0.2 + 0.75 * 0.5, 4e-16);
  // Lobes by their share of the largest channel, .25 * .3 to .75 * .5; the pdf is their balance.
  const double share = 0.075 / (0.075 + 0.375);
  EXPECT_NEAR(both.pdf(wo, wi, Walk::eye),
              share * diffuse.pdf(wo, wi, Walk::eye) + (1 - share) * gloss.pdf(wo, wi, Walk::eye), 1e-15);
  EXPECT_FALSE(both.is_delta());
}

TEST(Mixture, LobeOfWeightZeroIsAbsent) {
  const Mixture<Diffuse, Ward<double>> one({Diffuse{}, 1},
                                           {Ward<double>{Rgb<double>(1), 0.1, 0.1, WardVariant::original}, 0});
  EXPECT_EQ(one.eval(at_degrees(10), at_degrees(20)), Diffuse{}.eval(at_degrees(10), at_degrees(20)));
  const DirectionSet<double> all;
  EXPECT_NEAR(max_channel(one.eval(all, at_degrees(20))).hi, max_channel(Diffuse{}.eval(all, at_degrees(20))).hi,
              1e-14)  // the sum's outward rounding
      << "not 0 times infinity";
  EXPECT_EQ(one.pdf(at_degrees(20), at_degrees(10), Walk::eye),
            Diffuse{}.pdf(at_degrees(20), at_degrees(10), Walk::eye));
  const Mixture<Diffuse, Gloss> none({Diffuse{}, 0}, {Gloss{}, 0});
  EXPECT_FALSE(none.sample(at_degrees(20), Walk::eye, 0.5, {0.5, 0.5}).has_value());
  EXPECT_EQ(none.pdf(at_degrees(20), at_degrees(10), Walk::eye), 0.0);
}

// Delta lobes keep their probability and weight: the mean throughput is the sum of the parts' energies.
// Planted bug seen to fail: the weight not divided by the lobe's probability.
TEST(Mixture, DeltaLobesCarryTheirShare) {
  const Sheet mirror{Rgb<double>(0.8, 0.4, 0.2)};
  const Diffuse diffuse{Rgb<double>(0.5)};
  const Mixture<Diffuse, Sheet> both({diffuse, 0.6}, {mirror, 0.4});
  const Vec3<double> known = at_degrees(35, 1.0);
  const double mirror_share = 0.4 * 0.8 / (0.4 * 0.8 + 0.6 * 0.5);
  Rgb<double> delta(0);
  double deltas = 0;
  constexpr int k_draws = 10000;
  for (int i = 0; i < k_draws; ++i) {
    const auto s = both.sample(known, Walk::light, (i + 0.5) / k_draws, {0.3, 0.7});
    ASSERT_TRUE(s.has_value());
    if (!s->is_delta) continue;
    ++deltas;
    delta += s->delta_weight / double(k_draws);
    EXPECT_NEAR(s->pdf, mirror_share, 1e-15);
    EXPECT_EQ(s->direction, local::mirror(known));
  }
  EXPECT_NEAR(deltas / k_draws, mirror_share, 1.0 / k_draws);
  EXPECT_NEAR(delta.x, 0.4 * 0.8, 1e-4);  // midpoint rule in the lobe variate
  EXPECT_NEAR(delta.z, 0.4 * 0.2, 1e-4);
  // The pdf excludes the delta lobe and keeps its probability.
  EXPECT_NEAR(integrate_hemisphere([&](const Vec3<double>& w) { return both.pdf(known, w, Walk::light); }),
              1 - mirror_share, 1e-10);
  EXPECT_FALSE(both.is_delta());
  EXPECT_TRUE((Mixture<Sheet, Dielectric<double>>({mirror, 0.5}, {Dielectric<double>{}, 0.5}).is_delta()));
}

TEST(Mixture, IsAMaterialItself) {
  using Inner = Mixture<Diffuse, Gloss>;
  const Inner inner({Diffuse{}, 1}, {Gloss{}, 0.5});
  const Mixture<Inner, Sheet> outer({inner, 0.5}, {Sheet{}, 0.5});
  const Vec3<double> wi = at_degrees(20);
  const Vec3<double> wo = at_degrees(30, 2.5);
  EXPECT_NEAR(outer.eval(wi, wo).x, 0.5 * inner.eval(wi, wo).x, 1e-16);  // an ulp
  int lobes = 0;
  outer.for_each([&](const auto&) { ++lobes; });
  EXPECT_EQ(lobes, 2);
}

TEST(AnyOf, ForwardsToWhatItHolds) {
  const Ward<double> ward{Rgb<double>(0.7), 0.1, 0.3};
  using Any = AnyOf<Diffuse, Sheet, Ward<double>, Dielectric<double>>;
  Any any = ward;
  EXPECT_EQ(any.index(), 2u);
  EXPECT_NE(any.get_if<Ward<double>>(), nullptr);
  EXPECT_EQ(any.get_if<Diffuse>(), nullptr);
  const Vec3<double> wi = at_degrees(20);
  const Vec3<double> wo = at_degrees(30, 2.5);
  EXPECT_LT(glm::length(any.eval(wi, wo) - ward.eval(wi, wo)), 1e-13 * ward.eval(wi, wo).x);  // as below: fused
  EXPECT_DOUBLE_EQ(any.pdf(wi, wo, Walk::eye), ward.pdf(wi, wo, Walk::eye));
  EXPECT_EQ(any.albedo(), ward.albedo());
  const DirectionSet<double> around(wi, 0.2);
  EXPECT_DOUBLE_EQ(max_channel(any.eval(around, wo)).hi, max_channel(ward.eval(around, wo)).hi);
  EXPECT_DOUBLE_EQ(max_channel(any.eval_cos(around, wo)).hi, max_channel(ward.eval_cos(around, wo)).hi);
  EXPECT_FALSE(any.is_delta());
  const auto a = any.sample(wo, Walk::light, 0.3, {0.2, 0.9});
  const auto b = ward.sample(wo, Walk::light, 0.3, {0.2, 0.9});
  ASSERT_TRUE(a && b);
  EXPECT_LT(glm::length(a->direction - b->direction), 1e-14);  // inlined twice, products may be fused differently
  any = Sheet{};
  EXPECT_TRUE(any.is_delta());
  any = Dielectric<double>{};
  EXPECT_TRUE(any.is_delta());
  EXPECT_EQ(sampling_weight(any, wo), 1.0);
  EXPECT_EQ(Any{}.index(), 0u);
}

}  // namespace
}  // namespace manylight::test::mixture_test
