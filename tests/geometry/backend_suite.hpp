// SPDX-License-Identifier: Apache-2.0
#pragma once

// One suite for every ray-tracing backend; `backend_test.cpp` runs it for Bvh, `backend_embree_test.cpp` for Embree.
//
// Bugs planted once in the headers, and what caught them:
//  - edges exclusive (lowest > 0), slabs without slack, products of the edge functions left to be fused
//  (-march=native):
//    ClosedMeshesHaveNoCracks;
//  - the near plane chosen by d < 0 instead of the sign bit, `t <= t_max` forgotten: AgreesWithBruteForce;
//  - offsets of length 0, offsets to the wrong side: LeavesFlatWalls and LeavesSpheres.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "geometry/ray_oracle.hpp"
#include "geometry/test_meshes.hpp"
#include "manylight/core/error.hpp"
#include "manylight/geometry/bvh.hpp"
#include "manylight/geometry/concepts.hpp"
#include "manylight/geometry/mesh_builders.hpp"
#include "manylight/geometry/offset.hpp"
#include "manylight/geometry/surface_point.hpp"

namespace manylight::test {

template <class G>
class BackendSuite : public testing::Test {
 public:
  using Scalar = typename G::Scalar;

  /// Every answer for every ray against the oracle.
  static void expect_agreement(Shapes<Scalar> shapes, const std::vector<Ray<Scalar>>& rays, const std::string& what) {
    const G geometry(std::move(shapes));
    std::size_t wrong = 0;
    std::string first;
    const auto note = [&](std::size_t ray, const char* query) {
      if (wrong++ == 0) first = what + ", ray " + std::to_string(ray) + ": " + query;
    };
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const std::vector<Verdict> verdicts = judge(geometry.shapes(), rays[i]);
      const std::optional<Hit<Scalar>> closest = geometry.closest_hit(rays[i]);
      if (closest && !is_allowed(verdicts, *closest)) note(i, "closest hit where there is none");
      if (!is_closest(verdicts, closest)) note(i, "a closer hit was missed");
      const bool any = geometry.any_hit(rays[i]);
      if (any && verdicts.empty()) note(i, "any hit where there is none");
      if (!any && !is_closest<Scalar>(verdicts, std::nullopt)) note(i, "any hit missed");
      if (!all_hits_agree(geometry, rays[i], verdicts)) note(i, "all hits differ");
    }
    EXPECT_EQ(wrong, 0u) << "of " << rays.size() << "; first: " << first;
  }

  static bool all_hits_agree(const G& geometry, const Ray<Scalar>& ray, const std::vector<Verdict>& verdicts) {
    std::vector<Hit<Scalar>> hits;
    geometry.all_hits(ray, [&](const Hit<Scalar>& hit) { hits.push_back(hit); });
    for (const Hit<Scalar>& hit : hits) {
      if (!is_allowed(verdicts, hit)) return false;
    }
    return std::all_of(verdicts.begin(), verdicts.end(), [&](const Verdict& v) {
      const auto times = std::count_if(hits.begin(), hits.end(), [&](const Hit<Scalar>& hit) {
        return hit.shape == v.shape && hit.primitive == v.primitive && double(hit.t) >= v.lo && double(hit.t) <= v.hi;
      });
      return !v.must || times == 1;
    });
  }
};

/// `place` undone: the point in the room [-5,5]^3.
template <class S>
[[nodiscard]] Vec3<double> unplace(const Vec3<S>& p, const Placement& placement) {
  return (Vec3<double>(p) - place<double>(Vec3<double>(0), placement)) / placement.scale;
}

/// Walls of the room within 8 error bounds of the point, its own included.
template <class S>
[[nodiscard]] int count_near_walls(const SurfacePoint<S>& point, const Placement& placement) {
  const Vec3<double> p = glm::abs(unplace(point.position, placement));
  const double limit = 5 - 8 * double(point.error) / placement.scale;
  return (p.x > limit ? 1 : 0) + (p.y > limit ? 1 : 0) + (p.z > limit ? 1 : 0);
}

/// Whether the segment between the points passes through [-half_width, half_width]^3.
template <class S>
[[nodiscard]] bool crosses_cube(const SurfacePoint<S>& a, const SurfacePoint<S>& b, const Placement& placement,
                                double half_width) {
  const Vec3<double> from = unplace(a.position, placement);
  const Vec3<double> along = unplace(b.position, placement) - from;
  double enter = 0;
  double leave = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const double t0 = (-half_width - from[axis]) / along[axis];
    const double t1 = (half_width - from[axis]) / along[axis];
    enter = std::max(enter, std::min(t0, t1));
    leave = std::min(leave, std::max(t0, t1));
  }
  return enter < leave;
}

