// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "manylight/core/error.hpp"
#include "manylight/core/warp.hpp"
#include "manylight/scene/emitter_list.hpp"

namespace manylight {

/// Radiance from infinity as a function of direction, with importance sampling. Constant, or a latitude-longitude image
/// (layout: see EnvironmentEmitter) interpolated bilinearly. The density is piecewise constant per solid angle over the
/// cells between four texels, proportional to the mean of the corners' largest channels: it is positive wherever the
/// radiance is, radiance / density never exceeds 4 times its mean, and no sine appears in it, so the poles need no
/// guard.
/// Memory: image + 8 bytes per texel.
template <std::floating_point S>
class Environment {
 public:
  /// Throws ParameterError for an image of one row, a value that is negative or not finite, a degenerate transform.
  explicit Environment(const EnvironmentEmitter<S>& emitter) : radiance_(emitter.radiance), image_(emitter.image) {
    require(is_valid_radiance(radiance_), "environment radiance", max_channel(radiance_), "0 or positive, finite");
    set_frame(emitter.to_world);
    if (image_) {
      validate_image();
      build_distribution();
    } else {
      flux_ = radiance_ * (S(4) * k_pi<S>);
    }
  }

  /// Radiance arriving from the unit direction `w` (world, towards the light), W m^-2 sr^-1.
  [[nodiscard]] Rgb<S> eval(const Vec3<S>& w) const noexcept {
    if (!image_) return radiance_;
    const Cell cell = locate(to_local(w));
    const std::array<Rgb<S>, 4> c = corners(cell.row, cell.column);
    return radiance_ * glm::mix(glm::mix(c[0], c[1], cell.x), glm::mix(c[2], c[3], cell.x), cell.y);
  }

  /// Density of `sample`, sr^-1.
  [[nodiscard]] S pdf(const Vec3<S>& w) const noexcept {
    if (!image_) return k_inv_pi<S> / S(4);
    if (!(total_ > 0)) return S(0);
    const Cell cell = locate(to_local(w));
    return static_cast<S>(importance(cell.row, cell.column) / total_);
  }

  /// A unit direction towards the light, world. The environment must not be black.
  [[nodiscard]] Vec3<S> sample(const Vec2<S>& u) const noexcept {
    if (!image_) return warp::square_to_sphere(u);
    const Pick row = pick(row_cdf_, static_cast<double>(u.y));
    const std::span<const double> columns(column_cdf_.data() + row.index * columns_(), columns_());
    const Pick column = pick(columns, static_cast<double>(u.x));
    // Uniform in the cell: longitude and the cosine of the polar angle are.
    const double cos_theta = std::lerp(row_cos_[row.index], row_cos_[row.index + 1], row.rest);
    const double turn = (static_cast<double>(column.index) + column.rest + 0.5) / static_cast<double>(columns_());
    const double sin_theta = std::sqrt(std::max(0.0, 1 - cos_theta * cos_theta));
    const double phi = 2 * k_pi<double> * turn;
    const Vec3<double> local(sin_theta * std::sin(phi), cos_theta, -sin_theta * std::cos(phi));
    return glm::normalize(to_world_ * Vec3<S>(local));
  }

  /// Integral of the radiance over the sphere, W m^-2; bilinear cells are taken at the mean of their corners.
  [[nodiscard]] const Rgb<S>& flux() const noexcept { return flux_; }

 private:
  /// A cell between four texels, and where in it: x to the next column, y to the next row, both in [0, 1].
  struct Cell {
    std::uint32_t row, column;
    S x, y;
  };
  struct Pick {
    std::size_t index;
    double rest;  ///< position within the entry, [0, 1)
  };

  void set_frame(const glm::mat<3, 3, S, glm::defaultp>& m) {
    for (int i = 0; i < 3; ++i) {
      const S scale = glm::length(m[i]);
      require(std::isfinite(scale) && scale > S(0), "environment transform", "degenerate", "a rotation");
      to_world_[i] = m[i] / scale;
    }
    const S skew = std::abs(glm::dot(to_world_[0], to_world_[1])) + std::abs(glm::dot(to_world_[1], to_world_[2])) +
                   std::abs(glm::dot(to_world_[2], to_world_[0]));
    require(skew < S(1e-3), "environment transform", "sheared", "rotation, mirroring and uniform scale");
  }
  void validate_image() const {
    require(image_->height >= 2, "environment image height", image_->height, "2 rows or more");
    for (std::uint32_t y = 0; y < image_->height; ++y) {
      for (std::uint32_t x = 0; x < image_->width; ++x) {
        require(is_valid_radiance(image_->at(x, y)),
                "environment texel (" + std::to_string(x) + ", " + std::to_string(y) + ")",
                std::min(image_->at(x, y).x, std::min(image_->at(x, y).y, image_->at(x, y).z)),
                "0 or positive, finite");
      }
    }
  }

