// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <concepts>
#include <cstdint>

#include "manylight/core/vector.hpp"

namespace manylight {

/// What a stream of random numbers is for; part of its key, so that no two uses share numbers.
enum class Stage : std::uint32_t {
  eye, light, emission, pilot, roulette, representative, test, ledger, transmittance, instant
};

/// One block of Philox4x32-10: a counter-based generator, a pure function of counter and key.
/// [Salmon et al. 2011, "Parallel Random Numbers: As Easy as 1, 2, 3"]
[[nodiscard]] constexpr std::array<std::uint32_t, 4> philox4x32(std::array<std::uint32_t, 4> counter,
                                                                std::array<std::uint32_t, 2> key) noexcept {
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t p0 = std::uint64_t{0xD2511F53u} * counter[0];
    const std::uint64_t p1 = std::uint64_t{0xCD9E8D57u} * counter[2];
    counter = {static_cast<std::uint32_t>(p1 >> 32) ^ counter[1] ^ key[0], static_cast<std::uint32_t>(p1),
               static_cast<std::uint32_t>(p0 >> 32) ^ counter[3] ^ key[1], static_cast<std::uint32_t>(p0)};
    key[0] += 0x9E3779B9u;
    key[1] += 0xBB67AE85u;
  }
  return counter;
}

/// Mixes 64 bits (SplitMix64's finaliser); for hashing ids into slots and keys.
[[nodiscard]] constexpr std::uint64_t mix_bits(std::uint64_t x) noexcept {
  x += 0x9E3779B97F4A7C15u;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
  return x ^ (x >> 31);
}

/// [0, 1) from 32 random bits; float keeps 24 of them, so that 1 is never reached by rounding.
template <std::floating_point S>
[[nodiscard]] constexpr S to_unit_interval(std::uint32_t bits) noexcept {
  if constexpr (sizeof(S) <= 4) {
    return static_cast<S>(bits >> 8) * S(0x1p-24);
  } else {
    return static_cast<S>(bits) * S(0x1p-32);
  }
}

/// A stream of variates in [0, 1): each call takes the next dimension of one (stage, index, sample).
template <class T>
concept SampleStream = requires(T& stream) {
  typename T::Scalar;
  { stream.next() } -> std::same_as<typename T::Scalar>;
  { stream.next_2d() } -> std::same_as<Vec2<typename T::Scalar>>;
};

/// A seed for another stream, of two variates.
template <SampleStream Stream>
[[nodiscard]] inline std::uint64_t random_bits(Stream& stream) noexcept {
  const auto high = static_cast<std::uint64_t>(stream.next() * typename Stream::Scalar(0x1p24));
  return (high << 24) | static_cast<std::uint64_t>(stream.next() * typename Stream::Scalar(0x1p24));
}

/// Hands out streams; every variate is a function of (seed, stage, index, sample, dimension) alone. What shall fill a
/// domain together has one `index` and differs in `sample`: the samples of a pixel, the light paths of an image, of a pass
/// or of an instant; those of bidirectional path tracing belong to their pixel. A sampler may stratify over `sample`, from
/// 0 up to millions; different indices must be independent.
template <class T>
concept Sampler = requires(const T& sampler, Stage stage, std::uint64_t index, std::uint32_t sample) {
  { sampler.stream(stage, index, sample) } -> SampleStream;
};

/// Independent variates by Philox.
template <std::floating_point S>
class IndependentStream {
 public:
  using Scalar = S;
  IndependentStream(std::uint64_t seed, Stage stage, std::uint64_t index, std::uint32_t sample) noexcept
      : counter_{0, sample, static_cast<std::uint32_t>(index), static_cast<std::uint32_t>(index >> 32)},
        key_{static_cast<std::uint32_t>(seed),
             static_cast<std::uint32_t>(seed >> 32) ^ (static_cast<std::uint32_t>(stage) * 0x85EBCA6Bu)} {}

  [[nodiscard]] S next() noexcept {
    if (used_ == 4) {
      block_ = philox4x32(counter_, key_);
      ++counter_[0];
      used_ = 0;
    }
    return to_unit_interval<S>(block_[used_++]);
  }
  [[nodiscard]] Vec2<S> next_2d() noexcept {
    const S x = next();
    return {x, next()};
  }

 private:
  std::array<std::uint32_t, 4> counter_;
  std::array<std::uint32_t, 2> key_;
  std::array<std::uint32_t, 4> block_{};
  unsigned used_ = 4;
};

template <std::floating_point S>
struct IndependentSampler {
  using Scalar = S;
  std::uint64_t seed = 0;
  [[nodiscard]] IndependentStream<S> stream(Stage stage, std::uint64_t index, std::uint32_t sample = 0) const noexcept {
    return {seed, stage, index, sample};
  }
};

static_assert(Sampler<IndependentSampler<float>> && Sampler<IndependentSampler<double>>);

}  // namespace manylight
