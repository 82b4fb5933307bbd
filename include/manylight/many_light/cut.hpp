// SPDX-License-Identifier: Apache-2.0
#pragma once

// Multidimensional lightcuts [Walter 2006, section 4]: one cut through the product graph of a pixel's gather tree and the
// light trees. Each cluster pair is estimated by one representative pair and carries a bound of its error; the worst is
// split until no bound exceeds a fraction of the pixel's total.
//
//   symbol        here                      symbol        here
//   S_C, I_L      GatherNode, LightNode     UB(C, L)      pair_bound, PairBounds
//   s*, l*        Cluster::sensor, vpl      eps, floor    CutConfig
//
// Departure: the paper keeps one representative per gather node. Then all light clusters that meet an unsplit gather node
// see the same sensor, and their errors, each below the threshold, add up with one sign: pixels in the corner of three
// walls came out at a third of their value. Here every new cluster pair draws its own sensor; a split still hands the
// parent's pair to exactly one child, so that it costs one new evaluation.
//
// Work goes by small batches of the worst clusters: their nodes, bounds, VPLs and shadow rays are independent of each
// other, so that memory is asked for ahead, bounds are computed in packs and rays are traced together. A batch costs at
// most its size in splits too many. How a cluster will be split is settled when it enters the cut and its nodes are at hand.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "manylight/core/error.hpp"
#include "manylight/many_light/cut_parts.hpp"
#include "manylight/many_light/gather_tree.hpp"
#include "manylight/many_light/light_tree.hpp"
#include "manylight/many_light/pair_bound.hpp"
#include "manylight/many_light/pair_sum.hpp"

namespace manylight {

struct CutConfig {
  double threshold = 0.02;        ///< eps: largest bound of a cluster's error relative to the pixel's luminance, [0, 1]
  std::uint32_t max_cut = 20000;  ///< clusters at which refinement stops and the pixel counts as capped, >= 1
  double floor = 0;               ///< luminance below which errors do not matter, W/m^2/sr

  /// Throws ParameterError.
  void validate() const {
    require(threshold >= 0 && threshold <= 1, "cut threshold", threshold, "[0, 1]");
    require(max_cut >= 1, "maximum cut", max_cut, "at least 1");
    require(floor >= 0 && std::isfinite(floor), "cut floor", floor, "finite, at least 0");
  }
};

/// A pair sum by cuts; keeps its memory from pixel to pixel. `B` bounds the materials of sensors.
template <class Scene, class W, PatternBounds<typename Scene::Material> B = AutomaticBounds>
class CutSum {
  static_assert(Weighting<W>,
                "manylight::CutSum: the weighting must model Weighting: Scalar, Record, start, extend, extend_delta, weight, "
                "hit_weight, binding, hit_binding, takes_hits, prune, prune_delta, limit, clamp, light_limit");

 public:
  using S = typename Scene::Scalar;

  CutSum(const Scene& scene, const W& weighting, const LightTree<Scene>& lights, unsigned max_edges,
         const CutConfig& config, const B& bounds = {})
      : scene_(scene),
        weighting_(weighting),
        lights_(lights),
        limits_{weighting.light_limit(), weighting.clamp(), scene.emitters().scene_radius()},
        max_edges_(max_edges),
        config_(config),
        bounds_(bounds),
        parts_(gather_, lights) {
    config.validate();
  }
  CutSum(const CutSum&) = delete;  // parts_ refers to gather_
  CutSum& operator=(const CutSum&) = delete;

  /// Sum over all pairs of `sensors` and lights. `known`: radiance that the pixel has already, part of the total that
  /// errors are measured against. `key`: seeds the representatives, a function of the pixel.
  [[nodiscard]] PairSumResult operator()(const std::vector<Sensor<Scene, W>>& sensors, const Rgb<double>& known,
                                         std::uint64_t key);

 private:
  /// Clusters split together: enough to hide a memory access, few against a cut.
  static constexpr std::size_t k_batch = 16;

  /// A cluster pair of the cut.
  struct Cluster {
    Rgb<S> unit{0};        ///< w M T D of s*, l* with their colours: estimate per unit of the clusters' luminances
    ClusterPair<S> pair;   ///< (C, L)
    std::uint32_t sensor;  ///< s*, place in the gather tree's leaf order
    std::uint32_t vpl;     ///< l*, place in the light tree's leaf order
  };
  /// A new cluster whose representative waits to be evaluated.
  struct Pending {
    std::uint32_t cluster;
    S bound;   ///< UB
    S error;   ///< of the cluster, see pair_error
    double u;  ///< picks l*
  };

