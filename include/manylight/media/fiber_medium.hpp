// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "manylight/media/concepts.hpp"
#include "manylight/media/heterogeneous.hpp"
#include "manylight/media/packed_direction.hpp"
#include "manylight/media/tracking.hpp"

namespace manylight {

/// Makes the phase function of fibers along a unit axis (world frame), whose `projected_area(w)` is the mean projected
/// area of flakes in direction w, in [0, max_projected_area()] for every axis, the same for w and -w.
template <class F, class S>
concept FiberPhases = std::copyable<F> && requires(const F& make, const Vec3<S>& axis) {
  { make.max_projected_area() } -> std::same_as<S>;
  { make(axis).projected_area(axis) } -> std::same_as<S>;
  requires MediumPhase<std::remove_cvref_t<decltype(make(axis))>, S>;
};

/// Fibers in a grid: density rho (m^-1, times a scale) and axis per voxel, sigma_t(x, w) = 2 rho(x) projected_area(w)
/// [Jakob 2010, Sec. 4.2], sigma_s = albedo * sigma_t. Density is trilinear, the axis that of the nearest voxel; empty
/// voxels beside filled ones take the axis of their densest neighbour. 3 bytes per voxel for the axis, sizeof(T) for
/// the density: 7 with float, 4 with std::uint8_t.
template <class MakePhase, class Density = GridVolume<float>, class Albedo = Rgb<typename Density::Scalar>>
requires FiberPhases<MakePhase, typename Density::Scalar>
class FiberMedium {
 public:
  using Scalar = typename Density::Scalar;
  using S = Scalar;
  using Phase = std::remove_cvref_t<std::invoke_result_t<const MakePhase&, const Vec3<S>&>>;
  static constexpr bool k_closed_form = false;

  /// `axes`: one per sample of the density, in the grid's own frame, of any length but 0; those of empty voxels are not
  /// read. Throws ParameterError, also where rays would take more than 1e6 steps.
  FiberMedium(Density density, std::span<const Vec3<S>> axes, S scale, Albedo albedo, const MakePhase& make_phase,
              std::uint32_t cells_per_block = BlockMajorants<S>::k_cells_per_block)
      : density_(std::move(density)),
        scale_(scale),
        albedo_(std::move(albedo)),
        make_phase_(make_phase),
        blocks_(density_, cells_per_block) {
    check::non_negative("fiber density scale", scale);
    check::non_negative("largest projected area", make_phase_.max_projected_area());
    detail::check_albedo(albedo_);
    check_tracking_cost("largest optical thickness of the fibers", tracking_scale() * blocks_.maximum(),
                        density_.lattice());
    pack(axes);
  }

  [[nodiscard]] Rgb<S> sigma_t(const Vec3<S>& x, const Vec3<S>& w) const noexcept {
    const Vec3<S> g = density_.lattice().from_world(x);
    return Rgb<S>(density_.lattice().contains(g) ? grey_sigma_t(g, w) : S(0));
  }
  [[nodiscard]] Rgb<S> sigma_s(const Vec3<S>& x, const Vec3<S>& w) const noexcept {
    return sigma_t(x, w) * detail::albedo_at(albedo_, x);
  }
  [[nodiscard]] Phase phase(const Vec3<S>& x) const noexcept {
    const Vec3<S> g = density_.lattice().from_world(x);
    return make_phase_(density_.lattice().contains(g) ? axis_at(g) : Vec3<S>(0, 0, 1));
  }
  [[nodiscard]] S min_sigma_t() const noexcept { return S(0); }

  template <SampleStream Stream>
  [[nodiscard]] MediumSample<S> sample(const Ray<S>& ray, S t_max, Stream& stream) const noexcept {
    const auto segment = density_.lattice().clip(ray, t_max);
    if (!segment) return {t_max, Rgb<S>(S(1)), false};
    const auto hit = track_collision(blocks_, *segment, tracking_scale(), along(ray.direction), stream);
    if (!hit) return {t_max, Rgb<S>(S(1)), false};
    return {std::min(hit->t, t_max), Rgb<S>(S(1) / hit->sigma_t), true};
  }
  template <SampleStream Stream>
  [[nodiscard]] Rgb<S> transmittance(const Ray<S>& ray, S t_max, Stream& stream) const noexcept {
    const auto segment = density_.lattice().clip(ray, t_max);
    if (!segment) return Rgb<S>(S(1));
    return Rgb<S>(track_transmittance(blocks_, *segment, tracking_scale(), along(ray.direction), stream));
  }
  /// 1.
  [[nodiscard]] Rgb<S> mean_transmittance(const Ray<S>& /*ray*/, S /*t_max*/) const noexcept { return Rgb<S>(S(1)); }

