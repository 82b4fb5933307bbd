// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where light that leaves a body at one point may have entered it, by random lines [Walter 2012, section 7]; see
// SubsurfaceFalloff for their density. Lines need neither a parametrisation of the surface nor its area, and thin or
// curved bodies none of the care of projections along the normal.

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "manylight/core/sampler.hpp"
#include "manylight/core/warp.hpp"
#include "manylight/geometry/concepts.hpp"
#include "manylight/geometry/surface_point.hpp"
#include "manylight/scattering/subsurface_falloff.hpp"

namespace manylight {

namespace detail {

/// Tells the hits of one line on a mesh apart from hits that backends report twice, as they may on an edge that
/// triangles share. Distance cannot tell: the two sides of a thin body may be nearer than rounding. The edge can: both
/// hits have a weight of 0 up to rounding, and what remains of their corners, two of an edge or one, is in the same
/// places (meshes often have several vertices in one). Hits inside triangles always count.
template <std::floating_point S>
class EdgeCrossings {
 public:
  /// Whether `hit` is none of those seen before. More than k_most different crossings of edges on one line, which take
  /// a line through the vertices of a regular mesh, are all taken for new.
  [[nodiscard]] bool is_new(const TriangleMesh<S>& mesh, const Hit<S>& hit) noexcept {
    const Place place = place_of(mesh, hit);
    if (place.count == 3) return true;
    for (std::size_t i = 0; i < size_; ++i) {
      if (is_same(places_[i], place)) return false;
    }
    if (size_ < k_most) places_[size_++] = place;
    return true;
  }

 private:
  static constexpr std::size_t k_most = 16;

  /// The corners that bear weight.
  struct Place {
    std::array<Vec3<S>, 3> corners{};
    std::size_t count = 0;
  };

  [[nodiscard]] static Place place_of(const TriangleMesh<S>& mesh, const Hit<S>& hit) noexcept {
    // A weight of 0 is so exactly or, of the first corner, up to the rounding of the others; backends that test in
    // single precision accept weights down to -epsilon.
    constexpr S k_tolerance = S(8) * std::numeric_limits<S>::epsilon();
    const std::array<S, 3> weights{S(1) - hit.u - hit.v, hit.u, hit.v};
    Place place;
    for (std::size_t k = 0; k < 3; ++k) {
      if (weights[k] > k_tolerance) place.corners[place.count++] = mesh.positions[mesh.triangles[hit.primitive][k]];
    }
    return place;
  }
  /// Whether all corners of one are the other's: next to a vertex, rounding may give one hit two corners, another one.
  [[nodiscard]] static bool is_same(const Place& a, const Place& b) noexcept {
    return a.count <= b.count ? is_part(a, b) : is_part(b, a);
  }
  [[nodiscard]] static bool is_part(const Place& a, const Place& b) noexcept {
    for (std::size_t i = 0; i < a.count; ++i) {
      bool found = false;
      for (std::size_t k = 0; k < b.count; ++k) found = found || a.corners[i] == b.corners[k];
      if (!found) return false;
    }
    return true;
  }

  std::array<Place, k_most> places_;
  std::size_t size_ = 0;
};

}  // namespace detail

/// Calls `visit(hit)` for every crossing of `line` with the shape of that id, from either side, in no particular order;
/// each once, also on edges that triangles of a mesh share. Other shapes are passed through.
template <Geometry G, class Visit>
void shape_crossings(const G& geometry, std::uint32_t shape, const Ray<typename G::Scalar>& line, Visit&& visit) {
  using S = typename G::Scalar;
  const Shapes<S>& shapes = geometry.shapes();
  detail::EdgeCrossings<S> edges;
  geometry.all_hits(line, [&](const Hit<S>& hit) {
    if (hit.shape != shape) return;
    if (shapes.is_mesh(shape) && !edges.is_new(shapes.meshes[shape], hit)) return;
    visit(hit);
  });
}

/// A chord between two independent uniform points on the sphere around `center` (m) of a radius drawn from `falloff`; t
/// from 0 to just below 1, so that chords that begin or end on a surface are counted once on average.
template <SubsurfaceFalloff F, SampleStream Stream>
[[nodiscard]] Ray<typename F::Scalar> random_line(const Vec3<typename F::Scalar>& center, const F& falloff,
                                                  Stream& stream) noexcept {
  using S = typename F::Scalar;
  const S radius = falloff.sample_radius(stream);
  const Vec3<S> begin = warp::square_to_sphere(stream.next_2d());
  const Vec3<S> end = warp::square_to_sphere(stream.next_2d());
  // Not from the rounded origin to a rounded end: far from the world's origin these stand on a coarse lattice.
  return {center + begin * radius, (end - begin) * radius, S(0), S(1) - S(4) * std::numeric_limits<S>::epsilon()};
}

/// Draws `count` random lines around `center` (m), a point on or near the surface of the shape of that id, and calls
/// `visit(point, pdf_area)` for each of their crossings with that shape: a SurfacePoint and the expected number of
/// points per area there, m^-2, of all `count` lines together; always positive. A sum over crossings of f(point) /
/// pdf_area estimates the integral of f over the shape's surface, as far as the falloff reaches. Costs `count` all_hits
/// queries, no allocation beyond theirs.
///
/// Points nearer to `center` than the rounding of its coordinates are drawn inaccurately: the falloff should be much
/// longer than that.
template <Geometry G, SubsurfaceFalloff F, SampleStream Stream, class Visit>
void random_lines(const G& geometry, std::uint32_t shape, const Vec3<typename G::Scalar>& center, const F& falloff,
                  unsigned count, Stream& stream, Visit&& visit) {
  using S = typename G::Scalar;
  for (unsigned i = 0; i < count; ++i) {
    const Ray<S> line = random_line(center, falloff, stream);
    shape_crossings(geometry, shape, line, [&](const Hit<S>& hit) {
      const SurfacePoint<S> point = surface_point(geometry.shapes(), line, hit);
      const S pdf = static_cast<S>(count) * falloff.line_pdf(glm::length(point.position - center));
      if (pdf > S(0)) visit(point, pdf);
    });
  }
}

}  // namespace manylight
