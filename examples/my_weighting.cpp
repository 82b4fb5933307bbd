// SPDX-License-Identifier: Apache-2.0
// A user's own Weighting: virtual lights shine no farther than a given distance.
#include <cmath>
#include <cstdio>

#include "manylight/manylight.hpp"

/// The classical weights, and 0 beyond `reach`. The bounds of the base remain true, since weights only become smaller.
class NearLights : public manylight::StandardWeighting<float> {
 public:
  NearLights(const manylight::WeightingConfig<float>& config, float reach)
      : StandardWeighting(config), least_transit_(1 / (reach * reach)) {}

  [[nodiscard]] float weight(const Record& record, const manylight::PairPatterns<float>& pair) const noexcept {
    return pair.t < least_transit_ ? 0 : StandardWeighting::weight(record, pair);
  }

 private:
  float least_transit_;  ///< T^w at that distance, m^-2
};

static_assert(manylight::Weighting<NearLights>);

int main() {
  using namespace manylight;
  Shapes<float> shapes;
  shapes.spheres = {{.center = {0.7F, -0.5F, 5}, .radius = 0.5F}};
  shapes.disks = {{.center = {0, -1, 5}, .normal = {0, 1, 0}, .radius = 4},
                  {.center = {0, 1.5F, 5}, .normal = {0, -1, 0}, .radius = 0.5F}};
  EmitterList<float> lights;
  lights.areas = {{.shape = 2, .radiance = Rgb<float>(15)}};
  const std::vector<UniformShader<Lambertian<float>>> paints = {{{Rgb<float>(0.7F)}}};
  const Scene scene(Bvh<float>(shapes), paints, {0, 0, 0}, lights);
  const PerspectiveCamera<float> camera({.horizontal_fov = 30, .width = 16, .height = 16});

  const auto filter = ReconstructionFilter<float>::box();
  const IndependentSampler<float> sampler{1};
  const SerialExecutor executor;
  const ManyLightConfig config{.vpls = 2'000, .eye_paths = 4, .threshold = 2e-4, .window = {}};
  const auto side = prepare_lights(scene, camera, filter, config, sampler, executor);
  const LightTree<std::remove_const_t<decltype(scene)>> tree(side.lights.vpls, executor);
  const NearLights weighting(side.weights, 3);
  const auto cuts = render_by_cuts(scene, camera, filter, config, weighting, side, tree, sampler, executor);
  const auto pairs = render_all_pairs(scene, camera, filter, config, weighting, side, sampler, executor);

  double worst = 0, mean = 0;
  for (std::size_t i = 0; i < cuts.image.pixels.size(); ++i) {
    worst = std::max(worst, std::abs(double{cuts.image.pixels[i].x} - double{pairs.image.pixels[i].x}));
    mean += double{pairs.image.pixels[i].x} / static_cast<double>(pairs.image.pixels.size());
  }
  std::printf("mean radiance %.4f, cuts differ from all pairs by at most %.5f\n", mean, worst);
  // The threshold bounds each cluster's error by 0.02 % of a pixel; errors of many clusters have random signs.
  return worst < 0.02 * mean && cuts.statistics.pairs.bound_violations == 0 ? 0 : 1;
}
