// SPDX-License-Identifier: Apache-2.0
// A user's own Material: lunar dust after Lommel and Seeliger, brighter towards the rim than a Lambertian ball. Nothing
// but the struct is needed for every method; here it is rendered by bidirectional lightcuts beside path tracing.
#include <cmath>
#include <cstdio>

#include "manylight/manylight.hpp"

using manylight::Rgb;
using manylight::Vec3;

/// f = w / (4 pi (cos_i + cos_o)): single isotropic scattering in an opaque layer of dust.
struct LunarDust {
  using Scalar = float;
  static constexpr bool k_isotropic = true;  // vertices store a normal instead of a frame
  Rgb<float> single_albedo{0.9F};            ///< w, what one grain scatters of the light it meets, [0, 1]

  [[nodiscard]] Rgb<float> eval(const Vec3<float>& wi, const Vec3<float>& wo) const noexcept {
    if (!(wi.z > 0 && wo.z > 0)) return Rgb<float>(0);
    return single_albedo * (manylight::k_inv_pi<float> / (4 * (wi.z + wo.z)));
  }
  [[nodiscard]] std::optional<manylight::DirectionSample<float>> sample(const Vec3<float>& known, manylight::Walk, float,
                                                                        const manylight::Vec2<float>& u) const noexcept {
    if (!(known.z > 0)) return std::nullopt;
    const Vec3<float> w = manylight::warp::square_to_cosine_hemisphere(u);
    return manylight::DirectionSample<float>{w, manylight::warp::cosine_hemisphere_pdf(w), false, Rgb<float>(0)};
  }
  [[nodiscard]] float pdf(const Vec3<float>& known, const Vec3<float>& sampled, manylight::Walk) const noexcept {
    return known.z > 0 ? manylight::warp::cosine_hemisphere_pdf(sampled) : 0;
  }
  /// At normal incidence the integral of f cos_i is w (1 - log 2) / 2.
  [[nodiscard]] Rgb<float> albedo() const noexcept { return single_albedo * 0.15342641F; }
  [[nodiscard]] static constexpr bool is_delta() noexcept { return false; }
};

static_assert(manylight::Material<LunarDust>);

int main() {
  using namespace manylight;
  Shapes<float> shapes;
  shapes.spheres = {{.center = {0, 0, 5}}};
  shapes.disks = {{.center = {0, -1, 5}, .normal = {0, 1, 0}, .radius = 6}};
  EmitterList<float> lights;
  lights.directionals = {{.direction = {0.5F, -1, 1}, .irradiance = Rgb<float>(10)}};
  const std::vector<UniformShader<LunarDust>> shaders(1);
  const Scene scene(Bvh<float>(shapes), shaders, {0, 0}, lights);
  const PerspectiveCamera<float> camera({.horizontal_fov = 30, .width = 32, .height = 32});

  const auto filter = ReconstructionFilter<float>::box();
  const IndependentSampler<float> sampler{1};
  const SerialExecutor executor;
  const ManyLightConfig config{.vpls = 5'000, .eye_paths = 16};
  const auto side = prepare_lights(scene, camera, filter, config, sampler, executor);
  const LightTree<std::remove_const_t<decltype(scene)>> tree(side.lights.vpls, executor);
  const auto cuts = render_bidirectional_lightcuts(scene, camera, filter, config, side, tree, sampler, executor);

  std::vector<Rgb<double>> sums(32 * 32, Rgb<double>(0));
  accumulate_path_samples(PathIntegrator(scene, PathConfig{}), camera, filter, Window::of(camera), sampler, 0, 256, sums,
                          executor);

  double by_cuts = 0, by_paths = 0;
  for (std::size_t i = 0; i < sums.size(); ++i) {
    by_cuts += static_cast<double>(cuts.image.pixels[i].x) / 1024;
    by_paths += sums[i].x / 256 / 1024;
  }
  std::printf("mean radiance: bidirectional lightcuts %.4f, path tracing %.4f\n", by_cuts, by_paths);
  // 0.3 % is the standard error of 256 path samples in 1024 pixels, and 5,000 VPLs and the cuts leave about as much.
  return std::abs(by_cuts / by_paths - 1) < 0.01 ? 0 : 1;
}
