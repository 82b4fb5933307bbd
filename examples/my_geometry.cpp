// SPDX-License-Identifier: Apache-2.0
// A user's own Geometry: a handful of spheres, tested one by one.
#include <cstdio>

#include "manylight/manylight.hpp"

using namespace manylight;

struct SphereList {
  using Scalar = double;
  explicit SphereList(Shapes<double> shapes) : shapes_(std::move(shapes)) {}

  template <class Visit>
  void all_hits(const Ray<double>& ray, const Visit& visit) const {
    for (std::uint32_t id = 0; id < shapes_.size(); ++id) {  // |o + t d|^2 = radius^2, as a t^2 + 2 b t + c = 0
      const Vec3<double> o = ray.origin - shapes_.sphere(id).center, d = ray.direction;
      const double a = glm::dot(d, d), b = glm::dot(o, d), c = glm::dot(o, o) - sqr(shapes_.sphere(id).radius);
      for (const double sign : {-1.0, 1.0}) {
        const double t = (-b + sign * std::sqrt(b * b - a * c)) / a;  // a NaN if there is none
        if (t >= ray.t_min && t <= ray.t_max) visit(Hit<double>{t, id, 0, 0, 0});
      }
    }
  }
  [[nodiscard]] std::optional<Hit<double>> closest_hit(const Ray<double>& ray) const {
    std::optional<Hit<double>> best;
    all_hits(ray, [&](const Hit<double>& hit) { best = best && best->t <= hit.t ? best : hit; });
    return best;
  }
  [[nodiscard]] bool any_hit(const Ray<double>& ray) const { return closest_hit(ray).has_value(); }
  void any_hit_batch(std::span<const Ray<double>> rays, std::span<std::uint8_t> blocked) const {
    for (std::size_t i = 0; i < rays.size(); ++i) blocked[i] = any_hit(rays[i]) ? 1 : 0;
  }
  [[nodiscard]] Box<double> bounds() const {
    Box<double> all;
    for (const auto& s : shapes_.spheres) all.extend(Box<double>{s.center - s.radius, s.center + s.radius});
    return all;
  }
  [[nodiscard]] const Shapes<double>& shapes() const { return shapes_; }

  Shapes<double> shapes_;
};

int main() {
  // In a sphere of 1 m and albedo 0.5 around a light of pi W/sr all see 1/2 + 1/4 + ... = 1 W/m^2/sr, everywhere.
  Shapes<double> shapes;
  shapes.spheres = {{.flip_normals = true}};
  EmitterList<double> lights;
  lights.points = {{.intensity = Rgb<double>(k_pi<double>)}};
  const Scene scene(SphereList(shapes), std::vector<UniformShader<Lambertian<double>>>(1), {0}, lights);
  RayCounts rays;
  double sum = 0;
  for (std::uint64_t i = 0; i < 20'000; ++i) {
    auto stream = IndependentSampler<double>{1}.stream(Stage::eye, i);
    const Ray<double> ray{Vec3<double>(0.3, 0.2, -0.1), warp::square_to_sphere(stream.next_2d())};
    sum += PathIntegrator(scene, PathConfig{}).radiance(ray, stream, rays).x / 20'000;
  }
  std::printf("radiance %.4f, expected 1\n", sum);
  return std::abs(sum - 1) < 0.02 ? 0 : 1;  // 4 standard errors: a path's deviation is below 0.7
}
