// SPDX-License-Identifier: Apache-2.0
// A user's own Geometry: a handful of spheres, tested one by one.
#include <cmath>
#include <cstdio>

#include "manylight/geometry/concepts.hpp"
#include "manylight/scattering/lambertian.hpp"
#include "manylight/scene/scene.hpp"

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
  // A hollow sphere of radius 1 m with a point light of pi W/sr in its centre: the wall, of albedo 0.5, reflects
  // 0.5 / pi * pi / 1^2 = 0.5 W/m^2/sr of direct light everywhere.
  manylight::Shapes<double> shapes;
  shapes.spheres.push_back({.center = manylight::Vec3<double>(0), .radius = 1, .flip_normals = true});
  manylight::EmitterList<double> lights;
  lights.points.push_back({.position = manylight::Vec3<double>(0), .intensity = manylight::Rgb<double>(3.14159265358979)});

  using Shader = manylight::UniformShader<manylight::Lambertian<double>>;
  const manylight::Scene<SphereList, Shader> scene(SphereList(shapes), {Shader{}}, {0}, lights);
  return 0;
}
