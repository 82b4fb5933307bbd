// SPDX-License-Identifier: Apache-2.0
// What a pixel costs by cuts, on a scene file: stratified tiles of 16 x 16 pixels, each timed on one core by its
// thread's processor time, with the standard error over tiles; one light side for all of them. Method vpl sums all
// pairs on single pixels instead of tiles. Prints one line of JSON per method and number of VPLs.
//
//   bench_cuts SCENE.xml --size 512 --vpls 10000 --vpls 100000 --method lightcuts --method bdlc

#include <ctime>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <fmt/core.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "manylight/bounds/analytic.hpp"
#include "manylight/bounds/falsify.hpp"
#include "manylight/core/sobol.hpp"
#include "manylight/core/tbb_executor.hpp"
#include "manylight/geometry/bvh.hpp"
#include "manylight/integrator/bidirectional_lightcuts.hpp"
#include "manylight/integrator/instant_radiosity.hpp"
#include "render/file_media.hpp"
#include "render/file_shader.hpp"
#include "render/setup.hpp"
#include "scene_file/load_scene.hpp"

namespace {

using namespace manylight;
using namespace manylight::render;

struct Arguments {
  std::string scene;
  std::vector<std::string> methods{"lightcuts", "bdlc"};
  std::vector<std::string> bounds{"automatic"};
  std::vector<std::size_t> vpls{1'000'000};
  std::uint32_t side = 512;
  std::uint32_t tiles = 64;
  std::uint32_t eye_paths = 64;
  double threshold = 0.02;
};

double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// The n windows of `edge` pixels, one in each cell of a grid over the film, at places drawn by a fixed seed.
std::vector<Window> stratified_windows(std::uint32_t width, std::uint32_t height, std::uint32_t count,
                                       std::uint32_t edge) {
  const auto columns = static_cast<std::uint32_t>(std::ceil(std::sqrt(static_cast<double>(count) * width / height)));
  const std::uint32_t rows = (count + columns - 1) / columns;
  std::vector<Window> windows;
  for (std::uint32_t i = 0; i < count; ++i) {
    auto stream = IndependentSampler<double>{7}.stream(Stage::test, i);
    const double u = (i % columns + stream.next()) / columns;
    const double v = (i / columns + stream.next()) / rows;
    const std::uint32_t x = std::min(static_cast<std::uint32_t>(u * width), width - edge);
    const std::uint32_t y = std::min(static_cast<std::uint32_t>(v * height), height - edge);
    windows.push_back({x, y, x + edge, y + edge});
  }
  return windows;
}

/// The kinds of bounds as one type, so that cuts are instantiated once. `sampled`: the largest value that a search
/// finds, no bound but what a perfect one would come near to.
struct AnyBounds {
  std::string kind;
  CubeMapLimits limits{};

