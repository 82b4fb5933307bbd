// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <string>

#include "integrator/builders.hpp"
#include "manylight/geometry/bvh.hpp"
#include "manylight/scattering/lambertian.hpp"

namespace manylight::test::million_lights_slow_test {
namespace {

/// Stability case 23: a million lights at one point, or on a line, build a tree without recursion, below the depth at which
/// halving takes over twice. The time is recorded, not judged.
TEST(MillionLights, TreesOverDuplicatesAndLines) {
  using S = float;
  using SceneType = Scene<Bvh<S>, UniformShader<Lambertian<S>>>;
  for (const bool on_a_line : {false, true}) {
    std::array<double, 2> seconds{};
    for (std::size_t size = 0; size < 2; ++size) {
      const std::size_t n = size == 0 ? 100'000 : 1'000'000;
      std::vector<VertexOf<SceneType>> vpls(n);
      for (std::size_t i = 0; i < n; ++i) {
        vpls[i].kind = VertexKind::point_emitter;
        vpls[i].position = Vec3<S>(on_a_line ? static_cast<S>(i) : S(0), 0, 1);
        vpls[i].strength = Rgb<S>(1);
      }
      const auto start = std::chrono::steady_clock::now();
      const LightTree<SceneType> tree(vpls, SerialExecutor{});
      seconds[size] = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      ASSERT_EQ(tree.roots().size(), 1u);
      EXPECT_NEAR(tree.node(tree.roots()[0]).intensity.x, static_cast<S>(n),
                  1e-4 * static_cast<double>(n));  // float sum
      unsigned depth = 0;
      for (std::uint32_t node = tree.roots()[0]; !tree.node(node).is_leaf; node = tree.node(node).children[0]) ++depth;
      EXPECT_LT(depth, 64u);
    }
    RecordProperty(on_a_line ? "line_ratio" : "point_ratio", std::to_string(seconds[1] / seconds[0]));
    RecordProperty(on_a_line ? "line_seconds" : "point_seconds", std::to_string(seconds[1]));
  }
}

}  // namespace
}  // namespace manylight::test::million_lights_slow_test
