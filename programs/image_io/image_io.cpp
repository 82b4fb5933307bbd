// SPDX-License-Identifier: Apache-2.0
#include "image_io/image_io.hpp"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <system_error>

#include "image_io/formats.hpp"

namespace manylight::image_io {

namespace fs = std::filesystem;

namespace {

enum class Format { exr, pfm, png };

constexpr std::string_view k_known_extensions = "supported are .exr, .pfm and .png";

Format format_of(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension == ".exr") return Format::exr;
  if (extension == ".pfm") return Format::pfm;
  if (extension == ".png") return Format::png;
  throw ImageFileError(path, "unknown image extension '" + extension + "'; " + std::string(k_known_extensions));
}

fs::path temporary_beside(const fs::path& path) {
  fs::path temporary = path;
  temporary += ".partial-" + std::to_string(::getpid());
  return temporary;
}

/// Removes the file unless it was released: no partial output survives an exception.
class TemporaryFile {
 public:
  explicit TemporaryFile(const fs::path& target) : path_(temporary_beside(target)) {}
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove(path_, ignored);
  }
  [[nodiscard]] const fs::path& path() const { return path_; }
  void rename_to(const fs::path& target) {
    std::error_code error;
    fs::rename(path_, target, error);
    if (error) throw ImageFileError(target, "cannot be written: " + error.message());
    path_.clear();
  }

 private:
  fs::path path_;
};

bool starts_with(const std::string& bytes, std::string_view prefix) {
  return bytes.size() >= prefix.size() && std::memcmp(bytes.data(), prefix.data(), prefix.size()) == 0;
}

}  // namespace

namespace detail {

void check_size(const fs::path& path, std::int64_t width, std::int64_t height) {
  const auto limit = static_cast<std::int64_t>(k_max_image_side);
  const bool sides_fit = width >= 1 && height >= 1 && width <= limit && height <= limit;
  if (sides_fit && static_cast<std::size_t>(width) * static_cast<std::size_t>(height) <= k_max_pixels) return;
  throw ImageFileError(path, "impossible image size " + std::to_string(width) + " x " + std::to_string(height) +
                                 "; sides of 1 to 65535 and at most " + std::to_string(k_max_pixels) + " pixels");
}

std::string read_bytes(const fs::path& path) {
  std::error_code error;
  if (!fs::exists(path, error)) throw ImageFileError(path, "no such file");
  if (fs::is_directory(path, error)) throw ImageFileError(path, "is a folder, not an image");
  std::ifstream in(path, std::ios::binary);
  if (!in) throw ImageFileError(path, "cannot be opened");
  std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (in.bad()) throw ImageFileError(path, "cannot be read");
  return bytes;
}

}  // namespace detail

float srgb_to_linear(float encoded) noexcept {
  return encoded <= 0.04045F ? encoded / 12.92F : std::pow((encoded + 0.055F) / 1.055F, 2.4F);
}

float linear_to_srgb(float linear) noexcept {
  if (!(linear > 0.0F)) return 0.0F;  // also NaN
  const float x = std::min(linear, 1.0F);
  return x <= 0.0031308F ? 12.92F * x : 1.055F * std::pow(x, 1.0F / 2.4F) - 0.055F;
}

StoredImage read_stored(const fs::path& path) {
  const std::string bytes = detail::read_bytes(path);
  if (starts_with(bytes, std::string_view("\x76\x2f\x31\x01", 4))) return {detail::read_exr(path), false};
  if (starts_with(bytes, "PF") || starts_with(bytes, "Pf")) return {detail::decode_pfm(path, bytes), false};
  return detail::decode_ldr(path, bytes);
}

Image<float> read_image(const fs::path& path) {
  StoredImage stored = read_stored(path);
  if (stored.is_srgb_encoded) {
    for (Rgb<float>& pixel : stored.image.pixels) {
      pixel = {srgb_to_linear(pixel.x), srgb_to_linear(pixel.y), srgb_to_linear(pixel.z)};
    }
  }
  return std::move(stored.image);
}

void write_image(const fs::path& path, const Image<float>& image, const PngOptions& png) {
  const Format format = format_of(path);
  detail::check_size(path, image.width, image.height);
  TemporaryFile temporary(path);
  switch (format) {
    case Format::exr:
      detail::write_exr(temporary.path(), image);
      break;
    case Format::pfm:
      detail::write_pfm(temporary.path(), image);
      break;
    case Format::png:
      detail::write_png(temporary.path(), image, png);
      break;
  }
  temporary.rename_to(path);
}

void check_writable(const fs::path& path) {
  (void)format_of(path);
  std::error_code error;
  if (fs::is_directory(path, error)) throw ImageFileError(path, "is a folder, not an image file");
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  if (!fs::is_directory(folder, error)) throw ImageFileError(path, "its folder does not exist");
  const TemporaryFile temporary(path);
  std::ofstream probe(temporary.path(), std::ios::binary);
  if (!probe || !probe.put('\0').flush()) throw ImageFileError(path, "cannot be written");
}

}  // namespace manylight::image_io
