// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <utility>
#include <variant>
#include <vector>

#include "manylight/geometry/mesh_builders.hpp"
#include "manylight/integrator/bidirectional_lightcuts.hpp"
#include "manylight/integrator/instant_radiosity.hpp"
#include "manylight/integrator/path.hpp"
#include "manylight/scene/camera.hpp"
#include "support/z_test.hpp"

// Small scenes with known radiance, and one call that renders them by any integrator.

namespace manylight::test {

enum class ShapeKind : std::uint8_t { mesh, sphere, disk };
struct ShapeRef {
  ShapeKind kind = ShapeKind::mesh;
  std::size_t index = 0;
};

/// Collects shapes with one material each and lights; `build` numbers them as Shapes does.
template <Geometry G, Material M>
class SceneBuilder {
 public:
  using S = typename G::Scalar;
  using SceneType = Scene<G, UniformShader<M>>;

  EmitterList<S> lights;

  ShapeRef mesh(TriangleMesh<S> shape, const M& material, bool two_sided = true) {
    return add(ShapeKind::mesh, shapes_.meshes, std::move(shape), material, two_sided);
  }
  ShapeRef sphere(const Sphere<S>& shape, const M& material, bool two_sided = true) {
    return add(ShapeKind::sphere, shapes_.spheres, shape, material, two_sided);
  }
  ShapeRef disk(const Disk<S>& shape, const M& material, bool two_sided = true) {
    return add(ShapeKind::disk, shapes_.disks, shape, material, two_sided);
  }
  void emit(ShapeRef shape, const Rgb<S>& radiance, bool two_sided = false) {
    emissions_.push_back({shape, {0, Texture<S>(radiance), two_sided}});
  }
  void point_light(const Vec3<S>& position, S intensity) { lights.points.push_back({position, Rgb<S>(intensity)}); }

  [[nodiscard]] SceneType build() const {
    std::vector<UniformShader<M>> shaders;
    for (const auto& of_kind : shaders_) shaders.insert(shaders.end(), of_kind.begin(), of_kind.end());
    std::vector<std::uint32_t> ids(shaders.size());
    for (std::size_t i = 0; i < ids.size(); ++i) ids[i] = static_cast<std::uint32_t>(i);
    EmitterList<S> all = lights;
    for (const auto& [shape, area] : emissions_) {
      all.areas.push_back(area);
      all.areas.back().shape = id(shape);
    }
    return SceneType(G(shapes_), shaders, ids, all);
  }

 private:
  template <class List, class Shape>
  ShapeRef add(ShapeKind kind, List& list, Shape&& shape, const M& material, bool two_sided) {
    list.push_back(std::forward<Shape>(shape));
    shaders_[static_cast<std::size_t>(kind)].push_back(UniformShader<M>{material, two_sided});
    return {kind, list.size() - 1};
  }
  [[nodiscard]] std::uint32_t id(ShapeRef shape) const {
    std::size_t first = 0;
    for (std::size_t kind = 0; kind < static_cast<std::size_t>(shape.kind); ++kind) first += shaders_[kind].size();
    return static_cast<std::uint32_t>(first + shape.index);
  }

  Shapes<S> shapes_;
  std::array<std::vector<UniformShader<M>>, 3> shaders_;
  std::vector<std::pair<ShapeRef, AreaEmitter<S>>> emissions_;
};

/// Parallelogram center + [-1,1] u + [-1,1] v; its outer side is along cross(u, v).
template <std::floating_point S>
[[nodiscard]] TriangleMesh<S> parallelogram(const Vec3<S>& center, const Vec3<S>& u, const Vec3<S>& v) {
  const Vec3<S> n = glm::normalize(glm::cross(u, v));
  TriangleMesh<S> mesh;
  mesh.positions = {center - u - v, center + u - v, center + u + v, center - u + v};
  mesh.normals = {n, n, n, n};
  mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  mesh.triangles = {{0, 1, 2}, {2, 3, 0}};
  return mesh;
}

/// Box with the corners lo and hi, normals outward.
template <std::floating_point S>
[[nodiscard]] TriangleMesh<S> box_mesh(const Vec3<S>& lo, const Vec3<S>& hi) {
  using Mat = Mat4<S>;
  Mat m(S(1));
  for (int i = 0; i < 3; ++i) {
    m[i][i] = (hi[i] - lo[i]) / S(2);
    m[3][i] = (hi[i] + lo[i]) / S(2);
  }
  return cube_mesh<S>(m);
}

/// A camera that asks for the radiance leaving chosen points: pixel i looks at `targets[i]` from `from[i]`.
template <std::floating_point S>
struct ProbeCamera {
  using Scalar = S;
  std::vector<Vec3<S>> from;
  std::vector<Vec3<S>> targets;

