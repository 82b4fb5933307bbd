// SPDX-License-Identifier: Apache-2.0
#include "scene_file/spectrum.hpp"

#include <array>
#include <cmath>

#include <gtest/gtest.h>

namespace manylight::scene_file::spectrum_test {
namespace {

constexpr std::array<SpectrumSample, 2> k_flat{{{300.0, 1.0}, {900.0, 1.0}}};

// Oracle: the chromaticity of D65, (0.3127, 0.3290), CIE 15. It checks the table of D65, the fit and the matrix at
// once.
TEST(Spectrum, PerfectReflectorUnderD65IsWhite) {
  const Rgb<double> white = reflectance_to_rgb(k_flat);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(white[c], 1.0, 2e-3);  // error of the colour matching fit
  const Rgb<double> xyz = srgb_to_xyz(white);
  const double sum = xyz.x + xyz.y + xyz.z;
  EXPECT_NEAR(xyz.x / sum, 0.3127, 2e-4);  // the published four digits, and the fit
  EXPECT_NEAR(xyz.y / sum, 0.3290, 2e-4);
}

// Oracle: equal energy is (1, 1, 1) in XYZ by the definition of the observer, (1.2048, 0.9483, 0.9088) in linear sRGB.
TEST(Spectrum, EqualEnergyEmissionIsSlightlyPurple) {
  const Rgb<double> flat = emission_to_rgb(k_flat);
  const Rgb<double> exact = xyz_to_srgb(Rgb<double>(1.0));
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(flat[c], exact[c], 6e-3);  // the fit's areas under x, y, z differ by 0.5 %
  EXPECT_NEAR(exact.x, 1.2048, 1e-3);
  EXPECT_NEAR(exact.y, 0.9483, 1e-3);
  EXPECT_NEAR(exact.z, 0.9088, 1e-3);
}

// Oracle: the Macbeth-like walls of the Cornell box: integration is linear in the spectrum, and 0 outside of the list.
TEST(Spectrum, IsLinearAndEndsWithItsList) {
  const std::array<SpectrumSample, 3> low{{{400, 0.1}, {500, 0.2}, {600, 0.3}}};
  std::array<SpectrumSample, 3> high = low;
  for (SpectrumSample& s : high) s.value *= 2;
  const Rgb<double> a = reflectance_to_rgb(low);
  const Rgb<double> b = reflectance_to_rgb(high);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(b[c], 2 * a[c], 1e-12);  // rounding of a sum of 940 terms
  const std::array<SpectrumSample, 2> infrared{{{800, 1}, {900, 1}}};
  EXPECT_LT(emission_to_rgb(infrared).x, 1e-5);
  EXPECT_EQ(d65(300), 0.0);
  EXPECT_EQ(d65(560), 100.0);
}

// Oracle: the peaks of the colour matching functions in the CIE 1931 tables.
TEST(Spectrum, ColourMatchingFollowsTheTables) {
  EXPECT_NEAR(cie_xyz(555).y, 1.000, 0.01);  // error of the fit at the peak, stated by its authors as below 1 %
  EXPECT_NEAR(cie_xyz(600).x, 1.062, 0.011);
  EXPECT_NEAR(cie_xyz(445).z, 1.784, 0.03);
}

}  // namespace
}  // namespace manylight::scene_file::spectrum_test
