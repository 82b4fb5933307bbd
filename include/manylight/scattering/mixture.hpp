// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <concepts>
#include <optional>
#include <type_traits>

#include "manylight/scattering/concepts.hpp"
#include "manylight/scattering/validation.hpp"

namespace manylight {

/// A material and its weight in a sum.
template <Material M>
struct WeightedLobe {
  M lobe{};
  typename M::Scalar weight = 1;  ///< >= 0
};

namespace detail {

/// The lobes of a mixture, one inside the other; unlike std::tuple trivially copyable when they are.
template <class... Ms>
struct LobeList;

template <class M>
struct LobeList<M> {
  WeightedLobe<M> first;
  template <class Visit>
  constexpr void for_each(const Visit& visit) const noexcept {
    visit(first);
  }
};

template <class M, class... Ms>
struct LobeList<M, Ms...> {
  WeightedLobe<M> first;
  LobeList<Ms...> rest;
  template <class Visit>
  constexpr void for_each(const Visit& visit) const noexcept {
    visit(first);
    rest.for_each(visit);
  }
};

}  // namespace detail

/// Weighted sum of materials as one, f = sum of weight f_lobe; the lobes are chosen at compile time and may have delta
/// parts. A lobe is drawn with the probability of its share of the light that leaves for `known`, and the pdf is that
/// of all non-delta lobes together (one-sample balance heuristic), which leaves no spike where a narrow lobe is drawn
/// by a wide one.
template <Material M, Material... Ms>
class Mixture {
 public:
  using Scalar = typename M::Scalar;
  using S = Scalar;
  /// Vertices need no tangent: true if no part does.
  static constexpr bool k_isotropic = k_is_isotropic<M> && (k_is_isotropic<Ms> && ...);
  static_assert((std::same_as<typename Ms::Scalar, S> && ...), "all lobes of a Mixture need the same Scalar");

  Mixture() = default;
  explicit Mixture(const WeightedLobe<M>& first, const WeightedLobe<Ms>&... rest) noexcept
      : lobes_(make_list(first, rest...)) {}

  /// Throws ParameterError.
  void validate() const { for_each_throwing(lobes_); }

  /// Of vectors the BSDF; of direction sets a range that holds its values, the sum of the lobes' (see `eval_over`).
  template <LocalDirection<S> Wi = Vec3<S>, LocalDirection<S> Wo = Vec3<S>>
  [[nodiscard]] auto eval(const Wi& wi, const Wo& wo) const noexcept {
    return sum<PatternColour<Wi, Wo, S>>([&](const auto& lobe) { return eval_over(lobe, wi, wo); });
  }
  /// The BSDF times |wi.z|, see `eval_cos_over`.
  template <LocalDirection<S> Wi = Vec3<S>, LocalDirection<S> Wo = Vec3<S>>
  [[nodiscard]] auto eval_cos(const Wi& wi, const Wo& wo) const noexcept {
    return sum<PatternColour<Wi, Wo, S>>([&](const auto& lobe) { return eval_cos_over(lobe, wi, wo); });
  }

  [[nodiscard]] std::optional<DirectionSample<S>> sample(const Vec3<S>& known, Walk walk, S u_lobe,
                                                         const Vec2<S>& u) const noexcept {
    const S total = sampling_weight(known);
    if (!(total > S(0))) return std::nullopt;
    std::optional<DirectionSample<S>> result;
    S rest = std::min(u_lobe, S(1) - std::numeric_limits<S>::epsilon()) * total;
    bool drawn = false;
    lobes_.for_each([&](const auto& x) {
      const S share = x.weight * manylight::sampling_weight(x.lobe, known);
      if (drawn || !(share > S(0))) return;
      if (rest < share) {
        drawn = true;
        result = x.lobe.sample(known, walk, std::min(rest / share, S(1) - std::numeric_limits<S>::epsilon()), u);
        if (result && result->is_delta) {
          // The weight f |cos| / pdf of an event of probability share / total among the lobes.
          result->delta_weight *= x.weight * total / share;
          result->pdf *= share / total;
        }
      }
      rest -= share;
    });
    if (result && !result->is_delta) {
      result->pdf = pdf(known, result->direction, walk);
      if (!(result->pdf > S(0))) return std::nullopt;
    }
    return result;
  }

  [[nodiscard]] S pdf(const Vec3<S>& known, const Vec3<S>& sampled, Walk walk) const noexcept {
    S total = S(0);
    S density = S(0);
    lobes_.for_each([&](const auto& x) {
      const S share = x.weight * manylight::sampling_weight(x.lobe, known);
      total += share;
      if (share > S(0)) density += share * x.lobe.pdf(known, sampled, walk);
    });
    return total > S(0) ? density / total : S(0);
  }

  [[nodiscard]] Rgb<S> albedo() const noexcept {
    return sum<Rgb<S>>([](const auto& lobe) { return lobe.albedo(); });
  }
  [[nodiscard]] bool is_delta() const noexcept {
    bool all = true;
    lobes_.for_each([&](const auto& x) { all = all && (x.lobe.is_delta() || x.weight == S(0)); });
    return all;
  }
  [[nodiscard]] S sampling_weight(const Vec3<S>& known) const noexcept {
    return sum<S>([&](const auto& lobe) { return manylight::sampling_weight(lobe, known); });
  }

  /// Calls `visit` with each WeightedLobe in turn.
  template <class Visit>
  void for_each(const Visit& visit) const noexcept {
    lobes_.for_each(visit);
  }

 private:
  using List = detail::LobeList<M, Ms...>;

  template <class First, class... Rest>
  [[nodiscard]] static detail::LobeList<First, Rest...> make_list(const WeightedLobe<First>& first,
                                                                  const WeightedLobe<Rest>&... rest) noexcept {
    if constexpr (sizeof...(Rest) == 0) {
      return {first};
    } else {
      return {first, make_list(rest...)};
    }
  }
  /// Weighted sum; a lobe of weight 0 is skipped, so that its infinite bound does not make a NaN.
  template <class Result, class Term>
  [[nodiscard]] Result sum(const Term& term) const noexcept {
    Result result(S(0));
    lobes_.for_each([&](const auto& x) {
      if (x.weight > S(0)) result += x.weight * term(x.lobe);
    });
    return result;
  }
  template <class Lobes>
  static void for_each_throwing(const Lobes& lobes) {
    check::non_negative("Mixture weight", lobes.first.weight);
    if constexpr (requires { lobes.first.lobe.validate(); }) lobes.first.lobe.validate();
    if constexpr (requires { lobes.rest; }) for_each_throwing(lobes.rest);
  }

  List lobes_{};
};

}  // namespace manylight
