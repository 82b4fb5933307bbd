// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "manylight/core/sampler.hpp"
#include "manylight/scene/emitters.hpp"
#include "support/z_test.hpp"

namespace manylight::test {

/// Shapes and emitters under construction.
template <std::floating_point S>
struct LightRig {
  Shapes<S> shapes;
  EmitterList<S> list;
  Box<S> bounds{Vec3<S>(-1), Vec3<S>(1)};

  [[nodiscard]] Emitters<S> build() const { return Emitters<S>(list, shapes, bounds); }
  void emit(std::uint32_t shape, const Rgb<S>& radiance, bool two_sided = false) {
    list.areas.push_back({shape, Texture<S>(radiance), two_sided});
  }
};

/// Two triangles; the outer side is along cross(x, y), whole edges `x` and `y`.
template <std::floating_point S>
[[nodiscard]] TriangleMesh<S> rectangle(const Vec3<S>& center, const Vec3<S>& x, const Vec3<S>& y) {
  const Vec3<S> a = center - (x + y) / S(2);
  TriangleMesh<S> mesh;
  mesh.positions = {a, a + x, a + x + y, a + y};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  return mesh;
}

template <std::floating_point S>
[[nodiscard]] Disk<S> disk(const Vec3<S>& center, const Vec3<S>& normal, S radius) {
  return {center, normal, Frame<S>(normal).s, radius};
}

/// Irradiance (first channel) of the unoccluded lights at `p` with unit normal `n`, by next event estimation.
template <std::floating_point S>
[[nodiscard]] RunningMoments irradiance(const Emitters<S>& lights, const Vec3<S>& p, const Vec3<S>& n, int count,
                                        std::uint64_t seed = 1) {
  RunningMoments moments;
  IndependentStream<S> stream(seed, Stage::test, 0, 0);
  for (int i = 0; i < count; ++i) {
    const S select = stream.next();
    const auto sample = lights.sample_direct(p, select, stream.next_2d());
    const S cosine = sample ? glm::dot(sample->wi, n) : S(0);
    moments.add(cosine > S(0) ? static_cast<double>(sample->radiance.x * cosine / sample->pdf) : 0.0);
  }
  return moments;
}

/// Limit of |z| for the deterministic seeds of these tests: a change of seed raises a false alarm with probability
/// 1e-5.
inline constexpr double k_z_limit = 4.42;

/// z-test of a Monte Carlo mean against an exact value; `rounding` is a relative slack for estimators without noise.
inline void expect_mean(const RunningMoments& moments, double exact, double rounding, const char* what) {
  EXPECT_LE(std::abs(moments.mean() - exact), k_z_limit * moments.standard_error() + rounding * std::abs(exact))
      << what << ": " << moments.mean() << " +- " << moments.standard_error() << ", exact " << exact;
  EXPECT_LE(moments.standard_error(), 0.01 * std::abs(exact)) << what << ": too noisy to mean anything";
}

}  // namespace manylight::test
