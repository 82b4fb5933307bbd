// SPDX-License-Identifier: Apache-2.0
// Oracles: the density g / 2 per line and area, integrated in closed form or by quadrature; crossings of the same
// chords with analytic shapes.
#include "manylight/path/random_lines.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "manylight/geometry/bvh.hpp"
#include "manylight/geometry/mesh_builders.hpp"
#include "manylight/scattering/subsurface.hpp"
#include "path/line_shapes.hpp"
#include "scattering/falloff_support.hpp"
#include "support/chi_square.hpp"
#include "support/z_test.hpp"

namespace manylight::test::random_lines_test {
namespace {

/// Mean over the channels, what lines are drawn by.
template <class F>
[[nodiscard]] double mean_of(const F& falloff, double d) {
  const auto g = falloff.eval(static_cast<typename F::Scalar>(d));
  return (double(g.x) + double(g.y) + double(g.z)) / 3;
}

/// Distances of the crossings of `lines` single lines with a plane `offset` from the centre, against 2 pi d g / 2: a
/// line crosses it once or not at all, so that counts are multinomial.
template <Geometry G, SubsurfaceFalloff F>
[[nodiscard]] ChiSquareResult plane_chi_square(const G& plane, const F& falloff, const Vec3<typename G::Scalar>& center,
                                               double offset, int lines, std::uint64_t seed) {
  using S = typename G::Scalar;
  constexpr int k_bins = 40;
  const double least = std::max(offset, 1e-3);
  const auto edge = [&](int i) { return least * std::pow(20 / least, static_cast<double>(i) / k_bins); };
  const auto share = [&](double from, double to) {
    return 0.5 * plane_share([&](double d) { return mean_of(falloff, d); }, from, to);
  };
  std::vector<ExpectedCount> cells(k_bins + 3);
  double total = 0;
  const auto expect = [&](std::size_t cell, double p, const std::string& name) {
    cells[cell] = {lines * std::max(p, 1e-12), 0, name};
    total += p;
  };
  expect(0, offset > 0 ? 0 : share(1e-7, least), "near");
  for (int i = 0; i < k_bins; ++i)
    expect(static_cast<std::size_t>(i + 1), share(edge(i), edge(i + 1)), std::to_string(edge(i)));
  expect(k_bins + 1, share(20, 1e7), "far");
  cells[k_bins + 2] = {lines * (1 - total), 0, "none"};
  IndependentStream<S> stream(seed, Stage::test, 0, 0);
  for (int i = 0; i < lines; ++i) {
    std::size_t cell = k_bins + 2;
    random_lines(plane, 0, center, falloff, 1, stream, [&](const SurfacePoint<S>& point, S) {
      const double d = double(glm::length(point.position - center));
      EXPECT_EQ(cell, std::size_t{k_bins + 2}) << "a line crossed a plane twice";
      const double position = std::floor(std::log(std::max(d, 1e-9) / least) / std::log(20 / least) * k_bins);
      cell = static_cast<std::size_t>(std::clamp(position, offset > 0 ? 0.0 : -1.0, double(k_bins)) + 1);
    });
    cells[cell].observed += 1;
  }
  return chi_square(cells);
}

// Mean hits of 1/2 per line and distances by g / 2, family of all: level 1e-4. Planted bugs seen to fail: the second
// end of a chord opposite to the first; radii scaled by 1.05.
template <std::floating_point S>
void planes_are_crossed_by_half_the_falloff(std::uint64_t seed) {
  const Bvh<S> disk(disk_of(S(1e6)));
  const auto test = [&](const auto& falloff, const std::string& name) {
    for (const double offset : {0.0, 0.5}) {
      const auto r =
          plane_chi_square(disk, falloff, Vec3<S>(S(0.3), S(-0.2), static_cast<S>(offset)), offset, 100000, ++seed);
      EXPECT_TRUE(r.passes(sidak_level(1e-4, 16))) << name << ' ' << offset << ' ' << r.describe();
    }
  };
  test(exponential<S>(), "exponential");
  test(gaussian<S>(), "Gaussian");
  test(burley<S>(), "Burley");
  test(dipole<S>(), "dipole");
}
TEST(RandomLines, PlanesAreCrossedByHalfTheFalloff) {
  planes_are_crossed_by_half_the_falloff<double>(100);
  planes_are_crossed_by_half_the_falloff<float>(200);
}

// The same for a plane of triangles, with the centre on a vertex. Level 1e-4 for both.
template <std::floating_point S>
[[nodiscard]] ChiSquareResult tessellated(std::uint64_t seed) {
  const Bvh<S> grid(grid_of(256, S(64)));
  return plane_chi_square(grid, exponential<S>(), Vec3<S>(0), 0, 200000, seed);
}
TEST(RandomLines, TessellatedPlanesAreNoDifferent) {
  const auto in_float = tessellated<float>(300);
  EXPECT_TRUE(in_float.passes(sidak_level(1e-4, 2))) << in_float.describe();
  const auto in_double = tessellated<double>(301);
  EXPECT_TRUE(in_double.passes(sidak_level(1e-4, 2))) << in_double.describe();
}

// No line is lost or counted twice at an edge: lines that end next to the plane apart, a grid and a disk are crossed by
// the same ones, to the line.
TEST(RandomLines, GridsAndDisksAreCrossedByTheSameLines) {
  const auto falloff = gaussian<float>();
  const auto by_grid = counts_of(Bvh<float>(grid_of(100, 20.0F)), Vec3<float>(0), falloff, 50000, 310);
  const auto by_disk = counts_of(Bvh<float>(disk_of(30.0F)), Vec3<float>(0), falloff, 50000, 310);
  int different = 0;
  for (std::size_t i = 0; i < by_grid.size(); ++i) different += by_grid[i] != by_disk[i] ? 1 : 0;
  EXPECT_LE(different, 1);  // an end within some 1e-6 of the plane: one in 1e6
}

// A cube, from a face's centre and from next to an edge: lines against the slab test, in double. Planted bugs seen to
// fail, here and above: crossings near edges dropped; lines cut at t = 0.9 (here).
TEST(RandomLines, CubesAreCrossedWhereTheirSlabsAre) {
  Shapes<double> shapes;
  shapes.meshes.push_back(cube_mesh<double>());
  const Bvh<double> cube(shapes);
  const auto falloff = exponential<double>();
  for (const Vec3<double>& center : {Vec3<double>(0, 0, 1), Vec3<double>(1, 0.98, 0.1)}) {
    for (int i = 0; i < 50000; ++i) {
      IndependentStream<double> stream(320, Stage::test, static_cast<std::uint64_t>(i), 0);
      IndependentStream<double> same = stream;
      int count = 0;
      random_lines(cube, 0, center, falloff, 1, stream, [&](const SurfacePoint<double>&, double) { ++count; });
      const Ray<double> line = random_line(center, falloff, same);
      double enter = -1e300;
      double leave = 1e300;
      for (int axis = 0; axis < 3; ++axis) {
        const double a = (-1 - line.origin[axis]) / line.direction[axis];
        const double b = (1 - line.origin[axis]) / line.direction[axis];
        enter = std::max(enter, std::min(a, b));
        leave = std::min(leave, std::max(a, b));
      }
      const auto is_within = [](double t) { return t >= 0 && t <= 1 ? 1 : 0; };
      EXPECT_EQ(count, enter < leave ? is_within(enter) + is_within(leave) : 0) << i;
    }
  }
}

TEST(ShapeCrossings, EdgesCountOnce) {
  edges_count_once<Bvh<float>>(true);
  edges_count_once<Bvh<double>>(true);
}

// Far from the origin, where coordinates are a coarse lattice of 6e-5 m and so are the ends of lines: 1/2 per line
// still. Level 1e-4. Planted bugs seen to fail: lines to an end that is rounded, t up to 1; edges counted twice.
TEST(RandomLines, FarFromTheOriginMeshesAreCrossedJustAsOften) {
  const Vec3<float> center(1000, 1000, 1000);
  const Bvh<float> grid(grid_of(256, 0.25F, center));
  const ExponentialFalloff<float> falloff(Rgb<float>(0.001F));
  constexpr int k_lines = 200000;
  double hits = 0;
  for (const int count : counts_of(grid, center, falloff, k_lines, 330)) {
    EXPECT_LE(count, 1);
    hits += count;
  }
  const double z = (hits - 0.5 * k_lines) / std::sqrt(0.25 * k_lines);
  EXPECT_LT(std::abs(z), normal_limit(1e-4)) << hits / k_lines;
}

// The unit sphere, seen from a point on it: its part within the distance 1 has the area pi. Family: level 1e-4.
template <std::floating_point S>
void caps_have_the_area_pi(std::uint64_t seed) {
  Shapes<S> shapes;
  shapes.spheres.push_back({Vec3<S>(0, 0, 0), S(1)});
  const Bvh<S> sphere(shapes);
  const auto test = [&](const auto& falloff, const std::string& name) {
    const Vec3<S> center(0, S(0.6), S(0.8));
    RunningMoments area;
    for (int i = 0; i < 40000; ++i) {
      IndependentStream<S> stream(seed, Stage::test, static_cast<std::uint64_t>(i), 0);
      double sum = 0;
      random_lines(sphere, 0, center, falloff, 4, stream, [&](const SurfacePoint<S>& point, S pdf) {
        if (glm::length(point.position - center) < S(1)) sum += 1 / double(pdf);
      });
      area.add(sum);
    }
    const double z = z_score(area.mean(), area.standard_error(), k_pi<double>);
    EXPECT_LT(std::abs(z), normal_limit(sidak_level(1e-4, 8))) << name << ' ' << area.mean();
  };
  test(exponential<S>(), "exponential");
  test(gaussian<S>(), "Gaussian");
  test(burley<S>(), "Burley");
  test(dipole<S>(), "dipole");
}
TEST(RandomLines, CapsHaveTheAreaPi) {
  caps_have_the_area_pi<double>(400);
  caps_have_the_area_pi<float>(401);
}

// Exponential of length 1 m on the unit sphere. A share f = (1 - r / 2) / 2 of the sphere of radius r < 2 around x lies
// inside, so that a line has one hit with probability E[2 f (1 - f)]; its mean of hits is the integral of g / 2.
TEST(RandomLines, HitsPerLineOnASphere) {
  double one = 0;
  constexpr int k_steps = 20000;
  for (int i = 0; i < k_steps; ++i) {
    const double r = 2 * (i + 0.5) / k_steps;
    one += 0.5 * r * r * std::exp(-r) * 0.5 * (1 - 0.25 * r * r) * 2 / k_steps;
  }
  const double mean = 0.5 * (1 - 3 * std::exp(-2.0));
  const double two = 0.5 * (mean - one);
  EXPECT_NEAR(1 - one - two, 0.810, 5e-4);  // half a unit of the last digit
  EXPECT_NEAR(one, 0.083, 5e-4);
  EXPECT_NEAR(two, 0.107, 5e-4);
  Shapes<float> shapes;
  shapes.spheres.push_back({Vec3<float>(0, 0, 0), 1.0F});
  constexpr int k_lines = 200000;
  std::vector<ExpectedCount> cells{
      {k_lines * (1 - one - two), 0, "0"}, {k_lines * one, 0, "1"}, {k_lines * two, 0, "2"}};
  const ExponentialFalloff<float> falloff(Rgb<float>(1));
  for (const int count : counts_of(Bvh<float>(shapes), Vec3<float>(0.6F, 0, 0.8F), falloff, k_lines, 410)) {
    cells[static_cast<std::size_t>(count)].observed += 1;
  }
  const ChiSquareResult r = chi_square(cells);
  EXPECT_TRUE(r.passes(1e-4)) << r.describe();
}

// A half-space under the irradiance E leaves with the radiosity rho E, whatever the falloff: s_o tau s_i / p of each
// crossing. Family of channels and falloffs: level 1e-4. Planted bug seen to fail: the density of one line for n.
template <SubsurfaceFalloff F>
void half_space(const F& falloff, std::uint64_t seed, const std::string& name) {
  using S = typename F::Scalar;
  const Subsurface<F> body{falloff, {S(0.9), S(0.5), S(0.2)}, S(1)};
  const Bvh<S> plane(disk_of(S(1e6)));
  const Vec3<S> center(1, 2, 0);
  const S irradiance = S(3);
  const unsigned lines = 4;
  std::array<RunningMoments, 3> radiosity;
  for (int i = 0; i < 25000; ++i) {
    IndependentStream<S> stream(seed, Stage::test, static_cast<std::uint64_t>(i), 0);
    Rgb<S> radiance(0);  // the same to all sides
    random_lines(plane, 0, center, falloff, lines, stream, [&](const SurfacePoint<S>& point, S pdf) {
      const Rgb<S> tau = body.transit(glm::length(point.position - center));
      const Rgb<S> ends = body.sqrt_rho() * k_inv_pi<S> * body.sqrt_rho() * k_inv_pi<S>;
      radiance += ends * tau * (irradiance / pdf);
      EXPECT_LE(max_channel(tau), pdf * 6 * k_pi<S> / S(lines) * S(1.0001));  // some ulp
    });
    for (int k = 0; k < 3; ++k) radiosity[static_cast<std::size_t>(k)].add(double(radiance[k]) * k_pi<double>);
  }
  for (int k = 0; k < 3; ++k) {
    const RunningMoments& m = radiosity[static_cast<std::size_t>(k)];
    const double z = z_score(m.mean(), m.standard_error(), double(body.rho[k]) * 3);
    EXPECT_LT(std::abs(z), normal_limit(sidak_level(1e-4, 12))) << name << k << ' ' << m.mean();
  }
}
TEST(RandomLines, HalfSpacesReturnTheirAlbedo) {
  half_space(exponential<float>(), 500, "exponential");
  half_space(gaussian<float>(), 501, "Gaussian");
  half_space(burley<double>(), 502, "Burley");
  half_space(dipole<double>(), 503, "dipole");
}

// Other shapes of all kinds, around and in the way, change nothing. Planted bug seen to fail: hit.shape not asked for.
TEST(RandomLines, OtherShapesArePassedThrough) {
  const auto falloff = burley<double>();
  const Vec3<double> center(0.1, 0.2, 0);
  const auto alone = counts_of(Bvh<double>(grid_of(10, 5.0)), center, falloff, 5000, 600);
  Shapes<double> shapes = grid_of(10, 5.0);
  shapes.meshes.push_back(cube_mesh<double>());
  append_grid(shapes.meshes.emplace_back(), 10, 5.0, 0.0);
  shapes.spheres.push_back({center, 0.5});
  shapes.disks.push_back({center, {0, 0, 1}, {1, 0, 0}, 1.0});
  EXPECT_EQ(counts_of(Bvh<double>(shapes), center, falloff, 5000, 600), alone);
}

// Both sides of a slab much thinner than the falloff: each is crossed by half the lines, most lines cross both; the
// points stand on both. Level 1e-4. Planted bug seen to fail: edges counted twice.
TEST(RandomLines, ThinSlabsAreCrossedOnBothSides) {
  Shapes<float> slab;
  slab.meshes.emplace_back();
  append_grid(slab.meshes.front(), 128, 32.0F, 0.0F);
  append_grid(slab.meshes.front(), 128, 32.0F, -1e-4F);
  const Bvh<float> thin(slab);
  const ExponentialFalloff<float> falloff(Rgb<float>(1));
  std::array<int, 3> of_count{};
  int upper = 0;
  int lower = 0;
  constexpr int k_lines = 100000;
  IndependentStream<float> stream(610, Stage::test, 0, 0);
  for (int i = 0; i < k_lines; ++i) {
    std::size_t count = 0;
    random_lines(thin, 0, Vec3<float>(0), falloff, 1, stream, [&](const SurfacePoint<float>& point, float) {
      ++count;
      ++(point.position.z > -5e-5F ? upper : lower);
    });
    ASSERT_LE(count, 2U);
    ++of_count[count];
  }
  const double limit = normal_limit(sidak_level(1e-4, 2)) * std::sqrt(0.25 * k_lines);
  EXPECT_NEAR(upper, 0.5 * k_lines, limit);
  EXPECT_NEAR(lower, 0.5 * k_lines * (1 - 5e-9), limit);  // 1 - h^2 / 2 of them at the offset h
  // One side alone: an end between them, of probability E[h / (2 r)] = h / 4, once for either end.
  EXPECT_LE(of_count[1], 20);  // expects 5; Poisson, beyond 20 with probability 1e-7
}

TEST(RandomLines, AreAFunctionOfTheStream) {
  const Bvh<float> grid(grid_of(10, 5.0F));
  const auto draw = [&] {
    std::vector<float> values;
    IndependentStream<float> stream(620, Stage::test, 7, 3);
    random_lines(grid, 0, Vec3<float>(0), burley<float>(), 100, stream,
                 [&](const SurfacePoint<float>& point, float pdf) {
                   values.insert(values.end(), {point.position.x, point.position.y, pdf});
                   EXPECT_GT(pdf, 0.0F);
                 });
    return values;
  };
  EXPECT_EQ(draw(), draw());
  EXPECT_FALSE(draw().empty());
}

}  // namespace
}  // namespace manylight::test::random_lines_test