TYPED_TEST_SUITE_P(BackendSuite);

// Oracle: brute force in double (spheres: long double).
TYPED_TEST_P(BackendSuite, AgreesWithBruteForce) {
  using S = typename TypeParam::Scalar;
  const auto run = [](TriangleMesh<S> mesh, const char* what, std::uint64_t seed) {
    Shapes<S> shapes;
    shapes.meshes.push_back(std::move(mesh));
    TestFixture::expect_agreement(std::move(shapes), mixed_rays<S>(1500, seed), what);
  };
  run(rippled_sphere<S>(16, 0.2), "rippled sphere", 1);
  run(soup<S>(1000, 0.2, 2), "soup", 3);
  run(soup<S>(200, 2.0, 4), "soup of large triangles", 5);
  run(slivers<S>(400, 6), "slivers", 7);
  run(duplicates_and_rows<S>(), "duplicates and rows", 8);
}

TYPED_TEST_P(BackendSuite, AgreesWithBruteForceOnMixedShapes) {
  using S = typename TypeParam::Scalar;
  Shapes<S> analytic;
  add_analytic_shapes(analytic, 11);
  TestFixture::expect_agreement(analytic, mixed_rays<S>(4000, 12), "spheres and disks");
  Shapes<S> mixed = analytic;
  mixed.meshes = {soup<S>(300, 0.3, 13), cube_mesh<S>(Mat4<S>(S(0.8))), rippled_sphere<S>(8, 0.1)};
  TestFixture::expect_agreement(std::move(mixed), mixed_rays<S>(1500, 14), "meshes, spheres and disks");
}

TYPED_TEST_P(BackendSuite, OneTriangleAndNothing) {
  using S = typename TypeParam::Scalar;
  const TypeParam nothing{Shapes<S>{}};
  const Ray<S> ray{{0, 0, -1}, {0, 0, 1}};
  EXPECT_FALSE(nothing.closest_hit(ray).has_value());
  EXPECT_FALSE(nothing.any_hit(ray));
  nothing.all_hits(ray, [](const Hit<S>&) { ADD_FAILURE() << "a hit in an empty scene"; });

  Shapes<S> shapes;
  shapes.meshes.push_back({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}, {}, {}});
  const TypeParam one(shapes);
  const auto hit = one.closest_hit({{S(0.25), S(0.5), -2}, {0, 0, 4}});
  ASSERT_TRUE(hit.has_value());
  // Every operation on these numbers is exact but Embree's reciprocal, which depends on the processor's vector unit.
  const S slack = std::is_same_v<TypeParam, Bvh<S>> ? S(0) : S(2) * std::numeric_limits<S>::epsilon();
  EXPECT_NEAR(hit->t, S(0.5), slack);
  EXPECT_NEAR(hit->u, S(0.25), slack);
  EXPECT_NEAR(hit->v, S(0.5), slack);
  EXPECT_FALSE(one.any_hit({{S(0.75), S(0.5), -2}, {0, 0, 4}}));
  EXPECT_FALSE(one.any_hit({{S(0.25), S(0.5), -2}, {0, 0, 4}, S(0), S(0.499)}));
  EXPECT_FALSE(one.any_hit({{S(0.25), S(0.5), -2}, {0, 0, 4}, S(0.501), S(2)}));
}

TYPED_TEST_P(BackendSuite, ZeroAreaIsNeverHit) {
  using S = typename TypeParam::Scalar;
  Shapes<S> shapes;
  shapes.meshes.push_back(
      {{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 0, 1}, {3, 3, 3}, {0, 1, 3}}, {}, {}});
  const TypeParam geometry(shapes);
  for (const S x : {S(0), S(0.5), S(1.5)}) {
    const auto hit = geometry.closest_hit({{x, 0, -1}, {0, 0, 1}});
    EXPECT_EQ(hit.has_value(), x < S(1)) << x;
    EXPECT_TRUE(!hit || hit->primitive == 3u) << x;
  }
}

/// Share of rays aimed exactly at a vertex that a backend may lose. Bvh: none.
template <class G>
inline constexpr double k_lost_at_vertices = 0;

