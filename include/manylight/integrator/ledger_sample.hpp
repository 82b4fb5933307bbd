// SPDX-License-Identifier: Apache-2.0
#pragma once

// One sample of the ledger of missing energy (ledger.hpp): a walk of PathIntegrator, and for each of its paths what the
// generators of a weighting would leave of it.

#include <array>
#include <cmath>

#include "manylight/integrator/path.hpp"
#include "manylight/path/missing_energy.hpp"

namespace manylight {

struct LedgerConfig {
  unsigned max_edges = k_unlimited_edges;    ///< longest path of the image, segments; longer ones are missing: `depth`
  unsigned truth_edges = k_unlimited_edges;  ///< longest path of the truth, segments, at least `max_edges`
  unsigned roulette_edges = 4;               ///< roulette from this segment on

  /// Throws ParameterError.
  void validate() const {
    require(max_edges >= 1, "maximum path length", max_edges, "at least 1 segment");
    require(truth_edges >= max_edges, "longest path of the truth", truth_edges, "at least that of the image");
  }
};

/// One path-traced estimate, W/m^2/sr.
struct LedgerSample {
  Rgb<double> truth{0};
  Rgb<double> missing{0};
  std::array<Rgb<double>, k_ledger_entries> entries{};  ///< sum to `missing`

  [[nodiscard]] bool is_valid() const noexcept { return is_valid_radiance(truth) && is_valid_radiance(missing); }
};

namespace detail {

/// Follows the walk of a PathIntegrator and books what is missing of each of its paths. M, D and T^w by the formulas of
/// EyeSubpath and unoccluded_transfer: the weights are those of the image.
template <class Scene, class W>
class LedgerVisitor {
 public:
  using S = typename Scene::Scalar;

  LedgerVisitor(const Scene& scene, const W& weighting, unsigned max_edges)
      : scene_(scene), max_edges_(max_edges), shares_(weighting) {}

  [[nodiscard]] const LedgerSample& sample() const noexcept { return sample_; }

  void arrive(const Vec3<S>& position) {
    if (edges_ > 0) advance(S(1) / squared_length(position - position_));
    position_ = position;
    ++edges_;
  }
  void emission(const Rgb<S>& part, const SurfacePoint<S>& point, const Vec3<S>& wo) {
    if (!is_black(part)) book(part, edges_, shares_, std::abs(glm::dot(wo, point.ng)) * k_inv_pi<S>, false);
  }
  void environment(const Rgb<S>& part) {
    if (is_black(part)) return;
    if (edges_ > 0) advance(transit_from_infinity());
    book(part, edges_ + 1, shares_, k_inv_pi<S>, false);
  }
  template <class Hit>
  void direct(const Rgb<S>& part, const Hit& hit, const Vec3<S>& wo, const DirectSample<S>& light, const Rgb<S>& f) {
    if (is_black(part)) return;
    PathShares<W> shares = shares_;
    const PatternMaxima<S> here = pattern_maxima(hit, light.wi, wo, f);
    shares.leave(here.m, here.d, light.infinite ? transit_from_infinity() : S(1) / sqr(light.distance));
    book(part, edges_ + 1, shares, emitter_pattern(light), light.is_delta);
  }
  template <class Hit>
  void leave(const Hit& hit, const Vec3<S>& wo, const ScatterSample<S>& sample) {
    leaves_by_delta_ = sample.is_delta;
    if (!sample.is_delta) step_ = pattern_maxima(hit, sample.direction, wo, sample.f);
  }

  void pass_below(S m, S d, S t, const Vec3<S>& position) {
    shares_.leave(m, d, t);
    position_ = position;
    ++edges_;
  }

 private:
  [[nodiscard]] static S squared_length(const Vec3<S>& v) noexcept { return glm::dot(v, v); }
  [[nodiscard]] S transit_from_infinity() const noexcept { return S(1) / sqr(scene_.emitters().scene_radius()); }
  /// D of the emitter towards the vertex, as light_pattern gives it.
  [[nodiscard]] static S emitter_pattern(const DirectSample<S>& light) noexcept {
    if (light.infinite) return k_inv_pi<S>;
    if (light.is_delta) return S(0.25) * k_inv_pi<S>;
    return std::abs(glm::dot(light.wi, light.ng)) * k_inv_pi<S>;
  }
  /// The walk has reached the next vertex, over a segment of transit t.
  void advance(S t) {
    if (leaves_by_delta_) {
      shares_.leave_delta();
    } else {
      shares_.leave(step_.m, step_.d, t);
    }
  }
  void book(const Rgb<S>& part, unsigned edges, const PathShares<W>& shares, S d_light, bool exact) {
    const MissingShare missing =
        edges > max_edges_ ? MissingShare{LedgerEntry::depth, 1.0} : shares.missing(d_light, exact);
    const Rgb<double> radiance(part);
    sample_.truth += radiance;
    sample_.missing += radiance * missing.share;
    sample_.entries[static_cast<std::size_t>(missing.entry)] += radiance * missing.share;
  }

  const Scene& scene_;
  unsigned max_edges_;
  PathShares<W> shares_;  ///< at the newest vertex
  PatternMaxima<S> step_{};       ///< of the direction in which it was left
  bool leaves_by_delta_ = false;
  Vec3<S> position_{0};
  unsigned edges_ = 0;  ///< segments from the camera to the newest vertex
  LedgerSample sample_;
};

}  // namespace detail

/// Estimates the ledger of a weighting: the one that the image is rendered with, by the same scene. Both must outlive
/// it.
template <class Scene, class W>
class LedgerIntegrator {
  static_assert(
      Weighting<W>,
      "manylight::LedgerIntegrator: the weighting must model Weighting: Scalar, Record, start, extend, "
      "extend_delta, weight, hit_weight, binding, hit_binding, takes_hits, prune, prune_delta, limit, clamp, "
      "light_limit");

 public:
  using S = typename Scene::Scalar;

  /// Throws ParameterError.
  LedgerIntegrator(const Scene& scene, const W& weighting, const LedgerConfig& config)
      : scene_(scene), weighting_(weighting), config_(config), paths_(scene, path_config(config)) {}

  /// Truth and what is missing of it along `ray`. The truth is what PathIntegrator makes of the same stream.
  template <SampleStream Stream>
  [[nodiscard]] LedgerSample sample(const Ray<S>& ray, Stream& stream, RayCounts& rays) const {
    detail::LedgerVisitor<Scene, W> visitor(scene_, weighting_, config_.max_edges);
    paths_.trace(ray, stream, rays, visitor);
    return visitor.sample();
  }

 private:
  [[nodiscard]] static PathConfig path_config(const LedgerConfig& config) {
    config.validate();
    return {config.truth_edges, config.roulette_edges};
  }

  const Scene& scene_;
  const W& weighting_;
  LedgerConfig config_;
  PathIntegrator<Scene> paths_;
};

/// Of a scene in motion: one per instant.
template <class S, class W>
class LedgerIntegrator<Instants<S>, W> {
 public:
  LedgerIntegrator(const Instants<S>& scenes, const W& weighting, const LedgerConfig& config) {
    for (std::uint32_t i = 0; i < scenes.instants(); ++i) integrators_.emplace_back(scenes.at(i), weighting, config);
  }
  [[nodiscard]] std::uint32_t instants() const noexcept { return static_cast<std::uint32_t>(integrators_.size()); }
  [[nodiscard]] const LedgerIntegrator<S, W>& at(std::uint32_t instant) const noexcept { return integrators_[instant]; }

 private:
  std::vector<LedgerIntegrator<S, W>> integrators_;
};

}  // namespace manylight
