// SPDX-License-Identifier: Apache-2.0
// A user's own PhaseFunction: Rayleigh scattering by particles much smaller than the wavelength. eval is a template
// over its directions; its bounds follow, and are searched for violations.
#include <cmath>
#include <cstdio>

#include "manylight/manylight.hpp"

using namespace manylight;

/// f_p = 3 / (16 pi) (1 + cos^2 Theta), the same in the world's frame for every orientation.
struct Rayleigh {
  using Scalar = float;
  static constexpr bool k_isotropic_density = true;  // the medium is equally dense in all directions
  static constexpr float k_scale = 3 * k_inv_pi<float> / 16;

  /// Of two vectors a number, of sets of directions a range of numbers: one text for both.
  template <LocalDirection<float> W, LocalDirection<float> V>
  [[nodiscard]] auto eval(const W& sampled, const V& known) const noexcept {
    return k_scale * (1.0F + sqr(dot(sampled, known)));
  }
  /// The distribution function of c = cos Theta, u = (c^3 + 3 c + 4) / 8, solved for c by Cardano's formula.
  [[nodiscard]] std::optional<PhaseSample<float>> sample(const Vec3<float>& known,
                                                         const Vec2<float>& u) const noexcept {
    const float q = 4 * u.x - 2;
    const float root = std::cbrt(std::abs(q) + std::sqrt(1 + q * q));
    const float c = std::copysign(std::min(root - 1 / root, 1.0F), q);
    const float s = safe_sqrt(1 - c * c);
    const float phi = 2 * k_pi<float> * u.y;
    const Vec3<float> local(s * std::cos(phi), s * std::sin(phi), c);
    const Vec3<float> w = glm::normalize(Frame<float>(-known).to_world(local));
    return PhaseSample<float>{w, eval(w, known)};
  }
  [[nodiscard]] float pdf(const Vec3<float>& sampled, const Vec3<float>& known) const noexcept {
    return eval(sampled, known);
  }
  [[nodiscard]] float projected_area(const Vec3<float>&) const noexcept { return 0.5F; }
};

static_assert(SetEvaluablePhase<Rayleigh>);

int main() {
  const Vec3<float> known = glm::normalize(Vec3<float>(0.2F, -0.5F, 0.8F));
  double sum = 0, square_cosine = 0;
  for (std::uint32_t i = 0; i < 100000; ++i) {
    IndependentStream<float> stream(1, Stage::test, i, 0);
    const Vec3<float> anywhere = warp::square_to_sphere(stream.next_2d());
    sum += Rayleigh{}.eval(anywhere, known) * 4 * k_pi<float> / 100000;
    square_cosine += sqr(glm::dot(Rayleigh{}.sample(known, stream.next_2d())->direction, known)) / 100000;
  }
  const BoundsReport<float> report = falsify_phase(Rayleigh{}, AutomaticBounds{}, PhaseSets::both, 300);
  std::printf("integral %.4f, mean cos^2 of draws %.4f; bounds: %u of %u refuted, mean slack %.3f\n", sum,
              square_cosine, report.refuted, report.configurations, report.slack());
  // The integral of cos^2 f_p is 2 / 5; standard errors of the means are 1e-3.
  return std::abs(sum - 1) < 0.005 && std::abs(square_cosine - 0.4) < 0.005 && report.refuted == 0 ? 0 : 1;
}
