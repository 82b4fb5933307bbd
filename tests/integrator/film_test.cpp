// SPDX-License-Identifier: Apache-2.0
// Windows of a film. Oracle: the same pixels of the full image, bit for bit.

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "integrator/builders.hpp"
#include "manylight/geometry/bvh.hpp"
#include "manylight/integrator/film.hpp"
#include "manylight/integrator/lightcuts.hpp"
#include "manylight/scattering/any_of.hpp"
#include "manylight/scattering/lambertian.hpp"
#include "manylight/scattering/phong.hpp"

namespace manylight::test::film_test {
namespace {

using S = float;
using M = AnyOf<Lambertian<S>, Phong<S>>;
using SceneType = Scene<Bvh<S>, UniformShader<M>>;

constexpr std::uint32_t k_side = 40;  // 3 x 3 tiles of 16, the last ones 8 wide

// Pixels, corners of the film, and odd rectangles whose own tiles cross those of the film.
constexpr std::array<Window, 6> k_windows{
    {{0, 0, 1, 1}, {39, 39, 40, 40}, {15, 15, 17, 17}, {7, 9, 38, 30}, {3, 0, 4, 40}, {0, 31, 40, 33}}};

SceneType room() {
  SceneBuilder<Bvh<S>, M> builder;
  builder.mesh(box_mesh<S>({-1, -1, -1}, {1, 1, 1}), M(Lambertian<S>{Rgb<S>(0.6F, 0.5F, 0.4F)}));
  builder.sphere({{0.3F, 0.2F, -0.6F}, 0.4F, false}, M(Phong<S>{Rgb<S>(0.7F), 40}));
  builder.emit(builder.mesh(parallelogram<S>({0, 0, 0.95F}, {0, 0.3F, 0}, {0.3F, 0, 0}), M(Lambertian<S>{Rgb<S>(0)})),
               Rgb<S>(8, 7, 6));
  builder.point_light({-0.6F, -0.5F, 0.3F}, 0.3F);
  return builder.build();
}

/// What a window holds: pixels and, for the many-light methods, the cut of each.
struct WindowImage {
  std::vector<Rgb<double>> pixels;
  std::vector<std::uint32_t> cut_sizes;
};

/// One camera and one light side; renders any window by any method.
class Renderer {
 public:
  Renderer() : scene_(room()), camera_(look_at<S>({0, -0.9F, 0}, {0, 1, -0.3F}, 70, k_side)) {
    config_ = many_light_config(settings());
    side_ = prepare_lights(scene_, camera_, filter_, config_, sampler_, SerialExecutor{});
    tree_.emplace(side_.lights.vpls, SerialExecutor{});
  }
  [[nodiscard]] WindowImage operator()(Method method, const Window& window) const {
    WindowImage result;
    if (method == Method::path) {
      // A window turned inside out has a huge count; it is to be refused before the sums matter.
      result.pixels.assign(std::min(window.pixel_count(), std::size_t{k_side} * k_side), Rgb<double>(0));
      const PathIntegrator<SceneType> integrator(scene_, PathConfig{});
      accumulate_path_samples(integrator, camera_, filter_, window, sampler_, 0, 2, result.pixels, SerialExecutor{});
      return result;
    }
    const ManyLightImage<S> image = many_light(method, window);
    EXPECT_EQ(image.image.width, window.width());
    EXPECT_EQ(image.image.height, window.height());
    for (const Rgb<S>& pixel : image.image.pixels) result.pixels.emplace_back(pixel);
    result.cut_sizes = image.statistics.cut_sizes;
    return result;
  }

 private:
  static Settings settings() {
    Settings settings;
    settings.samples = 2;
    settings.vpls = 200;
    settings.max_cut = 100;
    settings.adaptation = 0;
    settings.clamp_scale = 1.0 / 800;
    return settings;
  }
  [[nodiscard]] ManyLightImage<S> many_light(Method method, const Window& window) const {
    ManyLightConfig config = config_;
    config.window = window;
    const SerialExecutor serial;
    if (method == Method::vpl)
      return render_instant_radiosity(scene_, camera_, filter_, config, side_, sampler_, serial);
    if (method == Method::lightcuts) {
      return render_lightcuts(scene_, camera_, filter_, config, side_, *tree_, sampler_, serial);
    }
    return render_bidirectional_lightcuts(scene_, camera_, filter_, config, side_, *tree_, sampler_, serial);
  }

