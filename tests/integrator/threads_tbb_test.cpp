// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <tbb/global_control.h>

#include "integrator/builders.hpp"
#include "manylight/core/tbb_executor.hpp"
#include "manylight/geometry/bvh.hpp"
#include "manylight/scattering/any_of.hpp"
#include "manylight/scattering/conductor.hpp"
#include "manylight/scattering/lambertian.hpp"
#include "manylight/scattering/phong.hpp"

namespace manylight::test::threads_tbb_test {
namespace {

/// Stability case 31: 1, 2 and 7 threads, each twice, give the bits of the serial executor. The film has 9 tiles, the
/// light tree tasks of its own (more than 4096 VPLs), ties come from a mirror and an emitter of few triangles.
TEST(Threads, ImagesAreEqualToTheBit) {
  using S = float;
  using M = AnyOf<Lambertian<S>, Phong<S>, Mirror<S>>;
  SceneBuilder<Bvh<S>, M> builder;
  auto room = box_mesh<S>({-1, -1, -1}, {1, 1, 1});
  builder.mesh(room, M(Lambertian<S>{Rgb<S>(0.6F, 0.5F, 0.4F)}));
  builder.sphere({{0.3F, 0.2F, -0.6F}, 0.4F, false}, M(Phong<S>{Rgb<S>(0.7F), 40}));
  builder.sphere({{-0.5F, 0.4F, -0.7F}, 0.3F, false}, M(Mirror<S>{Rgb<S>(0.9F)}));
  builder.emit(builder.mesh(parallelogram<S>({0, 0, 0.95F}, {0, 0.3F, 0}, {0.3F, 0, 0}), M(Lambertian<S>{Rgb<S>(0)})),
               Rgb<S>(8, 7, 6));
  builder.point_light({-0.6F, -0.5F, 0.3F}, 0.3F);
  const auto scene = builder.build();
  // Without it a machine of two cores would get two threads, whatever is asked for.
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 7);
  const auto camera = look_at<S>({0, -0.9F, 0}, {0, 1, -0.3F}, 70, 40);
  for (const Method method : k_methods) {
    Settings settings;
    settings.samples = 1;
    settings.vpls = method == Method::bdlc ? 9000 : 100;
    settings.max_cut = 300;
    settings.adaptation = 0;
    settings.clamp_scale = 1.0 / 800;
    const Film serial = render(method, scene, camera, settings);
    EXPECT_GT(serial.mean().x, 0.01) << name(method);
    for (const std::size_t threads : {1U, 2U, 7U}) {
      const TbbExecutor executor(threads);
      for (int run = 0; run < 2; ++run) {
        const Film parallel = render(method, scene, camera, settings, executor);
        EXPECT_EQ(parallel.pixels, serial.pixels) << name(method) << ", threads: " << threads;
        EXPECT_EQ(parallel.invalid, serial.invalid);
      }
    }
  }
}

}  // namespace
}  // namespace manylight::test::threads_tbb_test
