// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "manylight/core/error.hpp"
#include "manylight/scene/image.hpp"

/// Image files of the programs: EXR, PFM, PNG (read and write), JPEG and the like (read).
namespace manylight::image_io {

/// An image file that is missing, damaged, of an unknown kind, or cannot be written. One line: path, then reason.
class ImageFileError : public Error {
 public:
  ImageFileError(const std::filesystem::path& path, std::string_view reason)
      : Error(one_line(path.string() + ": " + std::string(reason))) {}

 private:
  /// What a damaged file says must not break the one line.
  static std::string one_line(std::string text) {
    for (char& c : text) {
      if (static_cast<unsigned char>(c) < 0x20) c = ' ';
    }
    return text;
  }
};

/// Pixels as a file stores them.
struct StoredImage {
  Image<float> image;
  bool is_srgb_encoded = false;  ///< values in [0, 1], to be passed through `srgb_to_linear`; else they are linear
};

/// How linear radiance becomes the 8 bits of a PNG.
struct PngOptions {
  float exposure = 0.0F;  ///< stops: values are multiplied by 2^exposure before the sRGB curve
};

/// IEC 61966-2-1, per channel. Input of `srgb_to_linear` in [0, 1]; `linear_to_srgb` clamps its input to [0, 1].
[[nodiscard]] float srgb_to_linear(float encoded) noexcept;
[[nodiscard]] float linear_to_srgb(float linear) noexcept;

/// Reads EXR, PFM, PNG, JPEG, TGA or BMP (by content) without changing the values; 8- and 16-bit ones are scaled to
/// [0, 1]. Grey files fill the three channels; alpha is dropped. Of an EXR the data window is read. Throws
/// ImageFileError.
[[nodiscard]] StoredImage read_stored(const std::filesystem::path& path);

/// `read_stored`, decoded to linear values. Throws ImageFileError.
[[nodiscard]] Image<float> read_image(const std::filesystem::path& path);

/// Writes .exr (float RGB), .pfm or .png by the extension, to a temporary file beside it that is then renamed: either
/// the whole image is there or nothing is changed. Throws ImageFileError.
void write_image(const std::filesystem::path& path, const Image<float>& image, const PngOptions& png = {});

/// Throws ImageFileError unless `write_image(path, ...)` can be expected to succeed: known extension, existing and
/// writable folder. To be asked before hours of rendering.
void check_writable(const std::filesystem::path& path);

}  // namespace manylight::image_io
