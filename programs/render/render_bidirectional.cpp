// SPDX-License-Identifier: Apache-2.0
#include "render/render_bidirectional.hpp"

#include <fmt/core.h>

namespace manylight::render {

void report_strategies(const StrategyImages& images, const Window& window, std::uint32_t samples, JobResult& result) {
  for (unsigned edges = 1; edges <= images.max_edges; ++edges) {
    for (unsigned s = 0; s <= edges; ++s) {
      const unsigned t = edges + 1 - s;
      const std::string name = fmt::format("s{}_t{}", s, t);
      const std::vector<Rgb<double>>& sums = images.at(s, t).weighted;
      double sum = 0;
      for (const Rgb<double>& pixel : sums) sum += luminance(pixel);
      result.statistics.set_strategy(name, sum / (static_cast<double>(sums.size()) * samples));
      result.strategies[name] = mean_image(window, sums, samples);
    }
  }
}

}  // namespace manylight::render
