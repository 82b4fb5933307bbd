// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>

#include "integrator/bidirectional_oracle.hpp"
#include "integrator/bidirectional_scenes.hpp"

// Weights of traced paths against the slow form. Caught: roulette in one walk's density only; the directions of the other
// walk's density exchanged; a point light's selection left out of its walks; cosines at vertices in media.

namespace manylight::test::bidirectional_oracle_test {
namespace {

using S = double;
using Stream = IndependentStream<S>;

/// Traces walks in a scene and compares the weight of everything that they find.
template <class SceneType>
class WeightCheck {
 public:
  WeightCheck(const SceneType& scene, const PerspectiveCamera<S>& camera, bool with_lens)
      : scene_(scene), camera_(camera), light_paths_(with_lens ? camera.width() * camera.height() : 0) {}

  void run(std::uint32_t samples) {
    const IndependentSampler<S> sampler{5};
    const auto filter = ReconstructionFilter<S>::box();
    for (std::uint32_t i = 0; i < samples; ++i) {
      for (std::uint32_t x = 0; x < camera_.width(); ++x) {
        const std::uint32_t y = (x + i) % camera_.height();
        Stream light_stream = sampler.stream(Stage::light, film_index(camera_, x, y), i);
        Stream stream = sampler.stream(Stage::eye, film_index(camera_, x, y), i);
        BidirectionalWalk<SceneType, Stream>(scene_, light_stream, rays_).trace_light(k_edges, light_);
        const Ray<S> ray = camera_ray(camera_, filter, x, y, stream);
        const S density = camera_.film_density(ray.direction);
        BidirectionalWalk<SceneType, Stream>(scene_, stream, rays_)
            .trace_eye(ray, PartialWeights<S>::of_lens(light_paths_, density), k_edges, eye_);
        check_eye(ray, density, stream);
        if (light_paths_ > 0) check_lens(light_stream);
      }
    }
  }
  S worst = 0;                                  ///< largest difference between a weight and the oracle's
  S worst_sum = 0;                              ///< of the oracle's from 1
  std::size_t compared = 0;
  std::array<std::size_t, 16> of_s{}, of_t{};   ///< how many of them had that s, t

 private:
  static constexpr unsigned k_edges = 7;
  using V = BidirectionalVertex<SceneType>;

  /// The part that eye vertices [0, t - 1) make, from the light's side on.
  WholePath<SceneType> eye_part(const Ray<S>& ray, S density, std::size_t count) const {
    WholePath<SceneType> path;
    path.lens = ray.origin;
    path.film_density = density;
    path.light_paths = light_paths_;
    for (std::size_t k = count; k-- > 0;) add(path, eye_.vertices[k], k + 1 < count, eye_.vertices[k].vertex.w);
    return path;
  }
  static void add(WholePath<SceneType>& path, const V& v, bool has_left, const Vec3<S>& towards_lens) {
    path.vertices.push_back(&v);
    path.is_dirac.push_back(has_left && v.left_by_dirac);
    path.directions.push_back(towards_lens);
  }
  void compare(WholePath<SceneType>& path, std::size_t s, S weight) {
    if (!(weight > 0)) return;
    const std::vector<S> expected = path.weights(s);
    S sum = 0;
    for (const S w : expected) sum += w;
    const S difference = std::abs(weight - expected[s]);
    if (!(difference <= worst)) worst = difference;  // also NaN
    if (!(std::abs(sum - 1) <= worst_sum)) worst_sum = std::abs(sum - 1);
    ++compared;
    ++of_s[s];
    ++of_t[path.length() + 1 - s];
  }

