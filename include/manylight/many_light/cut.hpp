// SPDX-License-Identifier: Apache-2.0
#pragma once

// Multidimensional lightcuts [Walter 2006, section 4]: one cut through the product graph of a pixel's gather tree and the
// light trees. Each cluster pair is estimated by one representative pair and carries a bound of its error; the worst is
// split until no bound exceeds a fraction of the pixel's total.
//
//   symbol        here                      symbol        here
//   S_C, I_L      GatherNode, LightNode     UB(C, L)      upper_bound
//   s*, l*        representative pair       eps, floor    CutConfig
//
//   UB = min( (w M)_ub  T_ub  D_ub , C_clamp )   with weights folded in as in the theory sheet, section 6.5.
//
// Departure: the paper keeps one representative per gather node. Then all light clusters that meet an unsplit gather node
// see the same sensor, and their errors, each below the threshold, add up with one sign: pixels in the corner of three
// walls came out at a third of their value. Here every new cluster pair draws its own sensor; a split still hands the
// parent's pair to exactly one child, so that it costs one new evaluation.

#include <algorithm>
#include <cstdint>
#include <vector>

#include "manylight/bounds/box_pair.hpp"
#include "manylight/core/error.hpp"
#include "manylight/many_light/gather_tree.hpp"
#include "manylight/many_light/light_tree.hpp"
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

template <class Scene, class W>
class CutSum {
  static_assert(Weighting<W>,
                "manylight::CutSum: the weighting must model Weighting: Scalar, Record, start, extend, extend_delta, weight, "
                "hit_weight, binding, hit_binding, prune, prune_delta, limit, clamp, light_limit");

 public:
  using S = typename Scene::Scalar;

  CutSum(const Scene& scene, const W& weighting, const LightTree<Scene>& lights, unsigned max_edges,
         const CutConfig& config)
      : scene_(scene), weighting_(weighting), lights_(lights), max_edges_(max_edges), config_(config) {
    config.validate();
  }

  /// Sum over all pairs of `sensors` and lights. `known`: radiance that the pixel has already, part of the total that
  /// errors are measured against. `key`: seeds the representatives, a function of the pixel.
  [[nodiscard]] PairSumResult operator()(const std::vector<Sensor<Scene, W>>& sensors, const Rgb<double>& known,
                                         std::uint64_t key);

 private:
  /// A cluster pair of the cut.
  struct Entry {
    double error;         ///< bound of the error, luminance
    Rgb<S> unit{0};       ///< estimate per unit of S_C and I_L luminance
    std::uint32_t gather;
    std::uint32_t light;
    std::uint32_t sensor;  ///< s*
    std::uint64_t key;     ///< s* is the gather node's representative for it

    /// Heap order: worst error first, ties by ids, never by address.
    friend bool operator<(const Entry& a, const Entry& b) noexcept {
      if (a.error != b.error) return a.error < b.error;
      if (a.gather != b.gather) return a.gather > b.gather;
      return a.light > b.light;
    }
  };

  [[nodiscard]] std::uint32_t slot(std::uint32_t sensor) const noexcept {
    return static_cast<std::uint32_t>(mix_bits(key_ + sensor) >> 40);
  }
  [[nodiscard]] Rgb<double> estimate(const Entry& entry) const noexcept {
    return Rgb<double>(entry.unit) * (static_cast<double>(gather_.node(entry.gather).luminance) *
                                      static_cast<double>(lights_.node(entry.light).luminance));
  }
  [[nodiscard]] S upper_bound(const GatherNode<S>& gather, const LightNode<S>& light) const noexcept;
  [[nodiscard]] bool splits_gather(const GatherNode<S>& gather, const LightNode<S>& light) const noexcept;
  /// The entry of a cluster pair with a representative of its own.
  [[nodiscard]] Entry fresh(std::uint32_t gather, std::uint32_t light);
  /// The entry of a cluster pair that holds its parent's representative.
  [[nodiscard]] Entry inherited(std::uint32_t gather, std::uint32_t light, const Entry& parent) const;
  void evaluate(Entry& entry, S bound);
  void push(const Entry& entry);
  void split(const Entry& entry);

  const Scene& scene_;
  const W& weighting_;
  const LightTree<Scene>& lights_;
  unsigned max_edges_;
  CutConfig config_;

  GatherTree<Scene, W> gather_;
  std::vector<Entry> heap_;
  std::vector<Entry> leaves_;  ///< pairs of single sensors and VPLs: exact
  Rgb<double> total_{0};
  std::uint64_t key_ = 0;
  PairStatistics statistics_;
};

template <class Scene, class W>
PairSumResult CutSum<Scene, W>::operator()(const std::vector<Sensor<Scene, W>>& sensors, const Rgb<double>& known,
                                           std::uint64_t key) {
  statistics_ = {};
  heap_.clear();
  leaves_.clear();
  if (sensors.empty()) return {};
  key_ = mix_bits(key);
  gather_.build(sensors, weighting_);
  total_ = known;
  for (const std::uint32_t root : lights_.roots()) push(fresh(0, root));
  while (!heap_.empty()) {
    const double allowed = config_.threshold * std::max(luminance(total_), config_.floor);
    if (heap_.front().error <= allowed) break;
    if (heap_.size() + leaves_.size() >= config_.max_cut) {
      statistics_.capped = true;
      break;
    }
    std::pop_heap(heap_.begin(), heap_.end());
    const Entry worst = heap_.back();
    heap_.pop_back();
    split(worst);
  }
  // Summed afresh: the running total has lost small terms under large early estimates.
  PairSumResult result;
  for (const Entry& entry : leaves_) result.radiance += estimate(entry);
  for (const Entry& entry : heap_) result.radiance += estimate(entry);
  statistics_.cut_size = heap_.size() + leaves_.size();
  result.statistics = statistics_;
  return result;
}

