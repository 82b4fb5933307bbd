// SPDX-License-Identifier: Apache-2.0
#include "metrics/estimate.hpp"

#include <fmt/format.h>

namespace manylight::metrics {

Image<double> checked_mean(const NoisyReference& reference) {
  if (reference.batches.empty()) throw MetricError("no reference given");
  const Image<float>& first = reference.batches.front();
  for (const Image<float>& batch : reference.batches) {
    require_measurable(batch, "reference");
    require_same_size(batch, "reference", first, "first reference");
  }
  if (!reference.variance.empty()) {
    if (reference.batches.size() > 1) {
      throw MetricError("several references tell their variance themselves: give one reference or no variance");
    }
    require_measurable(reference.variance, "reference's variance");
    require_same_size(reference.variance, "reference's variance", first, "reference");
    for (const Rgb<float>& v : reference.variance.pixels) {
      if (v.x < 0 || v.y < 0 || v.z < 0) throw MetricError("the reference's variance has a negative value");
    }
  }
  Image<double> mean(first.width, first.height);
  for (const Image<float>& batch : reference.batches) {
    for (std::size_t i = 0; i < mean.pixels.size(); ++i) mean.pixels[i] += Rgb<double>(batch.pixels[i]);
  }
  for (Rgb<double>& pixel : mean.pixels) pixel /= static_cast<double>(reference.batches.size());
  return mean;
}

void require_runs(const std::vector<Image<float>>& runs, std::size_t least, const Image<float>& reference) {
  if (runs.size() < least) throw MetricError(fmt::format("{} runs given, at least {} needed", runs.size(), least));
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const std::string name = fmt::format("run {}", i + 1);
    require_measurable(runs[i], name);
    require_same_size(runs[i], name, reference, "reference");
  }
}

}  // namespace manylight::metrics