// Oracle: a ray from inside a closed surface meets it. Aimed at points of the edges and at the vertices, where rounding
// decides between neighbours.
TYPED_TEST_P(BackendSuite, ClosedMeshesHaveNoCracks) {
  using S = typename TypeParam::Scalar;
  constexpr int k_rays = 60000;
  for (const Placement& placement : k_placements) {
    Shapes<S> shapes;
    shapes.meshes.push_back(rippled_sphere<S>(24, 0.1, placement));
    const TypeParam geometry(shapes);
    const TriangleMesh<S>& mesh = geometry.shapes().meshes[0];
    Random random(21);
    std::size_t lost_at_edges = 0;
    std::size_t lost_at_vertices = 0;
    for (int i = 0; i < k_rays; ++i) {
      const auto& corner = mesh.triangles[static_cast<std::size_t>(random.next() * double(mesh.triangles.size()))];
      const Vec3<double> a(mesh.positions[corner[0]]);
      const Vec3<double> b(mesh.positions[corner[1]]);
      const bool at_vertex = i % 3 == 0;
      const Vec3<S> origin = place<S>(0.3 * random.in_cube(), placement);
      const Vec3<S> target(a + (b - a) * (at_vertex ? 0.0 : random.next()));
      const Ray<S> ray{origin, target - origin};
      const bool lost = !geometry.closest_hit(ray) || !geometry.any_hit(ray);
      (at_vertex ? lost_at_vertices : lost_at_edges) += lost ? 1 : 0;
    }
    EXPECT_EQ(lost_at_edges, 0u) << placement.name;
    EXPECT_LE(double(lost_at_vertices), k_lost_at_vertices<TypeParam> * k_rays / 3) << placement.name;
  }
}

// Oracle: a line crosses a closed surface an even number of times from outside, an odd number from inside.
TYPED_TEST_P(BackendSuite, AllHitsKeepParity) {
  using S = typename TypeParam::Scalar;
  Shapes<S> shapes;
  shapes.meshes.push_back(rippled_sphere<S>(32, 0.3));
  const TypeParam geometry(shapes);
  Random random(31);
  int odd_outside = 0;
  int even_inside = 0;
  for (int i = 0; i < 20000; ++i) {
    int outside = 0;
    int inside = 0;
    geometry.all_hits({Vec3<S>(3.0 * random.direction()), Vec3<S>(random.direction())},
                      [&](const Hit<S>&) { ++outside; });
    geometry.all_hits({Vec3<S>(0.2 * random.in_cube()), Vec3<S>(random.direction())}, [&](const Hit<S>&) { ++inside; });
    odd_outside += outside % 2;
    even_inside += 1 - inside % 2;
  }
  // A crossing within rounding of an edge may count twice: one ray in 1e5 in float by the width of that band.
  EXPECT_LE(odd_outside, 2);
  EXPECT_LE(even_inside, 2);
}

TYPED_TEST_P(BackendSuite, BatchesEqualSingleRays) {
  using S = typename TypeParam::Scalar;
  Shapes<S> shapes;
  add_analytic_shapes(shapes, 41);
  shapes.meshes.push_back(soup<S>(300, 0.3, 42));
  const TypeParam geometry(shapes);
  for (const std::size_t count :
       {std::size_t{0}, std::size_t{1}, std::size_t{15}, std::size_t{16}, std::size_t{10001}}) {
    const std::vector<Ray<S>> rays = mixed_rays<S>(count, 43);
    std::vector<std::uint8_t> blocked(count, 7);
    geometry.any_hit_batch(rays, blocked);
    std::size_t differ = 0;
    for (std::size_t i = 0; i < count; ++i) differ += blocked[i] == (geometry.any_hit(rays[i]) ? 1 : 0) ? 0 : 1;
    // Embree's packets use another triangle test: a ray within rounding of an edge may differ, about 1 in 1e5.
    EXPECT_LE(differ, sizeof(S) == 4 ? count / 10000 : 0) << count;
  }
}

