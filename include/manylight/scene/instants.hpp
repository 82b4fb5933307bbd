// SPDX-License-Identifier: Apache-2.0
#pragma once

// Motion blur by instants [Walter 2006, section 4.3]: the shutter interval is cut into equal slots, each shown by one scene
// of its own. Eye and light subpaths live in one instant, only vertices of the same instant are connected, and an image is
// the mean over all instants. Camera, lights, shapes and materials may all move; paths, cuts and backends know nothing of it.

#include <cstdint>
#include <numeric>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "manylight/scene/concepts.hpp"
#include "manylight/scene/scene.hpp"

namespace manylight {

using InstantId = std::uint16_t;

/// A shadow ray at one instant.
template <class Ray>
struct InstantRay {
  Ray ray;
  InstantId instant;
};

/// A scene in motion. `S`: a Scene whose Motion is Moving.
template <class S>
class Instants {
  static_assert(S::k_moves,
                "manylight::Instants: the scenes must be of a Scene<..., Moving>, whose vertices tell instants apart");

 public:
  using Scalar = typename S::Scalar;
  using Material = typename S::Material;
  using Phase = typename S::Phase;
  using Subsurface = typename S::Subsurface;
  using MotionType = typename S::MotionType;
  using ShaderType = typename S::ShaderType;
  using InstantType = S;
  using ShadowRay = InstantRay<typename S::ShadowRay>;
  using Passed = typename S::Passed;
  static constexpr bool k_has_media = S::k_has_media;
  static constexpr bool k_has_subsurface = S::k_has_subsurface;
  static constexpr bool k_moves = true;

  /// One scene per instant, in order, all made with the same world bounds: lights at infinity have one unit. Throws
  /// SceneError.
  explicit Instants(std::vector<S> scenes) : scenes_(std::move(scenes)) {
    if (scenes_.empty() || scenes_.size() > 65535) {
      throw SceneError("a scene in motion has " + std::to_string(scenes_.size()) + " instants, allowed: 1 to 65535");
    }
    for (const S& scene : scenes_) {
      if (scene.emitters().scene_radius() != emitters().scene_radius()) {
        throw SceneError("instants of a scene in motion differ in their world bounds, allowed: the same for all");
      }
    }
  }

  [[nodiscard]] std::uint32_t instants() const noexcept { return static_cast<std::uint32_t>(scenes_.size()); }
  [[nodiscard]] const S& at(std::uint32_t instant) const noexcept { return scenes_[instant]; }
  /// Of the first instant: its radius is that of all.
  [[nodiscard]] const Emitters<Scalar>& emitters() const noexcept { return scenes_.front().emitters(); }

  [[nodiscard]] Passed visibility(const ShadowRay& ray, RayCounts& rays) const {
    return scenes_[ray.instant].visibility(ray.ray, rays);
  }
  void visibility(std::span<const ShadowRay> segments, std::span<Passed> passed, RayCounts& rays) const {
    for (std::size_t i = 0; i < segments.size(); ++i) passed[i] = visibility(segments[i], rays);
  }

 private:
  std::vector<S> scenes_;
};

/// The scene of an instant; a scene that stands still is its own at all of them. The same of cameras and integrators.
template <class T>
[[nodiscard]] inline const auto& at_instant(const T& scene, [[maybe_unused]] std::uint32_t instant) noexcept {
  if constexpr (requires { scene.at(instant); }) {
    return scene.at(instant);
  } else {
    return scene;
  }
}
template <class T>
[[nodiscard]] inline std::uint32_t instant_count([[maybe_unused]] const T& scene) noexcept {
  if constexpr (requires { scene.instants(); }) {
    return scene.instants();
  } else {
    return 1;
  }
}
/// The instant of a sample: `count` consecutive ones of an index meet each once, from a start that is the sampler's for that
/// index, so that other seeds and passes see others. Strides by the golden ratio spread fewer samples over the whole of the
/// shutter interval.
template <Sampler Random>
[[nodiscard]] std::uint32_t sample_instant(std::uint32_t count, const Random& sampler, std::uint64_t index,
                                           std::uint64_t sample) {
  if (count == 1) return 0;
  auto stream = sampler.stream(Stage::instant, index, 0);
  const auto start = static_cast<std::uint64_t>(static_cast<double>(stream.next()) * count);
  std::uint64_t stride = std::uint64_t{count} * 618 / 1000;  // of count >= 2: 1 or more
  while (std::gcd(stride, std::uint64_t{count}) != 1) ++stride;
  return static_cast<std::uint32_t>((start + sample % count * stride) % count);
}

/// A camera that moves: one per instant, all of one film.
template <Camera C>
class MovingCamera {
 public:
  using Scalar = typename C::Scalar;

  /// Throws ParameterError unless there is at least one and all have films of the same size.
  explicit MovingCamera(std::vector<C> cameras) : cameras_(std::move(cameras)) {
    require(!cameras_.empty(), "number of a moving camera's instants", cameras_.size(), "at least 1");
    for (const C& camera : cameras_) {
      require(camera.width() == width() && camera.height() == height(), "film of a moving camera", "of several sizes",
              "the same at all instants");
    }
  }
  [[nodiscard]] const C& at(std::uint32_t instant) const noexcept { return cameras_[instant % cameras_.size()]; }
  /// Of the first instant: a MovingCamera is a Camera.
  [[nodiscard]] Ray<Scalar> ray(const Vec2<Scalar>& film, const Vec2<Scalar>& lens_u) const noexcept {
    return cameras_.front().ray(film, lens_u);
  }
  [[nodiscard]] std::uint32_t width() const noexcept { return cameras_.front().width(); }
  [[nodiscard]] std::uint32_t height() const noexcept { return cameras_.front().height(); }

 private:
  std::vector<C> cameras_;
};

}  // namespace manylight
