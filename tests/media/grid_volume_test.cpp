// SPDX-License-Identifier: Apache-2.0
// Lookups against a naive trilinear formula, majorants against the values that they bound, walks against geometry.
#include "manylight/media/grid_volume.hpp"

#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/ext/matrix_transform.hpp>

#include "manylight/core/warp.hpp"
#include "manylight/media/block_majorants.hpp"
#include "media/media_support.hpp"

namespace manylight::test::grid_volume_test {
namespace {

using testing::HasSubstr;

Mat4<double> turned_and_stretched() {
  Mat4<double> m = glm::translate(Mat4<double>(1), Vec3<double>(3, -2, 1));
  m = glm::rotate(m, 0.7, glm::normalize(Vec3<double>(1, 2, -1)));
  return glm::scale(m, Vec3<double>(2, 0.5, 1.5));
}

/// sum over all samples of value * product of hats around them, at lattice coordinates `g`; periodic if `wraps`.
double by_hats(const GridVolume<double, double>& grid, const Vec3<double>& g) {
  const auto& lattice = grid.lattice();
  double sum = 0;
  std::size_t i = 0;
  for (std::uint32_t z = 0; z < lattice.size()[2]; ++z) {
    for (std::uint32_t y = 0; y < lattice.size()[1]; ++y) {
      for (std::uint32_t x = 0; x < lattice.size()[0]; ++x, ++i) {
        const std::uint32_t at[3] = {x, y, z};
        double weight = 1;
        for (int axis = 0; axis < 3; ++axis) {
          const double n = lattice.size()[static_cast<std::size_t>(axis)];
          double h = g[axis] - lattice.first_sample();
          double d = 0;
          if (lattice.copies(axis) > 1) {
            d = std::abs(std::remainder(h - at[axis], n));
          } else {
            h = std::clamp(h, 0.0, n - 1);
            d = std::abs(h - at[axis]);
          }
          weight *= std::max(0.0, 1 - d);
        }
        sum += weight * grid.sample(i);
      }
    }
  }
  return sum;
}

struct Setting {
  std::array<std::uint32_t, 3> size;
  std::array<std::uint32_t, 3> copies;
  GridSamples samples;
};
const std::vector<Setting> k_settings{{{5, 4, 3}, {1, 1, 1}, GridSamples::at_vertices},
                                      {{5, 4, 3}, {1, 1, 1}, GridSamples::at_centers},
                                      {{19, 2, 27}, {1, 1, 1}, GridSamples::at_vertices},
                                      {{17, 3, 9}, {3, 1, 2}, GridSamples::at_vertices},
                                      {{13, 3, 1}, {2, 5, 1}, GridSamples::at_centers}};

template <std::floating_point S>
GridVolume<S, S> noise_grid(const Setting& setting, const Mat4<double>& to_world = Mat4<double>(1)) {
  GridPlacement<S> placement;
  placement.box = {Vec3<S>(-1, 0, 2), Vec3<S>(1, 3, S(2.5))};
  placement.copies = setting.copies;
  placement.samples = setting.samples;
  placement.to_world = Mat4<S>(to_world);
  return make_grid<S, S>(setting.size, rough_noise, placement);
}

// Planted bug seen to fail: a repeated grid at vertices with n - 1 cells per copy.
TEST(GridVolume, LookupsAreTrilinear) {
  IndependentStream<double> stream(1, Stage::test, 0, 0);
  for (const Setting& setting : k_settings) {
    const auto grid = noise_grid<double>(setting);
    Vec3<double> cells;
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      const bool spans = setting.samples == GridSamples::at_vertices && setting.copies[a] == 1;
      cells[axis] = spans ? setting.size[a] - 1.0 : 1.0 * setting.size[a] * setting.copies[a];
    }
    for (int k = 0; k < 300; ++k) {
      Vec3<double> f(stream.next(), stream.next(), stream.next());
      if (k % 5 == 0) f[k % 3] = k % 2;  // faces
      const Vec3<double> p = Vec3<double>(-1, 0, 2) + f * Vec3<double>(2, 3, 0.5);
      EXPECT_NEAR(grid.eval(p), by_hats(grid, f * cells), 1e-12);  // some ulp of coordinates
    }
    EXPECT_EQ(grid.eval({-1.01, 1, 2.2}), 0.0);
    EXPECT_EQ(grid.eval({0, 1, 2.51}), 0.0);
    EXPECT_EQ(grid.eval({std::nan(""), 1, 2.2}), 0.0);
  }
}

TEST(GridVolume, AtVerticesTheFirstAndLastSamplesLieOnTheFaces) {
  const auto grid = make_grid<double, double>(
      {4, 2, 2}, [](auto x, auto, auto) { return 1.0 + x; }, in_box<double>({0, 0, 0}, {3, 1, 1}));
  EXPECT_NEAR(grid.eval({0, 0.5, 0.5}), 1, 1e-14);  // some ulp
  EXPECT_NEAR(grid.eval({1.25, 0.5, 0.5}), 2.25, 1e-14);
  EXPECT_NEAR(grid.eval({3, 0.5, 0.5}), 4, 1e-14);
}

TEST(GridVolume, TilesEqualOneGridOfTheirCopies) {
  Setting tile{{6, 5, 4}, {3, 2, 4}, GridSamples::at_centers};
  const auto repeated = noise_grid<double>(tile);
  GridPlacement<double> placement;
  placement.box = {Vec3<double>(-1, 0, 2), Vec3<double>(1, 3, 2.5)};
  placement.samples = GridSamples::at_centers;
  const auto written_out = make_grid<double, double>(
      {18, 10, 16}, [](auto x, auto y, auto z) { return rough_noise(x % 6, y % 5, z % 4); }, placement);
  IndependentStream<double> stream(2, Stage::test, 0, 0);
  for (int k = 0; k < 1000; ++k) {
    // Inside of the outermost half cell, where the one holds its border and the other goes on.
    const Vec3<double> f = 0.05 + 0.9 * Vec3<double>(stream.next(), stream.next(), stream.next());
    const Vec3<double> p = Vec3<double>(-1, 0, 2) + f * Vec3<double>(2, 3, 0.5);
    EXPECT_NEAR(repeated.eval(p), written_out.eval(p), 1e-12);  // some ulp of coordinates
  }
  EXPECT_EQ(repeated.bytes(), 6U * 5 * 4 * sizeof(double));
}

TEST(GridVolume, StorageOfFewBytesReadsAsFractions) {
  const auto bytes = make_grid<float, std::uint8_t>({2, 2, 2}, [](auto x, auto, auto) { return x == 0 ? 51 : 255; });
  EXPECT_FLOAT_EQ(bytes.eval({0, 0, 0}), 0.2F);
  EXPECT_FLOAT_EQ(bytes.eval({0.5F, 0, 0}), 0.6F);
  EXPECT_EQ(bytes.bytes(), 8U);
  using Colour = glm::vec<3, std::uint8_t, glm::defaultp>;
  LargeVector<Colour> colours(8, Colour(255, 0, 51));
  const GridVolume<float, Colour> grid({2, 2, 2}, std::move(colours));
  EXPECT_FLOAT_EQ(grid.eval({0.3F, 0.1F, 0.9F}).z, 0.2F);
  EXPECT_EQ(grid.bytes(), 24U);
}

/// Rays of all kinds: along axes and diagonals, on faces, edges and corners, from within and without, to and fro.
template <std::floating_point S>
std::vector<Ray<S>> hard_rays(const GridLattice<S>& lattice, std::uint64_t seed) {
  std::vector<Ray<S>> rays;
  const Box<S> box = lattice.world_bounds();
  IndependentStream<S> stream(seed, Stage::test, 0, 0);
  for (int k = 0; k < 400; ++k) {
    const auto in_unit = [&] {
      const S u = stream.next();
      return k % 4 == 0 ? std::floor(u * S(5)) / S(4) : u * S(1.4) - S(0.2);  // of 4 parts, or anywhere about
    };
    const Vec3<S> origin = box.lo + Vec3<S>(in_unit(), in_unit(), in_unit()) * box.extent();
    Vec3<S> w = warp::square_to_sphere(stream.next_2d());
    if (k % 3 == 0) w = glm::normalize(Vec3<S>(glm::sign(w.x), k % 2 == 0 ? 0 : glm::sign(w.y), 0));
    if (k % 3 == 1) w = glm::normalize(box.extent() * glm::sign(w));
    rays.push_back({k % 5 == 0 ? origin - w * S(10) : origin, w});
  }
  return rays;
}

template <std::floating_point S>
void walks_are_covered_and_bounded(const Setting& setting, const Mat4<double>& to_world, std::uint32_t block) {
  const auto grid = noise_grid<S>(setting, to_world);
  const BlockMajorants<S> blocks(grid, block);
  IndependentStream<S> stream(5, Stage::test, 0, 0);
  int met = 0;
  for (const Ray<S>& ray : hard_rays(grid.lattice(), 6)) {
    const auto segment = grid.lattice().clip(ray, k_infinity<S>);
    if (!segment) continue;
    ++met;
    S s = S(0);
    blocks.walk(*segment, [&](const BlockStretch<S>& stretch) {
      EXPECT_EQ(stretch.s0, s);
      EXPECT_GE(stretch.s1, stretch.s0);
      s = stretch.s1;
      for (int k = 0; k < 6; ++k) {
        const S u = k < 2 ? static_cast<S>(k) : stream.next();
        const Vec3<S> g = stretch.at(*segment, stretch.s0 + u * (stretch.s1 - stretch.s0));
        EXPECT_LE(grid.eval_lattice(g), stretch.majorant);
        // Clamping to the block is for rounding only. Lengths of the box are below 10 m, at most 100 cells per metre.
        const Vec3<S> off = glm::abs(g - segment->at(stretch.s0 + u * (stretch.s1 - stretch.s0)));
        EXPECT_LE(max_channel(off), S(4000) * std::numeric_limits<S>::epsilon());
      }
      return true;
    });
    EXPECT_EQ(s, segment->length);
  }
  EXPECT_GT(met, 50);
}

// Planted bugs seen to fail: majorants of the samples within a block without those on its upper faces; the
// upper face as the next one of rays that run down.
TEST(BlockMajorants, BoundEveryValueAlongEveryRay) {
  for (const Setting& setting : k_settings) {
    for (const std::uint32_t block : {1U, 3U, 8U, 1000U}) {
      for (const Mat4<double>& m : {Mat4<double>(1), turned_and_stretched()}) {
        walks_are_covered_and_bounded<float>(setting, m, block);
        walks_are_covered_and_bounded<double>(setting, m, block);
      }
    }
  }
}

TEST(BlockMajorants, AreAsTightAsTheirBlocks) {
  // One filled sample: of the blocks of 4 cells only those that its two hats reach may see it.
  const auto grid = make_grid<double, double>(
      {17, 17, 17}, [](auto x, auto y, auto z) { return x == 6 && y == 6 && z == 6 ? 1.0 : 0.0; });
  const BlockMajorants<double> blocks(grid, 4);
  int filled = 0;
  for (int y = 0; y < 4; ++y) {
    const auto segment = grid.lattice().clip({{-1, (4 * y + 2) / 16.0, 6 / 16.0}, {1, 0, 0}}, 10.0);
    blocks.walk(*segment, [&](const BlockStretch<double>& stretch) {
      filled += stretch.majorant > 0 ? 1 : 0;
      return true;
    });
  }
  EXPECT_EQ(filled, 1);
  EXPECT_EQ(blocks.bytes(), 64 * sizeof(double));
}

// Oracle: whether points of the ray, brought back by the inverse matrix, lie in the box.
TEST(GridLattice, ClipsInWorldMetres) {
  const Mat4<double> m = turned_and_stretched();
  const auto grid = noise_grid<double>(k_settings[2], m);
  const Mat4<double> back = glm::inverse(m);
  const Box<double> box{{-1, 0, 2}, {1, 3, 2.5}};
  int met = 0;
  for (const Ray<double>& ray : hard_rays(grid.lattice(), 7)) {
    const auto segment = grid.lattice().clip(ray, 8.0);
    const auto is_in = [&](double t) {
      return box.contains(detail::transform_point(back, ray.origin + ray.direction * t));
    };
    if (!segment) {
      for (int k = 0; k < 100; ++k) EXPECT_FALSE(is_in(0.08 * k + 0.0413));
      continue;
    }
    ++met;
    const double t0 = segment->t_entry;
    const double t1 = t0 + segment->length;
    constexpr double k_tiny = 1e-9;  // far above rounding, far below the box
    EXPECT_TRUE(t1 - t0 < 3 * k_tiny || (is_in(t0 + k_tiny) && is_in(t1 - k_tiny)));
    EXPECT_TRUE(t0 == 0.0 || !is_in(t0 - k_tiny));
    EXPECT_TRUE(t1 >= 8.0 - k_tiny || !is_in(t1 + k_tiny));
  }
  EXPECT_GT(met, 50);
}

TEST(GridLattice, RaysOnAFaceAreInsideAndBadOnesMiss) {
  const auto grid = make_grid<float>({2, 2, 2}, [](auto, auto, auto) { return 1; });
  const auto& lattice = grid.lattice();
  EXPECT_TRUE(lattice.clip({{-1, 1, 0.5F}, {1, 0, 0}}, 10.0F));
  EXPECT_TRUE(lattice.clip({{-1, 0, 0}, {1, 0, 0}}, 10.0F)) << "an edge";
  EXPECT_FALSE(lattice.clip({{-1, 1.0001F, 0.5F}, {1, 0, 0}}, 10.0F));
  EXPECT_FALSE(lattice.clip({{-1, 0.5F, 0.5F}, {1, 0, 0}}, 1.0F)) << "ends on the face";
  EXPECT_FALSE(lattice.clip({{2, 0.5F, 0.5F}, {1, 0, 0}}, k_infinity<float>)) << "behind";
  EXPECT_FALSE(lattice.clip({{0.5F, 0.5F, 0.5F}, {0, 0, 0}}, k_infinity<float>));
  const float nan = std::nanf("");
  EXPECT_FALSE(lattice.clip({{nan, 0.5F, 0.5F}, {1, 0, 0}}, 1.0F));
  EXPECT_FALSE(lattice.clip({{0.5F, 0.5F, 0.5F}, {nan, 0, 0}}, 1.0F));
  EXPECT_FALSE(lattice.clip({{0.5F, 0.5F, 0.5F}, {1, 0, 0}}, nan));
  EXPECT_FALSE(lattice.clip({{k_infinity<float>, 0.5F, 0.5F}, {-1, 0, 0}}, k_infinity<float>));
}

template <class Action>
std::string reason(const Action& action) {
  try {
    action();
  } catch (const ParameterError& error) {
    return error.what();
  }
  return "none";
}

TEST(GridVolume, WrongInputIsNamed) {
  const auto with = [](double value) {
    return reason([&] {
      static_cast<void>(make_grid<double, double>(
          {3, 2, 2}, [&](auto x, auto y, auto z) { return x == 1 && y == 0 && z == 1 ? value : 1.0; }));
    });
  };
  EXPECT_EQ(with(-2), "grid value 7 at (1, 0, 1) is -2, allowed: finite and >= 0");
  EXPECT_THAT(with(std::nan("")), HasSubstr("grid value 7 at (1, 0, 1) is nan"));
  EXPECT_THAT(with(k_infinity<double>), HasSubstr("is inf"));
  const auto placed = [](const GridPlacement<double>& placement, const std::array<std::uint32_t, 3>& size = {2, 2, 2}) {
    return reason([&] { static_cast<void>(make_grid<double, double>(size, rough_noise, placement)); });
  };
  EXPECT_EQ(placed({}), "none");
  EXPECT_THAT(placed({}, {2, 1, 2}), HasSubstr("number of grid samples along y is 1, allowed: 2 to"));
  EXPECT_THAT(placed(in_box<double>({0, 0, 1}, {1, 1, 1})), HasSubstr("upper end of the grid's box along z is 1"));
  GridPlacement<double> none;
  none.copies[2] = 0;
  EXPECT_THAT(placed(none), HasSubstr("number of grid copies along z is 0"));
  GridPlacement<double> flat;
  flat.to_world[1] = {0, 0, 0, 0};
  EXPECT_THAT(placed(flat), HasSubstr("determinant of the grid transform is 0"));
  GridPlacement<double> projective;
  projective.to_world[0][3] = 0.1;
  EXPECT_THAT(placed(projective), HasSubstr("row 3 column 0 is 0.1"));
  EXPECT_THAT(reason([] {
                GridVolume<float>({2, 2, 2}, LargeVector<float>(7));
              }),
              HasSubstr("number of grid values is 7, allowed: the product of the sizes, 8"));
  EXPECT_THAT(reason([] {
                GridVolume<float>({2, 2, 2}, std::shared_ptr<const LargeVector<float>>());
              }),
              HasSubstr("number of grid values is 0"));
}

}  // namespace
}  // namespace manylight::test::grid_volume_test