  void build_distribution() {
    const std::uint32_t rows = image_->height - 1;
    for (std::uint32_t i = 0; i <= rows; ++i) row_cos_.push_back(std::cos(k_pi<double> * i / rows));
    column_cdf_.reserve(static_cast<std::size_t>(rows) * image_->width);
    Vec3<double> flux(0);
    double sum = 0;
    for (std::uint32_t row = 0; row < rows; ++row) {
      const double cell_angle = 2 * k_pi<double> / image_->width * (row_cos_[row] - row_cos_[row + 1]);
      double in_row = 0;
      for (std::uint32_t column = 0; column < image_->width; ++column) {
        for (const Rgb<S>& c : corners(row, column)) flux += Vec3<double>(c) * (cell_angle / 4);
        in_row += importance(row, column) * cell_angle;
        column_cdf_.push_back(in_row);
      }
      sum += in_row;
      row_cdf_.push_back(sum);
    }
    total_ = sum;
    flux_ = radiance_ * Rgb<S>(flux);
  }

  [[nodiscard]] std::size_t columns_() const noexcept { return image_->width; }
  [[nodiscard]] Vec3<S> to_local(const Vec3<S>& w) const noexcept { return w * to_world_; }

  /// Corner texels: (row, column), (row, column + 1), (row + 1, column), (row + 1, column + 1); columns wrap around.
  [[nodiscard]] std::array<Rgb<S>, 4> corners(std::uint32_t row, std::uint32_t column) const noexcept {
    const std::uint32_t next = column + 1 == image_->width ? 0 : column + 1;
    return {image_->at(column, row), image_->at(next, row), image_->at(column, row + 1), image_->at(next, row + 1)};
  }
  [[nodiscard]] double importance(std::uint32_t row, std::uint32_t column) const noexcept {
    double sum = 0;
    for (const Rgb<S>& c : corners(row, column)) sum += static_cast<double>(max_channel(c));
    return sum / 4;
  }

  [[nodiscard]] Cell locate(const Vec3<S>& w) const noexcept {
    const S turn = std::atan2(w.x, -w.z) * (k_inv_pi<S> / S(2));
    // acos(y) loses half the digits near the poles, where rows are thin
    const S polar = std::atan2(std::sqrt(w.x * w.x + w.z * w.z), w.y) * k_inv_pi<S>;
    const S rows = static_cast<S>(image_->height - 1), columns = static_cast<S>(image_->width);
    const S y = std::clamp(polar * rows, S(0), rows);
    S x = turn * columns - S(0.5);
    if (x < S(0)) x += columns;
    const auto row = std::min(static_cast<std::uint32_t>(y), image_->height - 2);
    const auto column = std::min(static_cast<std::uint32_t>(std::max(x, S(0))), image_->width - 1);
    return {row, column, std::clamp(x - static_cast<S>(column), S(0), S(1)), y - static_cast<S>(row)};
  }

  /// Inverts a running sum.
  [[nodiscard]] static Pick pick(std::span<const double> cdf, double u) noexcept {
    const double target = u * cdf.back();
    const auto found = std::upper_bound(cdf.begin(), cdf.end(), target);
    const auto index = std::min(static_cast<std::size_t>(found - cdf.begin()), cdf.size() - 1);
    const double below = index == 0 ? 0.0 : cdf[index - 1];
    const double width = cdf[index] - below;
    return {index, width > 0 ? std::clamp((target - below) / width, 0.0, 1 - 0x1p-53) : 0.0};
  }

  Rgb<S> radiance_;
  std::shared_ptr<const Image<S>> image_;
  glm::mat<3, 3, S, glm::defaultp> to_world_{S(1)};  ///< orthogonal: its inverse is its transpose
  std::vector<double> row_cos_;                      ///< cosine of the polar angle of each texel row
  std::vector<double> row_cdf_;                      ///< running sum of importance times solid angle, per row of cells
  std::vector<double> column_cdf_;                   ///< the same within each row
  double total_ = 0;
  Rgb<S> flux_{0};
};

}  // namespace manylight