  void check_eye(const Ray<S>& ray, S density, Stream& stream) {
    for (std::size_t k = 0; k < eye_.vertices.size(); ++k) {
      const V& v = eye_.vertices[k];
      if (k > 0 && !is_black(v.emission)) {
        auto path = eye_part(ray, density, k);
        path.is_dirac.front() = eye_.vertices[k - 1].left_by_dirac;
        path.directions.insert(path.directions.begin(), v.vertex.w);
        path.light = hit_light(v, path.vertices.front()->vertex.position);
        compare(path, 0, v.emission_weight);
      }
      if (v.is_delta) continue;
      check_drawn(ray, density, k, stream);
      for (std::size_t l = 0; l < light_.vertices.size(); ++l) {
        if (light_.vertices[l].is_delta) continue;
        const auto found = connect_vertices(scene_, v, light_.vertices[l], stream, rays_);
        if (!found) continue;
        auto path = eye_part(ray, density, k + 1);
        const Vec3<S> joint = glm::normalize(v.vertex.position - light_.vertices[l].vertex.position);
        prepend_light(path, l + 1, joint);
        compare(path, l + 2, found->weight);
      }
    }
    if (!eye_.vertices.empty() && !is_black(eye_.environment)) {
      auto path = eye_part(ray, density, eye_.vertices.size());
      path.is_dirac.front() = eye_.vertices.back().left_by_dirac;
      path.directions.insert(path.directions.begin(), -eye_.last_direction);
      path.light = infinite_light(scene_, EmitterKind::environment, eye_.last_direction,
                                  scene_.emitters().pdf_direct_environment(eye_.last_direction));
      compare(path, 0, eye_.environment_weight);
    }
  }
  void check_drawn(const Ray<S>& ray, S density, std::size_t k, Stream& stream) {
    Stream same = stream;
    const V& v = eye_.vertices[k];
    const auto found = connect_with_drawn_light(scene_, v, stream, rays_);
    if (!found) return;
    const S u_select = same.next();
    const auto light = scene_.emitters().sample_direct(v.vertex.position, u_select, same.next_2d());
    auto path = eye_part(ray, density, k + 1);
    path.directions.insert(path.directions.begin(), -light->wi);
    path.light = drawn_light(*light, v.vertex.position);
    compare(path, 1, found->weight);
  }
  void check_lens(Stream& stream) {
    for (std::size_t l = 0; l < light_.vertices.size(); ++l) {
      if (light_.vertices[l].is_delta) continue;
      const auto found = connect_with_lens(scene_, camera_, light_.vertices[l], light_paths_, stream, rays_);
      if (!found) continue;
      const Vec3<S> lens = camera_.ray(found->film, {0.5, 0.5}).origin;  // of a pinhole
      const Vec3<S> joint = glm::normalize(lens - light_.vertices[l].vertex.position);
      WholePath<SceneType> path;
      path.lens = lens;
      path.film_density = camera_.film_density(-joint);
      path.light_paths = light_paths_;
      prepend_light(path, l + 1, joint);
      compare(path, l + 2, found->weight);
    }
  }

  /// Puts the first `count` vertices of the light walk and its start before `path`, `joint` being the segment in between.
  void prepend_light(WholePath<SceneType>& path, std::size_t count, const Vec3<S>& joint) const {
    WholePath<SceneType> front;
    front.directions.push_back(light_.start->wo);
    for (std::size_t k = 0; k < count; ++k) {
      const bool is_last = k + 1 == count;
      add(front, light_.vertices[k], !is_last, is_last ? joint : -light_.vertices[k + 1].vertex.w);
    }
    path.vertices.insert(path.vertices.begin(), front.vertices.begin(), front.vertices.end());
    path.is_dirac.insert(path.is_dirac.begin(), front.is_dirac.begin(), front.is_dirac.end());
    path.directions.insert(path.directions.begin(), front.directions.begin(), front.directions.end());
    path.light = started_light(path.vertices.front()->vertex.position);
  }
  [[nodiscard]] PathLight started_light(const Vec3<S>& reference) const {
    const EmissionSample<S>& start = *light_.start;
    if (is_infinite(start.kind)) return infinite_light(scene_, start.kind, -start.wo, start.pdf_direction);
    if (start.kind == EmitterKind::point) {
      return {start.kind, start.position, Vec3<S>(0), start.pdf_position, start.pdf_direction, start.pdf_position};
    }
    SurfacePoint<S> point{};
    point.position = start.position;
    point.ng = start.ng;
    point.shape = start.shape;
    point.primitive = start.primitive;
    return area_light(scene_, point, start.two_sided, reference);
  }
  [[nodiscard]] PathLight drawn_light(const DirectSample<S>& light, const Vec3<S>& reference) const {
    if (light.infinite) return infinite_light(scene_, light.kind, light.wi, light.pdf);
    if (light.kind == EmitterKind::point) {
      return {light.kind, light.position, Vec3<S>(0), light.pdf, 0.25 * k_inv_pi<S>, light.pdf};  // no spots here
    }
    SurfacePoint<S> point{};
    point.position = light.position;
    point.ng = light.ng;
    point.shape = light.shape;
    point.primitive = light.primitive;
    return area_light(scene_, point, false, reference);
  }
  [[nodiscard]] PathLight hit_light(const V& v, const Vec3<S>& reference) const {
    Stream unused(0, Stage::test, 0, 0);
    RayCounts rays;
    const Vec3<S> segment = v.vertex.position - reference;
    // Which shape and triangle it is, the vertex has forgotten.
    const auto point = scene_.intersect({v.vertex.position + v.vertex.w * 1e-3, -v.vertex.w}, unused, rays);
    EXPECT_LT(glm::length(point->position - v.vertex.position), 1e-9) << glm::length(segment);
    SurfacePoint<S> here = *point;
    here.position = v.vertex.position;
    return area_light(scene_, here, false, reference);
  }

