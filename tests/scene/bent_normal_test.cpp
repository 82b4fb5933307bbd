// SPDX-License-Identifier: Apache-2.0
// Bump and normal maps against closed forms, and where they meet the rule of sides.
#include "manylight/scene/bent_normal.hpp"

#include <cmath>
#include <memory>

#include <gtest/gtest.h>

#include "manylight/geometry/bvh.hpp"
#include "manylight/geometry/mesh_builders.hpp"
#include "manylight/geometry/surface_point.hpp"
#include "manylight/path/connect.hpp"
#include "manylight/scattering/lambertian.hpp"
#include "manylight/scattering/texture.hpp"
#include "manylight/scene/scene.hpp"

namespace manylight::bent_normal_test {
namespace {

using S = double;
constexpr S k_ulps = 1e-14;

/// A point of the plane z = 0 with position (2 u, 3 v) or its mirror image in uv.
SurfacePoint<S> plane_point(S u, S v, bool mirrored) {
  SurfacePoint<S> p{};
  p.ng = p.ns = {0, 0, 1};
  p.dpdu = {mirrored ? -2.0 : 2.0, 0, 0};
  p.dpdv = {0, 3, 0};
  p.uv = {mirrored ? -u : u, v};
  return p;
}

// Oracle: the plane z = h, h = a sin(k x) + b sin(m y), whose normal is (-h_x, -h_y, 1) up to its length.
// Planted bugs seen to fail: dh/du and dh/dv exchanged; no turn for mirrored texture coordinates.
TEST(BentNormal, SineBumpOnAPlane) {
  constexpr S a = 0.2;
  constexpr S b = 0.1;
  constexpr S k = 5;
  constexpr S m = 7;
  for (const bool mirrored : {false, true}) {
    for (int i = 0; i < 200; ++i) {
      const S x = 0.031 * i;
      const S y = 0.047 * i;
      const S h_x = a * k * std::cos(k * x);
      const S h_y = b * m * std::cos(m * y);
      const SurfacePoint<S> p = plane_point(x / 2, y / 3, mirrored);
      const Vec3<S> n = bumped_normal(p, Vec2<S>(h_x * p.dpdu.x, h_y * p.dpdv.y));
      EXPECT_NEAR(glm::length(n - glm::normalize(Vec3<S>(-h_x, -h_y, 1))), 0, k_ulps);
    }
  }
}

// The same bump as a texture: central texel differences, off by the third derivative, (2 pi / n)^2 / 24 of the slope.
TEST(BentNormal, SineBumpFromTexels) {
  constexpr std::uint32_t n = 256;
  auto texels = std::make_shared<Texels<S>>();
  texels->width = texels->height = n;
  for (std::uint32_t row = 0; row < n; ++row) {
    for (std::uint32_t column = 0; column < n; ++column) {
      texels->values.emplace_back(0.5 + 0.5 * std::sin(2 * k_pi<S> * (column + 0.5) / n));
    }
  }
  const Texture<S> heights = Texture<S>::bitmap(texels);
  for (std::uint32_t column = 0; column < n; ++column) {
    const S u = (column + 1.0) / n;  // half way between two texels
    const SurfacePoint<S> p = plane_point(u, 0.3, false);
    const Vec3<S> normal = bumped_normal(p, heights.gradient(p.uv) * 0.1);
    const S slope = 0.1 * k_pi<S> * std::cos(2 * k_pi<S> * u) / 2;
    EXPECT_NEAR(glm::length(normal - glm::normalize(Vec3<S>(-slope, 0, 1))), 0, 3e-5 * 0.16);
  }
}

// Oracle: differences of `eval`, exact within a bilinear patch. Planted bugs seen to fail: no chain rule through the
// map of texture coordinates; the weights of both rows exchanged.
TEST(BentNormal, GradientIsThatOfTheTexture) {
  auto texels = std::make_shared<Texels<S>>();
  texels->width = 3;
  texels->height = 2;
  for (const S value : {0.1, 0.7, 0.2, 0.9, 0.4, 0.3}) texels->values.emplace_back(value);
  const UvTransform<S> turned{0.8, -0.6, 0.1, 0.6, 0.8, 0.4};
  for (const TextureWrap wrap : {TextureWrap::repeat, TextureWrap::clamp, TextureWrap::mirror}) {
    const Texture<S> texture = Texture<S>::bitmap(texels, TextureFilter::bilinear, wrap, turned);
    for (int i = 0; i < 100; ++i) {
      const Vec2<S> uv(0.137 * i - 5, 0.071 * i - 3);
      constexpr S h = 1e-6;  // few of the points lie next to an edge of a patch: none of these
      const S du = (texture.eval(uv + Vec2<S>(h, 0)).x - texture.eval(uv - Vec2<S>(h, 0)).x) / (2 * h);
      const S dv = (texture.eval(uv + Vec2<S>(0, h)).x - texture.eval(uv - Vec2<S>(0, h)).x) / (2 * h);
      EXPECT_NEAR(texture.gradient(uv).x, du, 1e-8);  // rounding over h; the term s t bends by h^2
      EXPECT_NEAR(texture.gradient(uv).y, dv, 1e-8);  // the same
    }
  }
  EXPECT_EQ(Texture<S>::bitmap(texels, TextureFilter::nearest).gradient({0.3, 0.4}), Vec2<S>(0));
  EXPECT_EQ(Texture<S>(0.5).gradient({0.3, 0.4}), Vec2<S>(0));
}

TEST(BentNormal, NormalMapTurnsInTheShadingFrame) {
  SurfacePoint<S> p = plane_point(0.1, 0.2, false);
  EXPECT_NEAR(glm::length(mapped_normal(p, {0, 0, 0.2}) - Vec3<S>(0, 0, 1)), 0, k_ulps);
  EXPECT_NEAR(glm::length(mapped_normal(p, {0.6, 0, 0.8}) - Vec3<S>(0.6, 0, 0.8)), 0, k_ulps);
  EXPECT_NEAR(glm::length(mapped_normal(p, {0, 3, 4}) - Vec3<S>(0, 0.6, 0.8)), 0, k_ulps);
  p.dpdu = {0, 0, -5};  // a wall: u runs down
  p.ng = p.ns = {1, 0, 0};
  EXPECT_NEAR(glm::length(mapped_normal(p, {0.6, 0, 0.8}) - Vec3<S>(0.8, 0, -0.6)), 0, k_ulps);
}

// What cannot be bent stays as it is. Planted bug seen to fail: no look at ng.
TEST(BentNormal, FallsBackToTheShadingNormal) {
  SurfacePoint<S> p = plane_point(0.1, 0.2, false);
  EXPECT_EQ(mapped_normal(p, {0.5, 0, -0.1}), p.ns);
  EXPECT_EQ(mapped_normal(p, {0, 0, 0}), p.ns);
  const S inf = k_infinity<S>;
  EXPECT_EQ(bumped_normal(p, Vec2<S>(inf, 0)), p.ns);
  EXPECT_EQ(bumped_normal(p, Vec2<S>(std::nan(""), 0)), p.ns);
  EXPECT_EQ(mapped_normal(p, {std::nan(""), 0, 1}), p.ns);
  p.dpdu = p.dpdv = {0, 0, 0};  // no texture coordinates
  EXPECT_EQ(bumped_normal(p, Vec2<S>(0.5, 0.5)), p.ns);
  EXPECT_EQ(mapped_normal(p, {0.6, 0, 0.8}), p.ns);
  p = plane_point(0.1, 0.2, false);
  p.ns = glm::normalize(Vec3<S>(1, 0, 0.2));  // bent further along -dh/du it would leave the side of ng
  EXPECT_GT(glm::dot(bumped_normal(p, Vec2<S>(1, 0)), p.ng), 0);
  EXPECT_EQ(bumped_normal(p, Vec2<S>(-30, 0)), p.ns);
}

// Oracle: differences of the position over uv, along the tangents of a sphere and a disk; a triangle's linear map.
// Planted bug seen to fail: the sphere's dp/dv upwards.
TEST(BentNormal, TangentsAlongV) {
  Shapes<S> shapes;
  shapes.meshes.resize(1);
  shapes.meshes[0].positions = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}};
  shapes.meshes[0].triangles = {{0, 1, 2}};
  shapes.meshes[0].uvs = {{-0.5, 0}, {0, 0}, {-0.5, -1}};
  shapes.spheres.push_back({{1, 2, 3}, 2, false});
  shapes.disks.push_back({{0, 0, -4}, {0, 0, 1}, {1, 0, 0}, 3});
  const auto at = [&](std::uint32_t shape, const Vec3<S>& origin, const Vec3<S>& towards) {
    const Ray<S> ray{origin, towards - origin};
    return surface_point(shapes, ray, Hit<S>{1, shape, 0, 0.2, 0.3});
  };
  EXPECT_NEAR(glm::length(at(0, {0, 0, 1}, {0.4, 0.6, 0}).dpdv - Vec3<S>(0, -2, 0)), 0, k_ulps);
  for (const std::uint32_t shape : {1u, 2u}) {
    const Vec3<S> target =
        shape == 1 ? Vec3<S>(1, 2, 3) + 2.0 * glm::normalize(Vec3<S>(0.5, 0.3, 0.4)) : Vec3<S>(1, 1.5, -4);
    const SurfacePoint<S> p = at(shape, target + Vec3<S>(1, 1, 1), target);
    constexpr S h = 1e-5;
    const Vec3<S> step = p.dpdv * h + p.dpdu * (2 * h);
    const SurfacePoint<S> q = at(shape, target + Vec3<S>(1, 1, 1) + step, target + step);
    EXPECT_NEAR(q.uv.x - p.uv.x, 2 * h, 100 * h * h);  // second derivatives of order 10
    EXPECT_NEAR(q.uv.y - p.uv.y, h, 100 * h * h);
  }
}

