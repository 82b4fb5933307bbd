// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "manylight/core/spectrum.hpp"
#include "manylight/scene/image.hpp"
#include "render/options.hpp"
#include "render/progress.hpp"
#include "render/stop.hpp"

/// What all progressive methods share: samples are taken in passes; between them time limits and stop signals are
/// looked at and the image so far is written. How samples are split into passes changes no bit of the image, since all
/// that is random is keyed by the sample.
namespace manylight::render {

/// `image` into every file that `--output` names.
void write_outputs(const Options& options, const Image<float>& image);

/// Sums over samples as an image, `samples` >= 1.
[[nodiscard]] Image<float> mean_image(const Window& window, const std::vector<Rgb<double>>& sums,
                                      std::uint32_t samples);

/// Thrown by the progress callback of a pass that nobody waits for any more.
struct PassAbandoned {};

/// What a method's sample is.
enum class SampleUnit {
  sample,      ///< of every pixel: passes of any number of them, of about a second, always finished
  whole_image  ///< one is a pass, and long: abandoned by a stop signal if one was finished before
};

/// The loop
///
///     while (const std::uint32_t count = loop.next()) {
///       ... samples [loop.done(), loop.done() + count), with std::ref(loop) for a progress callback ...
///       loop.finish(count, [&] { return the image so far; });
///     }
///
/// ends when `total` samples are taken, when the time is up or after a stop signal; the first sample is always taken.
class PassLoop {
 public:
  /// `options` must outlive it. From now on stop signals are caught.
  PassLoop(const Options& options, std::uint32_t total, SampleUnit unit);

  /// How many samples the next pass takes, 0: no more.
  [[nodiscard]] std::uint32_t next();
  [[nodiscard]] std::uint32_t done() const noexcept { return done_; }
  /// Ended before its time by a stop signal.
  [[nodiscard]] bool is_interrupted() const noexcept { return done_ < total_ && stop_requested(); }

  template <class MakeImage>
  void finish(std::uint32_t count, const MakeImage& image_so_far) {
    done_ += count;
    pass_ = 0;
    if (is_image_due()) write_progress(image_so_far());
  }

  /// Progress callback of the running pass, safe to call from several threads. Throws PassAbandoned.
  void operator()(std::size_t done, std::size_t total) { tell(static_cast<double>(done) / static_cast<double>(total)); }
  /// The same, by the part of the pass that is done, 0 to 1.
  void tell(double part);

 private:
  [[nodiscard]] bool is_image_due() const;
  void write_progress(const Image<float>& image);

  const Options& options_;
  std::uint32_t total_;
  SampleUnit unit_;
  std::uint32_t done_ = 0;
  std::uint32_t pass_ = 0;  ///< samples of the running pass
  Stopwatch clock_;
  double image_written_ = 0;  ///< s, on that clock
  ProgressLine line_;
  std::atomic<bool> is_stop_told_{false};
};

}  // namespace manylight::render
