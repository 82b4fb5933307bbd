// SPDX-License-Identifier: Apache-2.0
// Oracle: the serial executor. Trees and light sets may not depend on who runs the tasks, to the bit.

#include <gtest/gtest.h>

#include "manylight/core/tbb_executor.hpp"
#include "manylight/many_light/light_tree.hpp"
#include "manylight/many_light/vpl_set.hpp"
#include "support/analytic_scenes.hpp"
#include "support/random_vertices.hpp"

namespace manylight::light_tree_tbb_test {
namespace {

template <class S>
void expect_same_nodes(const LightTree<test::MixedScene<S>>& a, const LightTree<test::MixedScene<S>>& b) {
  ASSERT_EQ(a.roots(), b.roots());
  std::vector<std::uint32_t> open = a.roots();
  std::size_t visited = 0;
  while (!open.empty()) {
    const std::uint32_t i = open.back();
    open.pop_back();
    ++visited;
    const LightNode<S> x = a.node(i);
    const LightNode<S> y = b.node(i);
    ASSERT_EQ(x.is_leaf, y.is_leaf);
    ASSERT_EQ(x.children, y.children);
    ASSERT_EQ(x.intensity, y.intensity);
    ASSERT_EQ(x.box.lo, y.box.lo);
    ASSERT_EQ(x.box.hi, y.box.hi);
    ASSERT_EQ(x.normals.axis, y.normals.axis);
    ASSERT_EQ(x.normals.cos_half, y.normals.cos_half);
    if (x.is_leaf) continue;
    open.push_back(x.children[0]);
    open.push_back(x.children[1]);
  }
  EXPECT_EQ(visited, 2 * a.vpls().size() - a.roots().size());
}

TEST(Executors, LightTreeIsTheSame) {
  test::RandomVertices<float> random(5);
  std::vector<VertexOf<test::MixedScene<float>>> lights;
  for (int i = 0; i < 50000; ++i) {
    lights.push_back(random.light(random.point(Vec3<float>(0), 3), random.direction(), test::Gloss::some,
                                  {VertexKind::surface, VertexKind::area_emitter, VertexKind::point_emitter}));
  }
  const LightTree<test::MixedScene<float>> serial(lights, SerialExecutor{});
  const LightTree<test::MixedScene<float>> parallel(lights, TbbExecutor{});
  expect_same_nodes<float>(serial, parallel);
}

TEST(Executors, VplSetIsTheSame) {
  const auto scene =
      test::compose_bvh<Lambertian<float>>(test::cornell_like_box<float>(), {Lambertian<float>{Rgb<float>(0.6f)}});
  const IndependentSampler<float> sampler{3};
  RayCounts serial_rays, parallel_rays;
  const VplConfig config{20000};
  const auto serial = trace_vpls(scene, config, sampler, SerialExecutor{}, serial_rays);
  const auto parallel = trace_vpls(scene, config, sampler, TbbExecutor{}, parallel_rays);
  EXPECT_EQ(serial.path_count, parallel.path_count);
  EXPECT_EQ(serial.mean_intensity, parallel.mean_intensity);
  EXPECT_EQ(serial_rays.closest, parallel_rays.closest);
  ASSERT_EQ(serial.vpls.size(), parallel.vpls.size());
  for (std::size_t i = 0; i < serial.vpls.size(); ++i) {
    ASSERT_EQ(serial.vpls[i].position, parallel.vpls[i].position);
    ASSERT_EQ(serial.vpls[i].strength, parallel.vpls[i].strength);
  }
}

}  // namespace
}  // namespace manylight::light_tree_tbb_test