/// A diffuse surface with one bent normal everywhere.
struct Bent {
  using Material = Lambertian<S>;
  static constexpr bool k_may_be_transparent = false;
  static constexpr bool k_may_absorb = false;
  Vec3<S> local;
  bool two_sided;
  [[nodiscard]] Material material(const SurfacePoint<S>&, bool) const noexcept { return {Rgb<S>(0.5)}; }
  [[nodiscard]] bool is_two_sided() const noexcept { return two_sided; }
  [[nodiscard]] Vec3<S> shading_normal(const SurfacePoint<S>& p) const noexcept { return mapped_normal(p, local); }
};

// The frame of an interaction is the bent one, turned to the side of the known direction; light from below ng and from
// below the bent normal is dark, in both roles. Planted bug seen to fail: the frame of `point.ns`.
TEST(BentNormal, SceneShadesWithItAndDoesNotLeak) {
  Shapes<S> shapes;
  shapes.meshes.push_back(rectangle_mesh<S>(glm::mat<4, 4, S>(1)));
  const Vec3<S> bent(0.6, 0, 0.8);
  EmitterList<S> lights;
  lights.points.push_back({{0, 0, 2}, Rgb<S>(1)});
  const Scene<Bvh<S>, Bent> scene(Bvh<S>(shapes), {Bent{bent, true}}, {0}, lights);
  for (const S side : {1.0, -1.0}) {
    const Ray<S> ray{{0.2, 0.1, side}, {0, 0, -side}};
    const auto hit = scene.geometry().closest_hit(ray);
    ASSERT_TRUE(hit.has_value());
    const auto at = scene.interaction(surface_point(scene.geometry().shapes(), ray, *hit), {0, 0, side});
    EXPECT_NEAR(glm::length(at.frame.n - bent * side), 0, k_ulps);
    const auto f = [&](const Vec3<S>& wi, const Vec3<S>& wo) {
      return scatter(at.material, at.frame, at.ng, glm::normalize(wi * side), glm::normalize(wo * side)).x;
    };
    EXPECT_NEAR(f({0.1, 0.2, 1}, {0, 0, 1}), 0.5 / k_pi<S>, k_ulps);
    EXPECT_EQ(f({1, 0, -0.1}, {0, 0, 1}), 0);  // above the bent normal, below the surface
    EXPECT_EQ(f({-1, 0, 0.1}, {0, 0, 1}), 0);  // below the bent normal, above the surface
    EXPECT_EQ(f({0, 0, 1}, {1, 0, -0.1}), 0);
    EXPECT_EQ(f({0, 0, 1}, {-1, 0, 0.1}), 0);
  }
}

}  // namespace
}  // namespace manylight::bent_normal_test