  [[nodiscard]] const Density& density() const noexcept { return density_; }
  /// World frame, as stored.
  [[nodiscard]] Vec3<S> axis(const Vec3<S>& x) const noexcept {
    const Vec3<S> g = density_.lattice().from_world(x);
    return density_.lattice().contains(g) ? axis_at(g) : Vec3<S>(0, 0, 1);
  }
  [[nodiscard]] std::size_t bytes() const noexcept {
    return density_.bytes() + blocks_.bytes() + axes_->capacity() * sizeof(PackedDirection);
  }

 private:
  void pack(std::span<const Vec3<S>> axes);
  [[nodiscard]] std::optional<std::size_t> densest_neighbour(std::size_t x, std::size_t y, std::size_t z) const;

  [[nodiscard]] S tracking_scale() const noexcept { return S(2) * scale_ * make_phase_.max_projected_area(); }
  [[nodiscard]] Vec3<S> axis_at(const Vec3<S>& g) const noexcept {
    const GridCell<S> cell = cell_at(density_.lattice(), g);
    const auto nearest = [&](int a) {
      return cell.sample[static_cast<std::size_t>(a)][cell.fraction[a] < S(0.5) ? 0 : 1];
    };
    return (*axes_)[density_.lattice().index(nearest(0), nearest(1), nearest(2))].template unpack<S>();
  }
  [[nodiscard]] S grey_sigma_t(const Vec3<S>& g, const Vec3<S>& w) const noexcept {
    const S rho = density_.eval_lattice(g);
    if (!(rho > S(0))) return S(0);
    const S area = std::clamp(make_phase_(axis_at(g)).projected_area(w), S(0), make_phase_.max_projected_area());
    return S(2) * scale_ * rho * area;
  }
  [[nodiscard]] auto along(const Vec3<S>& w) const noexcept {
    return [this, w](const Vec3<S>& g) { return grey_sigma_t(g, w); };
  }

  Density density_;
  S scale_;
  Albedo albedo_;
  MakePhase make_phase_;
  BlockMajorants<S> blocks_;
  std::shared_ptr<const std::vector<PackedDirection>> axes_;
};

template <class MakePhase, class Density, class Albedo>
requires FiberPhases<MakePhase, typename Density::Scalar>
void FiberMedium<MakePhase, Density, Albedo>::pack(std::span<const Vec3<S>> axes) {
  const GridLattice<S>& lattice = density_.lattice();
  require(axes.size() == lattice.sample_count(), "number of fiber axes", axes.size(),
          "the number of density values, " + std::to_string(lattice.sample_count()));
  auto packed = std::make_shared<std::vector<PackedDirection>>(axes.size());
  std::size_t i = 0;
  for (std::uint32_t z = 0; z < lattice.size()[2]; ++z) {
    for (std::uint32_t y = 0; y < lattice.size()[1]; ++y) {
      for (std::uint32_t x = 0; x < lattice.size()[0]; ++x, ++i) {
        if (!(density_.sample(i) > S(0))) continue;
        const Vec3<S> w = lattice.to_world_direction(axes[i]);
        if (!is_finite(w) || w == Vec3<S>(S(0))) {
          throw ParameterError("fiber axis " + std::to_string(i),
                               "(" + std::to_string(axes[i].x) + ", " + std::to_string(axes[i].y) + ", " +
                                   std::to_string(axes[i].z) + ")",
                               "finite and not 0 where the density is above 0");
        }
        (*packed)[i] = PackedDirection(w);
      }
    }
  }
  // Second pass, from the voxels that have an axis of their own: a point between voxels may have density though the
  // nearest one is empty, and all voxels around it are neighbours of each other.
  i = 0;
  for (std::uint32_t z = 0; z < lattice.size()[2]; ++z) {
    for (std::uint32_t y = 0; y < lattice.size()[1]; ++y) {
      for (std::uint32_t x = 0; x < lattice.size()[0]; ++x, ++i) {
        if (density_.sample(i) > S(0)) continue;
        if (const auto from = densest_neighbour(x, y, z)) (*packed)[i] = (*packed)[*from];
      }
    }
  }
  axes_ = std::move(packed);
}

template <class MakePhase, class Density, class Albedo>
requires FiberPhases<MakePhase, typename Density::Scalar> std::optional<std::size_t>
FiberMedium<MakePhase, Density, Albedo>::densest_neighbour(std::size_t x, std::size_t y, std::size_t z)
const {
  const GridLattice<S>& lattice = density_.lattice();
  std::optional<std::size_t> best;
  S most = S(0);
  for (std::int32_t k = 0; k < 27; ++k) {
    const std::size_t i = lattice.index(lattice.sample(0, static_cast<std::int32_t>(x) + k % 3 - 1),
                                        lattice.sample(1, static_cast<std::int32_t>(y) + k / 3 % 3 - 1),
                                        lattice.sample(2, static_cast<std::int32_t>(z) + k / 9 - 1));
    const S rho = density_.sample(i);
    if (rho > most) {
      most = rho;
      best = i;
    }
  }
  return best;
}

}  // namespace manylight
