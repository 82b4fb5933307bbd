// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "integrator/media_scenes.hpp"
#include "integrator/room.hpp"
#include "manylight/integrator/bidirectional_image.hpp"
#include "manylight/scattering/any_of.hpp"
#include "manylight/scattering/conductor.hpp"
#include "manylight/scattering/dielectric.hpp"
#include "manylight/scattering/phong.hpp"

// Scenes and renderings for bidirectional path tracing, in double.

namespace manylight::test {

using BallMaterial = AnyOf<Lambertian<double>, Phong<double>, Mirror<double>, Dielectric<double>>;
using BallScene = Scene<Bvh<double>, UniformShader<BallMaterial>>;
using BallBuilder = SceneBuilder<Bvh<double>, BallMaterial>;

[[nodiscard]] inline BallMaterial matte(double albedo) { return BallMaterial(grey(albedo)); }
[[nodiscard]] inline BallMaterial gloss() { return BallMaterial(Phong<double>{Rgb<double>(0.8), 60}); }

/// The room with a ball of glass, one of gloss and a mirror, lit by an area light and a weak point light.
[[nodiscard]] inline BallBuilder room_of_balls() {
  BallBuilder builder = cornell<BallMaterial>(gloss());
  builder.sphere({{-0.5, -0.2, -0.6}, 0.3, false}, BallMaterial(Dielectric<double>{1.5}), false);
  builder.sphere({{-0.2, 0.6, -0.5}, 0.3, false}, BallMaterial(Mirror<double>{Rgb<double>(0.9)}));
  builder.point_light({0.6, -0.4, 0.5}, 0.2);
  return builder;
}

/// A floor and balls in the open.
[[nodiscard]] inline BallBuilder open_floor() {
  BallBuilder builder;
  builder.mesh(parallelogram<double>({0, 0, -0.5}, {2, 0, 0}, {0, 2, 0}), matte(0.6));
  builder.sphere({{0.4, 0, 0}, 0.5, false}, gloss());
  builder.sphere({{-0.6, 0.2, 0}, 0.4, false}, matte(0.7));
  return builder;
}
inline void add_sky(BallBuilder& builder) {
  auto image = std::make_shared<Image<double>>(8, 5);
  for (auto& texel : image->pixels) texel = Rgb<double>(0.5);
  image->at(5, 1) = Rgb<double>(8);
  EnvironmentEmitter<double> sky{Rgb<double>(1), image};
  sky.to_world = {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}};  // its up is z
  builder.lights.environments.push_back(sky);
}
inline void add_sun(BallBuilder& builder) {
  builder.lights.directionals.push_back({{0.4, 0.3, -1}, Rgb<double>(2)});
}
[[nodiscard]] inline PerspectiveCamera<double> floor_camera(double aperture_radius) {
  PerspectiveConfig<double> config;
  config.to_world = {{1, 0, 0, 0}, {0, 0, 1, 0}, {0, 1, 0, 0}, {0, -2.5, 0.2, 1}};
  config.horizontal_fov = 50;
  config.width = 12;
  config.height = 8;
  config.aperture_radius = aperture_radius;
  config.focus_distance = 2.2;
  return PerspectiveCamera<double>(config);
}

/// A box of fog, or of smoke on a grid, over a floor: half in it, half below it.
[[nodiscard]] inline FoggyBuilder box_of_fog(bool is_grid) {
  FoggyBuilder builder;
  builder.media = {fog(0.2, 0.8, 0.5)};
  if (is_grid) builder.media = {even_smoke({-1, -1, -0.7}, {1, 1, 1}, 1, 0.8, 0.5)};
  builder.open_mesh(box_mesh<double>({-1, -1, -0.7}, {1, 1, 1}), {k_vacuum, 1});
  builder.mesh(parallelogram<double>({0, 0, -0.8}, {2, 0, 0}, {0, 2, 0}), 0.6);
  builder.mesh(parallelogram<double>({0.5, 0.5, 0}, {0.3, 0, 0}, {0, 0, 0.3}), 0.6);
  builder.lamp(parallelogram<double>({0, 0, 1.5}, {0, 0.5, 0}, {0.5, 0, 0}), 5);
  return builder;
}

/// Red channel of images, averaged over the film: of the whole and of the paths of 1, 2, ... segments.
struct LengthMeans {
  double all = 0;
  std::vector<double> by_length;
};

/// Visitor of PathIntegrator::trace.
struct LengthCounter {
  LengthMeans& means;
  double scale;
  unsigned edges = 0;

