// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <type_traits>
#include <variant>

#include "manylight/media/concepts.hpp"

namespace manylight {

/// One of a closed set of media, itself a medium, with phase functions of type `P`, which those of all of them convert
/// to. Dispatch happens once per segment of a path, not per step of a tracking loop.
template <class P, Medium M, Medium... Ms>
requires(std::convertible_to<typename M::Phase, P> &&
         (std::convertible_to<typename Ms::Phase, P> && ...)) class AnyMediumWith {
 public:
  using Scalar = typename M::Scalar;
  using Phase = P;
  using S = Scalar;
  static constexpr bool k_closed_form = M::k_closed_form && (Ms::k_closed_form && ...);
  static_assert((std::same_as<typename Ms::Scalar, S> && ...), "all media of an AnyMedium need the same Scalar");

  template <class Alternative>
  requires(std::same_as<Alternative, M> || (std::same_as<Alternative, Ms> || ...))
      AnyMediumWith(const Alternative& medium)
  noexcept : medium_(medium) {}  // NOLINT(google-explicit-constructor)

  /// Calls `function` with the medium that is held and returns its result.
  template <class Function>
  decltype(auto) visit(const Function& function) const {
    return visit_from<0>(function);
  }
  [[nodiscard]] std::size_t index() const noexcept { return medium_.index(); }

  [[nodiscard]] Rgb<S> sigma_t(const Vec3<S>& x, const Vec3<S>& w) const noexcept {
    return visit([&](const auto& m) { return m.sigma_t(x, w); });
  }
  [[nodiscard]] Rgb<S> sigma_s(const Vec3<S>& x, const Vec3<S>& w) const noexcept {
    return visit([&](const auto& m) { return m.sigma_s(x, w); });
  }
  [[nodiscard]] Phase phase(const Vec3<S>& x) const noexcept {
    return visit([&](const auto& m) -> Phase { return m.phase(x); });
  }
  template <SampleStream Stream>
  [[nodiscard]] MediumSample<S> sample(const Ray<S>& ray, S t_max, Stream& stream) const noexcept {
    return visit([&](const auto& m) { return m.sample(ray, t_max, stream); });
  }
  template <SampleStream Stream>
  [[nodiscard]] Rgb<S> transmittance(const Ray<S>& ray, S t_max, Stream& stream) const noexcept {
    return visit([&](const auto& m) { return m.transmittance(ray, t_max, stream); });
  }
  [[nodiscard]] Rgb<S> mean_transmittance(const Ray<S>& ray, S t_max) const noexcept {
    return visit([&](const auto& m) { return m.mean_transmittance(ray, t_max); });
  }
  [[nodiscard]] S min_sigma_t() const noexcept {
    return visit([](const auto& m) { return m.min_sigma_t(); });
  }

 private:
  template <std::size_t I, class Function>
  decltype(auto) visit_from(const Function& function) const {
    if constexpr (I == sizeof...(Ms)) {
      return function(*std::get_if<I>(&medium_));
    } else {
      if (const auto* medium = std::get_if<I>(&medium_)) return function(*medium);
      return visit_from<I + 1>(function);
    }
  }

  std::variant<M, Ms...> medium_;
};

/// The same for media whose phase functions have a common type.
template <Medium... Ms>
using AnyMedium = AnyMediumWith<std::common_type_t<typename Ms::Phase...>, Ms...>;

}  // namespace manylight
