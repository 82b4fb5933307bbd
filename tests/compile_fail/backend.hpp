// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "manylight/scattering/lambertian.hpp"
#include "manylight/scene/scene.hpp"

/// A Geometry with nothing behind it. A case defines WITHOUT_<MEMBER> to leave that one out.
struct Backend {
  using Scalar = float;
  using Ray = manylight::Ray<float>;
#ifndef WITHOUT_CLOSEST_HIT
  std::optional<manylight::Hit<float>> closest_hit(const Ray&) const { return std::nullopt; }
#endif
#ifndef WITHOUT_ANY_HIT
  bool any_hit(const Ray&) const { return false; }
#endif
#ifndef WITHOUT_ALL_HITS
  template <class Visit>
  void all_hits(const Ray&, const Visit&) const {}
#endif
#ifndef WITHOUT_ANY_HIT_BATCH
  void any_hit_batch(std::span<const Ray>, std::span<std::uint8_t>) const {}
#endif
#ifndef WITHOUT_BOUNDS
  manylight::Box<float> bounds() const { return {}; }
#endif
#ifndef WITHOUT_SHAPES
  const manylight::Shapes<float>& shapes() const { return held; }
#endif

  manylight::Shapes<float> held;
};
