// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "manylight/core/spectrum.hpp"

/// Spectra as linear sRGB values. CIE 1931 observer by the multi-lobe fit of [Wyman, Sloan, Shirley 2013, "Simple
/// Analytic Approximations to the CIE XYZ Color Matching Functions"]; D65 by its published table, every 10 nm.
namespace manylight::scene_file {

struct SpectrumSample {
  double wavelength;  ///< nm
  double value;
};

/// XYZ of a tristimulus with Y = 1 for the unit spectrum, to linear sRGB (D65 white is (1, 1, 1)).
[[nodiscard]] Rgb<double> xyz_to_srgb(const Rgb<double>& xyz) noexcept;
[[nodiscard]] Rgb<double> srgb_to_xyz(const Rgb<double>& rgb) noexcept;

/// Colour matching functions at a wavelength in nm, not normalised.
[[nodiscard]] Rgb<double> cie_xyz(double wavelength) noexcept;

/// Relative power of D65 at a wavelength in nm, 100 at 560 nm, 0 outside of 380 to 780 nm.
[[nodiscard]] double d65(double wavelength) noexcept;

/// Colour of a reflectance (or another ratio) under D65, in [0, 1] for values in [0, 1] up to gamut: negative channels
/// are cut to 0. `samples` rise in wavelength; between them values are linear, beyond them 0.
[[nodiscard]] Rgb<double> reflectance_to_rgb(std::span<const SpectrumSample> samples) noexcept;

/// Colour of an emission spectrum; the unit spectrum has Y = 1. Negative channels are cut to 0.
[[nodiscard]] Rgb<double> emission_to_rgb(std::span<const SpectrumSample> samples) noexcept;

}  // namespace manylight::scene_file
