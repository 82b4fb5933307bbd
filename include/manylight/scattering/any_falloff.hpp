// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstddef>
#include <variant>

#include "manylight/scattering/subsurface_falloff.hpp"

namespace manylight {

/// One of a closed set of falloffs, itself a falloff: for scenes whose bodies differ. What AnyOf is to materials.
template <SubsurfaceFalloff F, SubsurfaceFalloff... Fs>
class AnyFalloff {
 public:
  using Scalar = typename F::Scalar;
  using S = Scalar;
  static_assert((std::same_as<typename Fs::Scalar, S> && ...), "all parts of an AnyFalloff need the same Scalar");

  AnyFalloff() = default;
  template <class Alternative>
  requires(std::same_as<Alternative, F> || (std::same_as<Alternative, Fs> || ...))
      AnyFalloff(const Alternative& falloff)
  noexcept : falloff_(falloff) {}  // NOLINT(google-explicit-constructor)

  /// Calls `function` with the falloff that is held and returns its result.
  template <class Function>
  decltype(auto) visit(const Function& function) const {
    return visit_from<0>(function);
  }
  /// The falloff held, if it is of that type, else null.
  template <class Alternative>
  [[nodiscard]] const Alternative* get_if() const noexcept {
    return std::get_if<Alternative>(&falloff_);
  }
  [[nodiscard]] std::size_t index() const noexcept { return falloff_.index(); }

  /// Throws ParameterError.
  void validate() const {
    visit([](const auto& f) {
      if constexpr (requires { f.validate(); }) f.validate();
    });
  }

  [[nodiscard]] Rgb<S> eval(S d) const noexcept {
    return visit([&](const auto& f) { return f.eval(d); });
  }
  template <SampleStream Stream>
  [[nodiscard]] S sample_radius(Stream& stream) const noexcept {
    return visit([&](const auto& f) { return f.sample_radius(stream); });
  }
  [[nodiscard]] S line_pdf(S d) const noexcept {
    return visit([&](const auto& f) { return f.line_pdf(d); });
  }
  [[nodiscard]] S sup(S d_min) const noexcept {
    return visit([&](const auto& f) { return f.sup(d_min); });
  }

 private:
  template <std::size_t I, class Function>
  decltype(auto) visit_from(const Function& function) const {
    if constexpr (I == sizeof...(Fs)) {
      return function(*std::get_if<I>(&falloff_));
    } else {
      if (const auto* falloff = std::get_if<I>(&falloff_)) return function(*falloff);
      return visit_from<I + 1>(function);
    }
  }

  std::variant<F, Fs...> falloff_;
};

}  // namespace manylight
