// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "manylight/core/sampler.hpp"
#include "manylight/path/bidirectional_weights.hpp"

// The recursive weights against their definition on paths whose densities are random numbers.

namespace manylight::test::bidirectional_weights_test {
namespace {

using S = double;

/// A path z_0 ... z_n: of each segment its squared length and the cosines at both ends, of each vertex the densities of going
/// on, per solid angle.
struct RandomPath {
  std::size_t n;
  bool is_infinite, is_delta_light;
  S light_paths;
  std::vector<S> squared_length;          ///< [i]: z_i to z_{i+1}
  std::vector<S> cosine_out, cosine_back;  ///< [i]: at z_i towards z_{i+1}, towards z_{i-1}
  std::vector<S> forward, reverse;        ///< [i]: at z_i towards z_{i+1}, towards z_{i-1}; Dirac vertices 1
  std::vector<bool> is_dirac;
  std::vector<bool> is_below;             ///< [i]: z_i to z_{i+1} through an object, drawn per area
  S position_pdf, direct_pdf;             ///< f_0 and p_dir per area at z_0; at infinity the same per solid angle

  [[nodiscard]] S geometry(std::size_t from, std::size_t to) const {  // of a density per solid angle
    if (is_below[std::min(from, to)]) return 1;
    const S cosine = to > from ? cosine_back[to] : cosine_out[to];
    return is_infinite && from == 0 ? cosine : is_infinite && to == 0 ? S(1) : cosine / squared_length[std::min(from, to)];
  }
  [[nodiscard]] S f(std::size_t i) const { return i == 0 ? position_pdf : forward[i - 1] * geometry(i - 1, i); }
  [[nodiscard]] S b(std::size_t i) const { return reverse[i + 1] * geometry(i + 1, i); }
  [[nodiscard]] bool is_allowed(std::size_t s) const {
    if (s == 0) return !is_delta_light;
    if (s == 1) return !is_dirac[1];
    return !is_dirac[s - 1] && (s == n ? light_paths > 0 : !is_dirac[s]);
  }
  /// Expected number of times that strategy s makes the path.
  [[nodiscard]] S density(std::size_t s) const {
    if (!is_allowed(s)) return 0;
    S p = s == n ? light_paths : 1;
    for (std::size_t i = 0; i < s; ++i) p *= s == 1 ? direct_pdf : f(i);
    for (std::size_t i = s; i < n; ++i) p *= b(i);
    return p;
  }
};

RandomPath random_path(std::uint64_t index) {
  auto stream = IndependentSampler<S>{17}.stream(Stage::test, index);
  const auto positive = [&] { return std::exp(4 * stream.next() - 2); };
  RandomPath path;
  path.n = 2 + static_cast<std::size_t>(stream.next() * 7);
  path.is_infinite = stream.next() < 0.4;
  path.is_delta_light = stream.next() < 0.4;
  path.light_paths = stream.next() < 0.3 ? 0 : 1000;
  for (std::size_t i = 0; i <= path.n; ++i) {
    const bool is_dirac = i > 0 && i < path.n && stream.next() < 0.3;
    path.is_dirac.push_back(is_dirac);
    path.squared_length.push_back(positive());
    const bool is_end = i == 0 && (path.is_infinite || path.is_delta_light);  // no surface, no cosine
    path.cosine_out.push_back(is_end ? 1 : 0.01 + stream.next());
    path.cosine_back.push_back(0.01 + stream.next());
    path.forward.push_back(is_dirac ? 1 : positive());
    path.reverse.push_back(is_dirac ? 1 : positive());
  }
  path.is_below.assign(path.n, false);
  for (std::size_t i = 1; i + 1 < path.n; ++i) {
    path.is_below[i] = !path.is_dirac[i] && !path.is_dirac[i + 1] && !path.is_below[i - 1] && stream.next() < 0.3;
  }
  path.position_pdf = positive();
  path.direct_pdf = path.is_delta_light ? path.position_pdf : positive();  // the selection alone
  return path;
}

/// Per solid angle at z_1, as in `of_emission`.
S direct_pdf(const RandomPath& path) {
  return path.is_infinite ? path.direct_pdf : path.direct_pdf * path.squared_length[0] / path.cosine_out[0];
}
S projected_pdf(const RandomPath& path) {
  return path.position_pdf * path.forward[0] / path.cosine_out[0];
}

/// At z_i, on arrival; i >= 1.
PartialWeights<S> light_walk(const RandomPath& path, std::size_t to) {
  auto weights = PartialWeights<S>::of_emission(direct_pdf(path), projected_pdf(path), path.cosine_back[1],
                                                path.is_delta_light);
  for (std::size_t i = 1; i < to; ++i) {
    if (path.is_below[i]) {
      weights.pass_below(path.forward[i], path.reverse[i]);
      continue;
    }
    if (path.is_dirac[i]) weights.leave_by_dirac(path.cosine_out[i]);
    else weights.leave(path.cosine_out[i], path.forward[i], path.reverse[i]);
    weights.arrive(path.squared_length[i], path.cosine_back[i + 1]);
  }
  return weights;
}
/// On the segment from z_{i+1} to z_i; i < n.
PartialWeights<S> eye_walk(const RandomPath& path, std::size_t to) {
  auto weights = PartialWeights<S>::of_lens(path.light_paths, path.reverse[path.n]);
  for (std::size_t i = path.n - 1; i > to; --i) {
    if (!path.is_below[i]) weights.arrive(path.squared_length[i], path.cosine_out[i]);
    if (path.is_below[i - 1]) weights.pass_below(path.reverse[i], path.forward[i]);
    else if (path.is_dirac[i]) weights.leave_by_dirac(path.cosine_back[i]);
    else weights.leave(path.cosine_back[i], path.reverse[i], path.forward[i]);
  }
  return weights;
}
S eye_sum(const RandomPath& path, std::size_t i) {
  auto weights = eye_walk(path, i);
  if (!path.is_below[i]) weights.arrive(path.squared_length[i], path.cosine_out[i]);
  return weights.sum(path.forward[i]);
}

S weight(const RandomPath& path, std::size_t s) {
  if (s == 0) return weight_of_hit(eye_walk(path, 0), direct_pdf(path), projected_pdf(path));
  if (s == 1) {
    return weight_of_direct(path.is_delta_light ? 0 : path.reverse[1], direct_pdf(path), projected_pdf(path),
                            path.cosine_back[1], eye_sum(path, 1));
  }
  const S light_sum = light_walk(path, s - 1).sum(path.reverse[s - 1]);
  if (s == path.n) return weight_of_lens(path.b(s - 1), path.light_paths, light_sum);
  return weight_of_connection(path.b(s - 1), light_sum, path.f(s), eye_sum(path, s));
}

/// Lights at infinity and nearby, with and without a surface; Dirac vertices and segments through objects anywhere; with
/// and without lens. Rounding of some 50 operations: 1e-13. Caught: vcm kept at a Dirac vertex; no cosine in `leave`; no
/// cosine in s = 1; vc of a point light; the segment through an object left out.
TEST(BidirectionalWeights, AreTheSharesOfTheDensitiesAndSumToOne) {
  std::size_t strategies = 0;
  for (std::uint64_t index = 0; index < 20000; ++index) {
    const RandomPath path = random_path(index);
    S total = 0;
    for (std::size_t s = 0; s <= path.n; ++s) total += path.density(s);
    if (!(total > 0)) continue;  // no strategy makes it
    S sum = 0;
    for (std::size_t s = 0; s <= path.n; ++s) {
      if (!path.is_allowed(s)) continue;
      const S w = weight(path, s);
      EXPECT_NEAR(w, path.density(s) / total, 1e-13) << "path " << index << ", s = " << s << " of " << path.n;
      sum += w;
      ++strategies;
    }
    ASSERT_NEAR(sum, 1, 1e-12) << "path " << index;
  }
  EXPECT_GT(strategies, 50000U);
}

/// Whatever rounding does to the sums, a weight is a number from 0 to 1.
TEST(BidirectionalWeights, AreNumbersWhateverTheSums) {
  const float infinity = k_infinity<float>;
  EXPECT_EQ(weight_of_connection(infinity, 0.0F, 1.0F, 1.0F), 0);
  EXPECT_EQ(weight_of_connection(infinity, 1.0F, 1.0F, 1.0F), 0);
  EXPECT_EQ(weight_of_connection(0.0F, 0.0F, 0.0F, 1.0F), 1);
  EXPECT_EQ(weight_of_direct(0.0F, 0.0F, 0.0F, 1.0F, 1.0F), 0);
}

}  // namespace
}  // namespace manylight::test::bidirectional_weights_test
