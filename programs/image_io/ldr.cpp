// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <memory>
#include <vector>

#include "image_io/formats.hpp"

// The implementation lives in this unit only; its functions are static, so that another copy in the program is no
// clash.
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_NO_STDIO
#define STBI_NO_HDR
#define STBI_NO_GIF
#define STBI_NO_PSD
#define STBI_NO_PIC
#define STBI_NO_PNM
#define STB_IMAGE_WRITE_STATIC
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STBI_WRITE_NO_STDIO
#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#endif
#include <stb_image.h>
#include <stb_image_write.h>
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

namespace manylight::image_io::detail {

namespace {

struct Freed {
  void operator()(void* memory) const noexcept { stbi_image_free(memory); }
};

std::uint8_t byte_at(const std::string& bytes, std::size_t at) { return static_cast<std::uint8_t>(bytes[at]); }

/// A Huffman segment holds tables of a class byte, 16 counts, and as many bytes as the counts add up to. stb writes
/// past its tables where they add up to more than 256.
bool are_huffman_tables_sound(const std::string& bytes, std::size_t at, std::size_t end) {
  while (at < end) {
    if (end - at < 17) return false;
    std::size_t codes = 0;
    for (std::size_t i = 1; i <= 16; ++i) codes += byte_at(bytes, at + i);
    if (codes > 256 || end - at - 17 < codes) return false;
    at += 17 + codes;
  }
  return true;
}

/// Walks the segments of a JPEG to its end marker. stb fills the rest of a file that was cut off with grey and reports
/// success.
bool is_sound_jpeg(const std::string& bytes) {
  for (std::size_t at = 2; at + 1 < bytes.size();) {
    const std::uint8_t marker = byte_at(bytes, at + 1);
    const bool is_marker = byte_at(bytes, at) == 0xFF && marker != 0x00 && marker != 0x01 && marker != 0xFF;
    if (!is_marker || (marker >= 0xD0 && marker <= 0xD7)) {  // data of a scan, or a restart in it
      ++at;
      continue;
    }
    if (marker == 0xD9) return true;
    if (bytes.size() - at < 4) return false;
    const std::size_t length = std::size_t{byte_at(bytes, at + 2)} * 256 + byte_at(bytes, at + 3);
    if (length < 2 || bytes.size() - at - 2 < length) return false;
    if (marker == 0xC4 && !are_huffman_tables_sound(bytes, at + 4, at + 2 + length)) return false;
    at += 2 + length;
  }
  return false;
}

bool is_damaged_jpeg(const std::string& bytes) {
  const bool is_jpeg = bytes.size() >= 2 && byte_at(bytes, 0) == 0xFF && byte_at(bytes, 1) == 0xD8;
  return is_jpeg && !is_sound_jpeg(bytes);
}

bool is_cut_off_png(const std::string& bytes) {
  return bytes.rfind("\x89PNG", 0) == 0 && bytes.find("IEND") == std::string::npos;
}

template <class Value>
Image<float> unpack(const Value* values, int width, int height, int channels) {
  constexpr float k_scale = 1.0F / static_cast<float>(std::numeric_limits<Value>::max());
  Image<float> image(static_cast<std::size_t>(width), static_cast<std::size_t>(height));
  const int green = channels >= 3 ? 1 : 0;
  const int blue = channels >= 3 ? 2 : 0;
  for (Rgb<float>& pixel : image.pixels) {
    pixel = Rgb<float>(values[0], values[green], values[blue]) * k_scale;
    values += channels;
  }
  return image;
}

void append(void* context, void* data, int size) {
  static_cast<std::string*>(context)->append(static_cast<const char*>(data), static_cast<std::size_t>(size));
}

std::uint8_t quantise(float linear) { return static_cast<std::uint8_t>(linear_to_srgb(linear) * 255.0F + 0.5F); }

}  // namespace

StoredImage decode_ldr(const std::filesystem::path& path, const std::string& bytes) {
  if (bytes.empty()) throw ImageFileError(path, "empty file");
  if (is_damaged_jpeg(bytes) || is_cut_off_png(bytes)) throw ImageFileError(path, "truncated or damaged image");
  if (bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) {
    throw ImageFileError(path, "file too large");
  }
  const auto* data = reinterpret_cast<const stbi_uc*>(bytes.data());
  const int size = static_cast<int>(bytes.size());
  int width = 0;
  int height = 0;
  int channels = 0;
  if (stbi_info_from_memory(data, size, &width, &height, &channels) == 0) {
    throw ImageFileError(path, "not an image of a supported kind (EXR, PFM, PNG, JPEG, TGA, BMP)");
  }
  check_size(path, width, height);
  Image<float> image;
  if (stbi_is_16_bit_from_memory(data, size) != 0) {
    const std::unique_ptr<stbi_us, Freed> pixels(stbi_load_16_from_memory(data, size, &width, &height, &channels, 0));
    if (pixels) image = unpack(pixels.get(), width, height, channels);
  } else {
    const std::unique_ptr<stbi_uc, Freed> pixels(stbi_load_from_memory(data, size, &width, &height, &channels, 0));
    if (pixels) image = unpack(pixels.get(), width, height, channels);
  }
  if (image.empty()) throw ImageFileError(path, std::string("damaged image: ") + stbi_failure_reason());
  return {std::move(image), true};
}

void write_png(const std::filesystem::path& path, const Image<float>& image, const PngOptions& options) {
  const float scale = std::exp2(options.exposure);
  std::vector<std::uint8_t> pixels;
  pixels.reserve(image.pixels.size() * 3);
  for (const Rgb<float>& pixel : image.pixels) {
    for (const float value : {pixel.x, pixel.y, pixel.z}) pixels.push_back(quantise(value * scale));
  }
  std::string encoded;
  const int width = static_cast<int>(image.width);
  const int height = static_cast<int>(image.height);
  const int ok = stbi_write_png_to_func(append, &encoded, width, height, 3, pixels.data(), width * 3);
  std::ofstream out(path, std::ios::binary);
  out.write(encoded.data(), static_cast<std::streamsize>(encoded.size()));
  out.close();
  if (ok == 0 || !out) throw ImageFileError(path, "cannot be written");
}

}  // namespace manylight::image_io::detail
