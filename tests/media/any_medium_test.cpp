// SPDX-License-Identifier: Apache-2.0
// Oracle: the medium that is held.
#include "manylight/media/any_medium.hpp"

#include <gtest/gtest.h>

#include "manylight/media/heterogeneous.hpp"
#include "manylight/media/homogeneous.hpp"
#include "media/media_support.hpp"

namespace manylight::test::any_medium_test {
namespace {

using Fog = Homogeneous<PlainPhase<float>>;
using Smoke = Heterogeneous<PlainPhase<float>>;
/// Made from the phases of the parts.
struct EitherPhase {
  using Scalar = float;
  float id = 0;
  EitherPhase(const PlainPhase<float>& phase) : id(phase.id) {}  // NOLINT(google-explicit-constructor)
};
using Either = AnyMedium<Fog, Smoke>;
static_assert(Medium<Either> && !Either::k_closed_form && AnyMedium<Fog>::k_closed_form);
static_assert(Medium<AnyMediumWith<EitherPhase, Fog, Smoke>>);

template <class M>
void equals(const Either& any, const M& part) {
  const Ray<float> ray{{-1, 0.4F, 0.3F}, {1, 0, 0}};
  const Vec3<float> x(0.5F, 0.4F, 0.3F);
  EXPECT_EQ(any.sigma_t(x, ray.direction), part.sigma_t(x, ray.direction));
  EXPECT_EQ(any.sigma_s(x, ray.direction), part.sigma_s(x, ray.direction));
  EXPECT_EQ(any.phase(x).id, part.phase(x).id);
  EXPECT_EQ(any.min_sigma_t(), part.min_sigma_t());
  EXPECT_EQ(any.mean_transmittance(ray, 2), part.mean_transmittance(ray, 2));
  for (std::uint64_t k = 0; k < 50; ++k) {
    IndependentStream<float> a(1, Stage::test, k, 0);
    IndependentStream<float> b(1, Stage::test, k, 0);
    EXPECT_EQ(any.sample(ray, 2, a).t, part.sample(ray, 2, b).t);
    EXPECT_EQ(any.transmittance(ray, 2, a), part.transmittance(ray, 2, b));
  }
}

TEST(AnyMedium, IsTheMediumThatItHolds) {
  const Fog fog(Rgb<float>(0.1F, 0.2F, 0), Rgb<float>(1, 0, 0.5F), {0.25F});
  const Smoke smoke(make_grid<float, float>({8, 8, 8}, rough_noise), 9, Rgb<float>(0.5F), {0.75F});
  equals(Either(fog), fog);
  equals(Either(smoke), smoke);
  EXPECT_EQ(Either(smoke).index(), 1U);
  EXPECT_EQ((AnyMediumWith<EitherPhase, Fog, Smoke>(smoke).phase({0, 0, 0}).id), 0.75F);
}

}  // namespace
}  // namespace manylight::test::any_medium_test
