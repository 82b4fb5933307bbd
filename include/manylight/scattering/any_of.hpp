// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstddef>
#include <optional>
#include <type_traits>
#include <utility>
#include <variant>

#include "manylight/scattering/concepts.hpp"

namespace manylight {

/// One of a closed set of materials, itself a material: for scenes whose surfaces differ. As large as the largest plus
/// an index; dispatch is a chain of comparisons of the index that the compiler makes a switch of. List the common ones
/// first.
template <Material M, Material... Ms>
class AnyOf {
 public:
  using Scalar = typename M::Scalar;
  using S = Scalar;
  /// Vertices need no tangent: true if no part does.
  static constexpr bool k_isotropic = k_is_isotropic<M> && (k_is_isotropic<Ms> && ...);
  static_assert((std::same_as<typename Ms::Scalar, S> && ...), "all materials of an AnyOf need the same Scalar");

  AnyOf() = default;
  template <class Alternative>
  requires(std::same_as<Alternative, M> || (std::same_as<Alternative, Ms> || ...)) AnyOf(const Alternative& material)
  noexcept : material_(material) {}  // NOLINT(google-explicit-constructor)

  /// Calls `function` with the material that is held and returns its result.
  template <class Function>
  decltype(auto) visit(const Function& function) const {
    return visit_from<0>(function);
  }
  /// The material held, if it is of that type, else null.
  template <class Alternative>
  [[nodiscard]] const Alternative* get_if() const noexcept {
    return std::get_if<Alternative>(&material_);
  }
  [[nodiscard]] std::size_t index() const noexcept { return material_.index(); }

  /// Throws ParameterError.
  void validate() const {
    visit([](const auto& m) {
      if constexpr (requires { m.validate(); }) m.validate();
    });
  }

  /// Of vectors the BSDF; of direction sets a range that holds its values, see `eval_over`.
  template <LocalDirection<S> Wi = Vec3<S>, LocalDirection<S> Wo = Vec3<S>>
  [[nodiscard]] auto eval(const Wi& wi, const Wo& wo) const noexcept {
    return visit([&](const auto& m) { return eval_over(m, wi, wo); });
  }
  /// The BSDF times |wi.z|, see `eval_cos_over`.
  template <LocalDirection<S> Wi = Vec3<S>, LocalDirection<S> Wo = Vec3<S>>
  [[nodiscard]] auto eval_cos(const Wi& wi, const Wo& wo) const noexcept {
    return visit([&](const auto& m) { return eval_cos_over(m, wi, wo); });
  }
  [[nodiscard]] std::optional<DirectionSample<S>> sample(const Vec3<S>& known, Walk walk, S u_lobe,
                                                         const Vec2<S>& u) const noexcept {
    return visit([&](const auto& m) { return m.sample(known, walk, u_lobe, u); });
  }
  [[nodiscard]] S pdf(const Vec3<S>& known, const Vec3<S>& sampled, Walk walk) const noexcept {
    return visit([&](const auto& m) { return m.pdf(known, sampled, walk); });
  }
  [[nodiscard]] Rgb<S> albedo() const noexcept {
    return visit([](const auto& m) { return m.albedo(); });
  }
  [[nodiscard]] bool is_delta() const noexcept {
    return visit([](const auto& m) { return m.is_delta(); });
  }
  [[nodiscard]] S sampling_weight(const Vec3<S>& known) const noexcept {
    return visit([&](const auto& m) { return manylight::sampling_weight(m, known); });
  }

 private:
  template <std::size_t I, class Function>
  decltype(auto) visit_from(const Function& function) const {
    if constexpr (I == sizeof...(Ms)) {
      return function(*std::get_if<I>(&material_));
    } else {
      if (const auto* material = std::get_if<I>(&material_)) return function(*material);
      return visit_from<I + 1>(function);
    }
  }

  std::variant<M, Ms...> material_;
};

}  // namespace manylight
