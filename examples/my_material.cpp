// SPDX-License-Identifier: Apache-2.0
// A user's own Material (lunar_dust.hpp): lunar dust after Lommel and Seeliger, brighter towards the rim than a Lambertian
// ball. Nothing but eval, sample, pdf, albedo and is_delta is written; what the cuts need to know follows from eval.
#include <cmath>
#include <cstdio>

#include "ball_scene.hpp"
#include "lunar_dust.hpp"

static_assert(SetEvaluable<LunarDust>);

int main() {
  const example::Comparison mean = example::render_ball(LunarDust{});
  std::printf("mean radiance: bidirectional lightcuts %.4f (mean cut %.0f), path tracing %.4f\n", mean.by_cuts,
              mean.mean_cut, mean.by_paths);
  // 0.3 % is the standard error of 256 path samples in 1024 pixels, and 5,000 VPLs and the cuts leave about as much.
  return std::abs(mean.by_cuts / mean.by_paths - 1) < 0.01 && mean.bound_violations == 0 ? 0 : 1;
}
