// SPDX-License-Identifier: Apache-2.0
// Every sampler against its density, in both walks: chi-square of the drawn directions, and the Jacobian of the map.
#include <gtest/gtest.h>

#include "manylight/core/sampler.hpp"
#include "scattering/material_list.hpp"
#include "support/chi_square.hpp"
#include "support/jacobian.hpp"

namespace manylight::test::samplers_test {
namespace {

constexpr double k_family_level = 1e-4;  // probability of a false alarm of all cases of one test together

template <class M>
ChiSquareResult test_sampler(const M& material, const Vec3<double>& known, Walk walk, std::uint64_t count,
                             std::uint64_t seed) {
  using S = typename M::Scalar;
  const Vec3<S> w(static_cast<S>(known.x), static_cast<S>(known.y), static_cast<S>(known.z));
  IndependentStream<S> stream(seed, Stage::test, 0, 0);
  const auto draw = [&]() -> std::optional<Vec3<double>> {
    const S u_lobe = stream.next();
    const auto s = material.sample(w, walk, u_lobe, stream.next_2d());
    if (!s || s->is_delta) return std::nullopt;
    return Vec3<double>(s->direction);
  };
  const auto density = [&](const Vec3<double>& x) { return static_cast<double>(material.pdf(w, Vec3<S>(x), walk)); };
  return sphere_chi_square(draw, density, count);
}

// Planted bugs that this caught when written: G1 of the sampled instead of the known direction in the microfacet pdf;
// a factor 2 in the half-vector Jacobian; Phong's exponent n for n + 1; cos phi and sin phi exchanged in Ward's
// azimuth; alpha_u and alpha_v exchanged when the visible normal is unstretched.
void all_draw_by_their_density(Walk walk, std::uint64_t count, std::uint64_t seed) {
  constexpr double k_cases = 38 * 5 * 2;
  const double level = sidak_level(k_family_level, k_cases);
  for_each_material<double>([&](const std::string& name, const auto& material) {
    for (const double degrees : {0.0, 30.0, 60.0, 85.0, 89.0}) {
      const ChiSquareResult r = test_sampler(material, at_degrees(degrees, 0.7), walk, count, ++seed);
      EXPECT_TRUE(r.passes(level)) << name << " at " << degrees << " degrees, " << r.describe();
    }
  });
}

TEST(Samplers, DrawByTheirDensityInEyeWalks) { all_draw_by_their_density(Walk::eye, 70000, 1); }
TEST(Samplers, DrawByTheirDensityInLightWalks) { all_draw_by_their_density(Walk::light, 30000, 500); }

TEST(Samplers, DrawByTheirDensityInFloat) {
  constexpr double k_cases = 38 * 2;
  const double level = sidak_level(k_family_level, k_cases);
  std::uint64_t seed = 1000;
  for_each_material<float>([&](const std::string& name, const auto& material) {
    for (const double degrees : {40.0, 85.0}) {
      const ChiSquareResult r = test_sampler(material, at_degrees(degrees, 0.7), Walk::eye, 50000, ++seed);
      EXPECT_TRUE(r.passes(level)) << name << " at " << degrees << " degrees, " << r.describe();
    }
  });
}

TEST(Samplers, ReturnTheDensityThatPdfStates) {
  for_each_material<double>([&](const std::string& name, const auto& material) {
    IndependentStream<double> stream(5, Stage::test, 0, 0);
    for (int k = 0; k < 200; ++k) {
      const Vec3<double> known = warp::square_to_cosine_hemisphere(stream.next_2d());
      const Walk walk = k % 2 == 0 ? Walk::eye : Walk::light;
      const double u_lobe = stream.next();
      const auto s = material.sample(known, walk, u_lobe, stream.next_2d());
      if (!s) continue;
      EXPECT_NEAR(glm::length(s->direction), 1.0, 1e-14) << name;  // some ulp
      EXPECT_GT(s->pdf, 0.0) << name;
      if (!s->is_delta) {
        EXPECT_DOUBLE_EQ(s->pdf, material.pdf(known, s->direction, walk)) << name;
      }
    }
  });
}

// The map of a single lobe is smooth: the density must be the inverse of its Jacobian. An error of the same factor in
// draw and density, which leaves chi-square silent only if it cancels, cannot pass here.
TEST(Samplers, JacobianOfTheMapIsTheInverseDensity) {
  const auto check_lobe = [](const std::string& name, const auto& material) {
    int checked = 0;
    IndependentStream<double> stream(11, Stage::test, 0, 0);
    for (int k = 0; k < 300; ++k) {
      const Vec3<double> known = at_degrees(80.0 * stream.next(), 6.0 * stream.next());
      const Vec2<double> u = stream.next_2d();
      if (!clear_of_creases(u)) continue;
      const auto map = [&](const Vec2<double>& v) -> std::optional<Vec3<double>> {
        const auto s = material.sample(known, Walk::eye, 0.5, v);
        return s ? std::optional<Vec3<double>>(s->direction) : std::nullopt;
      };
      const auto expected = density_by_jacobian(map, u, 1e-5);
      const auto centre = material.sample(known, Walk::eye, 0.5, u);
      if (!expected || !centre) continue;
      ++checked;
      // Central differences: truncation h^2 times the map's curvature (margin 0.02 from its creases), 1e-10 / 0.02^2,
      // and cancellation 1e-16 / (h |dw/du|).
      EXPECT_NEAR(centre->pdf / *expected, 1.0, 1e-4) << name;
    }
    EXPECT_GT(checked, 50) << name;
  };
  const Rgb<double> white(1);
  check_lobe("Lambertian", Lambertian<double>{});
  check_lobe("Phong 0", Phong<double>{white, 0});
  check_lobe("Phong 1", Phong<double>{white, 1});
  check_lobe("Phong 50", Phong<double>{white, 50});
  check_lobe("RetroPhong 0", RetroPhong<double>{white, 0});
  check_lobe("RetroPhong 50", RetroPhong<double>{white, 50});
  check_lobe("Ward .1 .4", Ward<double>{white, 0.1, 0.4});
  check_lobe("Ward .5", Ward<double>{white, 0.5, 0.5});
  check_lobe("OrenNayar", OrenNayar<double>{white, 0.3});
  for (const MicrofacetType type : {MicrofacetType::beckmann, MicrofacetType::ggx}) {
    check_lobe("Conductor .05", RoughConductor<double>{type, 0.05, 0.05});
    check_lobe("Conductor .4 .1", RoughConductor<double>{type, 0.4, 0.1});
    check_lobe("Conductor 1", RoughConductor<double>{type, 1, 1});
  }
}

/// Share of the draws that stay above the surface.
template <class M>
double kept_share(const M& material, double degrees) {
  constexpr int k_side = 1000;  // midpoint rule: error of order (perimeter of the kept region) / 2 k_side
  int kept = 0;
  for (int i = 0; i < k_side; ++i) {
    for (int j = 0; j < k_side; ++j) {
      const Vec2<double> u((i + 0.5) / k_side, (j + 0.5) / k_side);
      kept += material.sample(at_degrees(degrees), Walk::eye, 0.5, u).has_value() ? 1 : 0;
    }
  }
  return static_cast<double>(kept) / (static_cast<double>(k_side) * k_side);
}

// Below-horizon mass by the published oracle; the pdf must integrate to the same share.
TEST(Samplers, KeepTheRightShareAboveTheHorizon) {
  const Rgb<double> white(1);
  const Ward<double> narrow{white, 0.2, 0.2};
  const Ward<double> wide{white, 0.5, 0.5};
  const Phong<double> phong{white, 10};
  EXPECT_NEAR(kept_share(narrow, 85), 0.6189, 6e-4);  // half a unit of the oracle + the midpoint rule
  EXPECT_NEAR(kept_share(wide, 45), 0.8465, 6e-4);    // the same
  const auto integral = [](const auto& material, double degrees) {
    return integrate_hemisphere([&](const Vec3<double>& w) { return material.pdf(at_degrees(degrees), w, Walk::eye); });
  };
  EXPECT_NEAR(integral(narrow, 85), 0.6189, 6e-5);  // half a unit of the oracle
  EXPECT_NEAR(integral(wide, 45), 0.8465, 6e-5);
  EXPECT_NEAR(integral(phong, 90 - 1e-9), 0.5, 1e-5);  // the lobe is cut through its axis; quadrature accuracy
  EXPECT_NEAR(kept_share(phong, 60), integral(phong, 60), 6e-4);
}

}  // namespace
}  // namespace manylight::test::samplers_test
