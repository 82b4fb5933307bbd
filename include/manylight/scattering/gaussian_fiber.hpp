// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <type_traits>

#include "manylight/core/chord.hpp"
#include "manylight/core/frame.hpp"
#include "manylight/core/sampler.hpp"
#include "manylight/scattering/gaussian_fiber_table.hpp"
#include "manylight/scattering/inverse_erf.hpp"
#include "manylight/scattering/phase_concepts.hpp"

namespace manylight {

/// Mirroring flakes around a fiber, f_p = Df(h) / (2 sigma(known)), h the half vector of the two directions; Df and
/// sigma as in GaussianFiberTable. The medium's coefficients depend on direction: fibers hide less seen end on. [Jakob
/// 2010, "A radiative transfer framework for rendering materials with anisotropic structure"; Zhao 2011]
template <std::floating_point S>
class GaussianFiber {
 public:
  using Scalar = S;

  /// `table` must outlive all copies; `axis` is the unit direction of the fiber, either way, world frame.
  GaussianFiber(const GaussianFiberTable<S>& table, const Vec3<S>& axis) noexcept : table_(&table), axis_(axis) {}
  GaussianFiber(GaussianFiberTable<S>&&, const Vec3<S>&) = delete;  // would dangle

  /// Throws ParameterError.
  void validate() const {
    const S length = glm::length(axis_);
    require(std::abs(length - S(1)) <= S(1e-5), "length of the Gaussian fiber's axis", length, "1 within 1e-5");
  }

  [[nodiscard]] const GaussianFiberTable<S>& table() const noexcept { return *table_; }
  [[nodiscard]] const Vec3<S>& axis() const noexcept { return axis_; }

  /// Of vectors the phase function, sr^-1; of direction sets the range of its values over them. Straight on, where half
  /// vectors point anywhere across, it is the largest of its limits, so that no bound is below it.
  template <LocalDirection<S> W = Vec3<S>, LocalDirection<S> V = Vec3<S>>
  [[nodiscard]] PatternScalar<W, V, S> eval(const W& sampled, const V& known) const noexcept {
    using T = PatternScalar<W, V, S>;
    const T gauss = exp(-(table_->inv_two_gamma2() * sqr(half_cosine(sampled, known))));
    return gauss * (table_->inv_norm() / S(2)) / T(projected_area(known));
  }

  /// Upper bound of `eval` over pairs, at least one a set. Near the fiber's own direction sigma(known) is small, but
  /// there the Gaussian is, too, unless `sampled` is as near: |h . f| = |sampled . f + known . f| / |sampled + known|.
  /// Bounded apart the two would be loose by 1 / gamma; hence the range of known . f in steps, each with both at its
  /// worst; the more of them, the wider the range of sigma.
  template <LocalDirection<S> W, LocalDirection<S> V>
  [[nodiscard]] S sup_eval(const W& sampled, const V& known) const noexcept {
    const S apart = Interval<S>(eval(sampled, known)).hi;
    if constexpr (std::is_same_v<V, Vec3<S>>) {
      return apart;
    } else {
      const Interval<S> sigma = projected_area(known);
      const int steps = std::min(k_steps, 1 + static_cast<int>(S(k_steps) * (S(1) - sigma.lo / sigma.hi)));
      if (steps == 1) return apart;
      const Interval<S> p = dot(sampled, axis_);
      const Interval<S> c = clamp(dot(known, axis_), S(-1), S(1));
      const S most_length2 = Interval<S>(sqr_distance(sampled, -known)).hi;
      const S from = std::acos(c.hi);
      const S step = (std::acos(c.lo) - from) / static_cast<S>(steps);
      S sup = S(0);
      S high = c.hi;
      for (int k = 1; k <= steps; ++k) {
        const S low = k < steps ? std::clamp(std::cos(from + step * static_cast<S>(k)), c.lo, high) : c.lo;
        const S gap = std::max(S(0), std::max(p.lo + low, -(p.hi + high)) - detail::k_cosine_margin<S>);
        const S most = std::min(S(1), std::max(high, -low) + detail::k_cosine_margin<S>);
        const Interval<S> sine = safe_sqrt((S(1) - most) * (S(1) + most)) * (S(1) - detail::k_cosine_margin<S>);
        const Interval<S> fall = sqr(Interval<S>(gap)) / Interval<S>(most_length2) * table_->inv_two_gamma2();
        sup = std::max(sup, (exp(-fall) / table_->sigma(sine)).hi);
        high = low;
      }
      return std::min(apart, (Interval<S>(sup) * (table_->inv_norm() / S(2))).hi);
    }
  }

