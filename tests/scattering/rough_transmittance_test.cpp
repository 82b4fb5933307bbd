// SPDX-License-Identifier: Apache-2.0
// The rough coat's table against an integral over the facets that involves no sampler, and against the smooth limit.
#include "manylight/scattering/rough_transmittance.hpp"

#include <gtest/gtest.h>

#include "support/quadrature.hpp"

namespace manylight::test::rough_transmittance_test {
namespace {

/// Share transmitted, int (1 - F(w . m)) D(m) G1(w) G1(t) (w . m) / w.z dm, with t the direction refracted at m.
double transmitted_by_quadrature(const MicrofacetDistribution<double>& facets, double eta, const Vec3<double>& w) {
  return integrate_hemisphere(
      [&](const Vec3<double>& m) {
        const double c = glm::dot(w, m);
        if (c <= 0) return 0.0;
        const auto surface = fresnel_dielectric(c, eta);
        const Vec3<double> t = m * (c * surface.eta_ratio + surface.cos_t) - w * surface.eta_ratio;
        if (t.z >= 0) return 0.0;
        return (1 - surface.reflectance) * facets.density(m) * facets.masking_over_cos(w) * facets.masking(t) * c;
      },
      1e-6);
}

// Planted bug seen to fail: the reflected in place of the refracted direction masked.
TEST(RoughTransmittance, EqualsTheIntegralOverTheFacets) {
  for (const MicrofacetType type : {MicrofacetType::beckmann, MicrofacetType::ggx}) {
    for (const double alpha : {0.1, 0.4, 1.0}) {
      for (const double eta : {1.5, 0.7}) {
        const RoughTransmittance<double> table(type, alpha, eta);
        for (const int node : {0, 20, 63}) {  // on the nodes: no interpolation error
          const double cosine = std::max(node / 63.0, 1e-6);
          const Vec3<double> w(std::sqrt(1 - cosine * cosine), 0, cosine);
          // The rule of 48 x 48 normals: 2e-4 measured; 6e-3 for eta < 1, where total reflection cuts an edge.
          EXPECT_NEAR(table.at(node / 63.0), transmitted_by_quadrature({type, alpha, alpha}, eta, w),
                      eta > 1 ? 3e-4 : 7e-3)
              << "alpha " << alpha << " eta " << eta << " node " << node;
        }
      }
    }
  }
}

TEST(GaussLegendre, IsExactForItsDegree) {
  for (const std::size_t count : {std::size_t{1}, std::size_t{5}, std::size_t{48}}) {
    const auto rule = gauss_legendre(count);
    for (const std::size_t degree : {std::size_t{0}, std::size_t{1}, 2 * count - 1}) {
      double sum = 0;
      for (const QuadratureNode& node : rule) sum += node.weight * std::pow(node.x, static_cast<double>(degree));
      EXPECT_NEAR(sum, 1.0 / (static_cast<double>(degree) + 1.0), 1e-14)
          << count << " points, degree " << degree;  // ulps
    }
  }
}

TEST(RoughTransmittance, BecomesTheSmoothInterface) {
  const RoughTransmittance<double> table(MicrofacetType::beckmann, 1e-3, 1.5);
  for (const int node : {13, 40, 63}) {
    // alpha^2 times the curvature of F.
    EXPECT_NEAR(table.at(node / 63.0), 1 - fresnel_dielectric(node / 63.0, 1.5).reflectance, 1e-4);
  }
  // The interpolation of the steep rise at grazing angles over 1/63 costs 5e-4.
  EXPECT_NEAR(table.mean(), 1 - fresnel_diffuse_outside(1.5), 6e-4);
  EXPECT_NEAR(table.reflectance_inside(), fresnel_diffuse_inside(1.5), 3e-4);
}

// Reciprocity: the mean transmittance from inside, integrated from inside, equals the one derived from outside.
TEST(RoughTransmittance, InsideFollowsFromOutside) {
  for (const MicrofacetType type : {MicrofacetType::beckmann, MicrofacetType::ggx}) {
    const RoughTransmittance<double> outside(type, 0.3, 1.5);
    const RoughTransmittance<double> inside(type, 0.3, 1 / 1.5);
    EXPECT_NEAR(1 - outside.reflectance_inside(), inside.mean(), 2e-3);  // quadrature and interpolation of both tables
  }
}

TEST(RoughTransmittance, InterpolatesAndStaysInRange) {
  const RoughTransmittance<float> table(MicrofacetType::ggx, 0.2f, 1.5f);
  float largest = 0;
  for (int i = 0; i <= 1000; ++i) {
    const float t = table.at(static_cast<float>(i) / 1000);
    EXPECT_TRUE(t >= 0 && t <= 1);
    largest = std::max(largest, t);
  }
  EXPECT_LE(largest, table.max());
  EXPECT_FLOAT_EQ(table.at(2.0f), table.at(1.0f));
  EXPECT_FLOAT_EQ(table.at(-1.0f), table.at(0.0f));
  const float middle = 10.5f / 63;
  EXPECT_NEAR(table.at(middle), 0.5f * (table.at(10.0f / 63) + table.at(11.0f / 63)), 1e-6f);  // some ulp
}

TEST(RoughTransmittance, SinglyReflectedDefinition) {
  const RoughTransmittance<double> smooth(MicrofacetType::beckmann, 1e-3, 1.5,
                                          InternalReflectance::singly_reflected_nodes);
  // Equal weights on 64 nodes, ends included: 2/64 (sum of F mu) with F of the smooth interface from inside.
  double sum = 0;
  for (int i = 0; i < 64; ++i) sum += i / 63.0 * fresnel_dielectric(-i / 63.0, 1.5).reflectance;
  EXPECT_NEAR(smooth.reflectance_inside(), 2 * sum / 64, 2e-3);  // F's kink at the critical angle, smeared by alpha
  const RoughTransmittance<double> rough(MicrofacetType::ggx, 0.4, 1.5, InternalReflectance::singly_reflected_nodes);
  const RoughTransmittance<double> all(MicrofacetType::ggx, 0.4, 1.5);
  EXPECT_LT(rough.reflectance_inside(), all.reflectance_inside());
}

}  // namespace
}  // namespace manylight::test::rough_transmittance_test
