// SPDX-License-Identifier: Apache-2.0
#pragma once

// Which medium fills space where. A boundary is a closed surface that tells its two sides apart; all other surfaces stand
// in one medium. Mediums are named by number, 0 is vacuum.

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "manylight/core/error.hpp"
#include "manylight/geometry/ray.hpp"
#include "manylight/media/concepts.hpp"
#include "manylight/scattering/phase_concepts.hpp"

namespace manylight {

/// 0: vacuum; n: the scene's medium n - 1.
using MediumId = std::uint16_t;
inline constexpr MediumId k_vacuum = 0;

/// What is on the two sides of a surface.
struct MediaSides {
  MediumId front = k_vacuum;  ///< on the side of the geometric normal that goes with it
  MediumId back = k_vacuum;

  friend bool operator==(const MediaSides&, const MediaSides&) = default;
};

/// Of a scene without media: no code, no data.
struct NoPhase {};
struct NoMedia {
  static constexpr bool k_exist = false;
  using Phase = NoPhase;
};

/// The media of a scene.
template <Medium M>
class SceneMedia {
 public:
  using Scalar = typename M::Scalar;
  using MediumType = M;
  using Phase = typename M::Phase;
  static constexpr bool k_exist = true;
  static_assert(PhaseFunction<Phase>, "manylight::SceneMedia: the medium's Phase must model PhaseFunction: Scalar, eval, "
                                      "sample, pdf, projected_area");

  /// `boundaries[shape]`: what is outside (front, the side of the shape's own normal) and inside of a shape that is a
  /// boundary; shorter than the number of shapes means no more boundaries. `outside`: what fills all space beyond the
  /// boundaries. Throws SceneError for numbers of media that do not exist.
  SceneMedia(std::vector<M> media, std::vector<std::optional<MediaSides>> boundaries, MediumId outside = k_vacuum)
      : media_(std::move(media)), boundaries_(std::move(boundaries)), outside_(outside) {
    check("outside", outside);
    for (std::size_t i = 0; i < boundaries_.size(); ++i) {
      if (!boundaries_[i]) continue;
      has_boundaries_ = true;
      check("front of shape " + std::to_string(i), boundaries_[i]->front);
      check("back of shape " + std::to_string(i), boundaries_[i]->back);
    }
  }

  /// Not of vacuum.
  [[nodiscard]] const M& medium(MediumId id) const noexcept { return media_[std::size_t{id} - 1]; }
  [[nodiscard]] std::size_t size() const noexcept { return media_.size(); }
  [[nodiscard]] MediumId outside() const noexcept { return outside_; }
  [[nodiscard]] bool has_boundaries() const noexcept { return has_boundaries_; }
  [[nodiscard]] bool is_boundary(std::uint32_t shape) const noexcept {
    return shape < boundaries_.size() && boundaries_[shape].has_value();
  }
  /// Of the point's shape, front on the side of `point.ng`; of no boundary, `current` on both.
  [[nodiscard]] MediaSides sides(const SurfacePoint<Scalar>& point, MediumId current) const noexcept {
    return is_boundary(point.shape) ? *boundaries_[point.shape] : MediaSides{current, current};
  }
  /// The medium that a ray of that direction is in behind `point`, having come through `current`.
  [[nodiscard]] MediumId behind(const SurfacePoint<Scalar>& point, const Vec3<Scalar>& direction,
                                MediumId current) const noexcept {
    const MediaSides both = sides(point, current);
    return glm::dot(direction, point.ng) > Scalar(0) ? both.front : both.back;
  }

 private:
  void check(const std::string& where, MediumId id) const {
    if (id > media_.size()) {
      throw SceneError("medium " + where + " is number " + std::to_string(id) + ", allowed: 0 (vacuum) to " +
                       std::to_string(media_.size()));
    }
  }

  std::vector<M> media_;
  std::vector<std::optional<MediaSides>> boundaries_;
  MediumId outside_;
  bool has_boundaries_ = false;
};

}  // namespace manylight
