// SPDX-License-Identifier: Apache-2.0
#include "render/passes.hpp"

#include <algorithm>

#include "image_io/image_io.hpp"

namespace manylight::render {

void write_outputs(const Options& options, const Image<float>& image) {
  for (const std::string& file : options.outputs) {
    const WritingFile whole;
    image_io::write_image(file, image, {options.exposure});
  }
}

Image<float> mean_image(const Window& window, const std::vector<Rgb<double>>& sums, std::uint32_t samples) {
  Image<float> image(window.width(), window.height());
  for (std::size_t i = 0; i < sums.size(); ++i) image.pixels[i] = Rgb<float>(sums[i] / static_cast<double>(samples));
  return image;
}

PassLoop::PassLoop(const Options& options, std::uint32_t total, SampleUnit unit)
    : options_(options), total_(total), unit_(unit), line_(method_name(options.method), options.quiet) {
  catch_stop_signals();
}

std::uint32_t PassLoop::next() {
  pass_ = 0;
  const std::uint32_t left = total_ - done_;
  if (done_ == 0 || left == 0) return pass_ = std::min(left, 1U);
  if (stop_requested()) return 0;
  const double elapsed = clock_.seconds();
  const double per_sample = std::max(elapsed, 1e-9) / done_;
  // Long enough not to cost anything, short enough to wait for; at most as long as all before, while times are unknown.
  double seconds = 1;
  if (options_.time_limit) {
    if (elapsed + per_sample > *options_.time_limit) return 0;
    seconds = std::min(seconds, *options_.time_limit - elapsed);
  }
  if (options_.progress_images) seconds = std::min(seconds, *options_.progress_images);
  const auto most = static_cast<double>(unit_ == SampleUnit::whole_image ? 1 : std::min(left, done_));
  return pass_ = static_cast<std::uint32_t>(std::clamp(seconds / per_sample, 1.0, most));
}

void PassLoop::tell(double part_of_pass) {
  if (stop_requested()) {
    if (unit_ == SampleUnit::whole_image && done_ > 0) throw PassAbandoned{};
    if (!is_stop_told_.exchange(true)) line_.note("stopping after this pass; interrupt again to end at once, without an image");
  }
  double part = (done_ + pass_ * part_of_pass) / total_;
  if (options_.time_limit) part = std::max(part, std::min(1.0, clock_.seconds() / *options_.time_limit));
  line_.update(part);
}

bool PassLoop::is_image_due() const {
  // The last one is written in the end.
  return options_.progress_images && done_ < total_ && clock_.seconds() - image_written_ >= *options_.progress_images;
}

void PassLoop::write_progress(const Image<float>& image) {
  write_outputs(options_, image);
  image_written_ = clock_.seconds();
}

}  // namespace manylight::render