  void add(unsigned length, double value) const {
    means.all += value * scale;
    if (length < means.by_length.size()) means.by_length[length] += value * scale;
  }
  void arrive(const Vec3<double>&) { ++edges; }
  void emission(const Rgb<double>& radiance, const SurfacePoint<double>&, const Vec3<double>&) const {
    add(edges, radiance.x);
  }
  void environment(const Rgb<double>& radiance) const { add(edges + 1, radiance.x); }
  template <class Hit>
  void direct(const Rgb<double>& radiance, const Hit&, const Vec3<double>&, const DirectSample<double>&,
              const Rgb<double>&) const {
    add(edges + 1, radiance.x);
  }
  template <class... Anything>
  void leave(const Anything&...) const {}
  template <class... Anything>
  void pass_below(const Anything&...) {
    ++edges;
  }
};

/// By path tracing; lengths below `lengths`.
template <class SceneType, Camera C>
[[nodiscard]] LengthMeans path_means(const SceneType& scene, const C& camera, std::uint32_t samples, std::size_t lengths,
                                     std::uint64_t seed, unsigned max_edges = k_unlimited_edges) {
  const PathIntegrator<SceneType> integrator(scene, PathConfig{max_edges});
  const auto filter = ReconstructionFilter<double>::box();
  const IndependentSampler<double> sampler{seed};
  LengthMeans means{0, std::vector<double>(lengths, 0.0)};
  const double scale = 1.0 / (static_cast<double>(samples) * camera.width() * camera.height());
  RayCounts rays;
  for (std::uint32_t y = 0; y < camera.height(); ++y) {
    for (std::uint32_t x = 0; x < camera.width(); ++x) {
      for (std::uint32_t i = 0; i < samples; ++i) {
        auto stream = sampler.stream(Stage::eye, film_index(camera, x, y), i);
        const Ray<double> ray = camera_ray(camera, filter, x, y, stream);
        LengthCounter counter{means, scale};
        integrator.trace(ray, stream, rays, counter);
      }
    }
  }
  return means;
}

struct BidirectionalFilm {
  BidirectionalSums sums;
  PathStatistics statistics;
  double samples;

  /// Red channel of the film's mean.
  [[nodiscard]] double mean(const std::vector<Rgb<double>>& image) const {
    double sum = 0;
    for (const Rgb<double>& pixel : image) sum += pixel.x;
    return sum / (static_cast<double>(image.size()) * samples);
  }
  [[nodiscard]] double mean() const { return mean(sums.eye) + mean(sums.light); }
  [[nodiscard]] double unweighted(unsigned s, unsigned t) const { return mean(sums.strategies.at(s, t).unweighted); }
  [[nodiscard]] double weighted(unsigned s, unsigned t) const { return mean(sums.strategies.at(s, t).weighted); }
};

template <class SceneType, Camera C, Executor Exec = SerialExecutor>
[[nodiscard]] BidirectionalFilm render_bidirectional(
    const SceneType& scene, const C& camera, std::uint32_t samples, std::uint64_t seed, unsigned strategy_edges = 0,
    const BidirectionalPathConfig& config = {},
    const ReconstructionFilter<typename SceneType::Scalar>& filter = ReconstructionFilter<typename SceneType::Scalar>::box(),
    const Exec& executor = {}) {
  const BidirectionalPathIntegrator<SceneType> integrator(scene, config);
  BidirectionalFilm film{BidirectionalSums(std::size_t{camera.width()} * camera.height(), strategy_edges), {},
                         static_cast<double>(samples)};
  film.statistics = accumulate_bidirectional_samples(integrator, camera, filter, Window::of(camera),
                                                     IndependentSampler<typename SceneType::Scalar>{seed}, 0, samples,
                                                     film.sums, executor);
  return film;
}

/// Means by path tracing and by bidirectional path tracing over `runs` independent renderings.
struct Comparison {
  RunningMoments path, bidirectional;
  std::vector<RunningMoments> path_of_length, weighted_of_length;
  std::vector<std::vector<RunningMoments>> unweighted;  ///< [length][s]
  unsigned runs;

  /// Largest difference that independent errors explain, in standard errors of a t-variable; family level 1e-3 over
  /// `comparisons` by Sidak.
  [[nodiscard]] double limit(double comparisons) const {
    return student_limit(sidak_level(1e-3, comparisons), static_cast<double>(runs - 1));
  }
};
[[nodiscard]] inline double z_between(const RunningMoments& a, const RunningMoments& b) {
  return z_score(a.mean(), a.standard_error(), b.mean(), b.standard_error());
}

