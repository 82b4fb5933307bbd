// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>

#include <glm/mat4x4.hpp>

#include "manylight/core/error.hpp"
#include "manylight/core/warp.hpp"
#include "manylight/scene/concepts.hpp"
#include "manylight/scene/image.hpp"

namespace manylight {

/// What a perspective camera is made from.
template <std::floating_point S>
struct PerspectiveConfig {
  /// Camera to world: the camera sits at the origin, looks along +z, +y is up and +x points to the LEFT of the image.
  /// Rotation, translation, mirroring and uniform scale; the scale is ignored.
  glm::mat<4, 4, S, glm::defaultp> to_world{S(1)};
  S horizontal_fov = S(45);  ///< whole angle between the left and the right border, degrees, (0, 180)
  std::uint32_t width = 0;   ///< pixels
  std::uint32_t height = 0;  ///< pixels; pixels are square
  S aperture_radius = S(0);  ///< m, world; 0 is a pinhole
  S focus_distance = S(1);   ///< m along the axis to the plane that is sharp; used by a lens only
};

/// Perspective camera with square pixels: a pinhole, or a thin lens of uniform transmission.
template <std::floating_point S>
class PerspectiveCamera {
 public:
  using Scalar = S;

  /// Throws ParameterError naming the parameter that is out of range.
  explicit PerspectiveCamera(const PerspectiveConfig<S>& config)
      : aperture_radius_(config.aperture_radius),
        focus_distance_(config.focus_distance),
        width_(config.width),
        height_(config.height) {
    validate(config);
    set_frame(config.to_world);
    tan_x_ = std::tan(config.horizontal_fov * k_pi<S> / S(360));
    pixel_ = S(2) * tan_x_ / static_cast<S>(width_);
    tan_y_ = pixel_ * static_cast<S>(height_) / S(2);
  }

  /// See concept Camera.
  [[nodiscard]] Ray<S> ray(const Vec2<S>& film, const Vec2<S>& lens_u) const noexcept {
    // On the plane at unit distance; film x grows to the right, local x to the left.
    const Vec3<S> through = axis_ + left_ * (tan_x_ - film.x * pixel_) + up_ * (tan_y_ - film.y * pixel_);
    if (aperture_radius_ == S(0)) return {position_, glm::normalize(through)};
    const Vec3<S> offset = lens_offset(lens_u);
    return {position_ + offset, glm::normalize(through * focus_distance_ - offset)};
  }

  /// See concept LensCamera. All rays of one lens point go through the plane in focus, of which a pixel covers the same
  /// area everywhere: 1 / (pixel^2 cos^3), whatever the lens point.
  [[nodiscard]] S film_density(const Vec3<S>& direction) const noexcept {
    const S cosine = glm::dot(direction, axis_);
    return cosine > S(0) ? S(1) / (sqr(pixel_) * cosine * cosine * cosine) : S(0);
  }
  /// See concept LensCamera.
  [[nodiscard]] std::optional<LensSample<S>> project(const Vec3<S>& point, const Vec2<S>& lens_u) const noexcept {
    const bool is_pinhole = aperture_radius_ == S(0);
    const Vec3<S> offset = is_pinhole ? Vec3<S>(0) : lens_offset(lens_u);
    const Vec3<S> segment = point - (position_ + offset);
    const S depth = glm::dot(segment, axis_);
    if (!(depth > S(0))) return std::nullopt;
    // The inverse of `ray`: where the ray meets the plane in focus, seen from the centre of the lens.
    Vec3<S> through = segment / depth;
    if (!is_pinhole) through += offset / focus_distance_;
    LensSample<S> sample;
    sample.film = {(tan_x_ - glm::dot(through, left_)) / pixel_, (tan_y_ - glm::dot(through, up_)) / pixel_};
    sample.position = position_ + offset;
    sample.film_density = film_density(glm::normalize(segment));
    if (!(sample.film_density > S(0)) || !std::isfinite(sample.film_density)) return std::nullopt;
    return sample;
  }

  [[nodiscard]] std::uint32_t width() const noexcept { return width_; }
  [[nodiscard]] std::uint32_t height() const noexcept { return height_; }
  /// Centre of the lens, world, m.
  [[nodiscard]] const Vec3<S>& position() const noexcept { return position_; }
  /// Unit viewing direction, world.
  [[nodiscard]] const Vec3<S>& axis() const noexcept { return axis_; }
  [[nodiscard]] S aperture_radius() const noexcept { return aperture_radius_; }

 private:
  static void validate(const PerspectiveConfig<S>& config) {
    require(config.width >= 1 && config.width <= k_max_image_side, "image width", config.width, "1 to 65535 pixels");
    require(config.height >= 1 && config.height <= k_max_image_side, "image height", config.height,
            "1 to 65535 pixels");
    require(config.horizontal_fov > S(0) && config.horizontal_fov < S(180), "camera field of view",
            config.horizontal_fov, "above 0 and below 180 degrees");
    require(config.aperture_radius >= S(0) && std::isfinite(config.aperture_radius), "camera aperture radius",
            config.aperture_radius, "0 or a positive length");
    require(config.aperture_radius == S(0) || (config.focus_distance > S(0) && std::isfinite(config.focus_distance)),
            "camera focus distance", config.focus_distance, "a positive length");
  }

  /// The three axes stay orthogonal but not necessarily right-handed: a mirrored camera shows a mirrored image.
  void set_frame(const glm::mat<4, 4, S, glm::defaultp>& to_world) {
    const Vec3<S> x(to_world[0]), y(to_world[1]), z(to_world[2]);
    position_ = Vec3<S>(to_world[3]);
    const S scale = glm::length(z);
    require(is_finite(position_) && std::isfinite(scale) && scale > S(0), "camera transform", "degenerate",
            "a finite position and viewing direction");
    // Matrices in files have some six digits.
    const S tolerance = S(1e-3) * scale;
    const bool uniform = std::abs(glm::length(x) - scale) < tolerance && std::abs(glm::length(y) - scale) < tolerance;
    const S skew = std::abs(glm::dot(x, y)) + std::abs(glm::dot(y, z)) + std::abs(glm::dot(z, x));
    require(uniform && skew < tolerance * scale, "camera transform", "sheared or unevenly scaled",
            "rotation, translation, mirroring and uniform scale");
    axis_ = z / scale;
    up_ = glm::normalize(y - axis_ * glm::dot(axis_, y));
    const Vec3<S> left = glm::cross(up_, axis_);
    left_ = glm::dot(left, x) < S(0) ? -left : left;
  }

  [[nodiscard]] Vec3<S> lens_offset(const Vec2<S>& lens_u) const noexcept {
    const Vec2<S> lens = aperture_radius_ * warp::square_to_disk(lens_u);
    return left_ * lens.x + up_ * lens.y;
  }

  Vec3<S> position_{0}, axis_{0}, up_{0}, left_{0};
  S tan_x_ = S(0);  ///< half the film's width on the plane at unit distance
  S tan_y_ = S(0);
  S pixel_ = S(0);  ///< a pixel's side on that plane
  S aperture_radius_, focus_distance_;
  std::uint32_t width_, height_;
};

static_assert(LensCamera<PerspectiveCamera<float>> && LensCamera<PerspectiveCamera<double>>);

}  // namespace manylight
