// SPDX-License-Identifier: Apache-2.0
#pragma once

// Chords |a - b| of directions: where they nearly coincide, 1 - cos and sqrt(1 - cos^2) lose half their digits, chords
// keep all of them.

#include <algorithm>
#include <limits>

#include "manylight/core/direction_set.hpp"
#include "manylight/core/interval_math.hpp"

namespace manylight {

namespace detail {
/// Upper bound of the chord from the axis to any member, 2 sin(half-angle / 2); 0 of a vector.
template <std::floating_point S>
[[nodiscard]] inline S chord_above(const Vec3<S>& /*w*/) noexcept {
  return S(0);
}
template <std::floating_point S>
[[nodiscard]] inline S chord_above(const DirectionSet<S>& w) noexcept {
  const S cosine = w.cone.cos_half;
  const S chord = cosine > S(0) ? w.cone.sin_half / std::sqrt((S(1) + cosine) / S(2)) : std::sqrt(S(2) - S(2) * cosine);
  return std::min(S(2), chord) * (S(1) + k_cosine_margin<S>);
}
template <std::floating_point S>
[[nodiscard]] inline const Vec3<S>& axis_of(const Vec3<S>& w) noexcept {
  return w;
}
template <std::floating_point S>
[[nodiscard]] inline const Vec3<S>& axis_of(const DirectionSet<S>& w) noexcept {
  return w.cone.axis;
}
/// By the cosines and, closer where those are next to 1, by the triangle inequality of chords.
template <std::floating_point S, class A, class B>
[[nodiscard]] inline Interval<S> sqr_distance_over(const A& a, const B& b) noexcept {
  const Interval<S> by_cosine = S(2) * max0(S(1) - dot(a, b));
  return refine(by_cosine, [&] {
    const S between = glm::length(axis_of(a) - axis_of(b));
    const S reach = chord_above(a) + chord_above(b) + k_cosine_margin<S>;
    return sqr(Interval<S>(std::max(S(0), between - reach), between + reach));
  });
}
}  // namespace detail

/// |a - b|^2 of unit vectors, 2 (1 - cos) of the angle between them. The same of members of sets.
template <std::floating_point S>
[[nodiscard]] inline S sqr_distance(const Vec3<S>& a, const Vec3<S>& b) noexcept {
  const Vec3<S> difference = a - b;
  return glm::dot(difference, difference);
}
template <std::floating_point S>
[[nodiscard]] inline Interval<S> sqr_distance(const DirectionSet<S>& a, const Vec3<S>& b) noexcept {
  return detail::sqr_distance_over<S>(a, b);
}
template <std::floating_point S>
[[nodiscard]] inline Interval<S> sqr_distance(const Vec3<S>& a, const DirectionSet<S>& b) noexcept {
  return detail::sqr_distance_over<S>(a, b);
}
template <std::floating_point S>
[[nodiscard]] inline Interval<S> sqr_distance(const DirectionSet<S>& a, const DirectionSet<S>& b) noexcept {
  return detail::sqr_distance_over<S>(a, b);
}

/// Sine of the angle between `w` and the unit vector `axis`, at most 1. The same of members of a set.
template <std::floating_point S>
[[nodiscard]] inline S sine_between(const Vec3<S>& w, const Vec3<S>& axis) noexcept {
  return std::min(S(1), glm::length(glm::cross(w, axis)));
}
template <std::floating_point S>
[[nodiscard]] inline Interval<S> sine_between(const DirectionSet<S>& w, const Vec3<S>& axis) noexcept {
  // Next to a right angle 1 - cos^2 is narrower than the sine's own rounding.
  const Interval<S> by_cosine = widen(sqrt(S(1) - sqr(dot(w, axis))), detail::k_cosine_margin<S>);
  const Interval<S> sine = refine(by_cosine, [&] {  // |w x f - a x f| <= |w - a|
    const S at_axis = glm::length(glm::cross(w.cone.axis, axis));
    const S reach = detail::chord_above(w) + detail::k_cosine_margin<S>;
    return Interval<S>(std::max(S(0), at_axis - reach), at_axis + reach);
  });
  return min(sine, S(1));
}

}  // namespace manylight
