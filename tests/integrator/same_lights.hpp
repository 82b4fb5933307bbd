// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "integrator/common_scenes.hpp"

// Every many-light method over one and the same set of VPLs, with the same sensors wherever the weighting is the same:
// what is left between a cut and the sum over all pairs is the cut's own error.

namespace manylight::test {

template <class SceneType>
class SameLights {
 public:
  using S = typename SceneType::Scalar;
  using Result = ManyLightImage<S>;

  /// Scene and camera must outlive it.
  SameLights(const SceneType& scene, const AnyCamera<S>& camera, const Settings& settings);

  /// Free to be changed between renderings.
  ManyLightConfig config;

  [[nodiscard]] Result all_pairs() const;
  [[nodiscard]] Result lightcuts() const;
  /// All pairs of the recursive sensors.
  [[nodiscard]] Result all_recursive_pairs() const;
  [[nodiscard]] Result bdlc() const;
  [[nodiscard]] Result brute(Method method) const {
    return method == Method::bdlc ? all_recursive_pairs() : all_pairs();
  }
  [[nodiscard]] Result cut(Method method) const { return method == Method::bdlc ? bdlc() : lightcuts(); }

 private:
  const SceneType& scene_;
  AnyCamera<S> camera_;
  ReconstructionFilter<S> filter_ = ReconstructionFilter<S>::box();
  IndependentSampler<S> sampler_;

 public:
  /// The VPLs and the constants of their weights; free to be changed between renderings.
  LightSide<SceneType> side;
};

template <class SceneType>
SameLights<SceneType>::SameLights(const SceneType& scene, const AnyCamera<S>& camera, const Settings& settings)
    : config(many_light_config(settings)),
      scene_(scene),
      camera_(camera),
      sampler_{settings.seed},
      side(prepare_lights(scene, camera, filter_, config, sampler_, SerialExecutor{})) {}
template <class SceneType>
auto SameLights<SceneType>::all_pairs() const -> Result {
  return render_instant_radiosity(scene_, camera_, filter_, config, side, sampler_, SerialExecutor{});
}
template <class SceneType>
auto SameLights<SceneType>::lightcuts() const -> Result {
  const LightTree<SceneType> tree(side.lights.vpls, SerialExecutor{});
  return render_lightcuts(scene_, camera_, filter_, config, side, tree, sampler_, SerialExecutor{});
}
template <class SceneType>
auto SameLights<SceneType>::all_recursive_pairs() const -> Result {
  const FourConstraints<S> weighting(side.weights);
  return render_all_pairs(scene_, camera_, filter_, config, weighting, side, sampler_, SerialExecutor{});
}
template <class SceneType>
auto SameLights<SceneType>::bdlc() const -> Result {
  const LightTree<SceneType> tree(side.lights.vpls, SerialExecutor{});
  return render_bidirectional_lightcuts(scene_, camera_, filter_, config, side, tree, sampler_, SerialExecutor{});
}
extern template class SameLights<DiffuseScene<Bvh<float>>>;
extern template class SameLights<DiffuseScene<Bvh<double>>>;

/// The two methods made of cuts; `SameLights::brute` has the sum that each of them approximates.
inline constexpr std::array<Method, 2> k_cut_methods{Method::lightcuts, Method::bdlc};

/// A box [-1,1]^3 seen from inside, an area light under its ceiling, a block to throw a shadow; all of it diffuse.
[[nodiscard]] inline SceneBuilder<Bvh<double>, Lambertian<double>> diffuse_room() {
  using S = double;
  SceneBuilder<Bvh<S>, Lambertian<S>> builder;
  auto walls = box_mesh<S>({-1, -1, -1}, {1, 1, 1});
  walls.flip_normals = true;
  builder.mesh(walls, {Rgb<S>(0.7, 0.6, 0.5)});
  builder.mesh(box_mesh<S>({-0.6, -0.2, -1}, {0.1, 0.4, -0.3}), {Rgb<S>(0.3, 0.6, 0.7)});
  builder.emit(builder.mesh(parallelogram<S>({0.2, 0.1, 0.95}, {0, 0.3, 0}, {0.3, 0, 0}), {Rgb<S>(0)}), {10, 9, 8});
  return builder;
}
[[nodiscard]] inline PerspectiveCamera<double> diffuse_room_camera(std::uint32_t side) {
  return look_at<double>({0.3, -0.95, 0.2}, {-0.1, 1, -0.4}, 70, side);
}

/// A sorted sample with quantiles.
class Quantiles {
 public:
  void add(double x) {
    values_.push_back(x);
    is_sorted_ = false;
  }
  [[nodiscard]] std::size_t count() const { return values_.size(); }
  [[nodiscard]] double at(double q) {
    sort();
    return values_[static_cast<std::size_t>(std::lround(q * static_cast<double>(values_.size() - 1)))];
  }
  /// Share of values that are at most `x`.
  [[nodiscard]] double share_up_to(double x) {
    sort();
    return static_cast<double>(std::upper_bound(values_.begin(), values_.end(), x) - values_.begin()) /
           static_cast<double>(values_.size());
  }
  [[nodiscard]] double mean() const {
    double sum = 0;
    for (const double x : values_) sum += x;
    return sum / static_cast<double>(values_.size());
  }
  [[nodiscard]] std::string text() {
    std::ostringstream out;
    out << "median " << at(0.5) << ", 90 % " << at(0.9) << ", 99 % " << at(0.99) << ", largest " << at(1);
    return out.str();
  }

 private:
  void sort() {
    if (!is_sorted_) std::sort(values_.begin(), values_.end());
    is_sorted_ = true;
  }
  std::vector<double> values_;
  bool is_sorted_ = true;
};

/// |a - b| of luminances per pixel, relative to max(b, floor), added to `errors`.
template <std::floating_point S>
void add_relative_errors(const Image<S>& a, const Image<S>& b, double floor, Quantiles& errors) {
  for (std::size_t i = 0; i < b.pixels.size(); ++i) {
    const double reference = luminance(Rgb<double>(b.pixels[i]));
    const double difference = std::abs(luminance(Rgb<double>(a.pixels[i])) - reference);
    errors.add(difference / std::max(reference, floor));
  }
}

/// Largest difference of a channel, relative to the largest channel of the reference image.
template <std::floating_point S>
[[nodiscard]] double largest_difference(const Image<S>& a, const Image<S>& b) {
  double scale = 0;
  double difference = 0;
  for (std::size_t i = 0; i < b.pixels.size(); ++i) {
    scale = std::max(scale, static_cast<double>(max_channel(b.pixels[i])));
    for (int c = 0; c < 3; ++c) {
      difference =
          std::max(difference, std::abs(static_cast<double>(a.pixels[i][c]) - static_cast<double>(b.pixels[i][c])));
    }
  }
  return scale > 0 ? difference / scale : difference;
}

/// Mean over pixels of the cuts' sizes.
template <std::floating_point S>
[[nodiscard]] double mean_cut(const ManyLightImage<S>& image) {
  return static_cast<double>(image.statistics.pairs.cut_size) / static_cast<double>(image.image.pixels.size());
}

}  // namespace manylight::test
