// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "manylight/core/sobol.hpp"
#include "render/options.hpp"

namespace manylight::render {

/// The sampler that the command line chose, as one type: everything is instantiated once instead of once per sampler,
/// for a well-predicted branch per variate.
struct EitherSampler {
  using Scalar = float;
  SamplerKind kind = SamplerKind::sobol;
  std::uint64_t seed = 0;

  class Stream {
   public:
    using Scalar = float;
    Stream(const EitherSampler& sampler, Stage stage, std::uint64_t index, std::uint32_t sample) noexcept
        : kind_(sampler.kind),
          independent_(sampler.seed, stage, index, sample),
          sobol_(sampler.seed, stage, index, sample) {}
    [[nodiscard]] float next() noexcept {
      return kind_ == SamplerKind::sobol ? sobol_.next() : independent_.next();
    }
    [[nodiscard]] Vec2<float> next_2d() noexcept {
      return kind_ == SamplerKind::sobol ? sobol_.next_2d() : independent_.next_2d();
    }

   private:
    SamplerKind kind_;
    IndependentStream<float> independent_;
    SobolStream<float> sobol_;
  };

  /// For an independent image; the first one's is this one.
  [[nodiscard]] EitherSampler pass(std::uint32_t index) const noexcept {
    return {kind, index == 0 ? seed : mix_bits(mix_bits(seed) + index)};
  }
  [[nodiscard]] Stream stream(Stage stage, std::uint64_t index, std::uint32_t sample = 0) const noexcept {
    return {*this, stage, index, sample};
  }
};

static_assert(Sampler<EitherSampler>);

}  // namespace manylight::render