  const SceneType& scene_;
  const PerspectiveCamera<S>& camera_;
  S light_paths_;
  Subpath<SceneType> light_, eye_;
  RayCounts rays_;
};

/// 1e-12: rounding of some hundred operations, ill-conditioned where directions graze.
template <class SceneType>
void expect_weights(const SceneType& scene, const PerspectiveCamera<S>& camera, std::uint32_t samples, bool sees_lights) {
  for (const bool with_lens : {true, false}) {
    WeightCheck<SceneType> check(scene, camera, with_lens);
    check.run(samples);
    EXPECT_LT(check.worst, 1e-12) << "lens " << with_lens;
    EXPECT_LT(check.worst_sum, 1e-12);
    for (std::size_t s = sees_lights ? 0 : 1; s <= 5; ++s) EXPECT_GT(check.of_s[s], 50U) << "s = " << s;
    for (std::size_t t = with_lens ? 1 : 2; t <= 6; ++t) EXPECT_GT(check.of_t[t], 50U) << "t = " << t;
    std::cout << check.compared << " weights, worst " << check.worst << '\n';
  }
}

TEST(BidirectionalOracle, RoomWithGlassAndMirror) {
  expect_weights(room_of_balls().build(), room_camera(), 200, true);
}
TEST(BidirectionalOracle, SkyAndSun) {
  BallBuilder builder = open_floor();
  add_sky(builder);
  add_sun(builder);
  builder.sphere({{0, -0.8, -0.2}, 0.3, false}, BallMaterial(Dielectric<S>{1.5}), false);
  builder.sphere({{0.9, 0.9, 0}, 0.5, false}, BallMaterial(Mirror<S>{Rgb<S>(0.9)}));
  builder.mesh(parallelogram<S>({0, 1.5, 0.5}, {1.5, 0, 0}, {0, 0, 1}), matte(0.8));
  expect_weights(builder.build(), floor_camera(0), 1500, true);
}
TEST(BidirectionalOracle, SphericalLight) {
  BallBuilder builder = open_floor();
  builder.mesh(parallelogram<S>({0, 1.5, 0.5}, {1.5, 0, 0}, {0, 0, 1}), matte(0.8));
  builder.emit(builder.sphere({{-0.5, 0.3, 1}, 0.3, false}, matte(0.4)), Rgb<S>(5));
  expect_weights(builder.build(), floor_camera(0), 1000, true);
}
TEST(BidirectionalOracle, Fog) {
  FoggyBuilder builder = box_of_fog(false);
  builder.point_light({0.3, 0.2, 0.4}, 0.4);
  expect_weights(builder.build(), floor_camera(0), 300, false);
}

}  // namespace
}  // namespace manylight::test::bidirectional_oracle_test
