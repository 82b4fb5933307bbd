// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "manylight/core/huge_pages.hpp"
#include "manylight/core/spectrum.hpp"
#include "manylight/media/grid_lattice.hpp"

namespace manylight {

/// How a stored value reads: floating-point numbers as they are, unsigned integers as fractions of their largest, GLM
/// vectors of three of either as colours.
template <std::floating_point S, class T>
struct GridElement {
  using Value = S;
  [[nodiscard]] static constexpr S read(const T& stored) noexcept {
    if constexpr (std::is_floating_point_v<T>) {
      return static_cast<S>(stored);
    } else {
      static_assert(std::unsigned_integral<T>, "grids hold floating-point numbers or unsigned integers");
      return static_cast<S>(stored) * (S(1) / static_cast<S>(std::numeric_limits<T>::max()));
    }
  }
};
template <std::floating_point S, class T, glm::qualifier Q>
struct GridElement<S, glm::vec<3, T, Q>> {
  using Value = Rgb<S>;
  [[nodiscard]] static constexpr Rgb<S> read(const glm::vec<3, T, Q>& stored) noexcept {
    using Channel = GridElement<S, T>;
    return {Channel::read(stored.x), Channel::read(stored.y), Channel::read(stored.z)};
  }
};

/// The samples that a lookup is made of, and where between them the point lies.
template <std::floating_point S>
struct GridCell {
  std::array<std::array<std::uint32_t, 2>, 3> sample;  ///< per axis, the lower and the upper
  Vec3<S> fraction;                                    ///< [0, 1] from the lower to the upper
};

template <std::floating_point S>
[[nodiscard]] inline GridCell<S> cell_at(const GridLattice<S>& lattice, const Vec3<S>& g) noexcept {
  GridCell<S> cell;
  for (int axis = 0; axis < 3; ++axis) {
    const S h = g[axis] - lattice.first_sample();
    const S below = std::floor(h);
    const auto i = static_cast<std::int32_t>(below);
    cell.sample[static_cast<std::size_t>(axis)] = {lattice.sample(axis, i), lattice.sample(axis, i + 1)};
    cell.fraction[axis] = h - below;
  }
  return cell;
}

/// Samples on a regular grid, finite and not negative, between them trilinear, 0 outside of the grid's box. The samples
/// are shared: copies of a GridVolume, and several placements of one set of samples, cost nothing. sizeof(T) bytes per
/// sample.
template <std::floating_point S, class T = float>
class GridVolume {
 public:
  using Scalar = S;
  using Element = GridElement<S, T>;
  using Value = typename Element::Value;  ///< S, or Rgb<S> of a coloured grid
  using Samples = LargeVector<T>;

  /// `samples`: x varies fastest, then y. Throws ParameterError.
  GridVolume(const std::array<std::uint32_t, 3>& size, std::shared_ptr<const Samples> samples,
             const GridPlacement<S>& placement = {})
      : lattice_(size, placement), samples_(std::move(samples)) {
    const std::size_t count = samples_ ? samples_->size() : 0;
    require(count == lattice_.sample_count(), "number of grid values", count,
            "the product of the sizes, " + std::to_string(lattice_.sample_count()));
    check_values();
  }
  GridVolume(const std::array<std::uint32_t, 3>& size, Samples samples, const GridPlacement<S>& placement = {})
      : GridVolume(size, std::make_shared<const Samples>(std::move(samples)), placement) {}

  /// At a point of the world; 0 outside and for NaN.
  [[nodiscard]] Value eval(const Vec3<S>& position) const noexcept {
    const Vec3<S> g = lattice_.from_world(position);
    return lattice_.contains(g) ? eval_lattice(g) : Value(S(0));
  }
  /// At lattice coordinates that lie in the grid.
  [[nodiscard]] Value eval_lattice(const Vec3<S>& g) const noexcept {
    const GridCell<S> cell = cell_at(lattice_, g);
    const Vec3<S>& f = cell.fraction;
    const T* const data = samples_->data();
    std::array<Value, 4> rows{};
    for (std::size_t i = 0; i < 4; ++i) {
      const T* const row = data + lattice_.index(0, cell.sample[1][i % 2], cell.sample[2][i / 2]);
      rows[i] = mix(Element::read(row[cell.sample[0][0]]), Element::read(row[cell.sample[0][1]]), f.x);
    }
    return mix(mix(rows[0], rows[1], f.y), mix(rows[2], rows[3], f.y), f.z);
  }
  [[nodiscard]] Value sample(std::size_t index) const noexcept { return Element::read((*samples_)[index]); }
  /// Largest sample, of the largest channel.
  [[nodiscard]] S maximum() const noexcept { return maximum_; }
  [[nodiscard]] const GridLattice<S>& lattice() const noexcept { return lattice_; }
  [[nodiscard]] std::size_t bytes() const noexcept { return samples_->capacity() * sizeof(T); }

 private:
  [[nodiscard]] static Value mix(const Value& a, const Value& b, S f) noexcept { return a * (S(1) - f) + b * f; }
  [[nodiscard]] static Rgb<S> channels(const Value& value) noexcept { return Rgb<S>(value); }
  void check_values() {
    for (std::size_t i = 0; i < samples_->size(); ++i) {
      const Rgb<S> value = channels(sample(i));
      const S wrong = first_invalid(value);
      if (!is_valid_radiance(value)) throw ParameterError(place_of(i), wrong, "finite and >= 0");
      maximum_ = std::max(maximum_, max_channel(value));
    }
  }
  [[nodiscard]] static S first_invalid(const Rgb<S>& v) noexcept {
    const auto is_wrong = [](S x) { return !(x >= S(0) && std::isfinite(x)); };
    return is_wrong(v.x) ? v.x : is_wrong(v.y) ? v.y : v.z;
  }
  [[nodiscard]] std::string place_of(std::size_t i) const {
    const std::size_t row = lattice_.size()[0];
    const std::size_t slice = row * lattice_.size()[1];
    return "grid value " + std::to_string(i) + " at (" + std::to_string(i % row) + ", " +
           std::to_string(i % slice / row) + ", " + std::to_string(i / slice) + ")";
  }

  GridLattice<S> lattice_;
  std::shared_ptr<const Samples> samples_;
  S maximum_ = S(0);
};

}  // namespace manylight
