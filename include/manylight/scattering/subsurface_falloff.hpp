// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <limits>
#include <type_traits>

#include "manylight/core/sampler.hpp"
#include "manylight/core/spectrum.hpp"
#include "manylight/core/vector.hpp"

namespace manylight {

/// How subsurface scattering falls off with the distance between where light enters a body and where it leaves, and the
/// random lines that draw such points [Walter 2012, section 7]: two independent uniform points on a sphere around x
/// span a chord, and its crossings with the body's surface are the points. A sphere of radius r makes 1 / (2 pi r^2)
/// crossings per chord and area everywhere inside, whatever the surface; with the density -pi r^2 g'(r) of radii that
/// becomes g(d) / 2 at the distance d. Contract:
///  - `eval(d)`: g per channel, m^-2, of d >= 0 m (may be infinite): finite, not negative, falling, and
///    int_0^inf 2 pi r g(r) dr = 1: how much comes back is the albedo of `Subsurface`;
///  - `sample_radius(stream)`: draws a sphere's radius, m, >= 0 and finite;
///  - `line_pdf(d)`: expected crossings per chord and area at the distance d, m^-2: int_d^inf p_r(r) / (2 pi r^2) dr of
///    the density p_r of radii. Positive where eval is; the variance is low if g / line_pdf is bounded, zero noise from
///    the falloff if it is constant;
///  - `sup(d_min)`: upper bound of every channel of `eval` over all d >= d_min (m) and over rounding of d_min by a few
///    ulp, m^-2, finite.
/// Falloffs are small values; all members are const, noexcept, thread-safe, never NaN.
template <class F>
concept SubsurfaceFalloff = std::copyable<F> &&
    requires(const F& f, typename F::Scalar d, IndependentStream<typename F::Scalar>& stream) {
  { f.eval(d) } -> std::same_as<Rgb<typename F::Scalar>>;
  { f.sample_radius(stream) } -> std::same_as<typename F::Scalar>;
  { f.line_pdf(d) } -> std::same_as<typename F::Scalar>;
  { f.sup(d) } -> std::same_as<typename F::Scalar>;
};

/// One channel of an RgbFalloff, of which all else follows:
///  - `eval(d)`: g, m^-2, as above: falling also in floating-point arithmetic, up to a few ulp;
///  - `sample_radius(stream)`: a radius of density -pi r^2 g'(r), for the same number of variates each time.
template <class P>
concept FalloffProfile = std::copyable<P> &&
    requires(const P& p, typename P::Scalar d, IndependentStream<typename P::Scalar>& stream) {
  { p.eval(d) } -> std::same_as<typename P::Scalar>;
  { p.sample_radius(stream) } -> std::same_as<typename P::Scalar>;
};

/// A falloff whose channels are profiles of their own. Radii are drawn for a channel chosen at random, so that their
/// density is the mean of the channels': g / line_pdf is 2 where the channels are alike and at most 6.
template <FalloffProfile P>
struct RgbFalloff {
  using Scalar = typename P::Scalar;
  using S = Scalar;
  using Profile = P;
  std::array<P, 3> channels{};

  RgbFalloff() = default;
  RgbFalloff(const P& r, const P& g, const P& b) noexcept : channels{r, g, b} {}
  /// Each channel made from its number, in the profile's unit.
  explicit RgbFalloff(const Rgb<S>& parameter) noexcept requires std::constructible_from<P, S>
      : channels{P(parameter.x), P(parameter.y), P(parameter.z)} {}

  /// Throws ParameterError.
  void validate() const {
    for (const P& channel : channels) {
      if constexpr (requires { channel.validate(); }) channel.validate();
    }
  }

  [[nodiscard]] Rgb<S> eval(S d) const noexcept {
    return {channels[0].eval(d), channels[1].eval(d), channels[2].eval(d)};
  }
  template <SampleStream Stream>
  [[nodiscard]] S sample_radius(Stream& stream) const noexcept {
    const auto k = static_cast<std::size_t>(S(3) * stream.next());
    return channels[std::min(k, std::size_t{2})].sample_radius(stream);
  }
  [[nodiscard]] S line_pdf(S d) const noexcept {
    const Rgb<S> g = eval(d);
    return (g.x + g.y + g.z) / S(6);
  }
  [[nodiscard]] S sup(S d_min) const noexcept {
    // Distances are off by a few ulp, and eval falls up to a few of its own.
    constexpr S k_margin = S(16) * std::numeric_limits<S>::epsilon();
    return max_channel(eval(d_min * (S(1) - k_margin))) * (S(1) + k_margin);
  }
};

}  // namespace manylight
