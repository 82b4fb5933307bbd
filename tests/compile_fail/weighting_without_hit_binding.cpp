// SPDX-License-Identifier: Apache-2.0
// expect: manylight::EyeSubpath: the weighting must model Weighting
// expect: hit_binding
#include "manylight/geometry/bvh.hpp"
#include "manylight/path/eye_subpath.hpp"
#include "manylight/scattering/lambertian.hpp"

/// A rule that forgot one member.
struct Nothing {
  using Scalar = float;
  using Pair = manylight::PairPatterns<float>;
  struct Record {};
  Record start() const { return {}; }
  Record extend(const Record&, float, float, float) const { return {}; }
  Record extend_delta(const Record&) const { return {}; }
  float weight(const Record&, const Pair&) const { return 0; }
  float hit_weight(const Record&, float) const { return 0; }
  manylight::Constraint binding(const Record&, const Pair&) const { return manylight::Constraint::energy; }
#ifdef MANYLIGHT_CORRECT
  manylight::Constraint hit_binding(const Record&, float) const { return manylight::Constraint::energy; }
#endif
  bool takes_hits() const { return false; }
  bool prune(const Record&, float) const { return true; }
  bool prune_delta(const Record&) const { return true; }
  manylight::SensorLimit<float> limit(const Record&) const { return {}; }
  float clamp() const { return 0; }
  float light_limit() const { return 0; }
};

using Scene = manylight::Scene<manylight::Bvh<float>, manylight::UniformShader<manylight::Lambertian<float>>>;
struct Visitor {};
using Subpath = manylight::EyeSubpath<Scene, Nothing, manylight::IndependentStream<float>, Visitor>;

int main() { return sizeof(Subpath) > 0 ? 0 : 1; }
