// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <type_traits>
#include <utility>

#include "manylight/media/concepts.hpp"
#include "manylight/media/tracking.hpp"
#include "manylight/scattering/validation.hpp"

namespace manylight {

namespace detail {
/// A medium's albedo: one colour, or a grid of colours or of numbers, black outside of it.
template <std::floating_point S>
[[nodiscard]] inline Rgb<S> albedo_at(const Rgb<S>& albedo, const Vec3<S>& /*x*/) noexcept {
  return albedo;
}
template <std::floating_point S, class T>
[[nodiscard]] inline Rgb<S> albedo_at(const GridVolume<S, T>& albedo, const Vec3<S>& x) noexcept {
  return glm::min(Rgb<S>(albedo.eval(x)), Rgb<S>(S(1)));  // rounding of the interpolation
}
template <std::floating_point S>
inline void check_albedo(const Rgb<S>& albedo) {
  check::reflectance("medium albedo", albedo);
}
template <std::floating_point S, class T>
inline void check_albedo(const GridVolume<S, T>& albedo) {
  require(albedo.maximum() <= S(1), "largest value of the albedo grid", albedo.maximum(), "0 to 1");
}
}  // namespace detail

/// sigma_t = scale * density, the same for all channels; sigma_s = albedo * sigma_t. Flights by delta tracking: weight
/// 1 / sigma_t at a collision, 1 if they get through.
/// `Density`: a GridVolume of numbers; `Albedo`: Rgb<S> or a GridVolume.
template <class P, class Density = GridVolume<typename P::Scalar>, class Albedo = Rgb<typename P::Scalar>>
requires MediumPhase<P, typename P::Scalar>
class Heterogeneous {
 public:
  using Scalar = typename P::Scalar;
  using Phase = P;
  using S = Scalar;
  static constexpr bool k_closed_form = false;
  static_assert(std::is_same_v<typename Density::Value, S>, "a density has one channel");

  /// `scale`: m^-1 per unit of density. `cells_per_block` of the majorants changes speed and noise, never the mean.
  /// Throws ParameterError, also where rays would take more than 1e6 steps.
  Heterogeneous(Density density, S scale, Albedo albedo, const Phase& phase = Phase(),
                std::uint32_t cells_per_block = BlockMajorants<S>::k_cells_per_block)
      : density_(std::move(density)),
        scale_(scale),
        albedo_(std::move(albedo)),
        phase_(phase),
        blocks_(density_, cells_per_block) {
    check::non_negative("density scale", scale);
    detail::check_albedo(albedo_);
    check_tracking_cost("largest optical thickness of the medium", scale * blocks_.maximum(), density_.lattice());
  }

  [[nodiscard]] Rgb<S> sigma_t(const Vec3<S>& x, const Vec3<S>& /*w*/) const noexcept {
    return Rgb<S>(scale_ * density_.eval(x));
  }
  [[nodiscard]] Rgb<S> sigma_s(const Vec3<S>& x, const Vec3<S>& w) const noexcept {
    return sigma_t(x, w) * detail::albedo_at(albedo_, x);
  }
  [[nodiscard]] Phase phase(const Vec3<S>& /*x*/) const noexcept { return phase_; }
  [[nodiscard]] S min_sigma_t() const noexcept { return S(0); }

  template <SampleStream Stream>
  [[nodiscard]] MediumSample<S> sample(const Ray<S>& ray, S t_max, Stream& stream) const noexcept {
    const auto segment = density_.lattice().clip(ray, t_max);
    if (!segment) return {t_max, Rgb<S>(S(1)), false};
    const auto hit = track_collision(blocks_, *segment, scale_, along(), stream);
    if (!hit) return {t_max, Rgb<S>(S(1)), false};
    return {std::min(hit->t, t_max), Rgb<S>(S(1) / hit->sigma_t), true};
  }
  template <SampleStream Stream>
  [[nodiscard]] Rgb<S> transmittance(const Ray<S>& ray, S t_max, Stream& stream) const noexcept {
    const auto segment = density_.lattice().clip(ray, t_max);
    return Rgb<S>(segment ? track_transmittance(blocks_, *segment, scale_, along(), stream) : S(1));
  }
  /// 1.
  [[nodiscard]] Rgb<S> mean_transmittance(const Ray<S>& /*ray*/, S /*t_max*/) const noexcept { return Rgb<S>(S(1)); }

  [[nodiscard]] const Density& density() const noexcept { return density_; }
  [[nodiscard]] std::size_t bytes() const noexcept { return density_.bytes() + blocks_.bytes(); }

 private:
  [[nodiscard]] auto along() const noexcept {
    return [this](const Vec3<S>& g) { return scale_ * density_.eval_lattice(g); };
  }

  Density density_;
  S scale_;
  Albedo albedo_;
  Phase phase_;
  BlockMajorants<S> blocks_;
};

}  // namespace manylight
