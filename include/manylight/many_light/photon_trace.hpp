// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "manylight/core/executor.hpp"
#include "manylight/many_light/photon_map.hpp"
#include "manylight/path/light_subpath.hpp"

namespace manylight {

struct PhotonPaths {
  std::size_t count = 100'000;       ///< light paths, 1 to 2^32 - 1
  unsigned max_edges = 0xFFFFu;      ///< longest full path, segments
  bool only_caustics = false;        ///< keep photons of Dirac lobes alone, and trace no farther than they need
};

/// Photons of surfaces and those of media.
template <std::floating_point S>
struct PhotonSet {
  std::vector<Photon<S>> surface;
  std::vector<Photon<S>> medium;
};

namespace detail {

/// Takes what a light path leaves, as photons for one path.
template <class Scene>
class PhotonSink {
 public:
  using S = typename Scene::Scalar;
  PhotonSink(PhotonSet<S>& out, bool only_caustics) : out_(out), only_caustics_(only_caustics) {}

  void push_back(const VertexOf<Scene>& v) {
    if (v.kind != VertexKind::surface && !v.is_in_medium()) return;
    const bool is_caustic = only_dirac_ && v.edges >= 2;
    if (only_caustics_ && !is_caustic) return;
    // I = flux alpha |wi.ns| / |wi.ng| on a surface, flux sigma_s times the mean free path's share in a medium.
    // The back of a one-sided surface keeps the normal of its front: its photons must not count there.
    const Vec3<S> ng = glm::dot(v.ng, v.w) < S(0) ? -v.ng : v.ng;
    Photon<S> photon{v.position, v.w, ng, v.strength / v.alpha, v.edges, is_caustic};
    (v.is_in_medium() ? out_.medium : out_.surface).push_back(photon);
  }
  [[nodiscard]] bool scattered(bool is_delta) noexcept {
    only_dirac_ = only_dirac_ && is_delta;
    return only_dirac_ || !only_caustics_;
  }

 private:
  PhotonSet<S>& out_;
  bool only_caustics_;
  bool only_dirac_ = true;
};

}  // namespace detail

/// Traces the light paths of one `pass`; every pass has its own random numbers. The power of the photons is that of the
/// whole set: those that come straight from lights in a closed room add up to the lights' flux. The roulette is that of
/// VPLs.
template <class Scene, Sampler Random, Executor Exec>
[[nodiscard]] PhotonSet<typename Scene::Scalar> trace_photons(const Scene& scene, const PhotonPaths& paths,
                                                              std::uint64_t pass, const Random& sampler,
                                                              const Exec& executor, RayCounts& rays) {
  static_assert(!Scene::k_has_subsurface,
                "manylight::trace_photons: photon maps know no subsurface scattering; a scene whose shader has a "
                "Subsurface is rendered by PathIntegrator or by bidirectional lightcuts");
  static_assert(!requires { scene.instants(); },
                "manylight::trace_photons: photon maps know no motion; a scene in motion is rendered by PathIntegrator, "
                "BidirectionalPathIntegrator or by lightcuts");
  using S = typename Scene::Scalar;
  struct Batch {
    PhotonSet<S> photons;
    RayCounts rays;
  };
  constexpr std::size_t k_per_batch = 1024;
  std::vector<Batch> batches((paths.count + k_per_batch - 1) / k_per_batch);
  executor.for_each_index(batches.size(), [&](std::size_t b) {
    const std::size_t end = std::min(paths.count, (b + 1) * k_per_batch);
    for (std::size_t i = b * k_per_batch; i < end; ++i) {
      auto stream = sampler.stream(Stage::light, pass, static_cast<std::uint32_t>(i));
      detail::PhotonSink<Scene> sink(batches[b].photons, paths.only_caustics);
      // A photon is at the vertex that merges with it: no segment is needed to connect them.
      LightSubpath<Scene, decltype(stream), detail::PhotonSink<Scene>>(scene, paths.max_edges + 1u, stream,
                                                                       batches[b].rays, sink)
          .trace();
    }
  });
  PhotonSet<S> all;
  const auto append = [&](std::vector<Photon<S>>& to, const std::vector<Photon<S>>& from) {
    for (Photon<S> photon : from) {
      photon.power /= static_cast<S>(paths.count);
      to.push_back(photon);
    }
  };
  for (const Batch& batch : batches) {
    append(all.surface, batch.photons.surface);
    append(all.medium, batch.photons.medium);
    rays += batch.rays;
  }
  return all;
}

}  // namespace manylight
