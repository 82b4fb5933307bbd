// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <memory>

#include "integrator/same_lights.hpp"

namespace manylight::test::many_rooms_slow_test {
namespace {

using S = float;
using SceneType = Scene<Bvh<S>, UniformShader<Lambertian<S>>>;

/// Stability case 8: a hundred closed rooms of a thousand lights each, of which the camera sees one. Bounds know
/// nothing of walls, so that a cut has to go down into every room near by. Asserted: the image is that of the visible
/// room's lights alone, by brute force, with a cut's usual error (measured: median 0.7 %, 90 % of pixels within 1.6 %,
/// largest 4.3 %); of 400,000 pairs the cut takes 528 on average and 1299 at most, four times the 125 of the visible
/// lights alone. All pinned with a margin. Caught: shadow rays of the cut left out; clusters dropped for good when
/// their representative is hidden.
TEST(ManyRooms, OneOfAHundredIsVisible) {
  SceneBuilder<Bvh<S>, Lambertian<S>> walls;
  EmitterList<S> visible;
  for (int room = 0; room < 100; ++room) {
    const Vec3<S> center(S(2.2) * static_cast<S>(room % 10), S(2.2) * static_cast<S>(room / 10), 0);
    auto box = box_mesh<S>(center - Vec3<S>(1), center + Vec3<S>(1));
    box.flip_normals = true;
    walls.mesh(box, {Rgb<S>(S(0.7), S(0.6), S(0.5))});
    for (int i = 0; i < 1000; ++i) {
      const auto at = [i](unsigned salt) {
        return to_unit_interval<S>(
            static_cast<std::uint32_t>(mix_bits(static_cast<std::uint64_t>(i) * 3 + salt) >> 32));
      };
      const Vec3<S> position =
          center + Vec3<S>(S(1.6) * at(0) - S(0.8), S(1.6) * at(1) - S(0.8), S(0.5) + S(0.4) * at(2));
      walls.point_light(position, S(1e-3));
      if (room == 55) visible.points.push_back({position, Rgb<S>(S(1e-3))});
    }
  }
  auto alone = walls;
  alone.lights = visible;
  const auto full_scene = walls.build();
  const auto visible_scene = alone.build();
  const Vec3<S> center(11, 11, 0);
  const auto camera = look_at<S>(center + Vec3<S>(S(0.3), S(-0.9), 0), center + Vec3<S>(0, 1, S(-0.4)), S(70), 24);
  Settings settings;
  settings.samples = 4;
  settings.vpls = 1;  // the point lights alone
  settings.max_edges = 2;
  SameLights few(visible_scene, camera, settings);
  const auto exact = few.all_pairs();
  double mean = 0;
  for (const auto& pixel : exact.image.pixels) mean += static_cast<double>(luminance(pixel)) / 576;
  settings.adaptation = mean;
  SameLights many(full_scene, camera, settings);
  ASSERT_EQ(many.side.lights.vpls.size(), 100'000u);
  for (const Method method : k_cut_methods) {
    const auto cut = many.cut(method);
    Quantiles errors, sizes;
    add_relative_errors(cut.image, exact.image, k_perceptual_floor * mean, errors);
    for (const std::uint32_t size : cut.statistics.cut_sizes) sizes.add(size);
    std::cout << name(method) << ": error " << errors.text() << "; cut " << sizes.text() << ", mean " << sizes.mean()
              << " of " << 400'000 << ", " << mean_cut(few.cut(method))
              << " with the visible room's lights alone; capped " << cut.statistics.capped_pixels << '\n';
    EXPECT_EQ(cut.statistics.pairs.bound_violations, 0u);
    EXPECT_EQ(cut.statistics.capped_pixels, 0u);
    EXPECT_LT(errors.at(0.5), 0.01) << name(method);
    EXPECT_LT(errors.at(0.9), 0.025) << name(method);
    EXPECT_LT(errors.at(1), 0.07) << name(method);
    EXPECT_LT(sizes.mean(), 700) << name(method);
    EXPECT_LT(sizes.at(1), 2000) << name(method);
  }
}

/// Stability case 37: a ceiling of a million emissive triangles under a texture in which four texels of 4096 are 10,000
/// times as bright as the rest. Asserted: memory per light, at most 88 bytes of tables per triangle; virtual lights
/// fall on the bright texels as often as the flux of their triangles says (binomial, 5 sigma: 6e-7); all bounds hold;
/// the floor's radiance agrees with the sum over texels (16 runs, see `agrees`). Caught: triangles chosen by area;
/// radiance looked up at the triangle's own coordinates instead of the texture's.
TEST(ManyRooms, CeilingOfAMillionTexturedTriangles) {
  constexpr std::uint32_t k_quads = 768;  // twelve to a texel: no triangle crosses a border
  constexpr std::uint32_t k_texels = 64;
  TriangleMesh<S> ceiling;
  for (std::uint32_t y = 0; y <= k_quads; ++y) {
    for (std::uint32_t x = 0; x <= k_quads; ++x) {
      const Vec2<S> uv(static_cast<S>(x) / k_quads, static_cast<S>(y) / k_quads);
      ceiling.positions.push_back({2 * uv.x - 1, 2 * uv.y - 1, 1});
      ceiling.uvs.push_back(uv);
    }
  }
  for (std::uint32_t y = 0; y < k_quads; ++y) {
    for (std::uint32_t x = 0; x < k_quads; ++x) {
      const std::uint32_t a = y * (k_quads + 1) + x;
      ceiling.triangles.push_back({a, a + k_quads + 1, a + 1});  // facing down
      ceiling.triangles.push_back({a + 1, a + k_quads + 1, a + k_quads + 2});
    }
  }
  auto texels = std::make_shared<Texels<S>>();
  texels->width = texels->height = k_texels;
  texels->values.assign(k_texels * k_texels, Rgb<S>(S(0.1)));
  const std::array<std::array<std::uint32_t, 2>, 4> bright{{{5, 7}, {20, 50}, {33, 33}, {60, 12}}};
  for (const auto& [column, row] : bright) texels->values[row * k_texels + column] = Rgb<S>(1000);
  Shapes<S> shapes;
  shapes.meshes = {parallelogram<S>({0, 0, 0}, {3, 0, 0}, {0, 3, 0}), ceiling};
  EmitterList<S> emitters;
  emitters.areas.push_back({1, Texture<S>::bitmap(texels, TextureFilter::nearest), false});
  const SceneType scene(Bvh<S>(shapes), {{Lambertian<S>{Rgb<S>(S(0.5))}}, {Lambertian<S>{Rgb<S>(0)}}}, {0, 1},
                        emitters);
  ASSERT_GE(scene.emitters().count(), 1'000'000u);
  std::cout << scene.emitters().bytes_per_primitive() << " bytes per triangle\n";
  EXPECT_LE(scene.emitters().bytes_per_primitive(), 88);

  ProbeCamera<S> camera;
  const std::array<Vec3<S>, 3> probes{{{0, 0, 0}, {S(0.7), S(-0.5), 0}, {S(1.5), S(1.2), 0}}};
  std::vector<double> exact;
  for (const Vec3<S>& p : probes) {
    camera.add(p, p + Vec3<S>(S(0.01), S(0.005), S(0.02)));
    double sum = 0;
    const std::uint32_t n = 8 * k_texels;  // 64 points per texel: 1e-4 of the nearest one's part
    for (std::uint32_t i = 0; i < n * n; ++i) {
      const double x = 2 * (i % n + 0.5) / n - 1 - static_cast<double>(p.x);
      const double y = 2 * (i / n + 0.5) / n - 1 - static_cast<double>(p.y);
      const double radiance = static_cast<double>(texels->values[(i / n / 8) * k_texels + i % n / 8].x);
      sum += radiance / sqr(x * x + y * y + 1) * 4 / (n * n);
    }
    exact.push_back(0.5 * k_inv_pi<double> * sum);
  }
  std::vector<RunningMoments> moments(exact.size());
  std::uint64_t on_bright = 0;
  std::uint64_t all = 0;
  Settings settings;
  settings.samples = 1;
  settings.vpls = 10'000;
  settings.max_edges = 2;
  settings.adaptation = 100;
  for (settings.seed = 1; settings.seed <= 16; ++settings.seed) {
    SameLights lights(scene, camera, settings);
    for (const auto& v : lights.side.lights.vpls) {
      const auto column = static_cast<std::uint32_t>((v.position.x + 1) / 2 * k_texels);
      const auto row = static_cast<std::uint32_t>((v.position.y + 1) / 2 * k_texels);
      for (const auto& texel : bright) on_bright += texel[0] == column && texel[1] == row ? 1 : 0;
      ++all;
    }
    const auto image = lights.lightcuts();
    EXPECT_EQ(image.statistics.pairs.bound_violations, 0u);
    EXPECT_EQ(image.statistics.invalid_samples, 0u);
    for (std::size_t i = 0; i < exact.size(); ++i) moments[i].add(static_cast<double>(image.image.pixels[i].x));
    if (settings.seed == 1) {
      const LightTree<SceneType> tree(lights.side.lights.vpls, SerialExecutor{});
      std::cout << tree.bytes() / tree.vpls().size() << " bytes per virtual light, mean cut " << mean_cut(image) << '\n';
    }
  }
  // Triangles are chosen by nine tenths of their own radiance and a tenth of the texture's mean, see
  // EmissiveShapes::flux.
  const double mean = (4 * 1000 + 4092 * 0.1) / 4096;
  const double share = 4 * (900 + 0.1 * mean) / (4096 * mean);
  const double found = static_cast<double>(on_bright) / static_cast<double>(all);
  EXPECT_NEAR(found, share, 5 * std::sqrt(share * (1 - share) / static_cast<double>(all)));
  for (std::size_t i = 0; i < exact.size(); ++i) {
    EXPECT_TRUE(agrees(moments[i], exact[i], 1e-3))
        << i << ": " << moments[i].mean() << " +- " << moments[i].standard_error() << ", exact " << exact[i];
    EXPECT_LT(moments[i].standard_error(), 0.03 * exact[i]);  // 0.3 to 2.5 % over 64 seeds
  }
}

}  // namespace
}  // namespace manylight::test::many_rooms_slow_test
