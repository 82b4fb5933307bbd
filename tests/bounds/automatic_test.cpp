// SPDX-License-Identifier: Apache-2.0
// Oracle: the materials' plain formulas, written down again, and dense sampling of cones. Deterministic seed.

#include "manylight/bounds/automatic.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "manylight/core/frame.hpp"
#include "manylight/scattering/lambertian.hpp"
#include "manylight/scattering/phong.hpp"
#include "manylight/scattering/retro_phong.hpp"

namespace manylight {
namespace {

template <class S>
class AutomaticBounds : public ::testing::Test {
 public:
  std::mt19937_64 random{41};
  double uniform() { return static_cast<double>(random() >> 11) * 0x1p-53; }
  Vec3<S> around(const Vec3<S>& axis, double angle) {
    const double phi = 2 * k_pi<double> * uniform();
    const double r = std::sin(angle);
    return glm::normalize(Vec3<S>(Frame<double>(glm::normalize(Vec3<double>(axis)))
                                      .to_world({r * std::cos(phi), r * std::sin(phi), std::cos(angle)})));
  }
  Vec3<S> upper() { return around({0, 0, 1}, std::acos(0.05 + 0.95 * uniform())); }

  /// Mean of bound over sampled maximum, for cones next to the mirror direction; fails if a sample is larger.
  template <class M>
  double mean_slack(const M& m, double half) {
    double sum = 0;
    int count = 0;
    int violations = 0;
    for (int i = 0; i < 1000; ++i) {
      const Vec3<S> wo = upper();
      const bool is_near = i % 2 == 0;
      const DirectionSet<S> set(is_near ? around(mirror(wo), 0.2 * uniform()) : around({0, 0, 1}, 3 * uniform()),
                                static_cast<S>(half));
      const S bound = sup_eval(m, set, wo);
      const S bound_cos = sup_eval_cos(m, set, wo);
      S most = 0;
      for (int k = 0; k < 1000; ++k) {
        const Vec3<S> wi = around(set.cone.axis, half * (uniform() < 0.5 ? 1 : std::sqrt(uniform())));
        const S value = max_channel(m.eval(wi, wo));
        most = std::max(most, value);
        violations += value <= bound && value * std::abs(wi.z) <= bound_cos ? 0 : 1;
      }
      if (!is_near || !(most > S(0))) continue;
      sum += static_cast<double>(bound / most);
      ++count;
    }
    EXPECT_EQ(violations, 0);
    return sum / count;
  }
};
using Scalars = ::testing::Types<float, double>;
TYPED_TEST_SUITE(AutomaticBounds, Scalars);

// Planted bug seen to fail: the minimum of two intervals with the upper end taken from the lower one.
TYPED_TEST(AutomaticBounds, AreNeverBelowSamplesAndTight) {
  using S = TypeParam;
  const Lambertian<S> diffuse{Rgb<S>(S(0.9), S(0.3), S(0.1))};
  const Phong<S> phong{Rgb<S>(S(0.2), S(0.8), S(0.3)), S(50)};
  for (const double half : {0.01, 0.1, 0.5}) {
    const double slack_diffuse = this->mean_slack(diffuse, half);
    const double slack_phong = this->mean_slack(phong, half);
    static_cast<void>(this->mean_slack(RetroPhong<S>{phong.specular, S(20)}, half));  // never below; its axis is wo
    const std::string name = "slack_at_" + std::to_string(half);
    ::testing::Test::RecordProperty(name + "_lambertian", std::to_string(slack_diffuse));
    ::testing::Test::RecordProperty(name + "_phong", std::to_string(slack_phong));
    EXPECT_LT(slack_diffuse, 1.001);  // constant: rounding alone
    EXPECT_LT(slack_phong, 1.2);      // exact but for the part below the horizon and sampling's own misses
  }
}

// Planted bug seen to fail: Phong's peak with its division turned into a product (float).
TYPED_TEST(AutomaticBounds, VectorsKeepTheirValuesToTheBit) {
  using S = TypeParam;
  const Lambertian<S> diffuse{Rgb<S>(S(0.9), S(0.3), S(0.1))};
  const Phong<S> phong{Rgb<S>(S(0.2), S(0.8), S(0.3)), S(50)};
  for (int i = 0; i < 100000; ++i) {
    const Vec3<S> wi = this->around({0, 0, 1}, 2 * this->uniform());
    const Vec3<S> wo = this->upper();
    const bool is_above = wi.z > S(0) && wo.z > S(0);
    EXPECT_EQ(diffuse.eval(wi, wo), is_above ? diffuse.reflectance * k_inv_pi<S> : Rgb<S>(0));
    const S c = glm::dot(Vec3<S>(-wo.x, -wo.y, wo.z), wi);
    const S lobe = c > S(0) ? std::pow(std::min(c, S(1)), phong.exponent) : S(0);
    const S peak = (phong.exponent + S(2)) / (S(2) * k_pi<S>);
    EXPECT_EQ(phong.eval(wi, wo), is_above ? phong.specular * (peak * lobe) : Rgb<S>(0));
  }
}

}  // namespace
}  // namespace manylight
