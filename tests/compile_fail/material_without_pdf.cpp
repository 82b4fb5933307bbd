// SPDX-License-Identifier: Apache-2.0
// expect: Material
// expect: pdf
#include "manylight/scattering/concepts.hpp"
#include "manylight/scene/shader.hpp"

struct Paint {
  using Scalar = float;
  using Color = manylight::Rgb<float>;
  using Vec3 = manylight::Vec3<float>;
  Color eval(const Vec3&, const Vec3&) const noexcept { return Color(0.1F); }
  std::optional<manylight::DirectionSample<float>> sample(const Vec3&, manylight::Walk, float,
                                                          const manylight::Vec2<float>&) const noexcept {
    return std::nullopt;
  }
#ifdef MANYLIGHT_CORRECT
  float pdf(const Vec3&, const Vec3&, manylight::Walk) const noexcept { return 0; }
#endif
  Color albedo() const noexcept { return Color(0.3F); }
  bool is_delta() const noexcept { return false; }
};

int main() { return sizeof(manylight::UniformShader<Paint>) > 0 ? 0 : 1; }