// Oracle: inside a convex room, a ray from one wall reaches another wall, never its own, and two points on different
// walls see each other, but not through a screen that stands close before the first.
TYPED_TEST_P(BackendSuite, LeavesFlatWalls) {
  using S = typename TypeParam::Scalar;
  for (const Placement& placement : k_placements) {
    Shapes<S> room;
    room.meshes.push_back(cube_mesh<S>());
    Shapes<S> screened = room;
    // 0.1 before the walls, whose half-width is 5: far more than what rounding of 1e4 m in float (1e-3 m) hides.
    screened.meshes.push_back(cube_mesh<S>());
    for (Vec3<S>& p : room.meshes[0].positions) p = place<S>(Vec3<double>(p) * 5.0, placement);
    screened.meshes[0] = room.meshes[0];
    for (Vec3<S>& p : screened.meshes[1].positions) p = place<S>(Vec3<double>(p) * 4.9, placement);
    const TypeParam geometry(room);
    const TypeParam with_screen(screened);
    Random random(51);
    std::size_t wrong = 0, blocked = 0, leaks = 0, pairs = 0;
    std::optional<SurfacePoint<S>> previous;
    for (int i = 0; i < 20000; ++i) {
      const Ray<S> ray{place<S>(4.5 * random.in_cube(), placement), Vec3<S>(random.direction())};
      const auto hit = geometry.closest_hit(ray);
      ASSERT_TRUE(hit.has_value()) << placement.name;
      SurfacePoint<S> point = surface_point(geometry.shapes(), ray, *hit);
      Vec3<double> direction = random.direction();
      // Into the room, every fourth one nearly along the wall.
      const double cosine = glm::dot(direction, Vec3<double>(point.ng));
      direction -= Vec3<double>(point.ng) * (cosine + std::abs(cosine) * (i % 4 == 0 ? 1e-3 : 1.0));
      const auto next = geometry.closest_hit(leaving_ray(point, Vec3<S>(direction)));
      if (!next || next->primitive / 2 == hit->primitive / 2) ++wrong;
      // A point within its error of a second wall may lie behind that one; nothing is demanded there.
      const bool clear = count_near_walls(point, placement) == 1;
      if (clear && previous && glm::dot(previous->ng, point.ng) < S(0.5)) {
        const Ray<S> segment =
            segment_ray(previous->position, previous->error, previous->ng, point.position, point.error, point.ng);
        ++pairs;
        if (geometry.any_hit(segment)) ++blocked;
        if (!with_screen.any_hit(segment) && crosses_cube(*previous, point, placement, 4.85)) ++leaks;
      }
      previous = clear ? std::optional(point) : std::nullopt;
    }
    EXPECT_GT(pairs, 10000u);
    EXPECT_EQ(wrong, 0u) << placement.name;
    EXPECT_EQ(blocked, 0u) << placement.name;
    EXPECT_EQ(leaks, 0u) << placement.name;
  }
}

// Oracle: a ray leaving a sphere outwards never meets it again; inwards it does after 2 r cos(theta). A shadow ray to a
// point outside is free exactly on the near side.
TYPED_TEST_P(BackendSuite, LeavesSpheres) {
  using S = typename TypeParam::Scalar;
  for (const Placement& placement : k_placements) {
    Shapes<S> shapes;
    shapes.spheres.push_back({place<S>(Vec3<double>(0), placement), static_cast<S>(2 * placement.scale)});
    const TypeParam geometry(shapes);
    Random random(61);
    std::size_t again = 0, lost = 0, far = 0, shadow = 0;
    for (int i = 0; i < 20000; ++i) {
      const Vec3<S> origin = place<S>(5.0 * random.direction(), placement);
      const Vec3<S> target = place<S>(1.9 * random.direction(), placement);
      const Ray<S> ray{origin, target - origin};
      const auto hit = geometry.closest_hit(ray);
      ASSERT_TRUE(hit.has_value()) << placement.name;
      const SurfacePoint<S> point = surface_point(geometry.shapes(), ray, *hit);
      Vec3<double> direction = random.direction();
      if (glm::dot(direction, Vec3<double>(point.ng)) < 0) direction = -direction;
      if (geometry.any_hit(leaving_ray(point, Vec3<S>(direction)))) ++again;
      const auto across = geometry.closest_hit(leaving_ray(point, Vec3<S>(-direction)));
      const double chord = 2 * double(shapes.spheres[0].radius) * glm::dot(direction, Vec3<double>(point.ng));
      if (!across) {
        ++lost;
        continue;
      }
      // Grazing: moving the start by e along the normal shortens the chord by up to sqrt(2 r e). Here e is below
      // (1 + sqrt(3)) error: that of the point, and the offset.
      const double e = 3 * double(point.error);
      const double slack = std::sqrt(2 * double(shapes.spheres[0].radius) * e) + e;
      if (std::abs(double(across->t) - chord) > slack) ++far;
      if (geometry.any_hit(segment_ray(point.position, point.error, point.ng, origin))) ++shadow;
    }
    EXPECT_EQ(again, 0u) << placement.name;
    EXPECT_EQ(lost, 0u) << placement.name;
    EXPECT_EQ(far, 0u) << placement.name;
    EXPECT_EQ(shadow, 0u) << placement.name;
  }
}

