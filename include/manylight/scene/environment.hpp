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

/// What arrives from a direction at infinity.
template <std::floating_point S>
struct EnvironmentLight {
  Rgb<S> radiance{0};  ///< W m^-2 sr^-1
  S pdf = S(0);        ///< density of drawing the direction, sr^-1
};

/// Radiance from infinity as a function of direction, with importance sampling. Constant, or a latitude-longitude image
/// (layout: see EnvironmentEmitter) interpolated bilinearly. The density is piecewise constant per solid angle over the
/// cells between four texels, proportional to the mean of the corners' largest channels: it is positive wherever the
/// radiance is, radiance / density never exceeds 4 times its mean, and no sine appears in it, so the poles need no
/// guard.
/// Memory: image + 12 bytes per texel.
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

  /// What arrives from the unit direction `w` (world, towards the light), and the density of `sample` there. Texels are
  /// far apart in memory: whoever needs both should not look them up twice.
  [[nodiscard]] EnvironmentLight<S> light(const Vec3<S>& w) const noexcept {
    if (!image_) return {radiance_, k_inv_pi<S> / S(4)};
    const Cell cell = locate(to_local(w));
    const std::array<Rgb<S>, 4> c = corners(cell.row, cell.column);
    return {radiance_ * glm::mix(glm::mix(c[0], c[1], cell.x), glm::mix(c[2], c[3], cell.x), cell.y),
            total_ > 0 ? static_cast<S>(importance(c) / total_) : S(0)};
  }
  [[nodiscard]] Rgb<S> eval(const Vec3<S>& w) const noexcept { return light(w).radiance; }
  [[nodiscard]] S pdf(const Vec3<S>& w) const noexcept { return light(w).pdf; }

  /// A unit direction towards the light, world. The environment must not be black.
  [[nodiscard]] Vec3<S> sample(const Vec2<S>& u) const noexcept {
    if (!image_) return warp::square_to_sphere(u);
    const Pick row = pick(row_cdf_, row_guide_, static_cast<double>(u.y));
    const std::size_t first = row.index * columns_();
    const Pick column = pick(std::span(column_cdf_).subspan(first, columns_()),
                             std::span(column_guide_).subspan(first, columns_()), static_cast<double>(u.x));
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
    column_guide_.reserve(column_cdf_.capacity());
    Vec3<double> flux(0);
    double sum = 0;
    for (std::uint32_t row = 0; row < rows; ++row) {
      const double cell_angle = 2 * k_pi<double> / image_->width * (row_cos_[row] - row_cos_[row + 1]);
      double in_row = 0;
      for (std::uint32_t column = 0; column < image_->width; ++column) {
        const std::array<Rgb<S>, 4> texels = corners(row, column);
        for (const Rgb<S>& c : texels) flux += Vec3<double>(c) * (cell_angle / 4);
        in_row += importance(texels) * cell_angle;
        column_cdf_.push_back(in_row);
      }
      sum += in_row;
      row_cdf_.push_back(sum);
      append_guide(std::span(column_cdf_).last(image_->width), column_guide_);
    }
    append_guide(row_cdf_, row_guide_);
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
  [[nodiscard]] static double importance(const std::array<Rgb<S>, 4>& texels) noexcept {
    double sum = 0;
    for (const Rgb<S>& c : texels) sum += static_cast<double>(max_channel(c));
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

  /// Entry k of a guide is where the k-th of n equal shares of a running sum begins, the first entry beyond k / n of all:
  /// searches start there and take two steps in the mean, where bisection jumps through the memory [Chen and Asau 1974].
  static void append_guide(std::span<const double> cdf, std::vector<std::uint32_t>& guide) {
    std::uint32_t i = 0;
    for (std::size_t k = 0; k < cdf.size(); ++k) {
      const double share = static_cast<double>(k) / static_cast<double>(cdf.size()) * cdf.back();
      while (i + 1 < cdf.size() && cdf[i] <= share) ++i;
      guide.push_back(i);
    }
  }
  /// Inverts a running sum: the first entry beyond the share `u` of all.
  [[nodiscard]] static Pick pick(std::span<const double> cdf, std::span<const std::uint32_t> guide, double u) noexcept {
    const double target = u * cdf.back();
    const auto n = static_cast<double>(cdf.size());
    std::size_t index = guide[std::min(static_cast<std::size_t>(u * n), cdf.size() - 1)];
    while (index > 0 && cdf[index - 1] > target) --index;  // u n was rounded up
    while (index + 1 < cdf.size() && cdf[index] <= target) ++index;
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
  std::vector<std::uint32_t> row_guide_;             ///< of row_cdf_
  std::vector<std::uint32_t> column_guide_;          ///< of each row's part of column_cdf_
  double total_ = 0;
  Rgb<S> flux_{0};
};

}  // namespace manylight
