// SPDX-License-Identifier: Apache-2.0
#include "scene_file/spectrum.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/common.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

namespace manylight::scene_file {

namespace {

constexpr double k_first = 360.0;  ///< nm; range over which the observer sees anything worth counting
constexpr double k_last = 830.0;
constexpr double k_step = 0.5;

/// Relative spectral power of the CIE standard illuminant D65, 380 to 780 nm in steps of 10 nm.
constexpr std::array<double, 41> k_d65{49.9755, 54.6482, 82.7549, 91.4860, 93.4318, 86.6823, 104.865, 117.008, 117.812,
                                       114.861, 115.923, 108.811, 109.354, 107.802, 104.790, 107.689, 104.405, 104.046,
                                       100.000, 96.3342, 95.7880, 88.6856, 90.0062, 89.5991, 87.6987, 83.2886, 83.6992,
                                       80.0268, 80.2146, 82.2778, 78.2842, 69.7213, 71.6091, 74.3490, 61.6040, 69.8856,
                                       75.0870, 63.5927, 46.4182, 66.8054, 63.3828};

/// Bell with different widths on its two sides.
double lobe(double x, double center, double left, double right) {
  const double t = (x - center) / (x < center ? left : right);
  return std::exp(-0.5 * t * t);
}

/// glm's matrices are filled column by column: here X, Y and Z of the red, green and blue primary.
const glm::dmat3& primaries() {
  static const glm::dmat3 k_matrix(0.4123907993, 0.2126390059, 0.0193308187, 0.3575843394, 0.7151686788, 0.1191947798,
                                   0.1804807884, 0.0721923154, 0.9505321522);
  return k_matrix;
}

double value_at(std::span<const SpectrumSample> samples, double wavelength) {
  if (samples.empty() || wavelength < samples.front().wavelength || wavelength > samples.back().wavelength) return 0.0;
  const auto after = std::upper_bound(samples.begin(), samples.end(), wavelength,
                                      [](double w, const SpectrumSample& s) { return w < s.wavelength; });
  if (after == samples.end()) return samples.back().value;
  const auto before = after - 1;
  const double t = (wavelength - before->wavelength) / (after->wavelength - before->wavelength);
  return before->value + t * (after->value - before->value);
}

/// Midpoint rule: integral of value * light * observer over that of light * y.
template <class Light>
Rgb<double> integrate(std::span<const SpectrumSample> samples, const Light& light) {
  Rgb<double> xyz(0.0);
  double norm = 0.0;
  for (double w = k_first + k_step / 2; w < k_last; w += k_step) {
    const Rgb<double> weight = cie_xyz(w) * light(w);
    xyz += weight * value_at(samples, w);
    norm += weight.y;
  }
  return glm::max(xyz_to_srgb(xyz / norm), Rgb<double>(0.0));
}

}  // namespace

Rgb<double> xyz_to_srgb(const Rgb<double>& xyz) noexcept {
  static const glm::dmat3 k_matrix = glm::inverse(primaries());
  return k_matrix * xyz;
}

Rgb<double> srgb_to_xyz(const Rgb<double>& rgb) noexcept { return primaries() * rgb; }

Rgb<double> cie_xyz(double w) noexcept {
  return {1.056 * lobe(w, 599.8, 37.9, 31.0) + 0.362 * lobe(w, 442.0, 16.0, 26.7) - 0.065 * lobe(w, 501.1, 20.4, 26.2),
          0.821 * lobe(w, 568.8, 46.9, 40.5) + 0.286 * lobe(w, 530.9, 16.3, 31.1),
          1.217 * lobe(w, 437.0, 11.8, 36.0) + 0.681 * lobe(w, 459.0, 26.0, 13.8)};
}

double d65(double wavelength) noexcept {
  const double at = (wavelength - 380.0) / 10.0;
  if (at < 0.0 || at >= static_cast<double>(k_d65.size() - 1)) return 0.0;
  const auto i = static_cast<std::size_t>(at);
  const double t = at - static_cast<double>(i);
  return k_d65[i] + t * (k_d65[i + 1] - k_d65[i]);
}

Rgb<double> reflectance_to_rgb(std::span<const SpectrumSample> samples) noexcept {
  return integrate(samples, [](double w) { return d65(w); });
}

Rgb<double> emission_to_rgb(std::span<const SpectrumSample> samples) noexcept {
  return integrate(samples, [](double) { return 1.0; });
}

}  // namespace manylight::scene_file