  /// Draws the visible normal, of density |known . m| Df(m) / sigma, and mirrors. With x = |m . f| and the azimuth phi
  /// to `known`, |known . m| <= c x + s |cos phi|, each term of which is drawn by inversion: 0.61 of the tries succeed
  /// at any angle and gamma, where of normals drawn from Df only sigma do, 0.008 along a smooth fiber. The two normals
  /// x, -x are drawn together. The first try takes `u`, later ones bits hashed from it.
  [[nodiscard]] std::optional<PhaseSample<S>> sample(const Vec3<S>& known, const Vec2<S>& u) const noexcept {
    const S c = std::abs(glm::dot(known, axis_));
    const S s = sine_between(known, axis_);
    const S cap = c * table_->sigma_along();
    const S share = cap / (cap + s * S(2) * k_inv_pi<S>);
    std::uint64_t key = mix_bits(bits_of(u.x) ^ mix_bits(bits_of(u.y)));
    const auto next = [&] { return to_unit_interval<S>(static_cast<std::uint32_t>((key = mix_bits(key)) >> 32)); };
    Vec2<S> v = u;
    for (int k = 0; k < k_tries; ++k) {
      const bool in_cap = v.x < share;
      const S x = in_cap ? rayleigh(v.x / share) : half_gauss((v.x - share) / (S(1) - share));
      const S sin_phi = in_cap ? std::sin(k_pi<S> * (v.y - S(0.5))) : S(2) * v.y - S(1);  // cos phi >= 0
      const S cos_phi = safe_sqrt((S(1) - sin_phi) * (S(1) + sin_phi));
      const S r = safe_sqrt((S(1) - x) * (S(1) + x));
      const S a = c * x;
      const S b = s * r * cos_phi;
      // |a + b| + |a - b| = 2 max(a, b): the share of both normals in what was drawn, then which of them.
      const S level = next() * (a + s * cos_phi);
      if (level < std::max(a, b)) {
        const auto w = mirrored(known, level < (a + b) / S(2) ? x : -x, Vec2<S>(r * cos_phi, r * sin_phi));
        if (w) return w;
      }
      v.x = next();
      v.y = next();
    }
    return std::nullopt;
  }

  /// The density of `sample`, as far as the table's sigma is the true one: never more, see there.
  [[nodiscard]] S pdf(const Vec3<S>& sampled, const Vec3<S>& known) const noexcept { return eval(sampled, known); }

  /// sigma(w), of a set the range of it.
  template <LocalDirection<S> W = Vec3<S>>
  [[nodiscard]] auto projected_area(const W& w) const noexcept {
    return table_->sigma(sine_between(w, axis_));
  }

 private:
  static constexpr int k_steps = 8;    ///< at most
  static constexpr int k_tries = 100;  ///< all fail with a probability of 1e-41

  [[nodiscard]] static std::uint64_t bits_of(S u) noexcept { return static_cast<std::uint64_t>(u * S(0x1p53)); }

  /// h . f.
  [[nodiscard]] S half_cosine(const Vec3<S>& a, const Vec3<S>& b) const noexcept {
    const Vec3<S> sum = a + b;
    const S length2 = glm::dot(sum, sum);
    // What the vectors' own rounding leaves of straight on points nowhere: across, as if they cancelled.
    return length2 > sqr(S(8) * std::numeric_limits<S>::epsilon()) ? glm::dot(sum, axis_) / std::sqrt(length2) : S(0);
  }
  template <class W, class V>
  [[nodiscard]] Interval<S> half_cosine(const W& a, const V& b) const noexcept {
    // The half vectors' cone is close for narrow sets; for wide ones (a . f + b . f) / |a + b| is.
    return refine(Interval<S>(dot(half_vector(a, b), axis_)), [&] {
      return (Interval<S>(dot(a, axis_)) + Interval<S>(dot(b, axis_))) / sqrt(Interval<S>(sqr_distance(a, V(-b))));
    });
  }

  /// x of density x exp(-x^2 / (2 gamma^2)) on [0, 1], up to a factor.
  [[nodiscard]] S rayleigh(S u) const noexcept {
    const S q = table_->inv_two_gamma2();
    return std::min(S(1), safe_sqrt(-std::log1p(u * std::expm1(-q)) / q));
  }
  /// x of density exp(-x^2 / (2 gamma^2)) on [0, 1], up to a factor.
  [[nodiscard]] S half_gauss(S u) const noexcept {
    return std::clamp(inverse_erf(u * table_->erf_one()) / std::sqrt(table_->inv_two_gamma2()), S(0), S(1));
  }

  /// `known` mirrored by the normal of cosine `x` to the fiber, on the side of `known`, and `across` it. None where so
  /// little is left of their sum that the density is rounding noise, and that is 0.
  [[nodiscard]] std::optional<PhaseSample<S>> mirrored(const Vec3<S>& known, S x,
                                                       const Vec2<S>& across) const noexcept {
    const Frame<S> frame(glm::dot(known, axis_) < S(0) ? -axis_ : axis_, known);
    const Vec3<S> m = glm::normalize(frame.to_world(Vec3<S>(across.x, across.y, x)));
    const Vec3<S> w = glm::normalize(mirror(known, m));
    const S density = eval(w, known);
    if (!(density > S(0))) return std::nullopt;
    return PhaseSample<S>{w, density};
  }

  const GaussianFiberTable<S>* table_;
  Vec3<S> axis_;
};

static_assert(SetEvaluablePhase<GaussianFiber<float>> && SetEvaluablePhase<GaussianFiber<double>>);

}  // namespace manylight