  void add(const Vec3<S>& target, const Vec3<S>& eye) {
    targets.push_back(target);
    from.push_back(eye);
  }
  [[nodiscard]] Ray<S> ray(const Vec2<S>& film, const Vec2<S>& /*lens*/) const noexcept {
    const auto i = std::min(static_cast<std::size_t>(film.x), targets.size() - 1);
    return {from[i], glm::normalize(targets[i] - from[i])};
  }
  [[nodiscard]] std::uint32_t width() const noexcept { return static_cast<std::uint32_t>(targets.size()); }
  [[nodiscard]] std::uint32_t height() const noexcept { return 1; }
};
static_assert(Camera<ProbeCamera<float>>);

/// A camera that looks at points drawn evenly from center + [-1,1] u + [-1,1] v, each from `above` it: the mean of its
/// only pixel is the area's mean radiance.
template <std::floating_point S>
struct AreaProbe {
  using Scalar = S;
  Vec3<S> center, u, v, above;
  bool is_disk = false;  ///< only the ellipse within

  [[nodiscard]] Ray<S> ray(const Vec2<S>& /*film*/, const Vec2<S>& lens) const noexcept {
    const Vec2<S> p = is_disk ? warp::square_to_disk(lens) : lens * S(2) - Vec2<S>(1);
    return {center + u * p.x + v * p.y + above, glm::normalize(-above)};
  }
  [[nodiscard]] std::uint32_t width() const noexcept { return 1; }
  [[nodiscard]] std::uint32_t height() const noexcept { return 1; }
};
static_assert(Camera<AreaProbe<float>>);

/// One of the cameras of these tests, which must outlive it.
template <std::floating_point S>
class AnyCamera {
 public:
  using Scalar = S;
  template <Camera C>
  AnyCamera(const C& camera) : camera_(&camera) {}

  [[nodiscard]] Ray<S> ray(const Vec2<S>& film, const Vec2<S>& lens) const noexcept {
    return std::visit([&](const auto* c) { return c->ray(film, lens); }, camera_);
  }
  [[nodiscard]] std::uint32_t width() const noexcept {
    return std::visit([](const auto* c) { return c->width(); }, camera_);
  }
  [[nodiscard]] std::uint32_t height() const noexcept {
    return std::visit([](const auto* c) { return c->height(); }, camera_);
  }

 private:
  std::variant<const PerspectiveCamera<S>*, const ProbeCamera<S>*, const AreaProbe<S>*> camera_;
};

template <std::floating_point S>
[[nodiscard]] PerspectiveCamera<S> look_at(const Vec3<S>& eye, const Vec3<S>& target, S fov, std::uint32_t side) {
  const Vec3<S> z = glm::normalize(target - eye);
  const Vec3<S> x = glm::normalize(glm::cross(std::abs(z.y) < S(0.9) ? Vec3<S>(0, 1, 0) : Vec3<S>(1, 0, 0), z));
  PerspectiveConfig<S> config;
  config.to_world[0] = {x, S(0)};
  config.to_world[1] = {glm::cross(z, x), S(0)};
  config.to_world[2] = {z, S(0)};
  config.to_world[3] = {eye, S(1)};
  config.horizontal_fov = fov;
  config.width = config.height = side;
  return PerspectiveCamera<S>(config);
}

enum class Method { path, vpl, lightcuts, bdlc };
inline constexpr std::array<Method, 4> k_methods{Method::path, Method::vpl, Method::lightcuts, Method::bdlc};
[[nodiscard]] inline const char* name(Method method) {
  constexpr std::array<const char*, 4> k_names{"path", "vpl", "lightcuts", "bdlc"};
  return k_names[static_cast<std::size_t>(method)];
}

struct Settings {
  std::uint32_t samples = 8;  ///< per pixel
  std::size_t vpls = 500;
  unsigned max_edges = k_unlimited_edges;
  double clamp_scale = std::numeric_limits<double>::infinity();  ///< no clamp: expectation is the full radiance
  double adaptation = 1;  ///< L_a; 0 runs the pilot, which costs more than these images
  double threshold = 0.02;
  std::uint32_t max_cut = 20000;
  EmitterHits hits = EmitterHits::all;
  std::uint64_t seed = 1;
};

struct Film {
  std::vector<Rgb<double>> pixels;
  std::uint64_t invalid = 0;
  std::uint64_t bound_violations = 0;

