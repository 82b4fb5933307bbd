// SPDX-License-Identifier: Apache-2.0
// A user's own Geometry: a handful of spheres, tested one by one.
#include <cmath>
#include <cstdio>

#include "manylight/geometry/concepts.hpp"
#include "manylight/integrator/path.hpp"
#include "manylight/scattering/lambertian.hpp"

class SphereList {
 public:
  using Scalar = double;
  using Ray = manylight::Ray<double>;
  using Hit = manylight::Hit<double>;

  explicit SphereList(manylight::Shapes<double> shapes) : shapes_(std::move(shapes)) {}

  [[nodiscard]] std::optional<Hit> closest_hit(Ray ray) const {
    std::optional<Hit> closest;
    all_hits(ray, [&](const Hit& hit) {
      if (!closest || hit.t < closest->t) closest = hit;
    });
    return closest;
  }
  [[nodiscard]] bool any_hit(const Ray& ray) const { return closest_hit(ray).has_value(); }

  template <class Visit>
  void all_hits(const Ray& ray, const Visit& visit) const {
    for (std::uint32_t id = 0; id < shapes_.size(); ++id) {
      const manylight::Sphere<double>& sphere = shapes_.sphere(id);
      // |origin + t direction - center|^2 = radius^2, as a t^2 + 2 b t + c = 0.
      const manylight::Vec3<double> from_center = ray.origin - sphere.center;
      const double a = glm::dot(ray.direction, ray.direction);
      const double b = glm::dot(from_center, ray.direction);
      const double c = glm::dot(from_center, from_center) - manylight::sqr(sphere.radius);
      const double discriminant = b * b - a * c;
      if (discriminant < 0) continue;
      for (const double sign : {-1.0, 1.0}) {
        const double t = (-b + sign * std::sqrt(discriminant)) / a;
        if (t >= ray.t_min && t <= ray.t_max) visit(Hit{t, id, 0, 0, 0});
      }
    }
  }
  void any_hit_batch(std::span<const Ray> rays, std::span<std::uint8_t> blocked) const {
    for (std::size_t i = 0; i < rays.size(); ++i) blocked[i] = any_hit(rays[i]) ? 1 : 0;
  }
  [[nodiscard]] manylight::Box<double> bounds() const {
    manylight::Box<double> box;
    for (const manylight::Sphere<double>& sphere : shapes_.spheres) {
      box.extend(sphere.center - sphere.radius);
      box.extend(sphere.center + sphere.radius);
    }
    return box;
  }
  [[nodiscard]] const manylight::Shapes<double>& shapes() const { return shapes_; }

 private:
  manylight::Shapes<double> shapes_;
};

static_assert(manylight::Geometry<SphereList>);

int main() {
  // A hollow sphere of radius 1 m and albedo 0.5 with a light of pi W/sr in its centre: each bounce adds half of the one
  // before, 1/2 + 1/4 + ..., so the radiance is 1 W/m^2/sr wherever one looks from.
  manylight::Shapes<double> shapes;
  shapes.spheres.push_back({.flip_normals = true});
  manylight::EmitterList<double> lights;
  lights.points.push_back({.intensity = manylight::Rgb<double>(manylight::k_pi<double>)});
  using Shader = manylight::UniformShader<manylight::Lambertian<double>>;
  const manylight::Scene<SphereList, Shader> scene(SphereList(shapes), {Shader{}}, {0}, lights);

  const manylight::PathIntegrator integrator(scene, manylight::PathConfig{});
  const manylight::IndependentSampler<double> sampler{1};
  manylight::RayCounts rays;
  double sum = 0;
  constexpr std::uint64_t samples = 20'000;
  for (std::uint64_t i = 0; i < samples; ++i) {
    auto stream = sampler.stream(manylight::Stage::eye, i);
    const manylight::Vec3<double> direction = manylight::warp::square_to_sphere(stream.next_2d());
    sum += integrator.radiance({manylight::Vec3<double>(0.3, 0.2, -0.1), direction}, stream, rays).x;
  }
  const double radiance = sum / samples;
  std::printf("radiance %.4f, expected 1, from %llu rays\n", radiance,
              static_cast<unsigned long long>(rays.closest + rays.shadow));
  return std::abs(radiance - 1) < 0.02 ? 0 : 1;  // 4 standard errors: a path's deviation is below 0.7
}
