// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "integrator/bidirectional_oracle.hpp"
#include "integrator/bidirectional_scenes.hpp"

// Weights of traced paths against the slow form.

namespace manylight::test {

/// Traces walks in a scene and compares the weight of everything that they find.
template <class SceneType>
class WeightCheck {
 public:
  using S = double;
  using Stream = IndependentStream<S>;

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
  std::size_t connected_below = 0;              ///< of these, how many through an object
  std::array<std::size_t, 16> of_s{}, of_t{};   ///< how many of them had that s, t

 private:
  static constexpr unsigned k_edges = 7;
  using V = BidirectionalVertex<SceneType>;

  /// The vertices of `walk` that lead to its vertex `last`, it included: all but inner ones where the walk stayed outside,
  /// and surfaces where it went in.
  static std::vector<std::size_t> chain(const Subpath<SceneType>& walk, std::size_t last) {
    std::vector<std::size_t> all{last};
    for (std::size_t k = last; k-- > 0;) {
      const auto& next = walk.vertices[all.front()].vertex;
      const auto& v = walk.vertices[k].vertex;
      if (v.edges + 1 == next.edges && v.is_inner() == next.is_outer()) all.insert(all.begin(), k);
    }
    return all;
  }

  /// The part that the eye vertices up to `last` make, from the light's side on.
  WholePath<SceneType> eye_part(const Ray<S>& ray, S density, std::size_t last) const {
    WholePath<SceneType> path;
    path.lens = ray.origin;
    path.film_density = density;
    path.light_paths = light_paths_;
    const auto all = chain(eye_, last);
    for (std::size_t k = all.size(); k-- > 0;) {
      const V& v = eye_.vertices[all[k]];
      add(path, v, k + 1 < all.size(), v.vertex.w, v.vertex.is_outer());
    }
    return path;
  }
  static void add(WholePath<SceneType>& path, const V& v, bool has_left, const Vec3<S>& towards_lens, bool is_below) {
    path.is_below.push_back(is_below);
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
        const auto all = chain(eye_, k);
        const std::size_t before = all[all.size() - 2];
        auto path = eye_part(ray, density, before);
        path.is_dirac.front() = eye_.vertices[before].left_by_dirac;
        path.directions.insert(path.directions.begin(), v.vertex.w);
        path.is_below.insert(path.is_below.begin(), false);
        path.light = hit_light(v, path.vertices.front()->vertex.position);
        compare(path, 0, v.emission_weight);
      }
      if (v.is_delta) continue;
      check_drawn(ray, density, k, stream);
      for (std::size_t l = 0; l < light_.vertices.size(); ++l) {
        if (light_.vertices[l].is_delta) continue;
        const auto found = connect_vertices(scene_, v, light_.vertices[l], stream, rays_);
        if (!found) continue;
        auto path = eye_part(ray, density, k);
        const Vec3<S> joint = glm::normalize(v.vertex.position - light_.vertices[l].vertex.position);
        prepend_light(path, l, joint, v.vertex.is_inner());
        compare(path, light_.vertices[l].vertex.edges + 1U, found->weight);
        connected_below += v.vertex.is_inner() ? 1 : 0;
      }
    }
    if (!eye_.vertices.empty() && !is_black(eye_.environment)) {
      // A walk that has left stood last on a surface's own vertex, before the inner one, or on an outer one.
      std::size_t last = eye_.vertices.size() - 1;
      if (eye_.vertices[last].vertex.is_inner()) --last;
      auto path = eye_part(ray, density, last);
      path.is_dirac.front() = eye_.vertices[last].left_by_dirac;
      path.directions.insert(path.directions.begin(), -eye_.last_direction);
      path.is_below.insert(path.is_below.begin(), false);
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
    auto path = eye_part(ray, density, k);
    path.directions.insert(path.directions.begin(), -light->wi);
    path.is_below.insert(path.is_below.begin(), false);
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
      prepend_light(path, l, joint, false);
      compare(path, light_.vertices[l].vertex.edges + 1U, found->weight);
    }
  }

  /// Puts the vertices of the light walk up to `last` and its start before `path`, `joint` being the segment in between.
  void prepend_light(WholePath<SceneType>& path, std::size_t last, const Vec3<S>& joint, bool joins_below) const {
    WholePath<SceneType> front;
    front.directions.push_back(light_.start->wo);
    front.is_below.push_back(false);
    const auto all = chain(light_, last);
    for (std::size_t k = 0; k < all.size(); ++k) {
      const bool is_last = k + 1 == all.size();
      const auto* next = is_last ? nullptr : &light_.vertices[all[k + 1]].vertex;
      add(front, light_.vertices[all[k]], !is_last, is_last ? joint : -next->w, is_last ? joins_below : next->is_outer());
    }
    path.vertices.insert(path.vertices.begin(), front.vertices.begin(), front.vertices.end());
    path.is_dirac.insert(path.is_dirac.begin(), front.is_dirac.begin(), front.is_dirac.end());
    path.directions.insert(path.directions.begin(), front.directions.begin(), front.directions.end());
    path.is_below.insert(path.is_below.begin(), front.is_below.begin(), front.is_below.end());
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
void expect_weights(const SceneType& scene, const PerspectiveCamera<double>& camera, std::uint32_t samples,
                    bool sees_lights) {
  for (const bool with_lens : {true, false}) {
    WeightCheck<SceneType> check(scene, camera, with_lens);
    check.run(samples);
    EXPECT_LT(check.worst, 1e-12) << "lens " << with_lens;
    EXPECT_LT(check.worst_sum, 1e-12);
    for (std::size_t s = sees_lights ? 0 : 1; s <= 5; ++s) EXPECT_GT(check.of_s[s], 50U) << "s = " << s;
    for (std::size_t t = with_lens ? 1 : 2; t <= 6; ++t) EXPECT_GT(check.of_t[t], 50U) << "t = " << t;
    EXPECT_GE(check.connected_below, SceneType::k_has_subsurface ? 50U : 0U);
  }
}

}  // namespace manylight::test