template <class SceneType, Camera C>
[[nodiscard]] Comparison compare_with_path(const SceneType& scene, const C& camera, std::uint32_t path_samples,
                                           std::uint32_t samples, unsigned lengths, unsigned runs = 16,
                                           const BidirectionalPathConfig& config = {}) {
  Comparison c{{}, {}, std::vector<RunningMoments>(lengths + 1), std::vector<RunningMoments>(lengths + 1), {}, runs};
  for (unsigned n = 0; n <= lengths; ++n) c.unweighted.emplace_back(n + 1);
  for (unsigned run = 0; run < runs; ++run) {
    const LengthMeans path = path_means(scene, camera, path_samples, lengths + 1, 100 + run, config.max_edges);
    c.path.add(path.all);
    const BidirectionalFilm film = render_bidirectional(scene, camera, samples, 200 + run, lengths, config);
    EXPECT_EQ(film.statistics.invalid, 0U);
    c.bidirectional.add(film.mean());
    for (unsigned n = 1; n <= lengths; ++n) {
      c.path_of_length[n].add(path.by_length[n]);
      double weighted = 0;
      for (unsigned s = 0; s <= n; ++s) {
        weighted += film.weighted(s, n + 1 - s);
        c.unweighted[n][s].add(film.unweighted(s, n + 1 - s));
      }
      c.weighted_of_length[n].add(weighted);
    }
  }
  return c;
}

/// The mean of the film and of each path length up to `lengths`, every one with both errors below `largest_error` of it.
template <class SceneType, Camera C>
void expect_equals_path(const SceneType& scene, const C& camera, std::uint32_t path_samples, std::uint32_t samples,
                        double largest_error, unsigned lengths = 4, const BidirectionalPathConfig& config = {}) {
  const Comparison c = compare_with_path(scene, camera, path_samples, samples, lengths, 16, config);
  const double limit = c.limit(1.0 + lengths);
  EXPECT_LT(std::abs(z_between(c.bidirectional, c.path)), limit)
      << c.bidirectional.mean() << " for " << c.path.mean() << " +- " << c.path.standard_error();
  EXPECT_LT(c.path.standard_error(), largest_error * c.path.mean());
  EXPECT_LT(c.bidirectional.standard_error(), largest_error * c.path.mean());
  for (unsigned n = 1; n <= lengths; ++n) {
    EXPECT_LT(std::abs(z_between(c.weighted_of_length[n], c.path_of_length[n])), limit)
        << n << " segments: " << c.weighted_of_length[n].mean() << " for " << c.path_of_length[n].mean();
  }
}

/// Where on the film light walks arrive: direct light by them alone, pixel by pixel against the drawn light alone.
inline void expect_light_image_equals_eye_image(double aperture, const ReconstructionFilter<double>& filter,
                                                std::uint32_t samples) {
  BallBuilder builder = open_floor();
  builder.lights.points.push_back({{0.3, -1, 1.5}, Rgb<double>(3)});
  const auto scene = builder.build();
  const auto camera = floor_camera(aperture);
  const std::size_t pixels = std::size_t{camera.width()} * camera.height();
  constexpr unsigned k_runs = 24;
  std::vector<RunningMoments> eye(pixels), light(pixels);
  for (unsigned run = 0; run < k_runs; ++run) {
    const BidirectionalFilm film = render_bidirectional(scene, camera, samples, run, 2, {2}, filter);
    for (std::size_t i = 0; i < pixels; ++i) {
      eye[i].add(film.sums.strategies.at(1, 2).unweighted[i].x / samples);
      light[i].add(film.sums.strategies.at(2, 1).unweighted[i].x / samples);
    }
  }
  double brightest = 0, mean_error = 0;
  for (const RunningMoments& m : eye) brightest = std::max(brightest, m.mean());
  EXPECT_GT(brightest, 0.1);
  const double limit = student_limit(sidak_level(1e-3, static_cast<double>(pixels)), k_runs - 1);
  for (std::size_t i = 0; i < pixels; ++i) {
    const double error = std::hypot(eye[i].standard_error(), light[i].standard_error());
    // Eye walks draw the far ends of a filter so seldom that their errors are not known there: 0.2 % of the brightest.
    EXPECT_LT(std::abs(eye[i].mean() - light[i].mean()), limit * error + 2e-3 * brightest)
        << "pixel " << i << ": " << eye[i].mean() << ' ' << light[i].mean() << ", filter "
        << static_cast<int>(filter.kind()) << ", aperture " << aperture;
    mean_error += error / static_cast<double>(pixels);
  }
  EXPECT_LT(mean_error, 0.02 * brightest);  // more in the highlight
}

}  // namespace manylight::test
