// SPDX-License-Identifier: Apache-2.0
// expect: manylight::Scene: the first argument must model Geometry
// expect: any_hit
#include "manylight/geometry/concepts.hpp"
#include "manylight/scattering/lambertian.hpp"
#include "manylight/scene/scene.hpp"

/// A backend that forgot one member.
struct Nothing {
  using Scalar = float;
  std::optional<manylight::Hit<float>> closest_hit(const manylight::Ray<float>&) const { return std::nullopt; }
#ifdef MANYLIGHT_CORRECT
  bool any_hit(const manylight::Ray<float>&) const { return false; }
#endif
  template <class Visit>
  void all_hits(const manylight::Ray<float>&, const Visit&) const {}
  void any_hit_batch(std::span<const manylight::Ray<float>>, std::span<std::uint8_t>) const {}
  manylight::Box<float> bounds() const { return {}; }
  const manylight::Shapes<float>& shapes() const { return shapes_; }

 private:
  manylight::Shapes<float> shapes_;
};

using Shader = manylight::UniformShader<manylight::Lambertian<float>>;

int main() { return sizeof(manylight::Scene<Nothing, Shader>) > 0 ? 0 : 1; }
