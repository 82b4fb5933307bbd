// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstddef>
#include <optional>
#include <variant>

#include "manylight/scattering/phase_concepts.hpp"

namespace manylight {

/// One of a closed set of phase functions, itself a phase function: for media that differ. What AnyOf is to materials.
template <PhaseFunction P, PhaseFunction... Ps>
class AnyPhase {
 public:
  using Scalar = typename P::Scalar;
  using S = Scalar;
  /// True if it is of every part.
  static constexpr bool k_isotropic_density = k_has_isotropic_density<P> && (k_has_isotropic_density<Ps> && ...);
  static_assert((std::same_as<typename Ps::Scalar, S> && ...), "all parts of an AnyPhase need the same Scalar");

  AnyPhase() = default;
  template <class Alternative>
  requires(std::same_as<Alternative, P> || (std::same_as<Alternative, Ps> || ...)) AnyPhase(const Alternative& phase)
  noexcept : phase_(phase) {}  // NOLINT(google-explicit-constructor)

  /// Calls `function` with the phase function that is held and returns its result.
  template <class Function>
  decltype(auto) visit(const Function& function) const {
    return visit_from<0>(function);
  }
  /// The phase function held, if it is of that type, else null.
  template <class Alternative>
  [[nodiscard]] const Alternative* get_if() const noexcept {
    return std::get_if<Alternative>(&phase_);
  }
  [[nodiscard]] std::size_t index() const noexcept { return phase_.index(); }

  /// Throws ParameterError.
  void validate() const {
    visit([](const auto& p) {
      if constexpr (requires { p.validate(); }) p.validate();
    });
  }

  /// Of vectors the phase function, sr^-1; of direction sets a range that holds its values, see `phase_over`.
  template <LocalDirection<S> W = Vec3<S>, LocalDirection<S> V = Vec3<S>>
  [[nodiscard]] auto eval(const W& sampled, const V& known) const noexcept {
    return visit([&](const auto& p) { return phase_over(p, sampled, known); });
  }
  [[nodiscard]] std::optional<PhaseSample<S>> sample(const Vec3<S>& known, const Vec2<S>& u) const noexcept {
    return visit([&](const auto& p) { return p.sample(known, u); });
  }
  [[nodiscard]] S pdf(const Vec3<S>& sampled, const Vec3<S>& known) const noexcept {
    return visit([&](const auto& p) { return p.pdf(sampled, known); });
  }
  [[nodiscard]] S projected_area(const Vec3<S>& w) const noexcept {
    return visit([&](const auto& p) { return p.projected_area(w); });
  }

 private:
  template <std::size_t I, class Function>
  decltype(auto) visit_from(const Function& function) const {
    if constexpr (I == sizeof...(Ps)) {
      return function(*std::get_if<I>(&phase_));
    } else {
      if (const auto* phase = std::get_if<I>(&phase_)) return function(*phase);
      return visit_from<I + 1>(function);
    }
  }

  std::variant<P, Ps...> phase_;
};

}  // namespace manylight
