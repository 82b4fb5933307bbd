// SPDX-License-Identifier: Apache-2.0
// What holds for every material alike: the concept, sizes, reciprocity, grazing directions, parameter checks.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <type_traits>

#include "manylight/core/sampler.hpp"
#include "scattering/material_list.hpp"
#include "support/quadrature.hpp"

namespace manylight::test::materials_test {
namespace {

template <class M>
constexpr bool is_small_value = SetEvaluable<M>&& std::is_trivially_copyable_v<M> && sizeof(M) <= 64;

static_assert(is_small_value<Lambertian<float>> && sizeof(Lambertian<float>) == 12);
static_assert(is_small_value<OrenNayar<float>> && is_small_value<Phong<float>> && is_small_value<Ward<float>>);
static_assert(is_small_value<Mirror<float>> && is_small_value<SmoothConductor<float>>);
static_assert(is_small_value<RoughConductor<float>> && is_small_value<Dielectric<float>>);
static_assert(is_small_value<ThinDielectric<float>> && is_small_value<Plastic<float>>);
static_assert(is_small_value<RoughPlastic<float>> && is_small_value<RoughDielectric<float>>);
static_assert(is_small_value<Mixture<Lambertian<float>, Ward<float>>>);
static_assert(is_small_value<AnyOf<Lambertian<float>, RoughPlastic<float>, RoughConductor<float>, Dielectric<float>>>);
/// A user's material: no sets, so no bounds. Mixtures of it evaluate sets all the same, up to infinity.
struct Unbounded {
  using Scalar = double;
  Lambertian<double> base;
  [[nodiscard]] Rgb<double> eval(const Vec3<double>& wi, const Vec3<double>& wo) const { return base.eval(wi, wo); }
  [[nodiscard]] auto sample(const Vec3<double>& known, Walk walk, double u_lobe, const Vec2<double>& u) const {
    return base.sample(known, walk, u_lobe, u);
  }
  [[nodiscard]] double pdf(const Vec3<double>& a, const Vec3<double>& b, Walk w) const { return base.pdf(a, b, w); }
  [[nodiscard]] Rgb<double> albedo() const { return base.albedo(); }
  [[nodiscard]] bool is_delta() const { return false; }
};
static_assert(Material<Unbounded> && !SetEvaluable<Unbounded> && SetEvaluable<Mixture<Unbounded, Phong<double>>>);

// Who needs no tangent. Ward and RoughConductor may be anisotropic, so they and what holds one store a frame.
template <class... Ms>
constexpr bool all_isotropic = (k_is_isotropic<Ms> && ...);
static_assert(all_isotropic<Lambertian<float>, OrenNayar<float>, Phong<float>, Plastic<float>, RoughPlastic<float>>);
static_assert(all_isotropic<Mirror<float>, SmoothConductor<float>, Dielectric<float>, ThinDielectric<float>>);
static_assert(all_isotropic<Mixture<Lambertian<float>, Phong<float>, Mirror<float>>>);
static_assert(all_isotropic<AnyOf<Lambertian<float>, Mixture<Lambertian<float>, Phong<float>>, Dielectric<float>>>);
static_assert(!k_is_isotropic<Ward<float>> && !k_is_isotropic<RoughConductor<float>> && !k_is_isotropic<Unbounded>);
static_assert(!k_is_isotropic<Mixture<Lambertian<float>, Ward<float>>>);
static_assert(!k_is_isotropic<Mixture<Ward<float>, Lambertian<float>>>);
static_assert(!k_is_isotropic<AnyOf<Lambertian<float>, Mixture<Lambertian<float>, Ward<float>>>>);
static_assert(!k_is_isotropic<AnyOf<Mirror<float>, RoughConductor<float>>>);

// Oracle: the definition, a turn of both directions by any angle about the normal. Planted bugs seen to fail: Ward that
// claims it (the parameter sets with different roughness along x and y); a Phong lobe whose axis leans along x by 0.1.
TEST(Materials, TurnsAboutTheNormalChangeNothingOfIsotropicOnes) {
  int tested = 0;
  for_each_material<double>([&](const std::string& name, const auto& material) {
    if constexpr (k_is_isotropic<std::remove_cvref_t<decltype(material)>>) {
      ++tested;
      IndependentStream<double> stream(12, Stage::test, 0, 0);
      for (int k = 0; k < 500; ++k) {
        const Vec3<double> a = warp::square_to_cosine_hemisphere(stream.next_2d());
        const Vec3<double> b = warp::square_to_cosine_hemisphere(stream.next_2d());
        const double angle = 2 * k_pi<double> * stream.next();
        const auto turned = [&](const Vec3<double>& w) {
          return Vec3<double>(std::cos(angle) * w.x - std::sin(angle) * w.y,
                              std::sin(angle) * w.x + std::cos(angle) * w.y, w.z);
        };
        const Rgb<double> before = material.eval(a, b);
        const Rgb<double> after = material.eval(turned(a), turned(b));
        // Rounding; exponents amplify an ulp by at most their size, 700, and OrenNayar cancels towards 0 where it is
        // cut, which an absolute ulp of 1/pi allows for.
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(after[c], before[c], 1e-10 * before[c] + 1e-15) << name;
        const double density = material.pdf(a, b, Walk::eye);
        ASSERT_NEAR(material.pdf(turned(a), turned(b), Walk::eye), density, 1e-10 * density + 1e-15) << name;
      }
    }
  });
  EXPECT_GE(tested, 15);
}

// Every model here with a part to connect is reciprocal. Planted bug seen to fail: masking of wo alone.
TEST(Materials, AreReciprocal) {
  for_each_material<double>([](const std::string& name, const auto& material) {
    IndependentStream<double> stream(9, Stage::test, 0, 0);
    for (int k = 0; k < 500; ++k) {
      const Vec3<double> a = warp::square_to_cosine_hemisphere(stream.next_2d());
      const Vec3<double> b = warp::square_to_cosine_hemisphere(stream.next_2d());
      const Rgb<double> forward = material.eval(a, b);
      const Rgb<double> backward = material.eval(b, a);
      // Rounding; exponents amplify an ulp by at most their size, 700, and the pole of a lobe by its slope.
      EXPECT_NEAR(forward.x, backward.x, 1e-10 * forward.x + 1e-290) << name;
      EXPECT_NEAR(forward.z, backward.z, 1e-10 * forward.z + 1e-290) << name;
    }
  });
}

template <class S>
bool is_fine(const Rgb<S>& c) {
  return is_valid_radiance(c);
}

/// eval, pdf, sample and bounds for one pair: finite, not negative, unit directions.
template <class M, class S>
void expect_sane(const std::string& name, const M& material, const Vec3<S>& a, const Vec3<S>& b) {
  EXPECT_TRUE(is_fine(material.eval(a, b))) << name << " z " << a.z << " and " << b.z;
  for (const Walk walk : {Walk::eye, Walk::light}) {
    const S pdf = material.pdf(a, b, walk);
    EXPECT_TRUE(std::isfinite(pdf) && pdf >= S(0)) << name << " z " << a.z << " and " << b.z;
    const S last = S(1) - S(0x1p-24);
    for (const Vec2<S>& u : {Vec2<S>(0), Vec2<S>(last), Vec2<S>(0, last), Vec2<S>(S(0.5)), Vec2<S>(S(0.3), S(0.8))}) {
      for (const S u_lobe : {S(0), S(0.4), last}) {
        const auto s = material.sample(a, walk, u_lobe, u);
        if (!s) continue;
        EXPECT_TRUE(is_finite(s->direction)) << name;
        EXPECT_NEAR(glm::length(s->direction), S(1), S(1e-5)) << name;  // some float ulp
        EXPECT_TRUE(s->pdf > S(0) && std::isfinite(s->pdf)) << name << " " << s->pdf;
        EXPECT_TRUE(is_fine(s->delta_weight)) << name;
        EXPECT_TRUE(is_fine(material.eval(s->direction, a)) && is_fine(material.eval(a, s->direction))) << name;
      }
    }
  }
}

template <class S>
void grazing_directions() {
  const auto near_plane = [](S z, S phi) {
    const S r = std::sqrt(S(1) - z * z);
    return Vec3<S>(r * std::cos(phi), r * std::sin(phi), z);
  };
  const std::array<S, 9> heights{S(1),
                                 S(0.5),
                                 S(1e-3),
                                 S(1e-6),
                                 S(1e-7),
                                 S(1e-12),
                                 S(1e-20),
                                 std::numeric_limits<S>::min(),
                                 std::numeric_limits<S>::denorm_min()};
  const auto all_pairs = [&](const std::string& name, const auto& material) {
    for (const S za : heights) {
      for (const S zb : heights) {
        for (const S phi : {S(0), S(1.3), k_pi<S>}) {  // retro, across, and forward: there a + b is only its z
          expect_sane(name, material, near_plane(za, S(0.2)), near_plane(zb, S(0.2) + phi));
        }
      }
      expect_sane(name, material, near_plane(za, S(0.2)), -near_plane(za, S(0.2)));
      expect_sane(name, material, near_plane(za, S(0.2)), Vec3<S>(1, 0, 0));
      expect_sane(name, material, Vec3<S>(0, 1, 0), near_plane(za, S(0.2)));
    }
  };
  for_each_material<S>(all_pairs);
  all_pairs("Mirror", Mirror<S>{});
  all_pairs("SmoothConductor", SmoothConductor<S>{});
  all_pairs("Dielectric", Dielectric<S>{});
  all_pairs("Dielectric inverse", Dielectric<S>{S(0.7)});
  all_pairs("ThinDielectric", ThinDielectric<S>{});
  all_pairs("RoughDielectric", RoughDielectric<S>{S(1.5), MicrofacetType::ggx, S(0.3), S(0.1)});
  all_pairs("RoughDielectric inverse", RoughDielectric<S>{S(0.7), MicrofacetType::beckmann, S(0.5), S(0.5)});
  // The sharpest roughness that is allowed.
  all_pairs("RoughDielectric 1e-4", RoughDielectric<S>{S(1.5), MicrofacetType::beckmann, S(1e-4), S(1e-4)});
  all_pairs("RoughDielectric weak", RoughDielectric<S>{S(1.001), MicrofacetType::ggx, S(1e-4), S(1e-4)});
  all_pairs("Ward 1e-4", Ward<S>{Rgb<S>(1), S(1e-4), S(1e-4)});
  all_pairs("GGX 1e-4", RoughConductor<S>{MicrofacetType::ggx, S(1e-4), S(1e-4)});
  all_pairs("Beckmann 1e-4", RoughConductor<S>{MicrofacetType::beckmann, S(1e-4), S(1e-4)});
  all_pairs("RetroPhong 1e5", RetroPhong<S>{Rgb<S>(1), S(1e5)});
  all_pairs("Phong 1e5", Phong<S>{Rgb<S>(1), S(1e5)});
}

// Stability case 36. Planted bug seen to fail: Ward without its floor.
TEST(Materials, StayFiniteAtGrazingDirectionsInFloat) { grazing_directions<float>(); }
TEST(Materials, StayFiniteAtGrazingDirectionsInDouble) { grazing_directions<double>(); }

/// G1(w) / w.z at a height of `z`.
template <class S>
S masking_near_plane(MicrofacetType type, S alpha, S z) {
  return MicrofacetDistribution<S>{type, alpha, alpha}.masking_over_cos(Vec3<S>(1, 0, z));
}

// The quotient has a limit in the tangent plane, 2 / alpha (GGX) and 2 sqrt(pi) / alpha (Beckmann), and keeps it down
// to the smallest number. Planted bug seen to fail: the quotient of G1 and the cosine, which falls to 0.
TEST(Materials, MaskingHasItsLimitInTheTangentPlane) {
  for (const float z : {1e-6f, 1e-20f, std::numeric_limits<float>::denorm_min()}) {
    // First order in z / alpha, and some ulp.
    EXPECT_NEAR(masking_near_plane(MicrofacetType::ggx, 0.1f, z), 20.0f, 20 * 2e-5f);
    EXPECT_NEAR(masking_near_plane(MicrofacetType::beckmann, 0.1f, z), 35.449077f, 35 * 4e-5f);
    EXPECT_NEAR(masking_near_plane(MicrofacetType::ggx, 0.1, static_cast<double>(z)), 20.0, 20 * 2e-5);
    EXPECT_NEAR(masking_near_plane(MicrofacetType::beckmann, 0.1, static_cast<double>(z)), 35.449077, 35 * 4e-5);
  }
}

template <class M>
void expect_rejected(M material, const std::string& named) {
  try {
    material.validate();
    ADD_FAILURE() << "accepted a bad " << named;
  } catch (const ParameterError& error) {
    EXPECT_NE(std::string(error.what()).find(named), std::string::npos) << error.what();
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
  }
}

// Stability case 23 and the like: NaN, negative and too large parameters are named.
TEST(Materials, RejectBadParameters) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, -0.1, 1.5, inf}) {
    const Rgb<double> colour(0.5, bad, 0.5);
    expect_rejected(Lambertian<double>{colour}, "Lambertian reflectance");
    expect_rejected(OrenNayar<double>{colour}, "OrenNayar reflectance");
    expect_rejected(Phong<double>{colour}, "Phong specular");
    expect_rejected(RetroPhong<double>{colour}, "RetroPhong specular");
    expect_rejected(Ward<double>{colour}, "Ward specular");
    expect_rejected(Mirror<double>{colour}, "Mirror reflectance");
    expect_rejected(SmoothConductor<double>{Rgb<double>(1), Rgb<double>(1), colour}, "SmoothConductor specular");
    expect_rejected(Dielectric<double>{1.5, colour}, "Dielectric specular_reflectance");
    expect_rejected(ThinDielectric<double>{1.5, Rgb<double>(1), colour}, "ThinDielectric specular_transmittance");
    expect_rejected(Plastic<double>(colour, Rgb<double>(1), 1.5), "Plastic diffuse");
    expect_rejected(RoughPlastic<double>{&coat_ggx<double>(), Rgb<double>(1), colour}, "RoughPlastic specular");
    expect_rejected(Mixture<Lambertian<double>, Phong<double>>({Lambertian<double>{}, 1}, {Phong<double>{colour}, 1}),
                    "Phong specular");
    expect_rejected(AnyMaterial<double>(Lambertian<double>{colour}), "Lambertian reflectance");
  }
  for (const double bad : {nan, -1.0, 0.0, 1e-6, inf}) {
    expect_rejected(Ward<double>{Rgb<double>(1), 0.1, bad}, "Ward alpha_v");
    expect_rejected(RoughConductor<double>{MicrofacetType::ggx, bad, 0.1}, "RoughConductor alpha_u");
    EXPECT_THROW((RoughTransmittance<double>(MicrofacetType::ggx, bad, 1.5)), ParameterError);
    expect_rejected(Dielectric<double>{bad}, "Dielectric eta");
    expect_rejected(ThinDielectric<double>{bad}, "ThinDielectric eta");
    expect_rejected(RoughDielectric<double>{bad}, "RoughDielectric eta");
    expect_rejected(RoughDielectric<double>{1.5, MicrofacetType::ggx, 0.1, bad}, "RoughDielectric alpha_v");
    expect_rejected(Plastic<double>(Rgb<double>(1), Rgb<double>(1), bad), "Plastic eta");
  }
  for (const double bad : {nan, -1.0, inf}) {
    expect_rejected(Phong<double>{Rgb<double>(1), bad}, "Phong exponent");
    expect_rejected(OrenNayar<double>{Rgb<double>(1), bad}, "OrenNayar alpha");
    expect_rejected(RoughConductor<double>{MicrofacetType::ggx, 0.1, 0.1, Rgb<double>(bad)}, "RoughConductor eta");
    expect_rejected(SmoothConductor<double>{Rgb<double>(1), Rgb<double>(bad)}, "SmoothConductor k");
    expect_rejected(Mixture<Lambertian<double>, Phong<double>>({Lambertian<double>{}, bad}, {Phong<double>{}, 1}),
                    "Mixture weight");
  }
  expect_rejected(RoughPlastic<double>{}, "RoughPlastic coat");
  expect_rejected(RoughDielectric<double>{1.0}, "RoughDielectric eta");
  EXPECT_THROW((RoughTransmittance<double>(MicrofacetType::ggx, 0.1, nan)), ParameterError);
  for_each_material<float>(
      [](const std::string& name, const auto& material) { EXPECT_NO_THROW(material.validate()) << name; });
}