  SceneType scene_;
  PerspectiveCamera<S> camera_;
  ReconstructionFilter<S> filter_ = ReconstructionFilter<S>::box();
  IndependentSampler<S> sampler_{3};
  ManyLightConfig config_;
  LightSide<SceneType> side_;
  std::optional<LightTree<SceneType>> tree_;
};

// Planted bugs seen to fail: samples of a path, or the key of a cut, numbered from the window's corner; tiles that
// reach beyond the window's border (the heap breaks).
TEST(Windows, HaveTheBitsOfTheFullImage) {
  const Renderer renderer;
  for (const Method method : k_methods) {
    const WindowImage full = renderer(method, {0, 0, k_side, k_side});
    for (const Window& window : k_windows) {
      const WindowImage part = renderer(method, window);
      ASSERT_EQ(part.pixels.size(), window.pixel_count());
      double brightest = 0;
      for (std::uint32_t y = window.y0; y < window.y1; ++y) {
        for (std::uint32_t x = window.x0; x < window.x1; ++x) {
          const std::size_t whole = std::size_t{y} * k_side + x;
          const std::size_t own = std::size_t{y - window.y0} * (window.x1 - window.x0) + (x - window.x0);
          ASSERT_EQ(part.pixels[own], full.pixels[whole]) << name(method) << ' ' << x << ' ' << y;
          brightest = std::max(brightest, part.pixels[own].x);
          if (method != Method::path) {
            ASSERT_EQ(part.cut_sizes[own], full.cut_sizes[whole]) << name(method);
          }
        }
      }
      EXPECT_GT(brightest, 0) << name(method);
    }
  }
}

// Planted bug seen to fail: the last column of tiles left out (width / 16 rounded down).
TEST(Windows, TilesCoverEveryPixelOnce) {
  for (const Window& window : k_windows) {
    std::vector<int> visits(std::size_t{k_side} * k_side, 0);
    std::size_t last = 0;
    const auto visit = [&](const Window& tile) {
      EXPECT_LE(tile.width(), k_tile_size);
      EXPECT_LE(tile.height(), k_tile_size);
      for (std::uint32_t y = tile.y0; y < tile.y1; ++y) {
        for (std::uint32_t x = tile.x0; x < tile.x1; ++x) ++visits.at(std::size_t{y} * k_side + x);
      }
      return tile.pixel_count();
    };
    const auto progress = [&](std::size_t done, std::size_t total) {
      EXPECT_EQ(done, ++last);
      EXPECT_LE(done, total);
    };
    std::size_t pixels = 0;
    for (const std::size_t count : for_each_tile(window, SerialExecutor{}, visit, progress)) pixels += count;
    EXPECT_EQ(pixels, window.pixel_count());
    for (std::uint32_t y = 0; y < k_side; ++y) {
      for (std::uint32_t x = 0; x < k_side; ++x) {
        const bool inside = x >= window.x0 && x < window.x1 && y >= window.y0 && y < window.y1;
        ASSERT_EQ(visits[std::size_t{y} * k_side + x], inside ? 1 : 0);
      }
    }
  }
}

std::string message_of(const Renderer& renderer, Method method, const Window& window) {
  try {
    static_cast<void>(renderer(method, window));
  } catch (const ParameterError& error) {
    return error.what();
  }
  return "accepted";
}

// Planted bugs seen to fail: no validation by the path integrator; x0 <= x1 allowed.
TEST(Windows, BadOnesAreRefusedWithValueAndRange) {
  using testing::AllOf;
  using testing::HasSubstr;
  const Renderer renderer;
  const std::array<std::pair<Window, const char*>, 6> bad{{{{5, 0, 5, 3}, "5,0,5,3"},
                                                           {{0, 7, 3, 7}, "0,7,3,7"},
                                                           {{9, 0, 5, 3}, "9,0,5,3"},
                                                           {{0, 0, 41, 3}, "0,0,41,3"},
                                                           {{0, 0, 4, 41}, "0,0,4,41"},
                                                           {{}, "0,0,0,0"}}};
  for (const Method method : k_methods) {
    for (const auto& [window, text] : bad) {
      EXPECT_THAT(message_of(renderer, method, window),
                  AllOf(HasSubstr("window"), HasSubstr(text), HasSubstr("x1 <= 40"), HasSubstr("y1 <= 40")))
          << name(method);
    }
  }
}

// Planted bug seen to fail: no check, which writes past the end.
TEST(Windows, PathSumsMustFitTheWindow) {
  const SceneType scene = room();
  const PathIntegrator<SceneType> integrator(scene, PathConfig{});
  const auto camera = look_at<S>({0, -0.9F, 0}, {0, 1, -0.3F}, 70, k_side);
  std::vector<Rgb<double>> sums(3);
  EXPECT_THROW(accumulate_path_samples(integrator, camera, ReconstructionFilter<S>::box(), Window{0, 0, 2, 2},
                                       IndependentSampler<S>{1}, 0, 1, sums, SerialExecutor{}),
               ParameterError);
}

}  // namespace
}  // namespace manylight::test::film_test
