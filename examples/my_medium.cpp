// SPDX-License-Identifier: Apache-2.0
// A user's own Medium: air that thins out with height, sigma_t = sigma_0 exp(-z / H), in closed form.
#include <cmath>
#include <cstdio>

#include "manylight/media/concepts.hpp"
#include "manylight/media/free_flight.hpp"

using manylight::k_infinity;
using Color = manylight::Rgb<double>;
using Vec3 = manylight::Vec3<double>;
using Ray = manylight::Ray<double>;

struct Isotropic {
  using Scalar = double;
};

/// For rays above the ground, z >= 0, where it is thickest.
struct Atmosphere {
  using Scalar = double;
  using Phase = Isotropic;
  static constexpr bool k_closed_form = true;
  double sigma_0 = 0.7;  ///< m^-1, above 0
  double height = 2;     ///< H, m: where 1 / e is left
  double albedo = 0.9;

  [[nodiscard]] double extinction(double z) const { return sigma_0 * std::exp(-z / height); }
  [[nodiscard]] Color sigma_t(const Vec3& x, const Vec3& /*w*/) const { return Color(extinction(x.z)); }
  [[nodiscard]] Color sigma_s(const Vec3& x, const Vec3& w) const { return albedo * sigma_t(x, w); }
  [[nodiscard]] Phase phase(const Vec3& /*x*/) const { return {}; }
  [[nodiscard]] double min_sigma_t() const { return 0; }

  /// int_0^t sigma_0 exp(-(z + w.z s) / H) ds.
  [[nodiscard]] double thickness(const Ray& ray, double t) const {
    const double rate = ray.direction.z / height;
    return extinction(ray.origin.z) * (rate == 0 ? t : -std::expm1(-rate * t) / rate);
  }
  [[nodiscard]] Color mean_transmittance(const Ray& ray, double t) const { return Color(std::exp(-thickness(ray, t))); }
  [[nodiscard]] Color transmittance(const Ray& ray, double t, manylight::SampleStream auto& /*stream*/) const {
    return mean_transmittance(ray, t);
  }
  /// The distance at which the thickness is an exponential variate; there may be none, as space above is thin.
  [[nodiscard]] manylight::MediumSample<double> sample(const Ray& ray, double t_max,
                                                       manylight::SampleStream auto& stream) const {
    const double rate = ray.direction.z / height;
    const double at_origin = manylight::optical_flight(stream.next()) / extinction(ray.origin.z);
    const double t = rate == 0              ? at_origin
                     : rate * at_origin < 1 ? -std::log1p(-rate * at_origin) / rate
                                            : k_infinity<double>;
    if (!(t < t_max)) return {t_max, Color(1), false};
    return {t, Color(1 / extinction(ray.origin.z + ray.direction.z * t)), true};
  }
};
static_assert(manylight::Medium<Atmosphere>);

int main() {
  const Atmosphere air;
  manylight::IndependentStream<double> stream(1, manylight::Stage::test, 0, 0);
  bool holds = true;
  for (const Vec3& w : {Vec3(0, 0, 1), Vec3(0.8, 0, 0.6), Vec3(1, 0, 0), Vec3(0.8, 0, -0.6)}) {
    constexpr int k_flights = 100'000;
    int through = 0;
    for (int i = 0; i < k_flights; ++i) through += air.sample({{0, 0, 3}, w}, 4, stream).scattered ? 0 : 1;
    const double share = static_cast<double>(through) / k_flights;
    const double oracle = air.mean_transmittance({{0, 0, 3}, w}, 4).x;
    std::printf("got through: %.4f, transmittance %.4f\n", share, oracle);
    holds = holds && std::abs(share - oracle) < 5 * std::sqrt(oracle * (1 - oracle) / k_flights);
  }
  return holds ? 0 : 1;
}
