// SPDX-License-Identifier: Apache-2.0
// Vertices of isotropic materials store the shading normal alone. Oracle: the BSDF in the frame of the hit.

#include <gtest/gtest.h>

#include <type_traits>

#include "manylight/path/connect.hpp"
#include "manylight/scattering/any_of.hpp"
#include "manylight/scattering/dielectric.hpp"
#include "manylight/scattering/lambertian.hpp"
#include "manylight/scattering/oren_nayar.hpp"
#include "manylight/scattering/plastic.hpp"
#include "manylight/scattering/ward.hpp"
#include "support/random_vertices.hpp"

namespace manylight::vertex_test {
namespace {

template <class S>
using GlossyPaint = Mixture<Lambertian<S>, Phong<S>>;

// One frame less is 12 bytes of 120: lights and their trees are read in large numbers.
static_assert(sizeof(Vertex<float, GlossyPaint<float>>) == 108);
static_assert(sizeof(Vertex<float, Mixture<Lambertian<float>, Ward<float>>>) ==
              sizeof(Vertex<float, GlossyPaint<float>>) + sizeof(Ward<float>) - sizeof(Phong<float>) + 12);

/// Both patterns of a vertex against eval in the frame of its hit, for `count` random hits with bent normals.
template <class S, class M>
void check_patterns(const M& material, S tolerance) {
  static_assert(k_is_isotropic<M>);
  test::RandomVertices<S> random(41);
  for (int n = 0; n < 500; ++n) {
    Interaction<S, M> hit{};
    hit.ng = random.direction();
    hit.frame = Frame<S>(glm::normalize(hit.ng + random.direction() * S(0.4)), random.direction());
    hit.material = material;
    const Vec3<S> w = random.above(hit.ng, hit.frame.n);
    const Vec3<S> other = random.above(hit.ng, hit.frame.n);
    const auto v = surface_vertex<Vertex<S, M>>(hit, w);
    const Rgb<S> f = material.eval(hit.frame.to_local(other), hit.frame.to_local(w));
    const Rgb<S> m = f * (std::abs(glm::dot(other, hit.frame.n)) / v.alpha);
    const Rgb<S> d =
        material.eval(hit.frame.to_local(w), hit.frame.to_local(other)) * (std::abs(glm::dot(other, hit.ng)) / v.alpha);
    for (int c = 0; c < 3; ++c) {
      ASSERT_NEAR(sensor_patterns(v, other).m[c], m[c], tolerance * (S(1) + m[c])) << n;
      ASSERT_NEAR(light_pattern(v, other)[c], d[c], tolerance * (S(1) + d[c])) << n;
    }
  }
}

template <class S>
void check_materials(S tolerance) {
  const Rgb<S> red(S(0.6), S(0.2), S(0.1));
  const GlossyPaint<S> paint({Lambertian<S>{red}, S(1)}, {Phong<S>{red, S(40)}, S(0.5)});
  check_patterns<S>(paint, tolerance);
  check_patterns<S>(OrenNayar<S>{red, S(0.7)}, tolerance);
  check_patterns<S>(Plastic<S>(red, Rgb<S>(1), S(1.5)), tolerance);
  check_patterns<S>(AnyOf<Lambertian<S>, GlossyPaint<S>, Dielectric<S>>(paint), tolerance);
}

// Planted bugs seen to fail: the frame built around ng; its s and n exchanged.
TEST(Vertex, NormalAloneGivesTheSamePatterns) {
  check_materials<double>(1e-12);
  check_materials<float>(2e-4F);  // direction rounding 1e-7 times the exponent 40, times 20 near grazing angles
}

}  // namespace
}  // namespace manylight::vertex_test
