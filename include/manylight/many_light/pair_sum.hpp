// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstdint>
#include <vector>

#include "manylight/path/transfer.hpp"

namespace manylight {

/// What summing a pixel's pairs cost.
struct PairStatistics {
  std::uint64_t pairs = 0;            ///< pairs evaluated (w M T D, before visibility)
  std::uint64_t cut_size = 0;         ///< clusters in the final cut; all pairs for brute force
  std::uint64_t invalid = 0;          ///< pairs that were not finite and were dropped
  std::uint64_t bound_violations = 0; ///< pairs found above their bound; always 0 unless a bound is wrong
  double error_bound = 0;             ///< sum of the cut's error bounds, luminance: a guarantee, mostly far from sharp
  bool capped = false;                ///< the maximum cut ended the refinement
  RayCounts rays;

  PairStatistics& operator+=(const PairStatistics& other) noexcept {
    pairs += other.pairs;
    cut_size += other.cut_size;
    invalid += other.invalid;
    bound_violations += other.bound_violations;
    error_bound += other.error_bound;
    capped = capped || other.capped;
    rays += other.rays;
    return *this;
  }
};

/// A pixel's sum over all (sensor, light) pairs, double precision, W/m^2/sr.
struct PairSumResult {
  Rgb<double> radiance{0};
  PairStatistics statistics;
};

/// Brute force: every pair, in order; shadow rays in batches. The oracle of every other pair sum.
template <class Scene, class W>
class BruteForceSum {
  static_assert(Weighting<W>,
                "manylight::BruteForceSum: the weighting must model Weighting: Scalar, Record, start, extend, "
                "extend_delta, weight, hit_weight, binding, hit_binding, takes_hits, prune, prune_delta, limit, "
                "clamp, light_limit");

 public:
  using S = typename Scene::Scalar;

  BruteForceSum(const Scene& scene, const W& weighting, const std::vector<VertexOf<Scene>>& vpls, unsigned max_edges)
      : scene_(scene), weighting_(weighting), vpls_(vpls), max_edges_(max_edges) {}

  /// `key`: any number of the pixel's own; draws the transmittance of media.
  [[nodiscard]] PairSumResult operator()(const std::vector<Sensor<Scene, W>>& sensors, const Rgb<double>& /*known*/,
                                         std::uint64_t key) const {
    PairSumResult result;
    Batch batch;
    std::uint64_t seed = mix_bits(key);
    for (const Sensor<Scene, W>& sensor : sensors) {
      for (const VertexOf<Scene>& light : vpls_) {
        ++result.statistics.pairs;
        const Transfer<S> transfer =
            unoccluded_transfer<Scene>(weighting_, sensor, light, scene_.emitters().scene_radius(), max_edges_);
        if (!transfer.is_valid) ++result.statistics.invalid;
        if (is_black(transfer.value)) continue;
        if (sensor.vertex.is_inner()) {  // through the object, no shadow ray
          result.radiance += Rgb<double>(sensor.vertex.strength * transfer.value * light.strength);
          continue;
        }
        batch.rays.push_back(shadow_ray<Scene>(sensor.vertex, light, ++seed));
        batch.values.push_back(sensor.vertex.strength * transfer.value * light.strength);
        if (batch.rays.size() == k_batch) flush(batch, result);
      }
    }
    flush(batch, result);
    result.statistics.cut_size = result.statistics.pairs;
    return result;
  }

 private:
  static constexpr std::size_t k_batch = 256;
  struct Batch {
    std::vector<typename Scene::ShadowRay> rays;
    std::vector<Rgb<S>> values;
    std::vector<typename Scene::Passed> visible;
  };

  void flush(Batch& batch, PairSumResult& result) const {
    batch.visible.resize(batch.rays.size());
    scene_.visibility(batch.rays, batch.visible, result.statistics.rays);
    for (std::size_t i = 0; i < batch.rays.size(); ++i) result.radiance += Rgb<double>(batch.values[i] * batch.visible[i]);
    batch.rays.clear();
    batch.values.clear();
  }

  const Scene& scene_;
  const W& weighting_;
  const std::vector<VertexOf<Scene>>& vpls_;
  unsigned max_edges_;
};

}  // namespace manylight
