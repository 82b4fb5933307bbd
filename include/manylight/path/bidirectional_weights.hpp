// SPDX-License-Identifier: Apache-2.0
#pragma once

// Weights of bidirectional path tracing by the balance heuristic, in O(1) per pair of vertices [Veach 1997, section 10.2;
// Georgiev 2012]. A path z_0 (light) ... z_n (lens) is made by strategy s with the density
//
//   p_s = prod_{i<s} f_i  prod_{i>=s} b_i
//
// f_i, b_i: density per area (in media per volume) of z_i when the walk comes from the light or from the lens. With the
// solid-angle density p and the cosine c at a surface (1 in a medium), f_i = p(z_{i-1} -> z_i) c_i / r^2. Every strategy
// holds the extinction at z_i once, so that it cancels; the transmittance of segments may be random and is left out of all
// densities. That keeps the weights of a path one function of the path alone, so that they sum to one. The
// weight is p_s / sum_j p_j = 1 / (1 + sum_{j<s} p_j / p_s + sum_{j>s} p_j / p_s). Each of the two sums is, at a vertex i
// of the walk that knows it, b_i times what that walk carries along:
//
//   vcm_i = 1 / f_i,    vc_i = (g_{i-1} / f_i) (vcm_{i-1} + rev_{i-2} vc_{i-1}),    sum_{j<s} p_j / p_s = b_i (vcm + rev vc)
//
// g turns a density per solid angle into one per area at z_{i-1}, rev is the other walk's density of going on to z_{i-2}.
// At a vertex where a Dirac lobe was drawn, neither segment can be a connection, and both densities count as 1.
// A segment through an object that scatters below its surface is drawn per area at its far end, whatever the way: there
// g = 1 for both walks, and it may be a connection like any other.
// Whatever a walk's own density leaves out, it has to leave out in the other walk's density of the same, too.

#include <concepts>

namespace manylight {

/// What a walk carries along. For the eye walk f and b change places.
template <std::floating_point S>
struct PartialWeights {
  S vcm = S(0);
  S vc = S(0);

  /// At the first vertex of a light walk. Densities of the start: `direct_pdf` of its choice for that vertex by
  /// `sample_direct`, sr^-1 (of point lights times the squared distance), `projected_pdf` of the light walk, as in
  /// EmissionSample; `cosine` at the vertex. Lights that no eye walk hits are `is_delta`.
  [[nodiscard]] static PartialWeights of_emission(S direct_pdf, S projected_pdf, S cosine, bool is_delta) noexcept {
    const S pdf = projected_pdf * cosine;
    return {direct_pdf / pdf, is_delta ? S(0) : S(1) / pdf};
  }
  /// On the first segment of an eye walk: `light_paths` are connected with the lens per image, 0 for none; see
  /// LensCamera::film_density.
  [[nodiscard]] static PartialWeights of_lens(S light_paths, S film_density) noexcept {
    return {light_paths > S(0) ? light_paths / film_density : S(0), S(0)};
  }

  /// At the end of a segment.
  void arrive(S squared_distance, S cosine) noexcept {
    vcm *= squared_distance / cosine;
    vc /= cosine;
  }
  /// The walk goes on in a direction of that density, sr^-1; `reverse_pdf` is the other walk's for the way back.
  void leave(S cosine, S pdf, S reverse_pdf) noexcept {
    vc = cosine / pdf * sum(reverse_pdf);
    vcm = S(1) / pdf;
  }
  void leave_by_dirac(S cosine) noexcept {
    vc *= cosine;
    vcm = S(0);
  }
  /// The walk goes through an object to a place of that density, m^-2, where it has then arrived; `reverse_pdf` as in
  /// `leave`.
  void pass_below(S pdf_area, S reverse_pdf) noexcept {
    vc = sum(reverse_pdf) / pdf_area;
    vcm = S(1) / pdf_area;
  }
  [[nodiscard]] S sum(S reverse_pdf) const noexcept { return vcm + reverse_pdf * vc; }
};

namespace detail {
/// 1 / (1 + others); 0 where rounding has left no number.
template <std::floating_point S>
[[nodiscard]] inline S balance(S others) noexcept {
  return others >= S(0) ? S(1) / (S(1) + others) : S(0);
}
}  // namespace detail

/// s = 0, the eye walk hits a light. `eye`: on its last segment, before `arrive`; densities as in `of_emission`.
template <std::floating_point S>
[[nodiscard]] inline S weight_of_hit(const PartialWeights<S>& eye, S direct_pdf, S projected_pdf) noexcept {
  return detail::balance(direct_pdf * eye.vcm + projected_pdf * eye.vc);
}

/// s = 1, a light drawn for an eye vertex. `pdf`: of that direction in the eye walk, 0 if it cannot hit the light;
/// `eye_sum`: PartialWeights::sum of the vertex; `cosine` there.
template <std::floating_point S>
[[nodiscard]] inline S weight_of_direct(S pdf, S direct_pdf, S projected_pdf, S cosine, S eye_sum) noexcept {
  return detail::balance((pdf + projected_pdf * cosine * eye_sum) / direct_pdf);
}

/// 2 <= s < n, a light vertex connected with an eye vertex. `to_light`, `to_eye`: densities per area with which the eye walk
/// would go on to the light vertex and the other way round.
template <std::floating_point S>
[[nodiscard]] inline S weight_of_connection(S to_light, S light_sum, S to_eye, S eye_sum) noexcept {
  return detail::balance(to_light * light_sum + to_eye * eye_sum);
}

/// s = n, a light vertex connected with the lens. `to_light`: density per area with which eye walks come to it, per pixel.
template <std::floating_point S>
[[nodiscard]] inline S weight_of_lens(S to_light, S light_paths, S light_sum) noexcept {
  return detail::balance(to_light / light_paths * light_sum);
}

}  // namespace manylight
