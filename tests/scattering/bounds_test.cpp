// SPDX-License-Identifier: Apache-2.0
// The materials' own bounds against searched maxima: never below, and not looser than stated.
#include <gtest/gtest.h>

#include "manylight/core/sampler.hpp"
#include "scattering/material_list.hpp"
#include "support/quadrature.hpp"

namespace manylight::test {
namespace {

/// Largest `value(w)` over random directions of the upper side, half of them uniform in the cosine and half drawn by
/// the material, then by local ascent with shrinking steps.
template <class M, class Value>
double searched_maximum(const M& material, const Vec3<double>& wo, int draws, const Value& value, std::uint64_t seed) {
  IndependentStream<double> stream(seed, Stage::test, 2, 0);
  Vec3<double> best(0, 0, 1);
  double maximum = value(best);
  const auto consider = [&](const Vec3<double>& w) {
    const double v = value(w);
    if (v > maximum) {
      maximum = v;
      best = w;
    }
  };
  consider(local::mirror(wo));
  for (int k = 0; k < draws / 2; ++k) {
    consider(direction(1.0 - stream.next(), 2 * k_pi<double> * stream.next()));
    const double u_lobe = stream.next();
    if (const auto s = material.sample(wo, Walk::eye, u_lobe, stream.next_2d())) consider(s->direction);
  }
  for (double step = 0.1; step > 1e-6; step *= 0.5) {
    for (int k = 0; k < 30; ++k) {
      const Vec2<double> d(stream.next() - 0.5, stream.next() - 0.5);
      Vec3<double> w = Frame<double>(best).to_world(glm::normalize(Vec3<double>(step * d.x, step * d.y, 1.0)));
      w.z = std::max(w.z, 1e-12);
      consider(glm::normalize(w));
    }
  }
  return maximum;
}

constexpr double k_rounding = 1.0 + 1e-11;  // some ulp, times the exponents' size

// Planted bugs seen to fail: 1/(8 c_o) for 1/(4 c_o) in Ward; the half angle theta for theta / 2; sup of GGX's density
// taken at normal incidence for alpha > 1; Fresnel at 45 degrees for every wo in the rough coat.
TEST(Bounds, AreNeverBelowASearchedMaximum) {
  std::uint64_t seed = 0;
  double slack_sum = 0;
  int slack_count = 0;
  for_each_material<double>([&](const std::string& name, const auto& material) {
    for (const double degrees : {0.0, 25.0, 50.0, 70.0, 85.0, 89.5}) {
      const Vec3<double> wo = at_degrees(degrees, 0.9);
      const double peak = searched_maximum(
          material, wo, 100000, [&](const Vec3<double>& wi) { return max_channel(material.eval(wi, wo)) * wi.z; },
          ++seed);
      EXPECT_LE(peak, material.sup_cos_eval(wo) * k_rounding) << name << " at " << degrees;
      const double out = searched_maximum(
          material, wo, 20000, [&](const Vec3<double>& wi) { return max_channel(material.eval(wi, wo)) * wo.z; },
          ++seed);
      EXPECT_LE(out, material.sup_eval_cos_wo(wo) * k_rounding) << name << " at " << degrees;
      slack_sum += material.sup_cos_eval(wo) / peak;
      ++slack_count;
    }
  });
  RecordProperty("mean_bound_over_maximum", std::to_string(slack_sum / slack_count));
  EXPECT_LT(slack_sum / slack_count, 1.75);  // measured 1.705; loose where F or masking is small at the peak
}

// Planted bug seen to fail: the retro-reflective lobe's angle not set off by that between wo and its mirror image.
TEST(Bounds, LobeProfileIsNeverBelowTheLobe) {
  std::uint64_t seed = 500;
  for_each_material<double>([&](const std::string& name, const auto& material) {
    for (const double degrees : {0.0, 30.0, 60.0, 85.0}) {
      const Vec3<double> wo = at_degrees(degrees, 0.9);
      const Vec3<double> r = local::mirror(wo);
      // The worst excess of the lobe over its profile at the very angle of each direction.
      const auto ratio = [&](const Vec3<double>& wi) {
        const double theta = std::atan2(glm::length(glm::cross(wi, r)), glm::dot(wi, r));
        const double bound = material.diffuse_albedo() * std::max(0.0, wi.z) / k_pi<double> +
                             material.sup_gloss_beyond(wo, theta * (1 - 1e-9));
        const double value = max_channel(material.eval(wi, wo)) * wi.z;
        return value > 1e-200 ? value / bound : 0.0;
      };
      EXPECT_LE(searched_maximum(material, wo, 40000, ratio, ++seed), 1 + 1e-6) << name << " at " << degrees;
      // The profile must fall with the angle: it is a supremum over what lies beyond.
      double previous = material.sup_gloss_beyond(wo, 0.0);
      for (double theta = 0.05; theta < 3.2; theta += 0.05) {
        const double next = material.sup_gloss_beyond(wo, std::min(theta, k_pi<double>));
        EXPECT_LE(next, previous * k_rounding) << name;
        EXPECT_GE(next, 0.0) << name;
        previous = next;
      }
    }
  });
}

// Single precision: the same with room for the rounding of sharp exponents, 1e-7 * 2 t q (t q < 88) and of theta.
TEST(Bounds, HoldInFloatUpToRounding) {
  for_each_material<float>([&](const std::string& name, const auto& material) {
    IndependentStream<float> stream(77, Stage::test, 0, 0);
    for (const double degrees : {5.0, 45.0, 80.0}) {
      const Vec3<float> wo(at_degrees(degrees, 0.9));
      for (int k = 0; k < 5000; ++k) {
        const float u_lobe = stream.next();
        const auto s = material.sample(wo, Walk::eye, u_lobe, stream.next_2d());
        if (!s || s->is_delta) continue;
        const Rgb<float> f = material.eval(s->direction, wo);
        EXPECT_LE(max_channel(f) * s->direction.z, material.sup_cos_eval(wo) * 1.0001f) << name;
        EXPECT_LE(max_channel(f) * wo.z, material.sup_eval_cos_wo(wo) * 1.0001f) << name;
      }
    }
  });
}

TEST(Bounds, DeltaMaterialsHaveNone) {
  const Vec3<double> wo = at_degrees(30);
  const auto expect_none = [&](const auto& material) {
    EXPECT_EQ(material.sup_cos_eval(wo), 0.0);
    EXPECT_EQ(material.sup_eval_cos_wo(wo), 0.0);
    EXPECT_EQ(material.diffuse_albedo(), 0.0);
    EXPECT_EQ(material.sup_gloss_beyond(wo, 0.1), 0.0);
  };
  expect_none(Mirror<double>{});
  expect_none(SmoothConductor<double>{});
  expect_none(Dielectric<double>{});
  expect_none(ThinDielectric<double>{});
}

// Known peaks: Ward at (.6, .2, .775) with alpha (.1, .3): 3.42447 of the bound, per unit of specular.
TEST(Bounds, WardPeakEqualsTheOracle) {
  const Ward<double> ward{Rgb<double>(1), 0.1, 0.3};
  EXPECT_NEAR(ward.sup_cos_eval(glm::normalize(Vec3<double>(0.6, 0.2, 0.775))), 3.42447,
              2e-3);  // wo rounded to 3 digits
}

}  // namespace
}  // namespace manylight::test
