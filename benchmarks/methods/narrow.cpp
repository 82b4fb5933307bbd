// SPDX-License-Identifier: Apache-2.0
// What a diffuse scene costs when its type knows that it is diffuse, against a type that also knows gloss, glass, opacity,
// media and subsurface scattering: processor time per pixel of path, lightcuts and bdlc, bytes per VPL; both render the same
// room in turn, several times. The object code of both is told apart by their shaders' names:
//
//   bench_narrow [REPETITIONS]
//   nm -CS -t d bench_narrow | awk '/WideShader/ {w += $2} /NarrowShader/ {n += $2} END {print n, w, w / n}'

#include <ctime>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "manylight/geometry/bvh.hpp"
#include "manylight/geometry/mesh_builders.hpp"
#include "manylight/integrator/bidirectional_lightcuts.hpp"
#include "manylight/integrator/path.hpp"
#include "manylight/media/any_medium.hpp"
#include "manylight/media/heterogeneous.hpp"
#include "manylight/media/homogeneous.hpp"
#include "manylight/scattering/any_of.hpp"
#include "manylight/scattering/conductor.hpp"
#include "manylight/scattering/dielectric.hpp"
#include "manylight/scattering/falloff_profiles.hpp"
#include "manylight/scattering/henyey_greenstein.hpp"
#include "manylight/scattering/lambertian.hpp"
#include "manylight/scattering/phong.hpp"
#include "manylight/scattering/subsurface.hpp"
#include "manylight/scattering/ward.hpp"
#include "manylight/scene/camera.hpp"

