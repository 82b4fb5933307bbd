// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "manylight/core/vector.hpp"
#include "manylight/geometry/ray.hpp"
#include "manylight/geometry/shapes.hpp"

namespace manylight::test {

/// What a backend computing in S may and must say about one ray and one primitive, found in double by brute force.
struct Verdict {
  std::uint32_t shape;
  std::uint32_t primitive;
  bool may = false;   ///< a hit at t in [lo, hi] is right
  bool must = false;  ///< a miss is wrong
  double lo = 0;
  double hi = 0;
};

/// Rounding in S of coordinates as large as the primitive's distance decides near edges and at grazing angles: there a
/// verdict is "may". 64 ulp: about 20 operations of the triangle tests, each half an ulp, on sums of three terms.
template <class S>
inline constexpr double k_slack = 64 * double(std::numeric_limits<S>::epsilon());

template <class S>
[[nodiscard]] Verdict judge_triangle(const Ray<S>& ray, const std::array<Vec3<S>, 3>& corners) {
  const Vec3<double> o(ray.origin);
  const double length = glm::length(Vec3<double>(ray.direction));
  const Vec3<double> d = Vec3<double>(ray.direction) / length;
  const std::array<Vec3<double>, 3> p{Vec3<double>(corners[0]) - o, Vec3<double>(corners[1]) - o,
                                      Vec3<double>(corners[2]) - o};
  const double size = std::max({glm::length(p[0]), glm::length(p[1]), glm::length(p[2])});
  const Vec3<double> cross = glm::cross(p[1] - p[0], p[2] - p[0]);
  Verdict verdict{};
  if (cross == Vec3<double>(0)) return verdict;
  const double determinant = glm::dot(cross, d);
  const std::array<double, 3> weight{glm::dot(glm::cross(p[1], p[2]), d) / determinant,
                                     glm::dot(glm::cross(p[2], p[0]), d) / determinant,
                                     glm::dot(glm::cross(p[0], p[1]), d) / determinant};
  const double lowest = std::min({weight[0], weight[1], weight[2]});
  const double weight_slack = k_slack<S> * size * size / std::abs(determinant);
  const std::array<double, 3> along{glm::dot(p[0], d), glm::dot(p[1], d), glm::dot(p[2], d)};
  const double t = weight[0] * along[0] + weight[1] * along[1] + weight[2] * along[2];
  if (weight_slack < 0.1) {
    const double extent = std::max({along[0], along[1], along[2]}) - std::min({along[0], along[1], along[2]});
    const double t_slack = k_slack<S> * size + 3 * weight_slack * extent;
    verdict.lo = (t - t_slack) / length;
    verdict.hi = (t + t_slack) / length;
    verdict.may = lowest >= -weight_slack;
    verdict.must = lowest >= weight_slack;
  } else {
    // Edge-on or a sliver: any t along it may come out, if the ray passes at all.
    const double slack = k_slack<S> * size;
    verdict.lo = (std::min({along[0], along[1], along[2]}) - slack) / length;
    verdict.hi = (std::max({along[0], along[1], along[2]}) + slack) / length;
    verdict.may = true;
  }
  verdict.must = verdict.must && verdict.lo >= double(ray.t_min) && verdict.hi <= double(ray.t_max);
  verdict.may = verdict.may && verdict.hi >= double(ray.t_min) && verdict.lo <= double(ray.t_max);
  return verdict;
}

/// Both crossings of a sphere, by the textbook's quadratic in long double.
template <class S>
[[nodiscard]] std::array<Verdict, 2> judge_sphere(const Ray<S>& ray, const Sphere<S>& sphere) {
  using Real = long double;
  const auto dot = [](const std::array<Real, 3>& a, const std::array<Real, 3>& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  };
  const std::array<Real, 3> d{ray.direction.x, ray.direction.y, ray.direction.z};
  const std::array<Real, 3> f{Real(ray.origin.x) - sphere.center.x, Real(ray.origin.y) - sphere.center.y,
                              Real(ray.origin.z) - sphere.center.z};
  const Real a = dot(d, d);
  const Real half_b = dot(f, d);
  const Real discriminant = half_b * half_b - a * (dot(f, f) - Real(sphere.radius) * sphere.radius);
  std::array<Verdict, 2> verdicts{};
  if (discriminant < 0) return verdicts;
  const Real root = std::sqrt(discriminant);
  const Real slack = Real(k_slack<S>) * (std::sqrt(dot(f, f)) + sphere.radius) / std::sqrt(a);
  for (std::size_t i = 0; i < 2; ++i) {
    const Real t = (-half_b + (i == 0 ? -root : root)) / a;
    Verdict& verdict = verdicts[i];
    verdict.lo = static_cast<double>(t - slack);
    verdict.hi = static_cast<double>(t + slack);
    verdict.must = verdict.lo >= double(ray.t_min) && verdict.hi <= double(ray.t_max);
    verdict.may = verdict.hi >= double(ray.t_min) && verdict.lo <= double(ray.t_max);
  }
  return verdicts;
}

template <class S>
[[nodiscard]] Verdict judge_disk(const Ray<S>& ray, const Disk<S>& disk) {
  const Vec3<double> n(disk.normal);
  const Vec3<double> d(ray.direction);
  const Vec3<double> f = Vec3<double>(ray.origin) - Vec3<double>(disk.center);
  const double t = -glm::dot(f, n) / glm::dot(d, n);
  const double distance = glm::length(f + d * t);
  const double slack = k_slack<S> * std::abs(t);
  Verdict verdict{};
  verdict.lo = t - slack;
  verdict.hi = t + slack;
  verdict.may = distance <= double(disk.radius) * (1 + k_slack<S>)&&verdict.hi >= double(ray.t_min) &&
                verdict.lo <= double(ray.t_max);
  verdict.must = distance <= double(disk.radius) * (1 - k_slack<S>)&&verdict.lo >= double(ray.t_min) &&
                 verdict.hi <= double(ray.t_max);
  return verdict;
}

/// Verdicts of all primitives that the ray may hit.
template <class S>
[[nodiscard]] std::vector<Verdict> judge(const Shapes<S>& shapes, const Ray<S>& ray) {
  std::vector<Verdict> verdicts;
  const auto add = [&](Verdict verdict, std::size_t shape, std::size_t primitive) {
    verdict.shape = static_cast<std::uint32_t>(shape);
    verdict.primitive = static_cast<std::uint32_t>(primitive);
    if (verdict.may) verdicts.push_back(verdict);
  };
  for (std::size_t m = 0; m < shapes.meshes.size(); ++m) {
    const TriangleMesh<S>& mesh = shapes.meshes[m];
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const auto& c = mesh.triangles[t];
      add(judge_triangle<S>(ray, {mesh.positions[c[0]], mesh.positions[c[1]], mesh.positions[c[2]]}), m, t);
    }
  }
  std::size_t id = shapes.meshes.size();
  for (const Sphere<S>& sphere : shapes.spheres) {
    for (const Verdict& verdict : judge_sphere(ray, sphere)) add(verdict, id, 0);
    ++id;
  }
  for (const Disk<S>& disk : shapes.disks) add(judge_disk(ray, disk), id++, 0);
  return verdicts;
}

/// Whether some verdict allows this hit.
template <class S>
[[nodiscard]] bool is_allowed(const std::vector<Verdict>& verdicts, const Hit<S>& hit) {
  return std::any_of(verdicts.begin(), verdicts.end(), [&](const Verdict& v) {
    return v.shape == hit.shape && v.primitive == hit.primitive && double(hit.t) >= v.lo && double(hit.t) <= v.hi;
  });
}
/// Nothing that must be hit lies before this hit (or at all, for a miss).
template <class S>
[[nodiscard]] bool is_closest(const std::vector<Verdict>& verdicts, const std::optional<Hit<S>>& hit) {
  return std::none_of(verdicts.begin(), verdicts.end(),
                      [&](const Verdict& v) { return v.must && (!hit || v.hi < double(hit->t)); });
}

}  // namespace manylight::test
