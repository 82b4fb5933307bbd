// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <optional>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "manylight/integrator/film.hpp"
#include "manylight/path/transfer.hpp"
#include "manylight/scene/camera.hpp"
#include "manylight/scene/instants.hpp"
#include "manylight/scene/scene.hpp"
#include "render/either_sampler.hpp"
#include "render/executor.hpp"
#include "render/file_media.hpp"
#include "render/job.hpp"
#include "render/progress.hpp"

namespace manylight::render {

/// Instants<Snapshot>, named only where it is used: it takes no scene that stands still.
template <class Snapshot>
struct InstantsOf {
  using type = Instants<Snapshot>;
};

/// A scene of one instantiation, its camera and film, and what the options say of both. The widest kind of scene has
/// instants, one if nothing moves.
template <class Geometry, class Shader, class Media>
struct Setup {
  static constexpr bool k_may_move = Media::k_exist;
  using Snapshot = Scene<Geometry, Shader, Media, std::conditional_t<k_may_move, Moving, Still>>;
  using SceneType = typename std::conditional_t<k_may_move, InstantsOf<Snapshot>, std::type_identity<Snapshot>>::type;
  using CameraType = std::conditional_t<k_may_move, MovingCamera<PerspectiveCamera<float>>, PerspectiveCamera<float>>;

  /// Moves the shapes out of `description`. Throws what scene, camera and window throw for values out of range.
  Setup(scene_file::SceneDescription& description, const Options& chosen)
      : options(chosen),
        executor(chosen.threads),
        scene(make_scene(description, instant_times(description, chosen))),
        camera(make_camera(description, instant_times(description, chosen))),
        filter(description.filter),
        window(chosen.window.value_or(Window::of(camera))),
        sampler{chosen.sampler, chosen.seed} {
    const int depth = options.max_depth.value_or(description.max_depth);
    max_edges = depth < 0 ? k_unlimited_edges : std::min(static_cast<unsigned>(depth), k_unlimited_edges);
    window.validate(camera.width(), camera.height());
  }

  const Options& options;
  ProgramExecutor executor;
  SceneType scene;
  CameraType camera;
  ReconstructionFilter<float> filter;
  Window window;
  EitherSampler sampler;
  unsigned max_edges = k_unlimited_edges;

 private:
  /// The middles of the shutter's slots; one time if nothing moves.
  [[nodiscard]] static std::vector<float> instant_times(const scene_file::SceneDescription& description,
                                                        const Options& options) {
    const scene_file::Shutter& shutter = description.shutter;
    const std::uint32_t count = description.moves() ? options.instants : 1;
    std::vector<float> times;
    for (std::uint32_t i = 0; i < count; ++i) {
      const float share = (static_cast<float>(i) + 0.5F) / static_cast<float>(count);
      times.push_back(shutter.open + (shutter.close - shutter.open) * (description.moves() ? share : 0.0F));
    }
    return times;
  }

  /// What surfaces are made of, and which shape is of what.
  struct Surfaces {
    std::vector<Shader> shaders;
    std::vector<std::uint32_t> of_shape;
  };
  [[nodiscard]] static Surfaces make_surfaces(const scene_file::SceneDescription& description) {
    Surfaces surfaces;
    using Key = std::tuple<std::uint32_t, std::array<float, 3>, std::optional<std::uint32_t>>;
    std::map<Key, std::uint32_t> known;
    for (const auto& info : description.shape_infos) {
      const Rgb<float>& a = info.interior_absorption;
      const auto [entry, is_new] = known.try_emplace({info.material, {a.x, a.y, a.z}, info.subsurface},
                                                     static_cast<std::uint32_t>(surfaces.shaders.size()));
      if (is_new) {
        const scene_file::MaterialDescription& material = description.materials[info.material];
        if constexpr (requires { typename Shader::Subsurface; }) {
          std::shared_ptr<const FileSubsurface> below;
          if (info.subsurface) {
            below = std::make_shared<const FileSubsurface>(
                make_file_subsurface(description.subsurfaces[*info.subsurface]));
          }
          surfaces.shaders.emplace_back(material, a, std::move(below));
        } else {
          surfaces.shaders.emplace_back(material, a);
        }
      }
      surfaces.of_shape.push_back(entry->second);
    }
    return surfaces;
  }

  [[nodiscard]] static SceneType make_scene(scene_file::SceneDescription& description, const std::vector<float>& times) {
    const Surfaces surfaces = make_surfaces(description);
    const Media media = make_media(description);
    if constexpr (!k_may_move) {
      return SceneType(Geometry(std::move(description.shapes)), surfaces.shaders, surfaces.of_shape,
                       description.emitters, media);
    } else {
      std::vector<Geometry> geometries;
      Box<float> world;
      for (const float time : times) {
        geometries.emplace_back(times.size() == 1 && !description.moves()
                                    ? std::move(description.shapes)
                                    : scene_file::at_time(description, time).shapes);
        world.extend(geometries.back().bounds());
      }
      std::vector<Snapshot> snapshots;
      for (Geometry& geometry : geometries) {
        snapshots.emplace_back(std::move(geometry), surfaces.shaders, surfaces.of_shape, description.emitters, media,
                               world);
      }
      return SceneType(std::move(snapshots));
    }
  }

  [[nodiscard]] static Media make_media(scene_file::SceneDescription& description) {
    if constexpr (Media::k_exist) {
      return make_file_media(description);
    } else {
      static_cast<void>(description);
      return {};
    }
  }

  [[nodiscard]] static CameraType make_camera(const scene_file::SceneDescription& description,
                                              const std::vector<float>& times) {
    const scene_file::CameraDescription& c = description.camera;
    PerspectiveConfig<float> config;
    config.to_world = c.to_world;
    config.horizontal_fov = scene_file::horizontal_fov_degrees(c);
    config.width = c.width;
    config.height = c.height;
    config.aperture_radius = c.aperture_radius;
    config.focus_distance = c.focus_distance;
    if constexpr (!k_may_move) {
      return CameraType(config);
    } else {
      std::vector<PerspectiveCamera<float>> cameras;
      for (const float time : times) {
        if (c.motion.moves()) config.to_world = c.motion.at(time);
        cameras.emplace_back(config);
      }
      return CameraType(std::move(cameras));
    }
  }
};

}  // namespace manylight::render
