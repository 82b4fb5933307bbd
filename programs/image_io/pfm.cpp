// SPDX-License-Identifier: Apache-2.0
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <sstream>

#include "image_io/formats.hpp"

namespace manylight::image_io::detail {

namespace {

struct PfmHeader {
  std::int64_t width = 0;
  std::int64_t height = 0;
  int channels = 3;
  bool is_little_endian = true;
  std::size_t data_offset = 0;
};

/// "PF" or "Pf", width, height, scale; one white space; then rows from the bottom to the top. A negative scale means
/// little-endian numbers.
PfmHeader parse_header(const std::filesystem::path& path, const std::string& bytes) {
  std::istringstream in(bytes.substr(0, 256));
  std::string magic;
  PfmHeader header;
  double scale = 0;
  if (!(in >> magic >> header.width >> header.height >> scale) || !std::isfinite(scale) || scale == 0) {
    throw ImageFileError(path, "damaged PFM header");
  }
  check_size(path, header.width, header.height);
  header.channels = magic == "PF" ? 3 : 1;
  header.is_little_endian = scale < 0;
  header.data_offset = static_cast<std::size_t>(in.tellg()) + 1;
  return header;
}

float load_float(const char* at, bool is_little_endian) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, at, sizeof bits);
  if (is_little_endian != (std::endian::native == std::endian::little)) bits = __builtin_bswap32(bits);
  return std::bit_cast<float>(bits);
}

}  // namespace

Image<float> decode_pfm(const std::filesystem::path& path, const std::string& bytes) {
  const PfmHeader header = parse_header(path, bytes);
  const auto width = static_cast<std::uint32_t>(header.width);
  const auto height = static_cast<std::uint32_t>(header.height);
  const auto channels = static_cast<std::size_t>(header.channels);
  const std::size_t needed = std::size_t{width} * height * channels * sizeof(float);
  if (bytes.size() < header.data_offset || bytes.size() - header.data_offset < needed) {
    throw ImageFileError(path, "truncated PFM image");
  }
  Image<float> image(width, height);
  const char* at = bytes.data() + header.data_offset;
  for (std::uint32_t y = height; y-- > 0;) {
    for (std::uint32_t x = 0; x < width; ++x) {
      Rgb<float>& pixel = image.at(x, y);
      pixel.x = load_float(at, header.is_little_endian);
      pixel.y = channels == 1 ? pixel.x : load_float(at + 4, header.is_little_endian);
      pixel.z = channels == 1 ? pixel.x : load_float(at + 8, header.is_little_endian);
      at += channels * sizeof(float);
    }
  }
  return image;
}

void write_pfm(const std::filesystem::path& path, const Image<float>& image) {
  std::ofstream out(path, std::ios::binary);
  const char* scale = std::endian::native == std::endian::little ? "-1.0" : "1.0";
  out << "PF\n" << image.width << ' ' << image.height << '\n' << scale << '\n';
  for (std::uint32_t y = image.height; y-- > 0;) {
    const auto bytes = static_cast<std::streamsize>(std::size_t{image.width} * sizeof(Rgb<float>));
    out.write(reinterpret_cast<const char*>(&image.at(0, y)), bytes);
  }
  out.close();
  if (!out) throw ImageFileError(path, "cannot be written");
}

}  // namespace manylight::image_io::detail