// Oracle: sphere radii and distances with a known answer, from outside, from inside, far away and huge.
TYPED_TEST_P(BackendSuite, SpheresFarAndHuge) {
  using S = typename TypeParam::Scalar;
  const auto closest = [](S radius, S distance) {
    Shapes<S> shapes;
    shapes.spheres.push_back({Vec3<S>(0, 0, distance), radius});
    return TypeParam(shapes).closest_hit({Vec3<S>(0), {0, 0, 1}});
  };
  const S eps = std::numeric_limits<S>::epsilon();
  for (const auto& [radius, distance] :
       {std::pair{S(1e-3), S(1e4)}, {S(1e4), S(1.0001e4)}, {S(1), S(0)}, {S(1e4), S(1)}}) {
    const auto hit = closest(radius, distance);
    ASSERT_TRUE(hit.has_value()) << radius << " at " << distance;
    const S expected = distance > radius ? distance - radius : distance + radius;
    EXPECT_NEAR(hit->t, expected, 2 * eps * (distance + radius)) << radius << " at " << distance;  // inputs' ulp
  }
  EXPECT_FALSE(closest(S(1), S(-5)).has_value());
}

// A million triangles at one place: any split is as bad as another, and the build must not mind (quadratic work would
// take hours).
TYPED_TEST_P(BackendSuite, MillionCoincidentTriangles) {
  using S = typename TypeParam::Scalar;
  Shapes<S> shapes;
  shapes.meshes.push_back({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {}, {}, {}});
  shapes.meshes[0].triangles.assign(1000000, {0, 1, 2});
  const TypeParam geometry(std::move(shapes));
  EXPECT_TRUE(geometry.closest_hit({{S(0.25), S(0.25), -1}, {0, 0, 1}}).has_value());
  EXPECT_TRUE(geometry.any_hit({{S(0.25), S(0.25), -1}, {0, 0, 1}}));
  EXPECT_FALSE(geometry.any_hit({{S(0.75), S(0.75), -1}, {0, 0, 1}}));
}

TYPED_TEST_P(BackendSuite, BoundsAndShapes) {
  using S = typename TypeParam::Scalar;
  Shapes<S> shapes;
  shapes.meshes.push_back(cube_mesh<S>());
  shapes.spheres.push_back({{3, 0, 0}, S(1)});
  shapes.disks.push_back({{0, 0, 5}, {0, 0, 1}, {1, 0, 0}, S(2)});
  const TypeParam geometry(shapes);
  const Box<S> box = geometry.bounds();
  EXPECT_EQ(geometry.shapes().size(), 3u);
  const S margin = S(0.01);  // a disk's box is up to 1e-3 of its radius too large
  for (const Vec3<S>& p : {Vec3<S>(-2, -2, -1), Vec3<S>(4, 2, 5)}) EXPECT_TRUE(box.contains(p));
  EXPECT_TRUE(Box<S>({Vec3<S>(-2, -2, -1) - margin, Vec3<S>(4, 2, 5) + margin}).contains(box.lo));
  EXPECT_TRUE(Box<S>({Vec3<S>(-2, -2, -1) - margin, Vec3<S>(4, 2, 5) + margin}).contains(box.hi));
}

TYPED_TEST_P(BackendSuite, RejectsBadShapes) {
  using S = typename TypeParam::Scalar;
  Shapes<S> shapes;
  shapes.meshes.push_back({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 3}}, {}, {}});
  EXPECT_THROW(TypeParam{shapes}, GeometryError);
  shapes.meshes[0].triangles.clear();
  EXPECT_THROW(TypeParam{shapes}, GeometryError);
}

REGISTER_TYPED_TEST_SUITE_P(BackendSuite, AgreesWithBruteForce, AgreesWithBruteForceOnMixedShapes,
                            OneTriangleAndNothing, ZeroAreaIsNeverHit, ClosedMeshesHaveNoCracks, AllHitsKeepParity,
                            BatchesEqualSingleRays, LeavesFlatWalls, LeavesSpheres, SpheresFarAndHuge,
                            MillionCoincidentTriangles, BoundsAndShapes, RejectsBadShapes);

}  // namespace manylight::test
