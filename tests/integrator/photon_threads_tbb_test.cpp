// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <tbb/global_control.h>

#include "integrator/common_scenes.hpp"
#include "manylight/core/tbb_executor.hpp"
#include "manylight/integrator/photon_map.hpp"
#include "manylight/integrator/progressive_photon_mapping.hpp"

namespace manylight::test::photon_threads_tbb_test {
namespace {

/// 1, 2 and 7 threads give the bits of the serial executor, in maps of many tasks and films of 9 tiles.
TEST(PhotonThreads, ImagesAreEqualToTheBit) {
  using S = float;
  SceneBuilder<Bvh<S>, SmoothMaterial<S>> builder;
  builder.mesh(box_mesh<S>({-1, -1, -1}, {1, 1, 1}), Lambertian<S>{Rgb<S>(0.6F, 0.5F, 0.4F)});
  builder.sphere({{0.3F, 0.2F, -0.6F}, 0.4F, false}, Dielectric<S>{1.5F}, false);
  builder.emit(builder.mesh(parallelogram<S>({0, 0, 0.95F}, {0, 0.3F, 0}, {0.3F, 0, 0}), Lambertian<S>{Rgb<S>(0)}),
               Rgb<S>(8, 7, 6));
  const auto scene = builder.build();
  using SceneType = std::remove_const_t<decltype(scene)>;
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 7);
  const auto camera = look_at<S>({0, -0.9F, 0}, {0, 1, -0.3F}, 70, 40);
  const auto filter = ReconstructionFilter<S>::box();
  const Window window = Window::of(camera);
  const IndependentSampler<S> sampler{5};
  const auto render = [&](const auto& executor) {
    std::vector<Rgb<double>> passes(window.pixel_count(), Rgb<double>(0));
    std::vector<Rgb<double>> gathered = passes;
    ProgressivePhotonConfig progressive;
    progressive.light_paths = 5000;
    const ProgressivePhotonIntegrator by_passes(scene, progressive);
    RayCounts rays;
    const auto radii = initial_photon_radii(by_passes, camera, filter, window, sampler, executor, rays);
    accumulate_photon_passes(by_passes, camera, filter, window, radii, sampler, 0, 2, passes, executor);
    PhotonMapConfig config;
    config.light_paths = config.caustic_paths = 5000;
    const auto maps = prepare_photon_maps(scene, config, sampler, executor);
    const PhotonMapIntegrator<SceneType> by_gather(scene, config, maps);
    accumulate_photon_map_samples(by_gather, camera, filter, window, sampler, 0, 1, gathered, executor);
    passes.insert(passes.end(), gathered.begin(), gathered.end());
    return passes;
  };
  const auto serial = render(SerialExecutor{});
  EXPECT_GT(serial[20 * 40 + 20].x, 0);
  EXPECT_GT(serial[(40 + 20) * 40 + 20].x, 0);
  for (const std::size_t threads : {1U, 2U, 7U}) EXPECT_EQ(render(TbbExecutor(threads)), serial) << threads;
}

}  // namespace
}  // namespace manylight::test::photon_threads_tbb_test
