// SPDX-License-Identifier: Apache-2.0
#pragma once

// Photons in a k-d tree, and density estimates by those around a point [Jensen 2001b].

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include <nanoflann.hpp>

#include "manylight/core/spectrum.hpp"
#include "manylight/core/vector.hpp"

namespace manylight {

/// Light that a light path has brought to a surface or to a point of a medium.
template <std::floating_point S>
struct Photon {
  using Scalar = S;
  Vec3<S> position{0};
  Vec3<S> wi{0, 0, 1};  ///< unit, towards where it came from
  Vec3<S> ng{0, 0, 1};  ///< geometric normal on the side of `wi`
  /// W. On a surface flux times |wi.ns| / |wi.ng|, so that radiance is the sum of f power per area; in a medium flux
  /// that is scattered, so that the sum of f_p power per volume is the radiance that is added per metre.
  Rgb<S> power{0};
  std::uint16_t edges = 0;  ///< segments behind it, from the light on
  bool is_caustic = false;  ///< all of its vertices were Dirac lobes, at least one
};

/// The part of a surface whose photons count for a point: what is within a ball and a slab of a tenth of its radius,
/// and faces the normal within 60 degrees. In the metric of `squared_distance` it is a ball of that radius. The slab is
/// measured along the mean of both normals, to which a chord of a sphere is perpendicular: all of a ball's surface is in
/// it, whatever the ball's size, and a ball cuts out pi r^2 of a sphere as of a plane.
template <std::floating_point S>
struct PhotonDisc {
  Vec3<S> center{0};
  Vec3<S> normal{0, 0, 1};
  bool both_sides = true;  ///< of a sheet: where the material lets light through; others scatter none of it

  /// None if `record` faces elsewhere: infinity.
  template <class Record>
  [[nodiscard]] S squared_distance(const Record& record, S squared_euclidean) const noexcept {
    const S facing = glm::dot(record.ng, normal);
    if (!((both_sides ? std::abs(facing) : facing) > S(0.5))) return k_infinity<S>;
    const Vec3<S> mean = facing < S(0) ? normal - record.ng : normal + record.ng;
    return std::max(squared_euclidean,
                    S(100) * sqr(glm::dot(record.position - center, mean)) / (S(2) + S(2) * std::abs(facing)));
  }
};
/// All that is near, for photons in a medium.
template <std::floating_point S>
struct PhotonBall {
  Vec3<S> center{0};
  template <class Record>
  [[nodiscard]] S squared_distance(const Record& /*record*/, S squared_euclidean) const noexcept {
    return squared_euclidean;
  }
};

namespace detail {

template <std::floating_point S>
struct PointCloud {
  std::vector<Vec3<S>> points;
  [[nodiscard]] std::size_t kdtree_get_point_count() const noexcept { return points.size(); }
  [[nodiscard]] S kdtree_get_pt(std::size_t i, std::size_t axis) const noexcept {
    return points[i][static_cast<int>(axis)];
  }
  template <class Bounds>
  [[nodiscard]] bool kdtree_get_bbox(Bounds& /*bounds*/) const noexcept {
    return false;
  }
};

/// A nanoflann result set that leaves everything to `found(squared distance, i)`, which returns the new limit.
template <std::floating_point S, class Found>
struct PointVisitor {
  S limit;
  Found& found;
  [[nodiscard]] S worstDist() const noexcept { return limit; }
  [[nodiscard]] bool full() const noexcept { return true; }
  bool addPoint(S squared_distance, std::uint32_t i) {
    if (squared_distance < limit) limit = found(squared_distance, i);
    return true;
  }
};

/// Interleaves 10 bits per axis: points that are near in space come near in memory.
template <std::floating_point S>
[[nodiscard]] std::uint32_t morton_code(const Vec3<S>& unit) noexcept {
  std::uint32_t code = 0;
  for (int axis = 0; axis < 3; ++axis) {
    auto x = static_cast<std::uint32_t>(std::clamp(unit[axis] * S(1024), S(0), S(1023)));
    x = (x | (x << 16)) & 0x030000FFu;
    x = (x | (x << 8)) & 0x0300F00Fu;
    x = (x | (x << 4)) & 0x030C30C3u;
    x = (x | (x << 2)) & 0x09249249u;
    code |= x << axis;
  }
  return code;
}

}  // namespace detail

/// Squared distances and places of records, a heap with the farthest on top; memory to be used again.
template <std::floating_point S>
using NearestPhotons = std::vector<std::pair<S, std::uint32_t>>;

/// Records with `position` and `ng`, found by place. Immutable; queries may run at the same time and give the records
/// in an order that depends on the map and the query alone.
template <class Record>
class PhotonMap {
 public:
  using S = typename Record::Scalar;

  PhotonMap() = default;
  explicit PhotonMap(std::vector<Record> records) : records_(std::move(records)) {
    if (records_.empty()) return;
    sort();
    cloud_ = std::make_unique<Cloud>();
    cloud_->points.reserve(records_.size());
    for (const Record& record : records_) cloud_->points.push_back(record.position);
    tree_ = std::make_unique<Tree>(3, *cloud_, nanoflann::KDTreeSingleIndexAdaptorParams(8));
  }

