// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "manylight/core/sampler.hpp"
#include "manylight/media/concepts.hpp"
#include "manylight/media/grid_volume.hpp"
#include "support/z_test.hpp"

namespace manylight::test {

/// The least that a medium asks of a phase function, and its value for airlight.
template <std::floating_point S>
struct PlainPhase {
  using Scalar = S;
  S id = S(0);  ///< tells phases apart
  [[nodiscard]] S eval(const Vec3<S>& /*sampled*/, const Vec3<S>& /*known*/) const noexcept {
    return k_inv_pi<S> / S(4);
  }
};

/// Thin cylinders: projected area |sin| of the angle to the axis.
template <std::floating_point S>
struct CylinderPhase {
  using Scalar = S;
  Vec3<S> axis{0, 0, 1};
  [[nodiscard]] S projected_area(const Vec3<S>& w) const noexcept { return glm::length(glm::cross(axis, w)); }
};
template <std::floating_point S>
struct Cylinders {
  [[nodiscard]] S max_projected_area() const noexcept { return S(1); }
  [[nodiscard]] CylinderPhase<S> operator()(const Vec3<S>& axis) const noexcept { return {axis}; }
};

/// A grid of values of a function of the sample's indices.
template <std::floating_point S, class T = S, class Function>
GridVolume<S, T> make_grid(const std::array<std::uint32_t, 3>& size, const Function& value,
                           const GridPlacement<S>& placement = {}) {
  LargeVector<T> values;
  values.reserve(std::size_t{size[0]} * size[1] * size[2]);
  for (std::uint32_t z = 0; z < size[2]; ++z) {
    for (std::uint32_t y = 0; y < size[1]; ++y) {
      for (std::uint32_t x = 0; x < size[0]; ++x) values.push_back(static_cast<T>(value(x, y, z)));
    }
  }
  return GridVolume<S, T>(size, std::move(values), placement);
}

/// Noise of hard edges: half of the samples are 0.
inline double rough_noise(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  const std::uint64_t bits = mix_bits(x + 1000ULL * y + 1000000ULL * z);
  return (bits & 1U) != 0 ? 0.0 : static_cast<double>(bits >> 40U) * 0x1p-24;
}

template <std::floating_point S>
GridPlacement<S> in_box(const Vec3<S>& lo, const Vec3<S>& hi) {
  GridPlacement<S> placement;
  placement.box = {lo, hi};
  return placement;
}

/// Optical thickness by the midpoint rule.
template <class M>
double midpoint_thickness(const M& medium, const Ray<typename M::Scalar>& ray, double t_max, int steps = 20000) {
  using S = typename M::Scalar;
  double sum = 0;
  for (int i = 0; i < steps; ++i) {
    const auto t = static_cast<S>((i + 0.5) / steps * t_max);
    sum += static_cast<double>(medium.sigma_t(ray.origin + ray.direction * t, ray.direction).x);
  }
  return sum * t_max / steps;
}

/// What tests ask of free flights: moments per channel over many draws.
struct FlightMoments {
  std::array<RunningMoments, 3> all;      ///< weight * sigma_t at a collision, weight of those that got through: mean 1
  std::array<RunningMoments, 3> through;  ///< weight of those that got through, else 0: mean is the transmittance
  double largest = 0;                     ///< weight * sigma_t
};
template <class M>
FlightMoments fly(const M& medium, const Ray<typename M::Scalar>& ray, typename M::Scalar t_max, int count,
                  std::uint64_t seed) {
  using S = typename M::Scalar;
  FlightMoments m;
  IndependentStream<S> stream(seed, Stage::test, 0, 0);
  for (int i = 0; i < count; ++i) {
    const MediumSample<S> s = medium.sample(ray, t_max, stream);
    const Rgb<S> sigma = medium.sigma_t(ray.origin + ray.direction * s.t, ray.direction);
    for (int c = 0; c < 3; ++c) {
      const auto k = static_cast<std::size_t>(c);
      const double weight = static_cast<double>(s.weight[c]);
      const double value = s.scattered ? weight * static_cast<double>(sigma[c]) : weight;
      m.all[k].add(value);
      m.through[k].add(s.scattered ? 0.0 : weight);
      m.largest = std::max(m.largest, value);
    }
  }
  return m;
}
template <class M>
RunningMoments transmit(const M& medium, const Ray<typename M::Scalar>& ray, typename M::Scalar t_max, int count,
                        std::uint64_t seed) {
  IndependentStream<typename M::Scalar> stream(seed, Stage::test, 1, 0);
  RunningMoments m;
  for (int i = 0; i < count; ++i) {
    const auto value = medium.transmittance(ray, t_max, stream);
    EXPECT_TRUE(value.x >= 0 && value.x <= 1) << value.x;
    m.add(static_cast<double>(value.x));
  }
  return m;
}

/// Two-sided z-test of a mean; `slack` is the oracle's own error. The level is per test: 1e-6, so that all of the some
/// hundred of a file raise a false alarm with probability 1e-4.
inline void expect_mean(const RunningMoments& m, double oracle, const std::string& what, double slack = 0) {
  const double limit = normal_limit(1e-6) * m.standard_error() + slack + 1e-12;  // 1e-12: means of equal values
  EXPECT_NEAR(m.mean(), oracle, limit) << what << ", standard error " << m.standard_error();
}

/// Hands out what it is told, over and over.
template <std::floating_point S>
struct FixedStream {
  using Scalar = S;
  std::vector<S> values;
  std::size_t at = 0;
  S next() { return values[at++ % values.size()]; }
  Vec2<S> next_2d() {
    const S x = next();
    return {x, next()};
  }
};

}  // namespace manylight::test
