// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <utility>

#include "manylight/media/concepts.hpp"
#include "manylight/media/grid_lattice.hpp"

namespace manylight {

/// A medium inside of a box that may be turned and sheared, vacuum outside: an end for media that have none.
template <Medium M>
class BoxedMedium {
 public:
  using Scalar = typename M::Scalar;
  using Phase = typename M::Phase;
  using S = Scalar;
  static constexpr bool k_closed_form = M::k_closed_form;

  /// The unit cube under `to_world` (affine, afterwards metres). Throws ParameterError.
  BoxedMedium(M medium, const Mat4<S>& to_world) : medium_(std::move(medium)), box_({2, 2, 2}, placed(to_world)) {}

  [[nodiscard]] Rgb<S> sigma_t(const Vec3<S>& x, const Vec3<S>& w) const noexcept {
    return contains(x) ? medium_.sigma_t(x, w) : Rgb<S>(S(0));
  }
  [[nodiscard]] Rgb<S> sigma_s(const Vec3<S>& x, const Vec3<S>& w) const noexcept {
    return contains(x) ? medium_.sigma_s(x, w) : Rgb<S>(S(0));
  }
  [[nodiscard]] Phase phase(const Vec3<S>& x) const noexcept { return medium_.phase(x); }
  /// 0: segments may miss the box.
  [[nodiscard]] S min_sigma_t() const noexcept { return S(0); }

  template <SampleStream Stream>
  [[nodiscard]] MediumSample<S> sample(const Ray<S>& ray, S t_max, Stream& stream) const noexcept {
    const auto segment = box_.clip(ray, t_max);
    if (!segment) return {t_max, Rgb<S>(S(1)), false};
    const MediumSample<S> inside = medium_.sample(from_entry(ray, *segment), segment->length, stream);
    return {inside.scattered ? std::min(segment->t_entry + inside.t, t_max) : t_max, inside.weight, inside.scattered};
  }
  template <SampleStream Stream>
  [[nodiscard]] Rgb<S> transmittance(const Ray<S>& ray, S t_max, Stream& stream) const noexcept {
    const auto segment = box_.clip(ray, t_max);
    return segment ? medium_.transmittance(from_entry(ray, *segment), segment->length, stream) : Rgb<S>(S(1));
  }
  [[nodiscard]] Rgb<S> mean_transmittance(const Ray<S>& ray, S t_max) const noexcept {
    const auto segment = box_.clip(ray, t_max);
    return segment ? medium_.mean_transmittance(from_entry(ray, *segment), segment->length) : Rgb<S>(S(1));
  }

 private:
  [[nodiscard]] static GridPlacement<S> placed(const Mat4<S>& to_world) {
    GridPlacement<S> placement;
    placement.to_world = to_world;
    return placement;
  }
  [[nodiscard]] bool contains(const Vec3<S>& x) const noexcept { return box_.contains(box_.from_world(x)); }
  [[nodiscard]] static Ray<S> from_entry(const Ray<S>& ray, const GridSegment<S>& segment) noexcept {
    return {ray.origin + ray.direction * segment.t_entry, ray.direction};
  }

  M medium_;
  GridLattice<S> box_;  ///< of one cell
};

}  // namespace manylight
