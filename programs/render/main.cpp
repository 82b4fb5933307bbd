// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <exception>
#include <filesystem>
#include <fstream>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "image_io/image_io.hpp"
#include "manylight/core/config.hpp"
#include "manylight/geometry/bvh.hpp"
#ifdef MANYLIGHT_HAS_EMBREE
#include "manylight/geometry/embree.hpp"
#endif
#include "render/job.hpp"
#include "render/passes.hpp"
#include "scene_file/load_scene.hpp"

namespace manylight::render {

namespace {

/// `Widest`: the shader of scenes of everything that the group's methods know.
template <MethodGroup group, class Geometry, class Widest>
JobResult run_narrowest(scene_file::SceneDescription& description, const Options& options, std::string& kind) {
  const auto all_fit = [&](auto fits) {
    return description.media.empty() && description.subsurfaces.empty() && !description.moves() &&
           std::all_of(description.materials.begin(), description.materials.end(), fits);
  };
  if (all_fit(DiffuseShader::fits)) {
    kind = "diffuse";
    return run_job<group, Geometry, DiffuseShader, NoMedia>(description, options);
  }
  if (all_fit(SurfaceFileShader::fits)) {
    kind = "surfaces";
    return run_job<group, Geometry, SurfaceFileShader, NoMedia>(description, options);
  }
  kind = "everything";
  return run_job<group, Geometry, Widest, FileMedia>(description, options);
}

/// On the narrowest kind of scene that holds all materials and media.
template <class Geometry>
JobResult run_narrowest(scene_file::SceneDescription& description, const Options& options, std::string& kind) {
  constexpr auto k_many_light = MethodGroup::many_light;
  constexpr auto k_bidirectional = MethodGroup::bidirectional;
  constexpr auto k_photons = MethodGroup::photons;
  switch (group_of(options.method)) {
    case k_many_light: return run_narrowest<k_many_light, Geometry, FullFileShader>(description, options, kind);
    case k_bidirectional: return run_narrowest<k_bidirectional, Geometry, FullFileShader>(description, options, kind);
    case k_photons: break;
  }
  if (!description.subsurfaces.empty()) {
    throw ParameterError(fmt::format("--method {}", method_name(options.method)),
                         "for a scene with subsurface scattering ('" + description.subsurfaces.front().name + "')",
                         "path, bdpt, vpl, ir, lightcuts or bdlc");
  }
  return run_narrowest<k_photons, Geometry, BlendedFileShader>(description, options, kind);
}

JobResult dispatch(scene_file::SceneDescription& description, const Options& options, std::string& kind) {
#ifdef MANYLIGHT_HAS_EMBREE
  if (options.backend == Backend::embree) return run_narrowest<EmbreeGeometry>(description, options, kind);
#endif
  return run_narrowest<Bvh<float>>(description, options, kind);
}

void check_outputs(const Options& options) {
  for (const std::string& file : options.outputs) image_io::check_writable(file);
  for (const auto& [name, file] : options.aovs) image_io::check_writable(file);
  if (!options.strategy_images.empty() && !std::filesystem::is_directory(options.strategy_images)) {
    throw ParameterError("--strategy-images", "'" + options.strategy_images + "'", "an existing folder");
  }
  if (options.stats.empty()) return;
  if (!std::filesystem::is_directory(std::filesystem::absolute(options.stats).parent_path())) {
    throw ParameterError("--stats", "'" + options.stats + "'", "a file in an existing folder");
  }
}

/// Written beside the target, then renamed: never half a file.
void write_text(const std::string& path, const std::string& text) {
  const WritingFile whole;
  const std::string temporary = path + ".partial";
  std::ofstream out(temporary);
  out << text << '\n';
  out.close();
  std::error_code error;
  if (out) std::filesystem::rename(temporary, path, error);
  if (!out || error) {
    std::filesystem::remove(temporary, error);
    throw Error(path + ": cannot be written");
  }
}

scene_file::SceneDescription load(const Options& options) {
  scene_file::LoadOptions load_options;
  load_options.defines = options.defines;
  load_options.is_lenient = options.lenient;
  scene_file::SceneDescription description = scene_file::load_scene(options.scene, load_options);
  if (options.width) {
    description.camera.width = *options.width;
    description.camera.height = *options.height;
  }
  if (options.filter == "box") description.filter = ReconstructionFilter<float>::box();
  if (options.filter == "tent") description.filter = ReconstructionFilter<float>::tent();
  if (options.filter == "gaussian") description.filter = ReconstructionFilter<float>::gaussian();
  for (const std::string& warning : description.warnings) {
    if (!options.quiet) fmt::print(stderr, "warning: {}\n", warning);
  }
  return description;
}

void write_images(const Options& options, const JobResult& result) {
  write_outputs(options, result.image);
  for (const auto& [name, image] : result.aovs) {
    const WritingFile whole;
    image_io::write_image(options.aovs.at(name), image);
  }
  for (const auto& [name, image] : result.strategies) {
    const WritingFile whole;
    image_io::write_image(std::filesystem::path(options.strategy_images) / (name + ".exr"), image);
  }
}

/// Returns the exit code.
int run(const Options& options) {
  const Stopwatch clock;
  check_outputs(options);
  scene_file::SceneDescription description = load(options);
  const double load_seconds = clock.seconds();
  std::string kind;
  JobResult result = dispatch(description, options, kind);
  write_images(options, result);
  nlohmann::json& statistics = result.statistics.json();
  statistics["version"] =
      fmt::format("{}.{}.{}", MANYLIGHT_VERSION_MAJOR, MANYLIGHT_VERSION_MINOR, MANYLIGHT_VERSION_PATCH);
  statistics["scene_kind"] = kind;
  statistics["width"] = result.image.width;
  statistics["height"] = result.image.height;
  statistics["seconds"]["load"] = load_seconds;
  statistics["seconds"]["total"] = clock.seconds();
  if (!options.stats.empty()) write_text(options.stats, statistics.dump(2));
  const bool is_interrupted = statistics["interrupted"].get<bool>();
  const int exit_code = is_interrupted ? k_exit_interrupted : 0;
  if (options.quiet) return exit_code;
  if (is_interrupted) fmt::print(stderr, "interrupted\n");
  for (const std::string& file : options.outputs) fmt::print("image: {}\n", std::filesystem::absolute(file).string());
  fmt::print("{} x {} pixels in {:.1f} s (load {:.1f}, build {:.1f}, light {:.1f}, pixels {:.1f}), {:.1f} million rays\n",
             result.image.width, result.image.height, clock.seconds(), load_seconds,
             statistics["seconds"]["build"].get<double>(), statistics["seconds"].value("vpls", 0.0),
             statistics["seconds"]["pixels"].get<double>(),
             1e-6 * static_cast<double>(statistics["rays"]["closest"].get<std::uint64_t>() +
                                        statistics["rays"]["shadow"].get<std::uint64_t>()));
  return exit_code;
}

}  // namespace

}  // namespace manylight::render

int main(int argc, char** argv) {
  try {
    const auto options = manylight::render::parse_options(argc, argv);
    if (!options) return 0;
#ifndef MANYLIGHT_HAS_EMBREE
    if (options->backend == manylight::render::Backend::embree) {
      throw manylight::ParameterError("--backend", "embree", "bvh (this program was built without Embree)");
    }
#endif
    return manylight::render::run(*options);
  } catch (const std::exception& error) {
    fmt::print(stderr, "manylight-render: {}\n", error.what());
    return 2;
  }
}
