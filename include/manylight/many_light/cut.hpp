// SPDX-License-Identifier: Apache-2.0
#pragma once

// Multidimensional lightcuts [Walter 2006, section 4]: one cut through the product graph of a pixel's gather tree and the
// light trees. Each cluster pair is estimated by one representative pair and carries a bound of its error; the worst is
// split until no bound exceeds a fraction of the pixel's total.
//
//   symbol        here                      symbol        here
//   S_C, I_L      GatherNode, LightNode     UB(C, L)      pair_bound
//   s*, l*        Cluster::sensor, vpl      eps, floor    CutConfig
//
// Departure: the paper keeps one representative per gather node. Then all light clusters that meet an unsplit gather node
// see the same sensor, and their errors, each below the threshold, add up with one sign: pixels in the corner of three
// walls came out at a third of their value. Here every new cluster pair draws its own sensor; a split still hands the
// parent's pair to exactly one child, so that it costs one new evaluation.
//
// Work goes by small batches of the worst clusters: their nodes, VPLs and shadow rays are independent of each other, so
// that memory is asked for ahead and rays are traced together. A batch costs at most its size in splits too many.

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "manylight/core/error.hpp"
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
                "hit_weight, binding, hit_binding, prune, prune_delta, limit, clamp, light_limit");

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
        bounds_(bounds) {
    config.validate();
  }

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
    S scale = S(0);        ///< luminance(S_C) luminance(I_L)
    std::uint32_t gather;  ///< C
    std::uint32_t light;   ///< L
    std::uint32_t sensor;  ///< s*, place in the gather tree's leaf order
    std::uint32_t vpl;     ///< l*, place in the light tree's leaf order
  };
  /// Heap order: worst error first, ties by age, never by address.
  struct Candidate {
    S error;
    std::uint32_t cluster;
    friend bool operator<(const Candidate& a, const Candidate& b) noexcept {
      return a.error != b.error ? a.error < b.error : a.cluster > b.cluster;
    }
  };
  /// A new cluster whose representative waits to be evaluated.
  struct Pending {
    std::uint32_t cluster;
    S bound;   ///< UB
    S error;   ///< of the cluster, see pair_error
    double u;  ///< picks l*
  };

  [[nodiscard]] static Rgb<double> estimate(const Cluster& c) noexcept {
    return Rgb<double>(c.unit) * static_cast<double>(c.scale);
  }
  [[nodiscard]] std::size_t cut_size() const noexcept { return heap_.size() + settled_count_; }

  void start(const std::vector<Sensor<Scene, W>>& sensors, const Rgb<double>& known, std::uint64_t key);
  [[nodiscard]] bool take_worst();
  void split_batch();
  void split(std::uint32_t cluster);
  void inherit(std::uint32_t cluster, std::uint32_t gather, std::uint32_t light);
  void open(std::uint32_t gather, std::uint32_t light);
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
  typename LightTree<Scene>::Leaf leaf_;
  std::vector<Cluster> clusters_;
  std::vector<Candidate> heap_;        ///< clusters that may be split
  std::size_t settled_count_ = 0;      ///< clusters without error
  Rgb<double> settled_{0};             ///< their sum
  Rgb<double> total_{0};               ///< of everything, `known` included
  std::vector<std::uint32_t> batch_;
  std::vector<Pending> pending_;
  std::vector<Ray<S>> rays_;
  std::vector<S> visible_;
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
  for (const Candidate& candidate : heap_) {
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
  for (const std::uint32_t root : lights_.roots()) open(0, root);
  evaluate_pending();
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
  for (const std::uint32_t cluster : batch_) lights_.prefetch_node(clusters_[cluster].light);
  for (const std::uint32_t cluster : batch_) lights_.prefetch_children(clusters_[cluster].light);
  for (const std::uint32_t cluster : batch_) split(cluster);
  evaluate_pending();
}

/// Replaces a cluster by two: one keeps its representative pair (and its slot), the other draws a new one.
template <class Scene, class W, PatternBounds<typename Scene::Material> B>
void CutSum<Scene, W, B>::split(std::uint32_t cluster) {
  const Cluster parent = clusters_[cluster];
  total_ -= estimate(parent);
  const GatherNode<S>& g = gather_.node(parent.gather);
  const bool on_gather = !g.is_leaf && (LightTree<Scene>::is_leaf(parent.light) ||
                                        splits_gather(g, lights_.node(parent.light, leaf_)));
  const std::array<std::uint32_t, 2> children =
      on_gather ? gather_.children(parent.gather) : lights_.node(parent.light, leaf_).children;
  const std::uint32_t heir = on_gather ? gather_.inheriting_child(parent.gather, parent.sensor)
                                       : lights_.inheriting_child(parent.light, parent.vpl);
  for (const std::uint32_t child : children) {
    const std::uint32_t gather = on_gather ? child : parent.gather;
    const std::uint32_t light = on_gather ? parent.light : child;
    if (child == heir) {
      inherit(cluster, gather, light);
    } else {
      open(gather, light);
    }
  }
}

template <class Scene, class W, PatternBounds<typename Scene::Material> B>
void CutSum<Scene, W, B>::inherit(std::uint32_t cluster, std::uint32_t gather, std::uint32_t light) {
  Cluster& c = clusters_[cluster];
  c.gather = gather;
  c.light = light;
  const GatherNode<S>& g = gather_.node(gather);
  const LightNode<S>& l = lights_.node(light, leaf_);
  c.scale = luminance(g.strength) * luminance(l.intensity);
  total_ += estimate(c);
  place(cluster, g.is_leaf && l.is_leaf ? S(0) : pair_error(g, l, c.scale, pair_bound(g, l, limits_)));
}

template <class Scene, class W, PatternBounds<typename Scene::Material> B>
void CutSum<Scene, W, B>::open(std::uint32_t gather, std::uint32_t light) {
  const GatherNode<S>& g = gather_.node(gather);
  const LightNode<S>& l = lights_.node(light, leaf_);
  const S bound = pair_bound(g, l, limits_);
  if (!(bound > S(0))) {
    ++settled_count_;
    return;
  }
  const std::uint64_t random = mix_bits(key_ ^ ((std::uint64_t{gather} << 32) | light));
  Cluster c{};
  c.gather = gather;
  c.light = light;
  c.scale = luminance(g.strength) * luminance(l.intensity);
  c.sensor = gather_.representative(gather, to_unit_interval<double>(static_cast<std::uint32_t>(random >> 32)));
  const auto u = to_unit_interval<double>(static_cast<std::uint32_t>(random));
  lights_.prefetch_representative(light, u);
  pending_.push_back({static_cast<std::uint32_t>(clusters_.size()), bound, pair_error(g, l, c.scale, bound), u});
  clusters_.push_back(c);
}

/// Draws and evaluates the representatives of all new clusters, with one batch of shadow rays, and puts them into the cut.
template <class Scene, class W, PatternBounds<typename Scene::Material> B>
void CutSum<Scene, W, B>::evaluate_pending() {
  for (const Pending& pending : pending_) {
    Cluster& c = clusters_[pending.cluster];
    c.vpl = lights_.representative(c.light, pending.u);
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
    rays_.push_back(shadow_ray<Scene>(sensor.vertex, light));
  }
  statistics_.pairs += pending_.size();
  visible_.resize(rays_.size());
  scene_.visibility(rays_, visible_, statistics_.rays);
  std::size_t ray = 0;
  for (const Pending& pending : pending_) {
    Cluster& c = clusters_[pending.cluster];
    if (!is_black(c.unit)) {
      c.unit *= visible_[ray++];
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

