// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>

#include "manylight/core/sampler.hpp"
#include "manylight/core/spectrum.hpp"
#include "manylight/geometry/ray.hpp"

namespace manylight {

/// A free flight that was drawn along a ray of unit direction.
template <std::floating_point S>
struct MediumSample {
  S t = S(0);              ///< m from the ray's origin; of a flight that got through, its end
  Rgb<S> weight{S(1)};     ///< scattered: transmittance / density per metre, m; else transmittance / probability, 1
  bool scattered = false;  ///< whether it ends at a collision
};

/// What a medium scatters by. Media only hand it out.
template <class P, class S>
concept MediumPhase = std::copyable<P> && std::same_as<typename P::Scalar, S>;

/// Participating medium: what fills space between surfaces, world frame, metres. Contract:
///  - `sigma_t(x, w)`, `sigma_s(x, w)`: extinction and scattering coefficients per channel, m^-1, for light along the
///    unit direction `w`, which points away from `x` and matters to anisotropic media only; w and -w are alike, for
///    else transmittance would not be reciprocal. 0 <= sigma_s <= sigma_t, finite;
///  - `phase(x)`: the phase function at `x`. Where sigma_s is 0 it is any one;
///  - `sample(ray, t_max, stream)`: draws a free flight from the ray's origin along its unit direction up to `t_max` >
///  0
///    (m, may be infinite); the ray's own t_min and t_max are for surfaces and are ignored. With the path weight
///    A <- A * weight, times sigma_s at a collision, every channel is unbiased; weight * sigma_s is finite;
///  - `transmittance(ray, t_max, stream)`: an unbiased estimate per channel, in [0, 1], of exp(-int sigma_t) over the
///    same segment; closed form where `k_closed_form`;
///  - `mean_transmittance(ray, t_max)`: a deterministic stand-in for it in [0, 1], for weights and densities. A random
///    transmittance must never enter a weight: the weights of all ways to make one path would no longer sum to one,
///    as each would see another value. The true transmittance if `k_closed_form`, else it may be 1;
///  - `min_sigma_t()`: at most every channel of sigma_t along any part of any segment, m^-1; exp(-min_sigma_t() d)
///  bounds
///    the transmittance over a distance of at least d.
/// Media are cheap to copy (grids are shared); all members are const, noexcept, thread-safe, and never give NaN,
/// whatever the ray.
template <class M>
concept Medium = std::copyable<M> && MediumPhase<typename M::Phase, typename M::Scalar> &&
    requires(const M& m, const Vec3<typename M::Scalar>& x, const Ray<typename M::Scalar>& ray,
             typename M::Scalar t_max, IndependentStream<typename M::Scalar>& stream) {
  { m.sigma_t(x, x) } -> std::same_as<Rgb<typename M::Scalar>>;
  { m.sigma_s(x, x) } -> std::same_as<Rgb<typename M::Scalar>>;
  { m.phase(x) } -> std::same_as<typename M::Phase>;
  { m.sample(ray, t_max, stream) } -> std::same_as<MediumSample<typename M::Scalar>>;
  { m.transmittance(ray, t_max, stream) } -> std::same_as<Rgb<typename M::Scalar>>;
  { m.mean_transmittance(ray, t_max) } -> std::same_as<Rgb<typename M::Scalar>>;
  { m.min_sigma_t() } -> std::same_as<typename M::Scalar>;
  { M::k_closed_form } -> std::convertible_to<bool>;
};

}  // namespace manylight
