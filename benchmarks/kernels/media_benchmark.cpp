// SPDX-License-Identifier: Apache-2.0
// Tracking through a smoke-like grid of 128^3 samples on one core: rays and steps (candidate collisions) per second,
// for majorants of blocks of 4, 8 and 16 cells and of the whole grid. Rays join random points of two spheres around the
// grid's box and cross its middle part. The argument is cells per block; 128: a single block.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "manylight/core/sampler.hpp"
#include "manylight/core/warp.hpp"
#include "manylight/media/heterogeneous.hpp"

namespace {

using namespace manylight;

constexpr std::uint32_t k_side = 128;
constexpr std::size_t k_rays = 4096;

struct Phase {
  using Scalar = float;
};
using Smoke = Heterogeneous<Phase>;

/// Value noise on an integer lattice, smooth, [0, 1].
float value_noise(const Vec3<float>& p) {
  const Vec3<float> below = glm::floor(p);
  const Vec3<float> f = (p - below) * (p - below) * (3.0F - 2.0F * (p - below));
  float sum = 0;
  for (unsigned k = 0; k < 8; ++k) {
    const Vec3<float> corner = below + Vec3<float>(k & 1U, (k >> 1U) & 1U, k >> 2U);
    const auto id = static_cast<std::uint64_t>(corner.x + 1000 * corner.y + 1'000'000 * corner.z);
    const Vec3<float> w(k & 1U ? f.x : 1 - f.x, (k >> 1U) & 1U ? f.y : 1 - f.y, k >> 2U ? f.z : 1 - f.z);
    sum += to_unit_interval<float>(static_cast<std::uint32_t>(mix_bits(id))) * w.x * w.y * w.z;
  }
  return sum;
}

/// A plume that widens upwards, torn by five octaves of noise; about four fifths of the box are empty.
GridVolume<float> smoke() {
  LargeVector<float> values;
  values.reserve(std::size_t{k_side} * k_side * k_side);
  for (std::uint32_t z = 0; z < k_side; ++z) {
    for (std::uint32_t y = 0; y < k_side; ++y) {
      for (std::uint32_t x = 0; x < k_side; ++x) {
        const Vec3<float> p = Vec3<float>(x, y, z) / static_cast<float>(k_side - 1);
        float noise = 0;
        for (int octave = 0; octave < 5; ++octave) {
          const float f = std::ldexp(4.0F, octave);
          noise += std::ldexp(value_noise(p * f + 7.0F), -octave - 1);
        }
        const float radius = glm::length(Vec2<float>(p.x - 0.5F, p.y - 0.5F)) / (0.15F + 0.25F * p.z);
        const float body = std::clamp(1.3F * noise + 0.4F - radius, 0.0F, 1.0F);
        values.push_back(body * body);
      }
    }
  }
  return GridVolume<float>({k_side, k_side, k_side}, std::move(values));
}

const GridVolume<float>& grid() {
  static const GridVolume<float> k_grid = smoke();
  return k_grid;
}

std::vector<Ray<float>> rays() {
  std::vector<Ray<float>> result;
  IndependentStream<float> stream(1, Stage::test, 0, 0);
  while (result.size() < k_rays) {
    const Vec3<float> a = Vec3<float>(0.5F) + 2.0F * warp::square_to_sphere(stream.next_2d());
    const Vec3<float> b = Vec3<float>(0.5F) + 0.4F * warp::square_to_sphere(stream.next_2d());
    result.push_back({a, glm::normalize(b - a)});
  }
  return result;
}

/// Counts variates.
struct CountingStream {
  using Scalar = float;
  IndependentStream<float> stream;
  std::int64_t used = 0;
  float next() noexcept {
    ++used;
    return stream.next();
  }
  Vec2<float> next_2d() noexcept {
    const float x = next();
    return {x, next()};
  }
};

Smoke medium_of(const benchmark::State& state) {
  return Smoke(grid(), static_cast<float>(state.range(1)), Rgb<float>(0.9F), {},
               static_cast<std::uint32_t>(state.range(0)));
}

template <class Track>
void run(benchmark::State& state, double variates_per_step, const Track& track) {
  const Smoke medium = medium_of(state);
  const std::vector<Ray<float>> all = rays();
  // A pass that counts, outside of the timed ones; the stream of a ray is the same in both.
  std::int64_t variates = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    CountingStream stream{{2, Stage::test, i, 0}};
    track(medium, all[i], stream);
    variates += stream.used;
  }
  for (auto _ : state) {
    for (std::size_t i = 0; i < all.size(); ++i) {
      IndependentStream<float> stream(2, Stage::test, i, 0);
      track(medium, all[i], stream);
    }
  }
  const auto iterations = static_cast<double>(state.iterations());
  const double count = static_cast<double>(k_rays);
  state.counters["rays/s"] = benchmark::Counter(count * iterations, benchmark::Counter::kIsRate);
  if (variates_per_step > 0) {
    const double steps = static_cast<double>(variates) / variates_per_step;
    state.counters["steps/ray"] = steps / count;
    state.counters["steps/s"] = benchmark::Counter(steps * iterations, benchmark::Counter::kIsRate);
  }
}

/// Two variates per candidate; the one too many of a ray that gets through is not told apart.
void delta_tracking(benchmark::State& state) {
  run(state, 2, [](const Smoke& medium, const Ray<float>& ray, auto& stream) {
    benchmark::DoNotOptimize(medium.sample(ray, k_infinity<float>, stream));
  });
}

void ratio_tracking(benchmark::State& state) {
  run(state, 0, [](const Smoke& medium, const Ray<float>& ray, auto& stream) {
    benchmark::DoNotOptimize(medium.transmittance(ray, k_infinity<float>, stream));
  });
}

// The second argument: extinction at density 1, m^-1, of a box of 1 m.
BENCHMARK(delta_tracking)->ArgsProduct({{4, 8, 16, 128}, {5, 50, 500}});
BENCHMARK(ratio_tracking)->ArgsProduct({{4, 8, 16, 128}, {5, 50, 500}});

}  // namespace

BENCHMARK_MAIN();
