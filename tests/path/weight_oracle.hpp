// SPDX-License-Identifier: Apache-2.0
#pragma once

// Oracle of the weights: each rule as it is defined, O(k) per weight with the whole history at hand, written here from
// the definitions [Walter 2012, Eq. 4-10; Kollig and Keller 2004] and sharing no code with the headers.

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "manylight/path/weighting.hpp"

namespace manylight::test {

inline constexpr double k_inf = std::numeric_limits<double>::infinity();
inline constexpr double k_one_over_pi = 0.318309886183790672;

/// Vertices 1 .. l (index 0 unused): patterns of v_j, transit of segment (j, j+1); a Dirac vertex has M = D = inf. The
/// last vertex is the light: only its D counts.
struct Path {
  bool exact_light = false;  ///< the light has no noise of its own and cannot be hit
  std::vector<double> m{0}, d{0}, t{0};
  std::vector<bool> dirac{false};
  void add(double m_j, double d_j, double t_j) {
    m.push_back(m_j);
    d.push_back(d_j);
    t.push_back(t_j);
    dirac.push_back(m_j == k_inf);
  }
  [[nodiscard]] std::size_t length() const { return m.size() - 1; }
};

inline double theta(const Path& p, std::size_t j) {
  double sum = 0;
  for (std::size_t i = 1; i + 1 <= j; ++i) sum += p.dirac[i] ? 0 : std::sqrt(1 / (3.14159265358979323846 * p.m[i]));
  return sum;
}
inline double gamma_of(const Path& p, const WeightingConfig<double>& c, std::size_t j) {
  return theta(p, j) <= std::sqrt(1 / (3.14159265358979323846 * c.c_m)) ? k_inf : c.c_v;
}
inline double ratio(double gamma, double x) {  // min(Gamma / x, 1) with the limits inf / anything = 1, finite / inf = 0
  if (gamma == k_inf) return 1;
  return x == k_inf ? 0 : std::min(gamma / x, 1.0);
}
inline double mu(const Path& p, const WeightingConfig<double>& c, std::size_t j) {
  const double gamma = gamma_of(p, c, j);
  double value = ratio(gamma, p.d[j + 1]) * std::min(ratio(gamma, p.d[j]), ratio(gamma, p.m[j]));
  for (std::size_t i = 1; i + 1 <= j; ++i) {
    const double next = gamma_of(p, c, i + 1);
    value *= std::min(ratio(next, p.d[i]), ratio(next, p.m[i]));
  }
  return value;
}
/// Clamp and diffuse limit of segment j.
inline double clamp_of(const Path& p, const WeightingConfig<double>& c, std::size_t j) {
  if (p.exact_light && j + 1 == p.length()) return 1;
  return c.c_clamp == k_inf ? 1 : std::min(c.c_clamp / (p.m[j] * p.t[j] * p.d[j + 1]), 1.0);
}
inline double diffuse_of(const Path& p, const WeightingConfig<double>& c, std::size_t j) {
  return c.c_d == k_inf ? 1 : std::min(c.c_d / p.d[j + 1], 1.0);
}
inline bool connects(const Path& p, std::size_t j) { return !p.dirac[j] && !p.dirac[j + 1]; }
inline bool all_dirac_before(const Path& p, std::size_t l) {
  for (std::size_t i = 1; i < l; ++i) {
    if (!p.dirac[i]) return false;
  }
  return true;
}
inline double sum_of(const std::vector<double>& w) {
  double sum = 0;
  for (const double x : w) sum += x;
  return sum;
}

/// w_1 .. w_{l-1} of the four constraints at [1 .. l-1].
inline std::vector<double> weights(const Path& p, const WeightingConfig<double>& c) {
  std::vector<double> w(p.length(), 0.0);
  double sum = 0;
  for (std::size_t j = 1; j < p.length(); ++j) {
    if (connects(p, j)) {
      w[j] = std::max(0.0, std::min({1 - sum, clamp_of(p, c, j), diffuse_of(p, c, j), mu(p, c, j) - sum}));
    }
    sum += w[j];
  }
  return w;
}
inline double hit_weight(const Path& p, const WeightingConfig<double>& c) {
  const std::size_t l = p.length();
  if (all_dirac_before(p, l)) return 1;
  if (c.hits == EmitterHits::after_dirac) return 0;
  const double sum = sum_of(weights(p, c));
  double mu_hit = ratio(gamma_of(p, c, l), p.d[l]);
  for (std::size_t i = 1; i < l; ++i) {
    const double next = gamma_of(p, c, i + 1);
    mu_hit *= std::min(ratio(next, p.d[i]), ratio(next, p.m[i]));
  }
  return std::max(0.0, std::min(1 - sum, mu_hit - sum));
}

/// Weights without the fourth constraint; with `product`, the paper's variant that has prod (1 - w_i) in its place.
inline std::vector<double> residual_weights(const Path& p, const WeightingConfig<double>& c, bool product = false) {
  std::vector<double> w(p.length(), 0.0);
  double sum = 0;
  double left = 1;
  for (std::size_t j = 1; j < p.length(); ++j) {
    if (connects(p, j)) {
      w[j] = std::max(0.0, std::min({1 - sum, clamp_of(p, c, j), diffuse_of(p, c, j), product ? left : 1.0}));
    }
    sum += w[j];
    left *= 1 - w[j];
  }
  return w;
}
/// Stick breaking: w_j = c_j prod_{i<j} (1 - c_i), c_j = 0 where nothing connects.
inline std::vector<double> stick_breaking_weights(const Path& p, const WeightingConfig<double>& c) {
  std::vector<double> w(p.length(), 0.0);
  for (std::size_t j = 1; j < p.length(); ++j) {
    double left = 1;
    for (std::size_t i = 1; i < j; ++i)
      left *= connects(p, i) ? 1 - std::min(clamp_of(p, c, i), diffuse_of(p, c, i)) : 1;
    if (connects(p, j)) w[j] = left * std::min(clamp_of(p, c, j), diffuse_of(p, c, j));
  }
  return w;
}
/// The first ordinary vertex alone.
inline std::vector<double> first_vertex_weights(const Path& p, const WeightingConfig<double>& c) {
  std::vector<double> w(p.length(), 0.0);
  for (std::size_t j = 1; j < p.length(); ++j) {
    if (p.dirac[j]) continue;
    if (connects(p, j)) w[j] = std::min(clamp_of(p, c, j), diffuse_of(p, c, j));
    break;
  }
  return w;
}

/// The record of v_k by the weighting's own steps, and the pair of generator k.
template <class W>
[[nodiscard]] typename W::Record record_at(const W& weighting, const Path& p, std::size_t k) {
  typename W::Record record = weighting.start();
  for (std::size_t j = 1; j < k; ++j) {
    record = p.dirac[j] ? weighting.extend_delta(record) : weighting.extend(record, p.m[j], p.d[j], p.t[j]);
  }
  return record;
}
[[nodiscard]] inline PairPatterns<double> pair_at(const Path& p, std::size_t k) {
  return {p.m[k], p.d[k], p.t[k], p.d[k + 1], p.exact_light && k + 1 == p.length()};
}

struct Random {
  std::mt19937_64 engine;
  double uniform() { return std::uniform_real_distribution<double>()(engine); }
  double log_uniform(double lo, double hi) { return lo * std::pow(hi / lo, uniform()); }
  WeightingConfig<double> config() {
    WeightingConfig<double> c;
    c.c_clamp = uniform() < 0.1 ? k_inf : log_uniform(1e-3, 1e4);
    c.c_d = log_uniform(0.5, 5);
    c.c_v = uniform() < 0.5 ? c.c_d : c.c_d * uniform();
    c.c_m = log_uniform(1, 1e3);
    return c;
  }
  Path path(std::size_t length, double dirac_share) {
    Path p;
    for (std::size_t j = 0; j < length; ++j) {
      // Every other pattern is diffuse, so that wide and narrow bounces mix.
      const bool delta = uniform() < dirac_share && j + 1 < length;
      const double m = delta ? k_inf : uniform() < 0.4 ? k_one_over_pi * uniform() + 1e-3 : log_uniform(0.01, 3000);
      const double d = delta ? k_inf : uniform() < 0.4 ? k_one_over_pi * uniform() + 1e-3 : log_uniform(0.01, 3000);
      p.add(m, d, log_uniform(1e-3, 1e4));
    }
    return p;
  }
};

}  // namespace manylight::test
