// SPDX-License-Identifier: Apache-2.0
// A user's own subsurface falloff: a narrow and a wide Gaussian per channel, as fits of skin have them. One profile
// makes the whole SubsurfaceFalloff; random lines around a point of a plane check it.
#include <cmath>
#include <cstdio>

#include "manylight/manylight.hpp"

using namespace manylight;

/// One channel: g = w g_narrow + (1 - w) g_wide, m^-2.
struct TwoGaussians {
  using Scalar = float;
  GaussianProfile<float> narrow, wide;
  float narrow_share = 0.5F;

  [[nodiscard]] float eval(float d) const noexcept {
    return narrow_share * narrow.eval(d) + (1 - narrow_share) * wide.eval(d);
  }
  /// Density -pi r^2 g'(r): linear in g, so that the law of a sum is the mixture of the laws.
  template <SampleStream Stream>
  [[nodiscard]] float sample_radius(Stream& stream) const noexcept {
    return stream.next() < narrow_share ? narrow.sample_radius(stream) : wide.sample_radius(stream);
  }
};

using SkinFalloff = RgbFalloff<TwoGaussians>;
static_assert(SubsurfaceFalloff<SkinFalloff>);

int main() {
  const auto channel = [](float narrow, float wide, float share) {
    return TwoGaussians{GaussianProfile<float>(narrow), GaussianProfile<float>(wide), share};
  };
  // Red light gets farthest.
  const SkinFalloff skin(channel(4e-4F, 2e-3F, 0.4F), channel(3e-4F, 9e-4F, 0.6F), channel(2e-4F, 5e-4F, 0.7F));
  const Subsurface<SkinFalloff> body{skin, {0.8F, 0.5F, 0.4F}};

  Shapes<float> shapes;
  shapes.disks.push_back({{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, 1.0F});  // a square metre and more: a plane to this skin
  const Bvh<float> plane(shapes);
  constexpr unsigned k_lines = 400000;
  IndependentStream<float> stream(1, Stage::test, 0, 0);
  unsigned hits = 0;
  Vec3<double> back(0);  // what returns of even light: rho
  random_lines(plane, 0, Vec3<float>(0), skin, k_lines, stream, [&](const SurfacePoint<float>& point, float pdf) {
    ++hits;
    back += Vec3<double>(body.rho * body.transit(glm::length(point.position)) * (k_inv_pi<float> / pdf));
  });
  std::printf("hits per line %.4f; returned %.4f %.4f %.4f\n", hits / double(k_lines), back.x, back.y, back.z);
  // Half of the lines cross a plane; standard errors are 1e-3 and, of the weighted sums, 3e-3.
  const Vec3<double> error = glm::abs(back - Vec3<double>(body.rho));
  return std::abs(hits / double(k_lines) - 0.5) < 0.005 && error.x + error.y + error.z < 0.03 ? 0 : 1;
}