  [[nodiscard]] Rgb<double> mean() const {
    Rgb<double> sum(0);
    for (const Rgb<double>& p : pixels) sum += p;
    return sum / static_cast<double>(pixels.size());
  }
};

[[nodiscard]] inline ManyLightConfig many_light_config(const Settings& s) {
  ManyLightConfig config;
  config.vpls = s.vpls;
  config.eye_paths = s.samples;
  config.max_edges = s.max_edges;
  config.threshold = s.threshold;
  config.max_cut = s.max_cut;
  config.adaptation_luminance = s.adaptation;
  config.clamp_scale = s.clamp_scale;
  config.emitter_hits = s.hits;
  return config;
}

template <class SceneType, Camera C, Executor Exec = SerialExecutor>
[[nodiscard]] Film render_paths(const SceneType& scene, const C& camera, const Settings& settings,
                                const Exec& executor = {}) {
  using S = typename SceneType::Scalar;
  const PathIntegrator<SceneType> integrator(scene, PathConfig{settings.max_edges});
  Film film;
  film.pixels.assign(std::size_t{camera.width()} * camera.height(), Rgb<double>(0));
  film.invalid = accumulate_path_samples(integrator, camera, ReconstructionFilter<S>::box(), Window::of(camera),
                                         IndependentSampler<S>{settings.seed}, 0, settings.samples, film.pixels,
                                         executor)
                     .invalid;
  for (Rgb<double>& p : film.pixels) p /= settings.samples;
  return film;
}

template <class SceneType, Executor Exec = SerialExecutor>
[[nodiscard]] Film render(Method method, const SceneType& scene,
                                  const AnyCamera<typename SceneType::Scalar>& camera, const Settings& settings,
                                  const Exec& executor = {}) {
  if (method == Method::path) return render_paths(scene, camera, settings, executor);
  using S = typename SceneType::Scalar;
  const auto filter = ReconstructionFilter<S>::box();
  const IndependentSampler<S> sampler{settings.seed};
  Film film;
  const ManyLightConfig config = many_light_config(settings);
  const auto lights = prepare_lights(scene, camera, filter, config, sampler, executor);
  ManyLightImage<S> result;
  if (method == Method::vpl) {
    result = render_instant_radiosity(scene, camera, filter, config, lights, sampler, executor);
  } else {
    const LightTree<SceneType> tree(lights.lights.vpls, executor);
    result = method == Method::lightcuts
                 ? render_lightcuts(scene, camera, filter, config, lights, tree, sampler, executor)
                 : render_bidirectional_lightcuts(scene, camera, filter, config, lights, tree, sampler, executor);
  }
  for (const Rgb<S>& p : result.image.pixels) film.pixels.emplace_back(p);
  film.invalid = result.statistics.invalid_samples;
  film.bound_violations = result.statistics.pairs.bound_violations;
  return film;
}

/// One probe's moments over `runs` independent renderings: pixels of one rendering share their VPLs, so only whole
/// renderings are independent.
template <class SceneType, Camera C>
[[nodiscard]] std::vector<RunningMoments> repeat(Method method, const SceneType& scene, const C& camera,
                                                 Settings settings, unsigned runs) {
  std::vector<RunningMoments> moments(std::size_t{camera.width()} * camera.height());
  for (unsigned run = 0; run < runs; ++run) {
    ++settings.seed;
    const Film film = render(method, scene, camera, settings);
    for (std::size_t i = 0; i < moments.size(); ++i) moments[i].add(film.pixels[i].x);
  }
  return moments;
}

/// |estimate - exact| within 5 standard errors of a t-variable plus rounding. With 16 runs and 15 degrees of freedom
/// the false-alarm rate is 2e-4 per comparison over all seeds; the seeds are fixed.
[[nodiscard]] inline bool agrees(const RunningMoments& estimate, double exact, double relative_slack) {
  const double slack = relative_slack * std::abs(exact);
  return std::abs(estimate.mean() - exact) <= 5 * estimate.standard_error() + slack;
}

}  // namespace manylight::test
