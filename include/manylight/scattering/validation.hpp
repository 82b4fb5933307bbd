// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <string_view>

#include "manylight/core/error.hpp"
#include "manylight/core/spectrum.hpp"

/// Parameter checks of the materials' `validate()`; all throw ParameterError. NaN fails every check.
namespace manylight::check {

/// Each channel in [0, 1]: more would create energy.
template <std::floating_point S>
inline void reflectance(std::string_view element, const Rgb<S>& value) {
  for (int channel = 0; channel < 3; ++channel) {
    const S v = value[channel];
    require(v >= S(0) && v <= S(1), element, v, "0 to 1 in each channel");
  }
}

/// Each channel finite and not negative.
template <std::floating_point S>
inline void non_negative(std::string_view element, const Rgb<S>& value) {
  for (int channel = 0; channel < 3; ++channel) {
    const S v = value[channel];
    require(v >= S(0) && std::isfinite(v), element, v, "finite and >= 0 in each channel");
  }
}

template <std::floating_point S>
inline void non_negative(std::string_view element, S value) {
  require(value >= S(0) && std::isfinite(value), element, value, "finite and >= 0");
}

template <std::floating_point S>
inline void positive(std::string_view element, S value) {
  require(value > S(0) && std::isfinite(value), element, value, "finite and > 0");
}

/// Roughness of a lobe that is connected: below 1e-4 single precision cannot resolve it; use the smooth material.
template <std::floating_point S>
inline void roughness(std::string_view element, S value) {
  require(value >= S(1e-4) && value <= S(10), element, value, "1e-4 to 10 (below, use the smooth material)");
}

/// Relative index of refraction, inside over outside.
template <std::floating_point S>
inline void relative_ior(std::string_view element, S value) {
  require(value >= S(0.1) && value <= S(10), element, value, "0.1 to 10");
}

}  // namespace manylight::check
