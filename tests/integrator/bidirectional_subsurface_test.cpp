// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <type_traits>
#include <utility>

#include "integrator/bidirectional_weight_check.hpp"
#include "integrator/subsurface_scenes.hpp"

// Bidirectional path tracing through objects that scatter below their surface. False alarms: see
// bidirectional_path_test.cpp.

namespace manylight::test::bidirectional_subsurface_test {
namespace {

using S = double;
using Builder = JadeBuilderOf<BallMaterial>;

// Vertices of scenes without objects carry nothing of them.
static_assert(std::is_empty_v<detail::VertexBelow<BallScene, BallScene::k_has_subsurface>>);
static_assert(sizeof(BidirectionalVertex<BallScene>) + sizeof(detail::VertexBelow<Builder::SceneType, true>) <=
              sizeof(BidirectionalVertex<Builder::SceneType>));

/// A ball of jade, partly diffuse or shining on its surface, near a wall, and a block of jade.
Builder jade_by_the_wall(double length, double eta, const BallMaterial& on_top) {
  Builder builder;
  builder.mesh(parallelogram<S>({0, 0, -0.5}, {2, 0, 0}, {0, 2, 0}), 0.6);
  builder.mesh(parallelogram<S>({0, 1.2, 0.5}, {2, 0, 0}, {0, 0, 1}), 0.7);
  builder.mesh(box_mesh<S>({-1, 0, -0.4}, {-0.3, 0.5, 0.3}), jade(0.8, length, eta));
  builder.sphere({0.4, 0.3, 0}, 0.45, jade(0.7, length, eta), on_top);
  builder.lamp(parallelogram<S>({-0.1, 0, 1.2}, {0, 0.4, 0}, {0.4, 0, 0}), 8);
  return builder;
}

/// Caught: the passage with twice its density in one walk; no connection through the object in what walks carry along; the
/// other walk's density on top of an object without its share.
TEST(BidirectionalSubsurface, WeightsAreTheSharesOfTheDensities) {
  expect_weights(jade_by_the_wall(0.1, 1.4, matte(0.3)).build(), floor_camera(0), 500, true);
  expect_weights(jade_by_the_wall(0.3, 1, BallMaterial(Mirror<S>{Rgb<S>(0.4)})).build(), floor_camera(0), 500, true);
}

/// Each strategy alone makes the whole image of its path length. Caught: the first two from above.
void expect_each_strategy_equals_path(const Builder& builder, std::uint32_t path_samples, std::uint32_t samples,
                                      unsigned lengths, double largest_error) {
  const Comparison c = compare_with_path(builder.build(), floor_camera(0), path_samples, samples, lengths);
  double count = 1;
  for (unsigned n = 2; n <= lengths; ++n) count += n + 2;
  const double limit = c.limit(count);
  EXPECT_LT(std::abs(z_between(c.bidirectional, c.path)), limit)
      << c.bidirectional.mean() << " +- " << c.bidirectional.standard_error() << " for " << c.path.mean() << " +- "
      << c.path.standard_error();
  EXPECT_LT(c.bidirectional.standard_error(), largest_error * c.path.mean());
  EXPECT_LT(c.path.standard_error(), largest_error * c.path.mean());
  for (unsigned n = 2; n <= lengths; ++n) {
    EXPECT_LT(std::abs(z_between(c.weighted_of_length[n], c.path_of_length[n])), limit)
        << n << " segments: " << c.weighted_of_length[n].mean() << " for " << c.path_of_length[n].mean();
    for (unsigned s = 0; s <= n; ++s) {
      EXPECT_LT(std::abs(z_between(c.unweighted[n][s], c.path_of_length[n])), limit)
          << "s = " << s << ", " << n << " segments: " << c.unweighted[n][s].mean() << " +- "
          << c.unweighted[n][s].standard_error() << " for " << c.path_of_length[n].mean();
    }
  }
}

TEST(BidirectionalSubsurface, JadeByTheWall) {
  expect_each_strategy_equals_path(jade_by_the_wall(0.1, 1.4, matte(0.3)), 48, 24, 4, 0.02);
}

/// Lit from behind, thin and thick: all light seen has been through the slab.
TEST(BidirectionalSubsurface, SlabLitFromBehind) {
  for (const double thickness : {0.02, 0.4}) {
    Builder builder;
    builder.mesh(box_mesh<S>({-1, 0, -1}, {1, thickness, 1}), jade(0.9, 0.1));
    builder.lamp(parallelogram<S>({0, 1.2, 0}, {0.4, 0, 0}, {0, 0, 0.4}), 20);
    expect_each_strategy_equals_path(builder, 48, 24, 4, 0.03);
  }
}

/// A ball of jade below a sheet of glass: only light walks and hits of the lamp get through.
TEST(BidirectionalSubsurface, JadeBelowGlass) {
  Builder builder;
  builder.mesh(parallelogram<S>({0, 0, -0.5}, {2, 0, 0}, {0, 2, 0}), 0.6);
  builder.sphere({0, 0.3, 0}, 0.4, jade(0.8, 0.2, 1.3), 0.2);
  builder.mesh(box_mesh<S>({-2, -2, 0.6}, {2, 2, 0.8}), BallMaterial(Dielectric<S>{1.5}));
  builder.lamp(parallelogram<S>({0, 0, 1.4}, {0, 0.5, 0}, {0.5, 0, 0}), 8);
  expect_equals_path(builder.build(), floor_camera(0), 250, 32, 0.03, 6);
}

/// Oracle O-15: under a uniform sky a half-space looks like a Lambertian one, whatever the falloff; here with one of 0.3 on
/// top. Caught: throughput without the share of walks that stay outside.
TEST(BidirectionalSubsurface, HalfSpaceUnderAUniformSky) {
  Builder builder;
  builder.mesh(parallelogram<S>({0, 0, -0.5}, {20, 0, 0}, {0, 20, 0}), jade(0.5, 0.2), 0.3);
  builder.sky(2);
  const auto scene = builder.build();
  const auto camera = look_at<S>({0, 0, 1}, {0.2, 0.1, -0.5}, 5, 4);
  const std::array<std::pair<unsigned, S>, 2> parts{{{2, 0.6}, {3, 1.0}}};  // segments: on top, below
  RunningMoments all;
  std::array<std::array<RunningMoments, 2>, 2> alone;  // s = 0 and 1
  for (unsigned run = 0; run < 16; ++run) {
    const BidirectionalFilm film = render_bidirectional(scene, camera, 100, run, 3);
    all.add(film.mean());
    for (std::size_t k = 0; k < 2; ++k) {
      for (unsigned s = 0; s < 2; ++s) alone[k][s].add(film.unweighted(s, parts[k].first + 1 - s));
    }
  }
  const double limit = student_limit(sidak_level(1e-3, 5), 15);
  EXPECT_NEAR(all.mean(), 1.6, limit * all.standard_error());
  EXPECT_LT(all.standard_error(), 0.02);
  for (std::size_t k = 0; k < 2; ++k) {
    for (std::size_t s = 0; s < 2; ++s) {
      EXPECT_NEAR(alone[k][s].mean(), parts[k].second, limit * alone[k][s].standard_error()) << k << ", s = " << s;
      EXPECT_LT(alone[k][s].standard_error(), 0.03) << k << ", s = " << s;
    }
  }
}

}  // namespace
}  // namespace manylight::test::bidirectional_subsurface_test