  [[nodiscard]] static Rgb<double> estimate(const Cluster& c) noexcept {
    return Rgb<double>(c.unit) * static_cast<double>(c.pair.scale);
  }
  [[nodiscard]] std::size_t cut_size() const noexcept { return heap_.size() + settled_count_; }

  void start(const std::vector<Sensor<Scene, W>>& sensors, const Rgb<double>& known, std::uint64_t key);
  [[nodiscard]] bool take_worst();
  void split_batch();
  void split(std::uint32_t cluster);
  void place_parts();
  void inherit(const CutPart<S>& part);
  void open(const CutPart<S>& part);
  void evaluate_pending();
  void place(std::uint32_t cluster, S error);

  const Scene& scene_;
  const W& weighting_;
  const LightTree<Scene>& lights_;
  PairLimits<S> limits_;
  unsigned max_edges_;
  CutConfig config_;
  B bounds_;

  GatherTree<Scene, W> gather_;
  std::vector<Cluster> clusters_;
  std::vector<CutCandidate<S>> heap_;  ///< clusters that may be split
  std::size_t settled_count_ = 0;      ///< clusters without error
  Rgb<double> settled_{0};             ///< their sum
  Rgb<double> total_{0};               ///< of everything, `known` included
  std::vector<std::uint32_t> batch_;
  CutParts<Scene, W> parts_;
  std::vector<Pending> pending_;
  std::vector<typename Scene::ShadowRay> rays_;
  std::vector<typename Scene::Passed> visible_;
  std::uint64_t key_ = 0;
  PairStatistics statistics_;
};

template <class Scene, class W, PatternBounds<typename Scene::Material> B>
PairSumResult CutSum<Scene, W, B>::operator()(const std::vector<Sensor<Scene, W>>& sensors, const Rgb<double>& known,
                                           std::uint64_t key) {
  statistics_ = {};
  if (sensors.empty()) return {};
  start(sensors, known, key);
  while (take_worst()) split_batch();
  // Summed afresh: the running total has lost small terms under large early estimates.
  PairSumResult result;
  result.radiance = settled_;
  for (const CutCandidate<S>& candidate : heap_) {
    result.radiance += estimate(clusters_[candidate.cluster]);
    statistics_.error_bound += static_cast<double>(candidate.error);
  }
  statistics_.cut_size = cut_size();
  result.statistics = statistics_;
  return result;
}

/// The coarsest cut: every pair of roots.
template <class Scene, class W, PatternBounds<typename Scene::Material> B>
void CutSum<Scene, W, B>::start(const std::vector<Sensor<Scene, W>>& sensors, const Rgb<double>& known,
                             std::uint64_t key) {
  key_ = mix_bits(key);
  gather_.build(sensors, weighting_, bounds_);
  clusters_.clear();
  heap_.clear();
  pending_.clear();
  settled_count_ = 0;
  settled_ = Rgb<double>(0);
  total_ = known;
  for (const std::uint32_t sensor_root : gather_.roots()) {
    for (const std::uint32_t light_root : lights_.roots()) {
      if constexpr (VertexOf<Scene>::k_has_channels) {
        if (parts_.channel(sensor_root) != lights_.channel(light_root)) continue;
      }
      parts_.add(CutPart<S>::k_new, sensor_root, light_root);
    }
  }
  place_parts();
}

/// Moves the worst clusters above the allowed error from the heap to the batch; false if there are none.
template <class Scene, class W, PatternBounds<typename Scene::Material> B>
bool CutSum<Scene, W, B>::take_worst() {
  batch_.clear();
  const double allowed = config_.threshold * std::max(luminance(total_), config_.floor);
  const std::size_t size = cut_size();
  while (batch_.size() < k_batch && !heap_.empty() && heap_.front().error > allowed) {
    if (size + batch_.size() >= config_.max_cut) {
      statistics_.capped = batch_.empty();
      break;
    }
    std::pop_heap(heap_.begin(), heap_.end());
    batch_.push_back(heap_.back().cluster);
    heap_.pop_back();
  }
  return !batch_.empty();
}

template <class Scene, class W, PatternBounds<typename Scene::Material> B>
void CutSum<Scene, W, B>::split_batch() {
  for (const std::uint32_t cluster : batch_) parts_.prefetch(clusters_[cluster].pair);
  for (const std::uint32_t cluster : batch_) split(cluster);
  place_parts();
}

/// Replaces a cluster by two: one keeps its representative pair (and its slot), the other draws a new one.
template <class Scene, class W, PatternBounds<typename Scene::Material> B>
void CutSum<Scene, W, B>::split(std::uint32_t cluster) {
  const Cluster& c = clusters_[cluster];
  const ClusterPair<S>& p = c.pair;
  total_ -= estimate(c);
  const std::uint32_t heir = p.splits_gather ? gather_.inheriting_child(p.gather, c.sensor)
                                             : lights_.inheriting_child(p.children, c.vpl);
  for (const std::uint32_t child : p.children) {
    const std::uint32_t slot = child == heir ? cluster : CutPart<S>::k_new;
    parts_.add(slot, p.splits_gather ? child : p.gather, p.splits_gather ? p.light : child);
  }
}

/// Puts all parts into the cut.
template <class Scene, class W, PatternBounds<typename Scene::Material> B>
void CutSum<Scene, W, B>::place_parts() {
  for (const CutPart<S>& part : parts_.evaluate(limits_)) {
    if (part.cluster == CutPart<S>::k_new) {
      open(part);
    } else {
      inherit(part);
    }
  }
  parts_.clear();
  // The front of the heap is close to the next batch, and shadow rays will give the memory time to answer.
  const std::size_t next = std::min(k_batch, heap_.size());
  for (std::size_t i = 0; i < next; ++i) parts_.prefetch(clusters_[heap_[i].cluster].pair);
  evaluate_pending();
}

template <class Scene, class W, PatternBounds<typename Scene::Material> B>
void CutSum<Scene, W, B>::inherit(const CutPart<S>& part) {
  Cluster& c = clusters_[part.cluster];
  c.pair = part.pair;
  total_ += estimate(c);
  place(part.cluster, part.error);
}

template <class Scene, class W, PatternBounds<typename Scene::Material> B>
void CutSum<Scene, W, B>::open(const CutPart<S>& part) {
  if (!(part.bound > S(0))) {
    ++settled_count_;
    return;
  }
  Cluster c{};
  c.pair = part.pair;
  const std::uint64_t random = mix_bits(key_ ^ ((std::uint64_t{c.pair.gather} << 32) | c.pair.light));
  c.sensor = gather_.representative(c.pair.gather, to_unit_interval<double>(static_cast<std::uint32_t>(random >> 32)));
  const auto u = to_unit_interval<double>(static_cast<std::uint32_t>(random));
  lights_.prefetch_representative(c.pair.light, u);
  pending_.push_back({static_cast<std::uint32_t>(clusters_.size()), part.bound, part.error, u});
  clusters_.push_back(c);
}

/// Draws and evaluates the representatives of all new clusters, with one batch of shadow rays, and puts them into the cut.
template <class Scene, class W, PatternBounds<typename Scene::Material> B>
void CutSum<Scene, W, B>::evaluate_pending() {
  for (const Pending& pending : pending_) {
    Cluster& c = clusters_[pending.cluster];
    c.vpl = lights_.representative(c.pair.light, pending.u);
    lights_.prefetch_vpl(c.vpl);
  }
  rays_.clear();
  for (const Pending& pending : pending_) {
    Cluster& c = clusters_[pending.cluster];
    const Sensor<Scene, W>& sensor = gather_.sensor_of_leaf(c.sensor);
    const VertexOf<Scene>& light = lights_.vpls()[c.vpl];
    const Transfer<S> transfer =
        unoccluded_transfer<Scene>(weighting_, sensor, light, scene_.emitters().scene_radius(), max_edges_);
    if (!transfer.is_valid) ++statistics_.invalid;
    if (is_black(transfer.value)) continue;
    if (max_channel(transfer.value) > pending.bound * S(1.00001)) ++statistics_.bound_violations;  // rounding of products
    c.unit = transfer.value * (sensor.vertex.strength / luminance(sensor.vertex.strength)) *
             (light.strength / luminance(light.strength));
    if (sensor.vertex.is_inner()) continue;  // through the object, no shadow ray
    // A pair that is met again must find the same transmittance.
    rays_.push_back(shadow_ray<Scene>(sensor.vertex, light, key_ ^ mix_bits((std::uint64_t{c.sensor} << 32) | c.vpl)));
  }
  statistics_.pairs += pending_.size();
  visible_.resize(rays_.size());
  scene_.visibility(rays_, visible_, statistics_.rays);
  std::size_t ray = 0;
  for (const Pending& pending : pending_) {
    Cluster& c = clusters_[pending.cluster];
    if (!is_black(c.unit)) {
      if (!gather_.sensor_of_leaf(c.sensor).vertex.is_inner()) c.unit *= visible_[ray++];
      total_ += estimate(c);
    }
    place(pending.cluster, pending.error);
  }
  pending_.clear();
}

template <class Scene, class W, PatternBounds<typename Scene::Material> B>
void CutSum<Scene, W, B>::place(std::uint32_t cluster, S error) {
  if (error > S(0)) {
    heap_.push_back({error, cluster});
    std::push_heap(heap_.begin(), heap_.end());
  } else {
    ++settled_count_;
    settled_ += estimate(clusters_[cluster]);
  }
}

}  // namespace manylight

