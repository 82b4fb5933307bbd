// SPDX-License-Identifier: Apache-2.0
#pragma once

// The adaptation luminance L_a of [Walter 2012, Eq. 6]: "the brightness of a mid-grey surface" in this view, by a coarse
// pilot (theory sheet, section 3.2): the log-average luminance of a grid of film points lit by standard virtual point
// lights. C_clamp = L_a / (800 I_avg) then removes only what stays invisible.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "manylight/integrator/film.hpp"
#include "manylight/many_light/vpl_set.hpp"
#include "manylight/path/transfer.hpp"

namespace manylight {

/// exp(mean log(eps + y)) with eps = 1e-4 of the mean; 0 if all are 0.
[[nodiscard]] inline double log_average(const std::vector<double>& luminances) {
  double mean = 0;
  for (const double y : luminances) mean += y;
  if (!(mean > 0)) return 0;
  mean /= static_cast<double>(luminances.size());
  double sum = 0;
  for (const double y : luminances) sum += std::log(1e-4 * mean + y);
  return std::exp(sum / static_cast<double>(luminances.size()));
}

namespace detail {

/// Draws VPLs with probability proportional to their luminance.
template <class Scene>
class VplPicker {
 public:
  explicit VplPicker(const std::vector<VertexOf<Scene>>& vpls) : vpls_(vpls) {
    cumulative_.reserve(vpls.size());
    for (const auto& v : vpls) cumulative_.push_back(total() + static_cast<double>(luminance(v.strength)));
  }
  [[nodiscard]] double total() const noexcept { return cumulative_.empty() ? 0.0 : cumulative_.back(); }
  [[nodiscard]] const VertexOf<Scene>& pick(double u) const noexcept {
    const auto it = std::upper_bound(cumulative_.begin(), cumulative_.end(), u * total());
    return vpls_[static_cast<std::size_t>(std::min(it, cumulative_.end() - 1) - cumulative_.begin())];
  }

 private:
  const std::vector<VertexOf<Scene>>& vpls_;
  std::vector<double> cumulative_;
};

/// Luminance of one eye sample lit by `count` picked VPLs, emitters that it sees left out.
template <class Scene, SampleStream Stream>
struct PilotVisitor {
  using S = typename Scene::Scalar;
  const Scene& scene;
  const StandardWeighting<S>& weighting;
  const VplPicker<Scene>& picker;
  Stream& stream;
  RayCounts& rays;
  unsigned max_edges;
  unsigned count;
  double sum = 0;
  bool meets_surface = false;
  std::uint32_t instant = 0;

  void emission(const Rgb<S>&) const noexcept {}
  void sensor(Sensor<Scene, StandardWeighting<S>> vps) {
    meets_surface = true;
    if constexpr (Scene::k_moves) vps.vertex.instant = static_cast<InstantId>(instant);
    for (unsigned i = 0; i < count; ++i) {
      const VertexOf<Scene>& light = picker.pick(static_cast<double>(stream.next()));
      const auto transfer =
          unoccluded_transfer<Scene>(weighting, vps, light, scene.emitters().scene_radius(), max_edges);
      if (is_black(transfer.value)) continue;
      const S probability = static_cast<S>(luminance(light.strength) / static_cast<S>(picker.total()));
      std::uint64_t seed = 0;
      if constexpr (Scene::k_has_media) seed = random_bits(stream);
      typename Scene::Passed passed(1);
      if (!vps.vertex.is_inner()) passed = scene.visibility(shadow_ray<Scene>(vps.vertex, light, seed), rays);
      const Rgb<S> value = vps.vertex.strength * transfer.value * light.strength * passed /
                           (probability * static_cast<S>(count));
      if (is_valid_radiance(value)) sum += static_cast<double>(luminance(value));
    }
  }
};

}  // namespace detail

/// L_a of a view, W/m^2/sr; 0 where nothing is lit (the caller falls back to 1). 32 x 32 film points, 4 eye samples each,
/// 64 VPLs per sample.
template <class Scene, Camera C, Sampler Random, Executor Exec>
[[nodiscard]] double adaptation_luminance(const Scene& scene, const C& camera,
                                          const ReconstructionFilter<typename Scene::Scalar>& filter,
                                          const std::vector<VertexOf<Scene>>& vpls, unsigned max_edges,
                                          const Random& sampler, const Exec& executor, RayCounts& rays) {
  using S = typename Scene::Scalar;
  using Stream = decltype(sampler.stream(Stage::pilot, 0, 0));
  constexpr std::uint32_t k_grid = 32;
  constexpr std::uint32_t k_eye_samples = 4;
  constexpr unsigned k_vpls = 64;
  const detail::VplPicker<Scene> picker(vpls);
  if (!(picker.total() > 0)) return 0;
  // A provisional clamp keeps corners from outshining the rest: M T D of two facing diffuse patches at 5 % of the radius.
  const S near = S(0.05) * scene.emitters().scene_radius();
  const StandardWeighting<S> weighting(WeightingConfig<S>{sqr(k_inv_pi<S> / near)});
  // Points that see only the background stay out (negative): as black ones they would pull the log average to its floor.
  std::vector<double> luminances(k_grid * k_grid, -1);
  std::vector<RayCounts> row_rays(k_grid);
  executor.for_each_index(k_grid, [&](std::size_t row) {
    for (std::uint32_t column = 0; column < k_grid; ++column) {
      const std::size_t point = row * k_grid + column;
      const std::uint32_t x = (2 * column + 1) * camera.width() / (2 * k_grid);
      const auto y = static_cast<std::uint32_t>((2 * row + 1) * camera.height() / (2 * k_grid));
      double sum = 0;
      bool meets_surface = false;
      for (std::uint32_t i = 0; i < k_eye_samples; ++i) {
        Stream stream = sampler.stream(Stage::pilot, point, i);
        const std::uint32_t instant = sample_instant(instant_count(scene), sampler, point, i);
        const auto& now = at_instant(scene, instant);
        const Ray<S> ray = camera_ray(at_instant(camera, instant), filter, x, y, stream);
        detail::PilotVisitor<Scene, Stream> visitor{scene, weighting, picker, stream, row_rays[row], max_edges, k_vpls};
        visitor.instant = instant;
        EyeSubpath<std::remove_cvref_t<decltype(now)>, StandardWeighting<S>, Stream, decltype(visitor)>(
            now, weighting, max_edges, stream, row_rays[row], visitor)
            .trace(ray, S(1));
        sum += visitor.sum / k_eye_samples;
        meets_surface = meets_surface || visitor.meets_surface;
      }
      if (meets_surface) luminances[point] = sum;
    }
  });
  for (const RayCounts& count : row_rays) rays += count;
  std::erase_if(luminances, [](double y) { return y < 0; });
  return log_average(luminances);
}

}  // namespace manylight
