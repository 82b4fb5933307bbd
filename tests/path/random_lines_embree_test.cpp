// SPDX-License-Identifier: Apache-2.0
// Oracle: the built-in backend, line by line.
#include <cstddef>
#include <vector>

#include <gtest/gtest.h>

#include "manylight/geometry/bvh.hpp"
#include "manylight/geometry/embree.hpp"
#include "path/line_shapes.hpp"
#include "scattering/falloff_support.hpp"

namespace manylight::test::random_lines_embree_test {
namespace {

TEST(RandomLinesEmbree, GridsAreCrossedByTheSameLines) {
  const auto falloff = gaussian<float>();
  const auto expected = counts_of(Bvh<float>(grid_of(100, 20.0F)), Vec3<float>(0), falloff, 50000, 310);
  const auto counts = counts_of(EmbreeGeometry(grid_of(100, 20.0F)), Vec3<float>(0), falloff, 50000, 310);
  int different = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) different += counts[i] != expected[i] ? 1 : 0;
  EXPECT_LE(different, 1);  // an end within some 1e-6 of the plane: one in 1e6
}

TEST(RandomLinesEmbree, EdgesCountOnce) { edges_count_once<EmbreeGeometry>(false); }

}  // namespace
}  // namespace manylight::test::random_lines_embree_test