  [[nodiscard]] std::size_t size() const noexcept { return records_.size(); }
  [[nodiscard]] const Record& operator[](std::size_t i) const noexcept { return records_[i]; }

  /// Calls `visit(record, squared distance)` for all within `radius` (m) in the metric of `region`.
  template <class Region, class Visit>
  void for_each_within(const Region& region, S radius, const Visit& visit) const {
    const S limit = radius * radius;
    search(region.center, limit, [&](S euclidean, std::uint32_t i) {
      const S squared = region.squared_distance(records_[i], euclidean);
      if (squared < limit) visit(records_[i], squared);
      return limit;
    });
  }

  /// Collects the `count` nearest within `max_radius` (m) into `found`.
  template <class Region>
  void find_nearest(const Region& region, std::size_t count, S max_radius, NearestPhotons<S>& found) const {
    found.clear();
    S limit = max_radius * max_radius;
    search(region.center, limit, [&](S euclidean, std::uint32_t i) {
      const S squared = region.squared_distance(records_[i], euclidean);
      if (!(squared < limit)) return limit;
      if (found.size() == count) {
        std::pop_heap(found.begin(), found.end());
        found.pop_back();
      }
      found.emplace_back(squared, i);
      std::push_heap(found.begin(), found.end());
      if (found.size() == count) limit = found.front().first;
      return limit;
    });
  }

 private:
  using Cloud = detail::PointCloud<S>;
  using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<S, Cloud>, Cloud, 3, std::uint32_t>;

  template <class Found>
  void search(const Vec3<S>& center, S limit, Found found) const {
    if (!tree_) return;
    detail::PointVisitor<S, Found> visitor{limit, found};
    const std::array<S, 3> point{center.x, center.y, center.z};
    if constexpr (requires { tree_->findNeighbors(visitor, point.data()); }) {
      tree_->findNeighbors(visitor, point.data());
    } else {
      tree_->findNeighbors(visitor, point.data(), {});  // before nanoflann 1.5
    }
  }
  void sort() {
    Vec3<S> low = records_.front().position;
    Vec3<S> high = low;
    for (const Record& record : records_) {
      low = glm::min(low, record.position);
      high = glm::max(high, record.position);
    }
    const S extent = std::max(std::numeric_limits<S>::min(), max_channel(high - low));
    std::vector<std::pair<std::uint32_t, std::uint32_t>> order(records_.size());
    for (std::uint32_t i = 0; i < order.size(); ++i) {
      order[i] = {detail::morton_code<S>((records_[i].position - low) / extent), i};
    }
    std::sort(order.begin(), order.end());
    std::vector<Record> sorted;
    sorted.reserve(records_.size());
    for (const auto& entry : order) sorted.push_back(records_[entry.second]);
    records_ = std::move(sorted);
  }

  std::vector<Record> records_;
  std::unique_ptr<Cloud> cloud_;
  std::unique_ptr<Tree> tree_;
};

/// How the weight of photons falls off with their distance.
enum class PhotonKernel : std::uint8_t { constant, cone, epanechnikov };

/// Weight per area of a photon at squared distance `squared` in a disc of `squared_radius`, m^-2; integrates to 1.
template <std::floating_point S>
[[nodiscard]] S kernel_value(PhotonKernel kernel, S squared, S squared_radius) noexcept {
  const S uniform = k_inv_pi<S> / squared_radius;
  if (kernel == PhotonKernel::cone) return S(3) * uniform * (S(1) - std::sqrt(squared / squared_radius));
  if (kernel == PhotonKernel::epanechnikov) return S(2) * uniform * (S(1) - squared / squared_radius);
  return uniform;
}

/// Calls `add(record, weight per area)` for the `count` records nearest to `disc` and returns the radius of the
/// estimate, m. Free of bias where their density is even: the farthest only tells the radius, as the k - 1 others are
/// evenly spread within it; where less than k lie within `max_radius`, all of them count within that radius. In both
/// cases together the expectation of the sum of weights is the density lambda: lambda P(N >= k - 1) + lambda P(N < k -
/// 1), N the number within `max_radius`.
template <class Record, class Add, std::floating_point S = typename Record::Scalar>
S estimate_by_nearest(const PhotonMap<Record>& map, const PhotonDisc<S>& disc, std::size_t count, S max_radius,
                      PhotonKernel kernel, NearestPhotons<S>& scratch, const Add& add) {
  map.find_nearest(disc, count, max_radius, scratch);
  S squared_radius = max_radius * max_radius;
  if (scratch.size() == count) {
    squared_radius = scratch.front().first;
    std::pop_heap(scratch.begin(), scratch.end());
    scratch.pop_back();
    // Only photons in the very same place: no density can be told.
    if (!(squared_radius > std::numeric_limits<S>::min())) return S(0);
  }
  for (const auto& [squared, i] : scratch) add(map[i], kernel_value(kernel, squared, squared_radius));
  return std::sqrt(squared_radius);
}

}  // namespace manylight
