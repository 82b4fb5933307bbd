// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "manylight/core/sampler.hpp"
#include "manylight/scene/image.hpp"

namespace manylight::test {

/// A standard normal variate by the polar transform of two uniform ones.
template <SampleStream Stream>
[[nodiscard]] double normal_variate(Stream& stream) {
  const double radius = std::sqrt(-2.0 * std::log(1.0 - static_cast<double>(stream.next())));
  return radius * std::cos(2.0 * 3.14159265358979 * static_cast<double>(stream.next()));
}

/// What the noisy images below scatter about: positive, with gradients and colour.
[[nodiscard]] inline Image<float> smooth_image(std::size_t width, std::size_t height) {
  Image<float> image(width, height);
  for (std::uint32_t y = 0; y < image.height; ++y) {
    for (std::uint32_t x = 0; x < image.width; ++x) {
      const float u = static_cast<float>(x) / static_cast<float>(width);
      const float v = static_cast<float>(y) / static_cast<float>(height);
      image.at(x, y) = Rgb<float>(1.0F + u, 1.5F - 0.5F * v, 0.75F + 0.5F * u * v);
    }
  }
  return image;
}

/// Spread of the noise relative to the image: that of each pixel and channel, and that which one image has in common,
/// as the noise of virtual lights.
struct Noise {
  double own = 0.0;
  double common = 0.0;
  bool is_grey = false;  ///< the three channels of a pixel share their noise
};

/// `truth` times (1 + bias + normal noise); `seed` and `index` choose the noise.
[[nodiscard]] inline Image<float> noisy_image(const Image<float>& truth, double bias, const Noise& noise,
                                              std::uint64_t seed, std::uint32_t index) {
  const IndependentSampler<double> sampler{.seed = seed};
  auto common_stream = sampler.stream(Stage::pilot, 0, index);
  const double common = noise.common * normal_variate(common_stream);
  Image<float> image = truth;
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    auto stream = sampler.stream(Stage::test, i, index);
    double own = 0.0;
    for (int c = 0; c < 3; ++c) {
      if (c == 0 || !noise.is_grey) own = noise.own * normal_variate(stream);
      const double factor = 1.0 + bias + common + own;
      image.pixels[i][c] = static_cast<float>(static_cast<double>(truth.pixels[i][c]) * factor);
    }
  }
  return image;
}

/// `count` of them, numbered from `first`.
[[nodiscard]] inline std::vector<Image<float>> noisy_images(const Image<float>& truth, double bias, const Noise& noise,
                                                            std::uint64_t seed, std::size_t count) {
  std::vector<Image<float>> images;
  for (std::size_t i = 0; i < count; ++i) {
    images.push_back(noisy_image(truth, bias, noise, seed, static_cast<std::uint32_t>(i)));
  }
  return images;
}

}  // namespace manylight::test