namespace {

using namespace manylight;
using S = float;
using V = Vec3<S>;

struct NarrowShader {
  using Material = Lambertian<S>;
  static constexpr bool k_may_be_transparent = false;
  static constexpr bool k_may_absorb = false;
  Material surface;
  [[nodiscard]] Material material(const SurfacePoint<S>&, bool) const noexcept { return surface; }
  [[nodiscard]] bool is_two_sided() const noexcept { return true; }
};
struct WideShader {
  using Material = AnyOf<Lambertian<S>, Phong<S>, Ward<S>, RoughConductor<S>, Dielectric<S>>;
  using Subsurface = manylight::Subsurface<ExponentialFalloff<S>>;
  static constexpr bool k_may_be_transparent = true;
  static constexpr bool k_may_absorb = true;
  Lambertian<S> surface;
  [[nodiscard]] Material material(const SurfacePoint<S>&, bool) const noexcept { return surface; }
  [[nodiscard]] bool is_two_sided() const noexcept { return true; }
  [[nodiscard]] bool is_transparent() const noexcept { return false; }
  [[nodiscard]] S opacity(const SurfacePoint<S>&) const noexcept { return 1; }
  [[nodiscard]] Rgb<S> interior_absorption() const noexcept { return Rgb<S>(0); }
  [[nodiscard]] const Subsurface* subsurface() const noexcept { return nullptr; }
};
using WideMedium = AnyMedium<Homogeneous<HenyeyGreenstein<S>>, Heterogeneous<HenyeyGreenstein<S>>>;
using NarrowScene = Scene<Bvh<S>, NarrowShader>;
using WideScene = Scene<Bvh<S>, WideShader, SceneMedia<WideMedium>>;

/// A room with 60 boxes and a ceiling light.
template <class SceneType, class Media>
SceneType room(const Media& media) {
  Shapes<S> shapes;
  const auto box = [&](const V& lo, const V& hi, bool inwards) {
    Mat4<S> m(S(1));
    for (int i = 0; i < 3; ++i) {
      m[i][i] = (hi[i] - lo[i]) / S(2);
      m[3][i] = (hi[i] + lo[i]) / S(2);
    }
    TriangleMesh<S> mesh = cube_mesh<S>(m);
    mesh.flip_normals = inwards;
    shapes.meshes.push_back(std::move(mesh));
  };
  box(V(-2, -2, 0), V(2, 2, 3), true);
  auto stream = IndependentSampler<S>{5}.stream(Stage::test, 0);
  for (int i = 0; i < 60; ++i) {
    const V at(4 * stream.next() - 2, 4 * stream.next() - 2, 0);
    box(at - V(0.1F, 0.1F, 0), at + V(0.1F, 0.1F, 0.1F + 0.5F * stream.next()), false);
  }
  box(V(-0.5F, -0.5F, 2.9F), V(0.5F, 0.5F, 2.95F), false);
  EmitterList<S> lights;
  lights.areas.push_back({static_cast<std::uint32_t>(shapes.meshes.size() - 1), Texture<S>(Rgb<S>(8)), false});
  using Shader = typename SceneType::ShaderType;
  Shader shader{};
  shader.surface = Lambertian<S>{Rgb<S>(0.6F)};
  std::vector<std::uint32_t> ids(shapes.meshes.size(), 0);
  return SceneType(Bvh<S>(shapes), std::vector<Shader>{shader}, ids, lights, media);
}

double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Times {
  double path, lightcuts, bdlc;  // ms per pixel
};
template <class SceneType>
Times render_all(const SceneType& scene, double& sum) {
  PerspectiveConfig<S> config;
  config.to_world[0] = {-1, 0, 0, 0};
  config.to_world[1] = {0, 0, 1, 0};
  config.to_world[2] = {0, 1, 0, 0};
  config.to_world[3] = {0.1F, -1.95F, 1.6F, 1};
  config.horizontal_fov = 75;
  config.width = config.height = 24;
  const PerspectiveCamera<S> camera(config);
  const auto filter = ReconstructionFilter<S>::box();
  const IndependentSampler<S> sampler{1};
  const double pixels = config.width * config.height;
  Times times{};
  double start = thread_seconds();
  std::vector<Rgb<double>> sums(static_cast<std::size_t>(pixels), Rgb<double>(0));
  (void)accumulate_path_samples(PathIntegrator(scene, PathConfig{}), camera, filter, Window::of(camera), sampler, 0, 64,
                                sums, SerialExecutor{});
  times.path = 1e3 * (thread_seconds() - start) / pixels;
  for (const Rgb<double>& p : sums) sum += p.x;
  ManyLightConfig many;
  many.vpls = 100000;
  many.eye_paths = 16;
  many.adaptation_luminance = 1;
  const LightSide<SceneType> side = prepare_lights(scene, camera, filter, many, sampler, SerialExecutor{});
  const LightTree<SceneType> tree(side.lights.vpls, SerialExecutor{});
  start = thread_seconds();
  const auto cuts = render_lightcuts(scene, camera, filter, many, side, tree, sampler, SerialExecutor{});
  times.lightcuts = 1e3 * (thread_seconds() - start) / pixels;
  start = thread_seconds();
  const auto bdlc = render_bidirectional_lightcuts(scene, camera, filter, many, side, tree, sampler, SerialExecutor{});
  sum += static_cast<double>(cuts.image.pixels[0].x + bdlc.image.pixels[0].x);
  times.bdlc = 1e3 * (thread_seconds() - start) / pixels;
  return times;
}

template <double Times::*Member>
void report(const char* name, const std::vector<Times>& narrow, const std::vector<Times>& wide) {
  std::vector<double> ratios, times;
  for (std::size_t i = 0; i < narrow.size(); ++i) {
    ratios.push_back(wide[i].*Member / narrow[i].*Member);
    times.push_back(narrow[i].*Member);
  }
  std::sort(ratios.begin(), ratios.end());
  std::sort(times.begin(), times.end());
  const std::size_t middle = ratios.size() / 2;
  std::printf("%-10s narrow %.3f core-ms per pixel, wide / narrow %.3f (%.3f to %.3f)\n", name, times[middle],
              ratios[middle], ratios.front(), ratios.back());
}

}  // namespace

int main(int argc, char** argv) {
  const int repetitions = argc > 1 ? std::max(1, std::atoi(argv[1])) : 7;
  const auto narrow = room<NarrowScene>(NoMedia{});
  const auto wide = room<WideScene>(SceneMedia<WideMedium>({}, {}));
  std::vector<Times> of_narrow, of_wide;
  double sum = 0;
  for (int i = 0; i < repetitions; ++i) {
    of_narrow.push_back(render_all(narrow, sum));
    of_wide.push_back(render_all(wide, sum));
  }
  std::printf("bytes per VPL without tree: narrow %zu, wide %zu (checksum %g)\n", sizeof(VertexOf<NarrowScene>),
              sizeof(VertexOf<WideScene>), sum);
  report<&Times::path>("path", of_narrow, of_wide);
  report<&Times::lightcuts>("lightcuts", of_narrow, of_wide);
  report<&Times::bdlc>("bdlc", of_narrow, of_wide);
}
