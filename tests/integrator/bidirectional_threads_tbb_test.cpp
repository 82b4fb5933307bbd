// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <tbb/global_control.h>

#include "integrator/builders.hpp"
#include "manylight/core/tbb_executor.hpp"
#include "manylight/geometry/bvh.hpp"
#include "manylight/integrator/bidirectional_image.hpp"
#include "manylight/scattering/any_of.hpp"
#include "manylight/scattering/conductor.hpp"
#include "manylight/scattering/lambertian.hpp"
#include "manylight/scattering/phong.hpp"

namespace manylight::test::bidirectional_threads_tbb_test {
namespace {

/// 1, 2 and 7 threads, each twice, give the bits of the serial executor; the film has 132 tiles, so two batches of them, and
/// light walks fall on any. Caught: splats added as they are found.
TEST(BidirectionalThreads, ImagesAreEqualToTheBit) {
  using S = float;
  using M = AnyOf<Lambertian<S>, Phong<S>, Mirror<S>>;
  SceneBuilder<Bvh<S>, M> builder;
  builder.mesh(box_mesh<S>({-1, -1, -1}, {1, 1, 1}), M(Lambertian<S>{Rgb<S>(0.6F, 0.5F, 0.4F)}));
  builder.sphere({{0.3F, 0.2F, -0.6F}, 0.4F, false}, M(Phong<S>{Rgb<S>(0.7F), 40}));
  builder.sphere({{-0.5F, 0.4F, -0.7F}, 0.3F, false}, M(Mirror<S>{Rgb<S>(0.9F)}));
  builder.emit(builder.mesh(parallelogram<S>({0, 0, 0.95F}, {0, 0.3F, 0}, {0.3F, 0, 0}), M(Lambertian<S>{Rgb<S>(0)})),
               Rgb<S>(8, 7, 6));
  builder.point_light({-0.6F, -0.5F, 0.3F}, 0.3F);
  const auto scene = builder.build();
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 7);
  PerspectiveConfig<S> config;
  config.to_world = {{1, 0, 0, 0}, {0, 0, 1, 0}, {0, 1, 0, 0}, {0, -0.9F, 0, 1}};
  config.horizontal_fov = 70;
  config.width = 161;
  config.height = 177;
  const PerspectiveCamera<S> camera(config);
  const BidirectionalPathIntegrator<decltype(builder)::SceneType> integrator(scene, {6});
  const auto render = [&](const auto& executor) {
    BidirectionalSums sums(std::size_t{config.width} * config.height);
    const PathStatistics statistics =
        accumulate_bidirectional_samples(integrator, camera, ReconstructionFilter<S>::tent(), Window::of(camera),
                                         IndependentSampler<S>{4}, 0, 1, sums, executor);
    return std::pair(sums, statistics);
  };
  const auto [serial, statistics] = render(SerialExecutor{});
  double eye = 0, light = 0;
  for (std::size_t i = 0; i < serial.eye.size(); ++i) {
    eye += serial.eye[i].x;
    light += serial.light[i].x;
  }
  EXPECT_GT(eye, 0);
  EXPECT_GT(light, 0.01 * eye);
  for (const std::size_t threads : {1U, 2U, 7U}) {
    const TbbExecutor executor(threads);
    for (int run = 0; run < 2; ++run) {
      const auto [parallel, counted] = render(executor);
      EXPECT_EQ(parallel.eye, serial.eye) << "threads: " << threads;
      EXPECT_EQ(parallel.light, serial.light) << "threads: " << threads;
      EXPECT_EQ(counted.invalid, statistics.invalid);
      EXPECT_EQ(counted.rays.shadow, statistics.rays.shadow);
    }
  }
}

}  // namespace
}  // namespace manylight::test::bidirectional_threads_tbb_test
