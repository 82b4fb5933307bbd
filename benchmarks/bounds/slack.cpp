// SPDX-License-Identifier: Apache-2.0
// The tables of docs/methods/bounds.md: how far bounds of f |cos| lie above the largest values found, per material and
// kind of bound, how long they take, and what the rules for authors of `eval` are worth.
//
//   bench_slack                        the tables, in Markdown
//   bench_slack --samples 1000000      more directions per configuration: also a longer search for violations
// Exit status 1 if a value above its bound was found.

#include <algorithm>
#include <cmath>
#include <ctime>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/core.h>

#include "manylight/bounds/analytic.hpp"
#include "manylight/bounds/box_pair.hpp"
#include "manylight/bounds/falsify.hpp"
#include "manylight/bounds/sensor_map.hpp"
#include "scattering/material_list.hpp"

namespace {

using namespace manylight;
using S = float;

struct Arguments {
  std::uint32_t configurations = 1000;
  std::uint32_t samples = 1000;
  std::uint32_t ascents = 20;
};

/// Mean bound over mean of the largest values.
struct Slack {
  double bound = 0;
  bool is_finite = true;
  void add(S b) {
    is_finite = is_finite && b < k_infinity<S>;
    if (b < k_infinity<S>) bound += static_cast<double>(b);
  }
  [[nodiscard]] std::string over(double value) const {
    return is_finite ? fmt::format("{:.2f}", bound / value) : std::string("inf");
  }
};

/// Boxes that span 0.1 rad or so, half of them near the mirror direction: what a cut asks of a gather node.
struct Query {
  Vec3<S> wo;
  Box<S> box;
};
Query random_query(IndependentStream<S>& stream) {
  const auto sphere = [&] { return warp::square_to_sphere(stream.next_2d()); };
  Query q;
  const Vec3<S> up = sphere();
  q.wo = glm::normalize(Vec3<S>(up.x, up.y, std::max(std::abs(up.z), S(0.05))));
  const Vec3<S> far = sphere();
  const Vec3<S> center = stream.next() < S(0.5) ? glm::normalize(mirror(q.wo) + S(0.2) * sphere())
                                                : Vec3<S>(far.x, far.y, std::abs(far.z));
  const Vec3<S> half(S(0.1) * stream.next(), S(0.1) * stream.next(), S(0.1) * stream.next());
  q.box = {center - half, center + half};
  return q;
}

template <class M>
bool print_row(const std::string& name, const M& material, const Arguments& arguments) {
  constexpr std::uint32_t k_nodes[] = {8, 64, 512};
  Slack automatic, analytic, maps[3];
  double value = 0, seconds = 0;
  std::uint32_t refuted = 0;
  FalsifySearch search;
  search.samples = arguments.samples;
  search.ascents = arguments.ascents;
  for (std::uint32_t i = 0; i < arguments.configurations; ++i) {
    IndependentStream<S> stream(1, Stage::test, i, 2);
    const Query q = random_query(stream);
    const DirectionSet<S> set(directions(q.box));
    const S bound = AutomaticBounds{}.sup(material, set, q.wo).eval_cos;
    const std::clock_t start = std::clock();  // processor time: others may be busy
    volatile S sink = bound;
    for (int k = 0; k < 32; ++k) sink = sink + AutomaticBounds{}.sup(material, set, q.wo).eval_cos;
    seconds += static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC / 32;
    const auto at = [&](const Vec3<S>& w) { return max_channel(material.eval(w, q.wo)) * std::abs(w.z); };
    // The largest value in the box itself; the cone around it holds more and is searched for violations.
    S most = S(0);
    for (std::uint32_t k = 0; k < arguments.samples; ++k) {
      const Vec3<S> u(stream.next(), stream.next(), stream.next());
      most = std::max(most, at(glm::normalize(q.box.lo + (q.box.hi - q.box.lo) * u)));
    }
    search.seed = i;
    refuted += falsify(set, bound, at, search).is_refuted() ? 1 : 0;
    value += static_cast<double>(most);
    automatic.add(bound);
    analytic.add(AnalyticBounds{}.sup(material, set, q.wo).eval_cos);
    for (int m = 0; m < 3; ++m) {
      CubeMap<S> map;
      CubeMapBounds<> bounds;
      bounds.limits.nodes = k_nodes[m];
      build_sensor_map(bounds, material, Frame<S>(Vec3<S>(0, 0, 1)), q.wo, S(1), map);
      maps[m].add(map.sup(q.box));
      refuted += most <= map.sup(q.box) * S(1.0001) ? 0 : 1;  // rounding of vectors of the box
    }
  }
  fmt::print("| {} | {} | {} | {} | {} | {} | {:.0f} | {} |\n", name, automatic.over(value), analytic.over(value),
             maps[0].over(value), maps[1].over(value), maps[2].over(value), 1e9 * seconds / arguments.configurations,
             refuted);
  return refuted == 0;
}

/// Mean width of two ways to write the same function, over random intervals; `plain` must contain `close`.
template <class Plain, class Close>
void print_rule(const char* rule, const Plain& plain, const Close& close) {
  double widths[2] = {0, 0};
  for (std::uint32_t i = 0; i < 10000; ++i) {
    IndependentStream<S> stream(2, Stage::test, i, 0);
    const S center = stream.next();
    const Interval<S> x(std::max(S(0), center - S(0.1)), center + S(0.1));
    const S other = S(0.05) + S(0.95) * stream.next();
    widths[0] += static_cast<double>(plain(x, other).hi);
    widths[1] += static_cast<double>(close(x, other).hi);
  }
  fmt::print("| {} | {:.2f} |\n", rule, widths[0] / widths[1]);
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app{"How far bounds lie above the largest values found.", "bench_slack"};
  app.add_option("--configurations", arguments.configurations, "Pairs of wo and box per material")
      ->check(CLI::PositiveNumber);
  app.add_option("--samples", arguments.samples, "Directions per configuration")->check(CLI::PositiveNumber);
  app.add_option("--ascents", arguments.ascents, "Local ascents per configuration");
  CLI11_PARSE(app, argc, argv);
  fmt::print("| material | automatic | analytic | cube-map 8 | 64 | 512 | ns | violations |\n");
  fmt::print("|---|---|---|---|---|---|---|---|\n");
  bool fine = true;
  test::for_each_material<S>([&](const std::string& name, const auto& material) {
    fine = print_row(name, material, arguments) && fine;
  });
  using I = Interval<S>;
  fmt::print("\n| rule | bound of the plain text / of the rule |\n|---|---|\n");
  print_rule("`sqr(x - c)` for `(x - c) * (x - c)`, x - c around 0",
             [](const I& x, S c) { return exp(-((x - I(c)) * (x - I(c))) * I(S(20))); },
             [](const I& x, S c) { return exp(-sqr(x - I(c)) * I(S(20))); });
  print_rule("`ratio_peak(c, c0)` for `c / ((c + c0) * (c + c0))`",
             [](const I& c, S c0) { return c / ((c + I(c0)) * (c + I(c0))); },
             [](const I& c, S c0) { return ratio_peak(c, I(c0)); });
  print_rule("`gauss_slope(t, q)` for `(1 + t) * exp(-q * t)`, alpha = .2",
             [](const I& t, S) { return (I(S(1)) + t) * exp(-(I(S(25)) * t)); },
             [](const I& t, S) { return gauss_slope(t, I(S(25))); });
  print_rule("`dot(set, v)` for the sum of products of components, cones of 0.1 rad, to the 50th power",
             [](const I& x, S c) {
               const S angle = (x.lo + x.hi) * S(0.5) + c;
               const DirectionSet<S> set(Vec3<S>(std::sin(angle), 0, std::cos(angle)), S(0.1));
               return pow(set.x * I(std::sin(c)) + set.z * I(std::cos(c)), S(50));
             },
             [](const I& x, S c) {
               const S angle = (x.lo + x.hi) * S(0.5) + c;
               const DirectionSet<S> set(Vec3<S>(std::sin(angle), 0, std::cos(angle)), S(0.1));
               return pow(dot(set, Vec3<S>(std::sin(c), 0, std::cos(c))), S(50));
             });
  return fine ? 0 : 1;
}
