// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "manylight/core/sampler.hpp"

namespace manylight {

namespace sobol {

[[nodiscard]] constexpr std::uint32_t reverse_bits(std::uint32_t x) noexcept {
  x = (x >> 16) | (x << 16);
  x = ((x & 0xFF00FF00u) >> 8) | ((x & 0x00FF00FFu) << 8);
  x = ((x & 0xF0F0F0F0u) >> 4) | ((x & 0x0F0F0F0Fu) << 4);
  x = ((x & 0xCCCCCCCCu) >> 2) | ((x & 0x33333333u) << 2);
  return ((x & 0xAAAAAAAAu) >> 1) | ((x & 0x55555555u) << 1);
}

/// Dimension 1 of the Sobol sequence with its bits reversed (dimension 0 so reversed is the index itself). The
/// direction numbers v_0 = 2^31, v_{j+1} = v_j ^ (v_j >> 1) are the columns of Pascal's triangle modulo 2: output bit i
/// is the sum of the index bits j whose binary digits include those of i, which five butterfly steps add up.
[[nodiscard]] constexpr std::uint32_t reversed_second_dimension(std::uint32_t x) noexcept {
  x ^= (x & 0xAAAAAAAAu) >> 1;
  x ^= (x & 0xCCCCCCCCu) >> 2;
  x ^= (x & 0xF0F0F0F0u) >> 4;
  x ^= (x & 0xFF00FF00u) >> 8;
  return x ^ ((x & 0xFFFF0000u) >> 16);
}

/// Hash in which each bit depends on the bits below it only: between two bit reversals it is a nested uniform (Owen)
/// scramble. [Laine and Karras 2011; constants of Burley 2020, "Practical Hash-based Owen Scrambling"]
[[nodiscard]] constexpr std::uint32_t hash_upwards(std::uint32_t x, std::uint32_t seed) noexcept {
  x += seed;
  x ^= x * 0x6C50B47Cu;
  x ^= x * 0xB82F1E52u;
  x ^= x * 0xC7AFE638u;
  return x ^ (x * 0x8D22F6E6u);
}

/// Nested uniform scramble of 32 bits: permutes every aligned block of 2^m values among themselves, for all m.
[[nodiscard]] constexpr std::uint32_t scramble(std::uint32_t x, std::uint32_t seed) noexcept {
  return reverse_bits(hash_upwards(reverse_bits(x), seed));
}

}  // namespace sobol

/// Variates from padded two-dimensional Owen-scrambled Sobol sets: each `next_2d()` (and each `next()`) of a stream
/// uses its own scramble and its own shuffle of the sample order, keyed by (seed, stage, index, dimension). For a fixed
/// index and dimension, the first 2^m values of `sample` form a (0, m, 2)-net; different indices and dimensions are
/// independent. Error bars come from different seeds, not from the samples of one.
template <std::floating_point S>
class SobolStream {
 public:
  using Scalar = S;
  SobolStream(std::uint64_t seed, Stage stage, std::uint64_t index, std::uint32_t sample) noexcept
      : key_(mix_bits(mix_bits(mix_bits(seed) ^ static_cast<std::uint64_t>(stage)) ^ index)), sample_(sample) {}

  [[nodiscard]] S next() noexcept {
    const Set set = next_set();
    return to_unit_interval<S>(sobol::reverse_bits(sobol::hash_upwards(set.index, set.seed_x)));
  }
  [[nodiscard]] Vec2<S> next_2d() noexcept {
    const Set set = next_set();
    const std::uint32_t x = sobol::hash_upwards(set.index, set.seed_x);
    const std::uint32_t y = sobol::hash_upwards(sobol::reversed_second_dimension(set.index), set.seed_y);
    return {to_unit_interval<S>(sobol::reverse_bits(x)), to_unit_interval<S>(sobol::reverse_bits(y))};
  }

 private:
  struct Set {
    std::uint32_t index, seed_x, seed_y;
  };
  [[nodiscard]] Set next_set() noexcept {
    const std::uint64_t seeds = mix_bits(key_ + dimension_);
    const std::uint64_t order = mix_bits(seeds);
    ++dimension_;
    return {sobol::scramble(sample_, static_cast<std::uint32_t>(order)), static_cast<std::uint32_t>(seeds),
            static_cast<std::uint32_t>(seeds >> 32)};
  }

  std::uint64_t key_;
  std::uint32_t sample_;
  std::uint32_t dimension_ = 0;
};

/// Hands out SobolStreams; a model of Sampler.
template <std::floating_point S>
struct SobolSampler {
  using Scalar = S;
  std::uint64_t seed = 0;
  [[nodiscard]] SobolStream<S> stream(Stage stage, std::uint64_t index, std::uint32_t sample = 0) const noexcept {
    return {seed, stage, index, sample};
  }
};

static_assert(Sampler<SobolSampler<float>> && Sampler<SobolSampler<double>>);

}  // namespace manylight
