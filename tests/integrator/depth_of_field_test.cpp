// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <iostream>

#include "integrator/builders.hpp"
#include "manylight/core/sobol.hpp"
#include "manylight/geometry/bvh.hpp"
#include "manylight/scattering/lambertian.hpp"

namespace manylight::test::depth_of_field_test {
namespace {

using S = double;

/// A small bright disk that faces the lens, out of focus. A thin lens of radius A focused at f spreads a point at
/// distance d over a disc of radius A |1/f - 1/d| on the film at unit distance; the disk itself, of radius r, is r/d
/// large there and keeps its energy: the film's integral of radiance is L pi (r/d)^2 whatever the lens. Asserted,
/// behind and before the plane of focus and in it, on the axis and beside it, by path tracing and both kinds of cuts:
/// that energy within 1 %; the radius from the second moment of the image (a disc convolved with a disc) within one
/// pixel, and the same by where light ends and where it has no gaps; the centre within a tenth of a pixel. 256 Sobol
/// samples per pixel leave 0.4 %. Caught: the lens' diameter for its radius; lens points crowded in the middle; a focus
/// distance 0.7 times as long.
TEST(DepthOfField, DiscOfConfusionOfASmallEmitter) {
  constexpr std::uint32_t k_side = 40;
  constexpr double k_aperture = 0.1;
  constexpr double k_focus = 2;
  struct Case {
    double distance, x, size;
  };
  for (const Case& c : {Case{4, 0, 0.08}, Case{1.2, 0, 0.024}, Case{3.5, 0.1, 0.07}, Case{2, 0, 0.1}}) {
    SceneBuilder<Bvh<S>, Lambertian<S>> builder;
    builder.emit(builder.disk({{c.x, 0, c.distance}, {0, 0, -1}, {1, 0, 0}, c.size}, {Rgb<S>(0)}), Rgb<S>(7));
    const auto scene = builder.build();
    PerspectiveConfig<S> lens;
    lens.horizontal_fov = 2 * std::atan(0.1) * 180 / k_pi<S>;  // the film is 0.2 wide: 0.005 per pixel
    lens.width = lens.height = k_side;
    lens.aperture_radius = k_aperture;
    lens.focus_distance = k_focus;
    const PerspectiveCamera<S> camera(lens);
    const double pixel = 0.2 / k_side;
    const double blur = k_aperture * std::abs(1 / k_focus - 1 / c.distance) / pixel;
    const double image_size = c.size / c.distance / pixel;
    const double center_x = k_side / 2.0 - c.x / c.distance / pixel;  // local x points to the left

    for (const Method method : {Method::path, Method::lightcuts, Method::bdlc}) {
      const auto filter = ReconstructionFilter<S>::box();
      const SobolSampler<S> sampler{3};
      ManyLightConfig config = many_light_config(Settings{});
      config.eye_paths = 256;
      config.vpls = 10;
      Image<S> image(k_side, k_side);
      if (method == Method::path) {
        const PathIntegrator<decltype(builder)::SceneType> integrator(scene, PathConfig{});
        std::vector<Rgb<double>> sums(image.pixels.size(), Rgb<double>(0));
        (void)accumulate_path_samples(integrator, camera, filter, Window::of(camera), sampler, 0, config.eye_paths,
                                      sums, SerialExecutor{});
        for (std::size_t i = 0; i < sums.size(); ++i) image.pixels[i] = sums[i] / static_cast<double>(config.eye_paths);
      } else {
        const auto side = prepare_lights(scene, camera, filter, config, sampler, SerialExecutor{});
        const LightTree<decltype(builder)::SceneType> tree(side.lights.vpls, SerialExecutor{});
        if (method == Method::lightcuts) {
          image = render_lightcuts(scene, camera, filter, config, side, tree, sampler, SerialExecutor{}).image;
        } else {
          image = render_bidirectional_lightcuts(scene, camera, filter, config, side, tree, sampler, SerialExecutor{})
                      .image;
        }
      }
      double energy = 0, first_x = 0, first_y = 0, second = 0, farthest = 0, gap = k_side;
      for (std::uint32_t y = 0; y < k_side; ++y) {
        for (std::uint32_t x = 0; x < k_side; ++x) {
          const double value = image.at(x, y).x;
          const double dx = x + 0.5 - center_x;
          const double dy = y + 0.5 - k_side / 2.0;
          energy += value;
          first_x += value * dx;
          first_y += value * dy;
          second += value * (dx * dx + dy * dy);
          if (value > 0) farthest = std::max(farthest, std::hypot(dx, dy));
          if (!(value > 0)) gap = std::min(gap, std::hypot(dx, dy));
        }
      }
      const double moment = second / energy + 1.0 / 6;  // pixels are taken at their centres
      const double radius = std::sqrt(std::max(0.0, 2 * moment - image_size * image_size));
      if (method == Method::lightcuts) {
        std::cout << "distance " << c.distance << ": radius " << radius << " for " << blur << " pixels, energy "
                  << energy * pixel * pixel / (7 * k_pi<S> * sqr(c.size / c.distance)) << '\n';
      }
      EXPECT_NEAR(energy * pixel * pixel, 7 * k_pi<S> * sqr(c.size / c.distance),
                  0.01 * 7 * k_pi<S> * sqr(c.size / c.distance))
          << name(method);
      EXPECT_NEAR(radius, blur, 1) << name(method) << " distance " << c.distance;
      EXPECT_NEAR(farthest, blur + image_size, 1) << name(method) << " distance " << c.distance;
      EXPECT_GT(gap, std::abs(blur - image_size)) << name(method) << " no gap inside, distance " << c.distance;
      EXPECT_NEAR(first_x / energy, 0, 0.1) << name(method);
      EXPECT_NEAR(first_y / energy, 0, 0.1) << name(method);
    }
  }
}

}  // namespace
}  // namespace manylight::test::depth_of_field_test
