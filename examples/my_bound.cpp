// SPDX-License-Identifier: Apache-2.0
// A user's own bound, closer than the one that follows from eval, and how to try to refute it.
#include <cstdio>

#include "ball_scene.hpp"
#include "lunar_dust.hpp"

/// f cos_i = w cos_i / (4 pi (cos_i + cos_o)) rises with cos_i: its maximum is at the largest one. Derived from eval, f and
/// cos_i are bounded apart, f where cos_i is smallest.
template <>
struct manylight::MaterialBound<LunarDust> {
  template <class Wi, class Wo>
  static float sup_eval(const LunarDust& m, const Wi& wi, const Wo& wo) {
    const Interval<float> ci(wi.z), co(wo.z);  // of a vector a number, of a set a range
    if (!(ci.hi > 0 && co.hi > 0)) return 0;
    return scale(m) / (max0(ci.lo) + max0(co.lo));
  }
  template <class Wi, class Wo>
  static float sup_eval_cos(const LunarDust& m, const Wi& wi, const Wo& wo) {
    const Interval<float> ci(wi.z), co(wo.z);
    if (!(ci.hi > 0 && co.hi > 0)) return 0;
    return scale(m) * ci.hi / (ci.hi + max0(co.lo));
  }
  /// With room for rounding.
  static float scale(const LunarDust& m) { return 1.00001F * max_channel(m.single_albedo) / (4 * k_pi<float>); }
};

/// The same material without the bound.
struct PlainDust : LunarDust {};

int main() {
  const BoundsReport<float> own = falsify_bounds(LunarDust{}, AutomaticBounds{}, 300);
  const BoundsReport<float> derived = falsify_bounds(PlainDust{}, AutomaticBounds{}, 300);
  std::printf("bound of f cos over largest value, mean: own %.3f (%u of %u refuted), derived %.3f\n", own.slack(),
              own.refuted, own.configurations, derived.slack());
  const example::Comparison with_own = example::render_ball(LunarDust{});
  const example::Comparison with_derived = example::render_ball(PlainDust{});
  std::printf("mean cut: own %.1f, derived %.1f\n", with_own.mean_cut, with_derived.mean_cut);
  return own.refuted == 0 && own.slack() < derived.slack() && with_own.mean_cut <= with_derived.mean_cut &&
                 with_own.bound_violations == 0
             ? 0
             : 1;
}