// Oren-Nayar: alpha = 0 is Lambertian, and the retro-reflection exceeds the forward scattering.
TEST(OrenNayar, LimitsAndRetroReflection) {
  for (const OrenNayarModel model : {OrenNayarModel::full, OrenNayarModel::qualitative}) {
    const OrenNayar<double> smooth{Rgb<double>(0.6), 0.0, model};
    EXPECT_NEAR(smooth.eval(at_degrees(50), at_degrees(70, 1.0)).x, 0.6 / k_pi<double>, 1e-16);  // an ulp
    const OrenNayar<double> rough{Rgb<double>(0.6), 0.8, model};
    EXPECT_GT(rough.eval(at_degrees(60), at_degrees(60)).x,
              1.3 * rough.eval(at_degrees(60, k_pi<double>), at_degrees(60)).x);
  }
  // The short form by hand: sigma^2 = .32, A = 1 - .5 * .32 / .65, B = .45 * .32 / .41, both at 45 degrees, same
  // azimuth.
  const OrenNayar<double> rough{Rgb<double>(1), 0.8, OrenNayarModel::qualitative};
  const double expected = (1 - 0.5 * 0.32 / 0.65 + 0.45 * 0.32 / 0.41 * std::sqrt(0.5)) / k_pi<double>;
  EXPECT_NEAR(rough.eval(at_degrees(45), at_degrees(45)).x, expected, 1e-15);  // some ulp
  // The full form by hand at the same place: a = b = 45 degrees: C1 + C2 sin a tan b, and rho^2 C4 (1 - (2b/pi)^2).
  const OrenNayar<double> full{Rgb<double>(0.5), 0.8};
  const double single = 1 - 0.5 * 0.32 / 0.65 + 0.45 * 0.32 / 0.41 * std::sqrt(0.5);
  const double twice = 0.17 * 0.32 / 0.45 * (1 - 0.25);
  EXPECT_NEAR(full.eval(at_degrees(45), at_degrees(45)).x, (0.5 * single + 0.25 * twice) / k_pi<double>, 1e-15);
  // And across (cos phi = 0): the C3 term, (4 a b / pi^2)^2 tan((a + b) / 2) with a = b = 45 degrees.
  const double across = 1 - 0.5 * 0.32 / 0.65 + 0.125 * 0.32 / 0.41 * sqr(0.25) * 1.0;
  EXPECT_NEAR(full.eval(at_degrees(45), at_degrees(45, k_pi<double> / 2)).x,
              (0.5 * across + 0.25 * 0.17 * 0.32 / 0.45) / k_pi<double>, 1e-14);
}

}  // namespace
}  // namespace manylight::test::materials_test
