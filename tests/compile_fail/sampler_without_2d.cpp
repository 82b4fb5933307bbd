// SPDX-License-Identifier: Apache-2.0
// expect: SampleStream
#include "manylight/core/sampler.hpp"

struct Constant {
  using Scalar = float;
  float next() { return 0.5F; }
#ifdef MANYLIGHT_CORRECT
  manylight::Vec2<float> next_2d() { return manylight::Vec2<float>(0.5F); }
#endif
};
struct Constants {
  Constant stream(manylight::Stage, std::uint64_t, std::uint32_t) const { return {}; }
};

void render(const manylight::Sampler auto&) {}

int main() { render(Constants{}); }