/// Bound of w M T D over the pair, sr^-2 m^-2 [theory 6.2, 6.5].
template <class Scene, class W>
typename Scene::Scalar CutSum<Scene, W>::upper_bound(const GatherNode<S>& gather,
                                                     const LightNode<S>& light) const noexcept {
  const Box<S> vectors = light.is_infinite ? light.box : difference(gather.box, light.box);
  const DirectionCone<S> to_light = directions(vectors);
  const S m = sup_sensor_pattern(gather, to_light);
  if (!(m > S(0))) return S(0);
  const S limit = weighting_.light_limit();
  const S d = sup_light_pattern(light, {-to_light.axis, to_light.cos_half, to_light.sin_half}, limit);
  if (!(d > S(0))) return S(0);
  const S squared = light.is_infinite ? sqr(scene_.emitters().scene_radius()) : min_squared_length(vectors);
  const S weighted_d = d < limit ? d * gather.remaining : limit;
  const S bound = squared > S(0) ? m * weighted_d / squared : k_infinity<S>;
  const S rounding = S(1) + S(64) * std::numeric_limits<S>::epsilon();
  return light.is_exact ? bound * rounding : std::min(bound * rounding, weighting_.clamp());
}

/// Splits the side whose size, or spread of normals seen from the other side's distance, is larger [theory 5.4].
template <class Scene, class W>
bool CutSum<Scene, W>::splits_gather(const GatherNode<S>& gather, const LightNode<S>& light) const noexcept {
  if (gather.is_leaf) return false;
  if (light.is_leaf) return true;
  if (light.is_infinite) {
    const S spread = std::min(S(2), S(2) * gather.normals.half_angle());
    return spread > light.box.diagonal();
  }
  const S distance = glm::length(gather.box.center() - light.box.center());
  const S gather_size = gather.box.diagonal() + distance * std::min(S(1), gather.normals.half_angle());
  const S light_size = light.box.diagonal() + distance * std::min(S(1), light.normals.half_angle()) * S(0.5);
  return gather_size > light_size;
}

template <class Scene, class W>
auto CutSum<Scene, W>::inherited(std::uint32_t gather, std::uint32_t light, const Entry& parent) const -> Entry {
  Entry entry = parent;
  entry.gather = gather;
  entry.light = light;
  const GatherNode<S>& c = gather_.node(gather);
  const LightNode<S>& l = lights_.node(light);
  entry.error = c.is_leaf && l.is_leaf ? 0 : static_cast<double>(luminance(c.strength * l.intensity) * upper_bound(c, l));
  return entry;
}

template <class Scene, class W>
auto CutSum<Scene, W>::fresh(std::uint32_t gather, std::uint32_t light) -> Entry {
  Entry entry{};
  entry.gather = gather;
  entry.light = light;
  entry.key = mix_bits(key_ ^ ((std::uint64_t{gather} << 32) | light));
  entry.sensor = gather_.representative(gather, entry.key);
  const GatherNode<S>& c = gather_.node(gather);
  const LightNode<S>& l = lights_.node(light);
  const S bound = upper_bound(c, l);
  entry.error = c.is_leaf && l.is_leaf ? 0 : static_cast<double>(luminance(c.strength * l.intensity) * bound);
  if (bound > S(0)) evaluate(entry, bound);
  return entry;
}

template <class Scene, class W>
void CutSum<Scene, W>::evaluate(Entry& entry, S bound) {
  const Sensor<Scene, W>& sensor = gather_.sensor(entry.sensor);
  const VertexOf<Scene>& light = lights_.vpl(lights_.representative(entry.light, slot(entry.sensor)));
  ++statistics_.pairs;
  const Transfer<S> transfer =
      unoccluded_transfer<Scene>(weighting_, sensor, light, scene_.emitters().scene_radius(), max_edges_);
  if (!transfer.is_valid) ++statistics_.invalid;
  if (is_black(transfer.value)) return;
  if (max_channel(transfer.value) > bound * S(1.00001)) ++statistics_.bound_violations;  // rounding of the product
  const S visible = visibility(scene_, sensor.vertex, light, statistics_.rays);
  entry.unit = transfer.value * (sensor.vertex.strength / luminance(sensor.vertex.strength)) *
               (light.strength / luminance(light.strength)) * visible;
}

template <class Scene, class W>
void CutSum<Scene, W>::push(const Entry& entry) {
  total_ += estimate(entry);
  if (!(entry.error > 0)) {
    leaves_.push_back(entry);
    return;
  }
  heap_.push_back(entry);
  std::push_heap(heap_.begin(), heap_.end());
}

template <class Scene, class W>
void CutSum<Scene, W>::split(const Entry& entry) {
  total_ -= estimate(entry);
  const GatherNode<S>& gather = gather_.node(entry.gather);
  const LightNode<S>& light = lights_.node(entry.light);
  const bool on_gather = splits_gather(gather, light);
  const std::uint32_t first = on_gather ? gather.child : light.child;
  const std::uint32_t heir = on_gather ? gather_.inheriting_child(entry.gather, entry.key)
                                       : lights_.inheriting_child(entry.light, slot(entry.sensor));
  for (std::uint32_t child = first; child < first + 2; ++child) {
    const std::uint32_t g = on_gather ? child : entry.gather;
    const std::uint32_t l = on_gather ? entry.light : child;
    push(child == heir ? inherited(g, l, entry) : fresh(g, l));
  }
}

}  // namespace manylight