  [[nodiscard]] bool makes_maps() const noexcept { return kind == "cube-map"; }
  template <Material M, class Wi, class Wo>
  [[nodiscard]] PatternSup<float> sup(const M& m, const Wi& wi, const Wo& wo) const noexcept {
    if (kind == "analytic") return AnalyticBounds{}.sup(m, wi, wo);
    if (kind != "sampled") return AutomaticBounds{}.sup(m, wi, wo);
    FalsifySearch search;
    search.samples = 64;
    search.ascents = 4;
    // Random directions alone would miss the peak of a sharp lobe in a wide set.
    const auto largest = [&](const DirectionSet<float>& set, const Vec3<float>& known, const auto& value) {
      const auto inside = [&](const Vec3<float>& w) { return set.z.contains(w.z) ? value(w) : 0.0F; };
      const float found = falsify(set, k_infinity<float>, inside, search).value;
      return detail::is_member(set, mirror(known)) ? std::max(found, inside(mirror(known))) : found;
    };
    if constexpr (std::is_same_v<Wi, Vec3<float>>) {
      const float f = largest(wo, wi, [&](const Vec3<float>& w) { return max_channel(m.eval(wi, w)); });
      return {f, f * std::abs(wi.z)};
    } else {
      return {largest(wi, wo, [&](const Vec3<float>& w) { return max_channel(m.eval(w, wo)); }),
              largest(wi, wo, [&](const Vec3<float>& w) { return max_channel(m.eval(w, wo)) * std::abs(w.z); })};
    }
  }
  template <class P, class W, class V>
  [[nodiscard]] float sup_phase(const P& phase, const W& w, const V& v) const noexcept {
    return kind == "analytic" ? AnalyticBounds{}.sup_phase(phase, w, v) : AutomaticBounds{}.sup_phase(phase, w, v);
  }
};

struct Moments {
  double sum = 0, squares = 0;
  std::size_t count = 0;
  void add(double x) {
    sum += x;
    squares += x * x;
    ++count;
  }
  [[nodiscard]] double mean() const { return sum / static_cast<double>(count); }
  [[nodiscard]] double standard_error() const {
    const auto n = static_cast<double>(count);
    return n > 1 ? std::sqrt(std::max(0.0, squares / n - mean() * mean()) / (n - 1)) : 0;
  }
};

template <class Render>
nlohmann::json measure(const std::vector<Window>& windows, const Render& render) {
  Moments milliseconds, cut, pairs, rays, sensors;
  std::uint64_t capped = 0;
  for (const Window& window : windows) {
    const double start = thread_seconds();
    const ManyLightImage<float> tile = render(window);
    const auto pixels = static_cast<double>(window.pixel_count());
    milliseconds.add(1e3 * (thread_seconds() - start) / pixels);
    const auto& s = tile.statistics;
    cut.add(static_cast<double>(s.pairs.cut_size) / pixels);
    pairs.add(static_cast<double>(s.pairs.pairs) / pixels);
    rays.add(static_cast<double>(s.pairs.rays.shadow + s.eye_rays.closest) / pixels);
    sensors.add(static_cast<double>(s.sensors) / pixels);
    capped += s.capped_pixels;
  }
  return {{"core_ms_per_pixel", milliseconds.mean()},
          {"standard_error", milliseconds.standard_error()},
          {"cut", cut.mean()},
          {"pairs", pairs.mean()},
          {"rays", rays.mean()},
          {"sensors", sensors.mean()},
          {"capped", static_cast<double>(capped) /
                         (static_cast<double>(windows.size()) * static_cast<double>(windows.front().pixel_count()))}};
}

template <class Shader, class Media>
void run(scene_file::SceneDescription& description, const Arguments& arguments) {
  using SceneType = typename Setup<Bvh<float>, Shader, Media>::SceneType;
  const Options options;
  const Setup<Bvh<float>, Shader, Media> setup(description, options);
  for (const std::size_t count : arguments.vpls) {
    ManyLightConfig config;
    config.vpls = count;
    config.eye_paths = arguments.eye_paths;
    config.max_edges = setup.max_edges;
    config.threshold = arguments.threshold;
    const Stopwatch clock;
    auto lights = prepare_lights(setup.scene, setup.camera, setup.filter, config, setup.sampler, setup.executor);
    const LightTree<SceneType> tree(lights.lights.vpls, setup.executor);
    const double light_seconds = clock.seconds();
    for (const std::string& method : arguments.methods) {
      for (const std::string& kind : arguments.bounds) {
        const AnyBounds bounds{kind};
        const std::uint32_t edge = method == "vpl" ? 1 : 16;
        const auto windows = stratified_windows(arguments.side, arguments.side, arguments.tiles, edge);
        nlohmann::json row = measure(windows, [&](const Window& window) {
          ManyLightConfig tile = config;
          tile.window = window;
          const SerialExecutor serial;
          if (method == "vpl") {
            return render_instant_radiosity(setup.scene, setup.camera, setup.filter, tile, lights, setup.sampler,
                                            serial);
          }
          if (method == "lightcuts") {
            return render_lightcuts(setup.scene, setup.camera, setup.filter, tile, lights, tree, setup.sampler, serial,
                                    NoProgress{}, bounds);
          }
          return render_bidirectional_lightcuts(setup.scene, setup.camera, setup.filter, tile, lights, tree,
                                                setup.sampler, serial, NoProgress{}, bounds);
        });
        row["method"] = method;
        row["bounds"] = kind;
        row["scene_kind"] = Media::k_exist ? "everything" : "surfaces";
        row["vpl_pass_seconds"] = light_seconds;
        row["vpls"] = tree.vpls().size();
        row["bytes_per_vpl"] = static_cast<double>(tree.bytes()) / static_cast<double>(tree.vpls().size());
        fmt::print("{}\n", row.dump());
        std::fflush(stdout);
      }
    }
  }
}

/// The narrower of two kinds of scene that holds what the file has, as manylight-render takes it.
void run(const Arguments& arguments) {
  scene_file::SceneDescription description = scene_file::load_scene(arguments.scene, {});
  description.camera.width = description.camera.height = arguments.side;
  const bool is_narrow = description.media.empty() && description.subsurfaces.empty() && !description.moves() &&
                         std::all_of(description.materials.begin(), description.materials.end(), SurfaceFileShader::fits);
  if (is_narrow) {
    run<SurfaceFileShader, NoMedia>(description, arguments);
  } else {
    run<FullFileShader, FileMedia>(description, arguments);
  }
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app{"Core-milliseconds per pixel of cuts and of all pairs.", "bench_cuts"};
  app.add_option("scene", arguments.scene, "Scene file, .xml")->required();
  app.add_option("--method", arguments.methods, "lightcuts, bdlc, vpl; repeatable");
  app.add_option("--bounds", arguments.bounds,
                 "automatic, analytic, cube-map, sampled (no bound: a yardstick); repeatable");
  app.add_option("--vpls", arguments.vpls, "Virtual point lights; repeatable");
  app.add_option("--size", arguments.side, "Side of the square image, pixels");
  app.add_option("--tiles", arguments.tiles, "Tiles (single pixels of method vpl)");
  app.add_option("--eye-paths", arguments.eye_paths, "Eye paths per pixel");
  app.add_option("--threshold", arguments.threshold, "Error threshold");
  CLI11_PARSE(app, argc, argv);
  try {
    run(arguments);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench_cuts: {}\n", error.what());
    return 2;
  }
}
