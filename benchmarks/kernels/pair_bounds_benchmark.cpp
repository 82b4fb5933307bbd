// SPDX-License-Identifier: Apache-2.0
// Bounds of cluster pairs per second on one core: pair by pair and in packs. The pairs are those that cuts of a box
// room make: 100,000 lights on its walls, diffuse and glossy sensors on patches of them, each pair split at the side
// that splits_gather names. Nodes stay in the cache, as a cut's prefetches have them.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "manylight/many_light/gather_tree.hpp"
#include "manylight/many_light/light_tree.hpp"
#include "manylight/many_light/pair_bound_pack.hpp"
#include "manylight/path/four_constraints.hpp"
#include "support/random_vertices.hpp"

namespace {

using namespace manylight;

constexpr std::size_t k_pairs = 512;
constexpr std::size_t k_batch = 32;  ///< of a cut: two parts of each of 16 clusters

template <std::floating_point S>
class Pairs {
 public:
  using SceneType = test::MixedScene<S>;
  using Weights = FourConstraints<S>;
  struct Pair {
    GatherNode<S> gather;
    LightNode<S> light;
  };

  Pairs() {
    const Weights weighting(WeightingConfig<S>{});
    std::vector<VertexOf<SceneType>> vpls;
    for (int i = 0; i < 100'000; ++i) {
      const Wall wall = random_wall();
      vpls.push_back(random_.light(wall.position, wall.normal, test::Gloss::none,
                                   {VertexKind::surface, VertexKind::surface, VertexKind::area_emitter}));
    }
    const LightTree<SceneType> lights(std::move(vpls), SerialExecutor{});
    for (int pixel = 0; pixel < 8; ++pixel) {
      const Wall wall = random_wall();
      std::vector<Sensor<SceneType, Weights>> sensors;
      for (int i = 0; i < 64; ++i) {
        const Vec3<S> offset = random_.point(Vec3<S>(0), 0.05);
        const Vec3<S> on_wall = wall.position + offset - wall.normal * glm::dot(wall.normal, offset);
        sensors.push_back(
            random_.sensor(weighting, on_wall, wall.normal, pixel % 2 == 0 ? test::Gloss::none : test::Gloss::some));
      }
      GatherTree<SceneType, Weights> gather;
      gather.build(sensors, weighting);
      add_cut(gather, lights);
    }
  }

  [[nodiscard]] const std::vector<Pair>& all() const { return pairs_; }
  PairLimits<S> limits{k_infinity<S>, S(1), S(3)};

 private:
  struct Wall {
    Vec3<S> position, normal;
  };
  /// A point on the inside of [-1, 1]^3.
  Wall random_wall() {
    const int axis = static_cast<int>(random_.uniform(0, 2.999));
    const S side = random_.chance(0.5) ? S(1) : S(-1);
    Wall wall{random_.point(Vec3<S>(0), 1), Vec3<S>(0)};
    wall.position[axis] = side;
    wall.normal[axis] = -side;
    return wall;
  }
  /// Pairs met on the way from the roots, the oldest split first.
  void add_cut(const GatherTree<SceneType, Weights>& gather, const LightTree<SceneType>& lights) {
    std::vector<std::array<std::uint32_t, 2>> open;
    for (const std::uint32_t root : lights.roots()) open.push_back({0, root});
    for (std::size_t i = 0; i < open.size() && i < k_pairs / 8; ++i) {
      const auto [g, l] = open[i];
      const GatherNode<S>& of_gather = gather.node(g);
      const LightNode<S> of_light = lights.node(l);
      pairs_.push_back({of_gather, of_light});
      if (of_gather.is_leaf && of_light.is_leaf) continue;
      const bool on_gather = !of_gather.is_leaf && (of_light.is_leaf || splits_gather(of_gather, of_light));
      if (on_gather) {
        for (const std::uint32_t child : gather.children(g)) open.push_back({child, l});
      } else {
        for (const std::uint32_t child : of_light.children) open.push_back({g, child});
      }
    }
  }

  test::RandomVertices<S> random_{1};
  std::vector<Pair> pairs_;
};

template <std::floating_point S>
const Pairs<S>& pairs() {
  static const Pairs<S> k_pairs_of_room;
  return k_pairs_of_room;
}

void set_rate(benchmark::State& state, std::size_t count) {
  state.SetItemsProcessed(static_cast<std::int64_t>(count) * static_cast<std::int64_t>(state.iterations()));
}

template <std::floating_point S>
void scalar(benchmark::State& state) {
  const Pairs<S>& p = pairs<S>();
  for (auto _ : state) {
    for (const auto& pair : p.all()) benchmark::DoNotOptimize(pair_bound(pair.gather, pair.light, p.limits));
  }
  set_rate(state, p.all().size());
}

/// The bound and the side to split, which PairBounds gives at once.
template <std::floating_point S>
void scalar_with_side(benchmark::State& state) {
  const Pairs<S>& p = pairs<S>();
  for (auto _ : state) {
    for (const auto& pair : p.all()) {
      benchmark::DoNotOptimize(pair_bound(pair.gather, pair.light, p.limits));
      benchmark::DoNotOptimize(splits_gather(pair.gather, pair.light));
    }
  }
  set_rate(state, p.all().size());
}

template <std::floating_point S>
void packs(benchmark::State& state) {
  const Pairs<S>& p = pairs<S>();
  PairBounds<S> bounds;
  for (auto _ : state) {
    for (std::size_t first = 0; first < p.all().size(); first += k_batch) {
      const std::size_t end = std::min(first + k_batch, p.all().size());
      bounds.clear();
      for (std::size_t i = first; i < end; ++i) bounds.add(p.all()[i].gather, p.all()[i].light);
      bounds.evaluate(p.limits);
      for (std::size_t i = 0; i < bounds.size(); ++i) benchmark::DoNotOptimize(bounds.bound(i));
    }
  }
  set_rate(state, p.all().size());
}

BENCHMARK_TEMPLATE(scalar, float);
BENCHMARK_TEMPLATE(scalar_with_side, float);
BENCHMARK_TEMPLATE(packs, float);
BENCHMARK_TEMPLATE(scalar, double);
BENCHMARK_TEMPLATE(scalar_with_side, double);
BENCHMARK_TEMPLATE(packs, double);

}  // namespace

BENCHMARK_MAIN();
