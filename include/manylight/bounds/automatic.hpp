// SPDX-License-Identifier: Apache-2.0
#pragma once

// Upper bounds that the compiler derives from a material's `eval`, a template over its directions [theory 6.6].

#include "manylight/core/direction_set.hpp"
#include "manylight/core/rgb_interval.hpp"
#include "manylight/scattering/concepts.hpp"

namespace manylight {

/// Upper bound over `wi` of the BSDF's largest channel, sr^-1; may be infinite.
template <SetEvaluable M, LocalDirection<typename M::Scalar> Wo>
[[nodiscard]] inline typename M::Scalar sup_eval(const M& m, const DirectionSet<typename M::Scalar>& wi,
                                                 const Wo& wo) noexcept {
  return max_channel(m.eval(wi, wo)).hi;
}

/// The same of the BSDF times |wi.z|.
template <SetEvaluable M, LocalDirection<typename M::Scalar> Wo>
[[nodiscard]] inline typename M::Scalar sup_eval_cos(const M& m, const DirectionSet<typename M::Scalar>& wi,
                                                     const Wo& wo) noexcept {
  return (max_channel(m.eval(wi, wo)) * abs(wi.z)).hi;
}

}  // namespace manylight
