// SPDX-License-Identifier: Apache-2.0
// Oracle: the exponential law in closed form.
#include "manylight/media/homogeneous.hpp"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "media/media_support.hpp"
#include "support/chi_square.hpp"

namespace manylight::test::homogeneous_test {
namespace {

template <std::floating_point S>
using Medium = Homogeneous<PlainPhase<S>>;
static_assert(manylight::Medium<Medium<float>> && manylight::Medium<Medium<double>>);

const Ray<double> k_ray{{1, 2, 3}, {0, 0.6, 0.8}};

struct Case {
  Rgb<double> sigma_a, sigma_s;
  double t_max;
};
const std::vector<Case> k_cases{{{0.05, 0.05, 0.05}, {0.1, 0.1, 0.1}, 3},
                                {{0.5, 0, 0.1}, {0.1, 0.7, 3}, 1.5},
                                {{0, 0, 0}, {0.2, 0, 5}, 2},
                                {{0, 0, 0}, {0.2, 0, 5}, k_infinity<double>},
                                {{0.3, 2, 0}, {0, 0, 0}, 0.7},
                                {{1, 2, 3}, {1, 1, 1}, k_infinity<double>}};

double transmittance_of(double sigma, double t) { return sigma > 0 ? std::exp(-sigma * t) : 1.0; }

TEST(Homogeneous, TransmittanceEqualsTheExponentialLaw) {
  IndependentStream<double> stream(1, Stage::test, 0, 0);
  const Medium<double> medium(Rgb<double>(0.1, 0.5, 2), Rgb<double>(0, 0.5, 3));
  const Rgb<double> t = medium.transmittance(k_ray, 1.0, stream);
  EXPECT_NEAR(t.x, 0.904837, 5e-7);  // half a unit of the last digit, as all of these
  EXPECT_NEAR(t.y, 0.367879, 5e-7);
  EXPECT_NEAR(t.z, 0.00673795, 5e-9);
  EXPECT_EQ(medium.mean_transmittance(k_ray, 1.0), t);
  EXPECT_EQ(medium.min_sigma_t(), 0.1);
}

TEST(Homogeneous, WithoutExtinctionItIsVacuumToTheBit) {
  IndependentStream<float> stream(2, Stage::test, 0, 0);
  for (const float t_max : {1e-3F, 5.0F, k_infinity<float>}) {
    for (int i = 0; i < 100; ++i) {
      const auto s = Medium<float>().sample({{0, 0, 0}, {1, 0, 0}}, t_max, stream);
      EXPECT_FALSE(s.scattered);
      EXPECT_EQ(s.weight, Rgb<float>(1));
      EXPECT_EQ(s.t, t_max);
    }
    EXPECT_EQ(Medium<float>().mean_transmittance({{0, 0, 0}, {1, 0, 0}}, t_max), Rgb<float>(1));
  }
}

// Planted bugs seen to fail: division by the density of the drawn channel alone; the mean density over the channels
// with extinction only.
TEST(Homogeneous, FlightsAreUnbiasedInEachChannel) {
  std::uint64_t seed = 10;
  for (const Case& c : k_cases) {
    const Medium<double> medium(c.sigma_a, c.sigma_s);
    const FlightMoments m = fly(medium, k_ray, c.t_max, 100000, ++seed);
    for (int k = 0; k < 3; ++k) {
      const std::string what = "case " + std::to_string(seed - 11) + " channel " + std::to_string(k);
      expect_mean(m.all[static_cast<std::size_t>(k)], 1, what);
      expect_mean(m.through[static_cast<std::size_t>(k)], transmittance_of((c.sigma_a + c.sigma_s)[k], c.t_max), what);
    }
    EXPECT_LE(m.largest, 3 * (1 + 1e-12));  // a mean of three densities, one of them the channel's own; some ulp
  }
}

TEST(Homogeneous, GreyFlightsAreAnalog) {
  const Medium<double> medium(Rgb<double>(0.5), Rgb<double>(1.5));
  IndependentStream<double> stream(20, Stage::test, 0, 0);
  for (int i = 0; i < 1000; ++i) {
    const auto s = medium.sample(k_ray, 0.5, stream);
    EXPECT_NEAR(s.weight.x, s.scattered ? 0.5 : 1.0, 1e-14);  // some ulp
  }
}

// Family of the cases: level 1e-4.
TEST(Homogeneous, FlightsFollowTheMeanDensityOfTheChannels) {
  std::uint64_t seed = 30;
  for (const Case& c : k_cases) {
    const Rgb<double> sigma = c.sigma_a + c.sigma_s;
    const Medium<double> medium(c.sigma_a, c.sigma_s);
    const double end = std::isfinite(c.t_max) ? c.t_max : 60.0;
    constexpr int k_bins = 60;
    const double n = 100000;
    // Bins narrow towards the origin: edges are end (i / k_bins)^2.
    const auto edge = [&](int i) { return end * sqr(static_cast<double>(i) / k_bins); };
    const auto survival = [&](double t) {
      return (transmittance_of(sigma.x, t) + transmittance_of(sigma.y, t) + transmittance_of(sigma.z, t)) / 3;
    };
    std::vector<ExpectedCount> cells(k_bins + 1);
    for (int i = 0; i < k_bins; ++i) {
      auto& cell = cells[static_cast<std::size_t>(i)];
      cell.expected = n * std::max(survival(edge(i)) - survival(edge(i + 1)), 1e-12);
      cell.name = std::to_string(edge(i));
    }
    cells.back() = {n * std::max(survival(end), 1e-12), 0, "through"};
    IndependentStream<double> stream(++seed, Stage::test, 0, 0);
    for (int i = 0; i < static_cast<int>(n); ++i) {
      const auto s = medium.sample(k_ray, c.t_max, stream);
      EXPECT_EQ(s.scattered, s.t < c.t_max);
      const int bin = s.t < end ? static_cast<int>(std::sqrt(s.t / end) * k_bins) : k_bins;
      cells[static_cast<std::size_t>(bin)].observed += 1;
    }
    const auto r = chi_square(cells);
    EXPECT_TRUE(r.passes(sidak_level(1e-4, static_cast<double>(k_cases.size())))) << seed << ' ' << r.describe();
  }
}

TEST(Homogeneous, WeightsIntegrateToTheTransmittance) {
  const Medium<double> medium(Rgb<double>(0.1, 0.5, 2), Rgb<double>(0.3));
  IndependentStream<double> stream(40, Stage::test, 0, 0);
  std::array<RunningMoments, 3> up_to;
  constexpr double k_x = 0.8;
  for (int i = 0; i < 200000; ++i) {
    const auto s = medium.sample(k_ray, 4.0, stream);
    for (int c = 0; c < 3; ++c) {
      up_to[static_cast<std::size_t>(c)].add(s.scattered && s.t < k_x ? s.weight[c] : 0.0);
    }
  }
  for (int c = 0; c < 3; ++c) {
    const double sigma = medium.sigma_t(k_ray.origin, k_ray.direction)[c];
    expect_mean(up_to[static_cast<std::size_t>(c)], -std::expm1(-sigma * k_x) / sigma, "channel");
  }
}

// One scattering between an isotropic point light (1 W/sr) and the eye, sigma_s .1, sigma_a .05: light 1 m beside the
// ray, its foot at t = 2. Oracle: quadrature, to the digits given.
TEST(Homogeneous, AirlightEqualsTheQuadrature) {
  const Medium<double> medium(Rgb<double>(0.05), Rgb<double>(0.1));
  const Ray<double> ray{{0, 0, 0}, {1, 0, 0}};
  const Vec3<double> light(2, 1, 0);
  for (const auto& [t_max, oracle] : {std::pair{k_infinity<double>, 0.0115445}, std::pair{5.0, 0.0112312}}) {
    IndependentStream<double> stream(50, Stage::test, 0, 0);
    RunningMoments m;
    for (int i = 0; i < 1000000; ++i) {
      const auto s = medium.sample(ray, t_max, stream);
      if (!s.scattered) {
        m.add(0);
        continue;
      }
      const Vec3<double> x = ray.origin + ray.direction * s.t;
      const double d = glm::length(light - x);
      const Vec3<double> w = (light - x) / d;
      const double sigma_s = medium.sigma_s(x, w).x;
      m.add(s.weight.x * sigma_s * medium.phase(x).eval(w, -ray.direction) * medium.mean_transmittance({x, w}, d).x /
            (d * d));
    }
    expect_mean(m, oracle, "airlight", 5e-8);  // half a unit of the last digit
  }
}

TEST(Homogeneous, ExtremeVariatesAndCoefficientsStayFinite) {
  const Ray<float> ray{{0, 0, 0}, {0, 0, 1}};
  const std::vector<float> sigmas{0.0F, 1e-20F, 1e-3F, 1.0F, 1e20F};
  for (const float r : sigmas) {
    for (const float g : sigmas) {
      const Medium<float> medium(Rgb<float>(r, g, 1), Rgb<float>(0, r, g));
      for (const float t_max : {1e-30F, 1.0F, 1e30F, k_infinity<float>}) {
        for (const float u : {0.0F, 0.4F, 1 - 0x1p-24F}) {
          for (const float channel : {0.0F, 0.5F, 1 - 0x1p-24F}) {
            FixedStream<float> stream{{channel, u}};
            const auto s = medium.sample(ray, t_max, stream);
            EXPECT_TRUE(is_valid_radiance(s.weight)) << r << ' ' << g << ' ' << t_max << ' ' << u;
            EXPECT_TRUE(s.t > 0 && s.t <= t_max);
            EXPECT_TRUE(is_valid_radiance(s.weight * medium.sigma_s({}, {})));
            EXPECT_TRUE(is_valid_radiance(medium.mean_transmittance(ray, t_max)));
          }
        }
      }
    }
  }
}

TEST(Homogeneous, WrongCoefficientsAreNamed) {
  EXPECT_THROW(Medium<double>(Rgb<double>(-1, 0, 0), Rgb<double>(0)), ParameterError);
  EXPECT_THROW(Medium<double>(Rgb<double>(0), Rgb<double>(0, std::nan(""), 0)), ParameterError);
  EXPECT_THROW(Medium<double>(Rgb<double>(0), Rgb<double>(0, 0, k_infinity<double>)), ParameterError);
  try {
    Medium<double>(Rgb<double>(0), Rgb<double>(0, -2, 0));
    FAIL();
  } catch (const ParameterError& error) {
    EXPECT_STREQ(error.what(), "scattering coefficient is -2, allowed: 0 or 1e-20 to 1e20 in each channel");
  }
}

}  // namespace
}  // namespace manylight::test::homogeneous_test
