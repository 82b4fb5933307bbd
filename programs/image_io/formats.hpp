// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "image_io/image_io.hpp"

/// One reader and writer per file format; `image_io.hpp` chooses among them.
namespace manylight::image_io::detail {

/// Most pixels accepted from a file: a damaged header must not exhaust the memory.
inline constexpr std::size_t k_max_pixels = std::size_t{1} << 27;

/// Throws ImageFileError unless both sides lie in [1, 65535] and the image has at most k_max_pixels.
void check_size(const std::filesystem::path& path, std::int64_t width, std::int64_t height);

[[nodiscard]] std::string read_bytes(const std::filesystem::path& path);

[[nodiscard]] Image<float> read_exr(const std::filesystem::path& path);
void write_exr(const std::filesystem::path& path, const Image<float>& image);

[[nodiscard]] Image<float> decode_pfm(const std::filesystem::path& path, const std::string& bytes);
void write_pfm(const std::filesystem::path& path, const Image<float>& image);

[[nodiscard]] StoredImage decode_ldr(const std::filesystem::path& path, const std::string& bytes);
void write_png(const std::filesystem::path& path, const Image<float>& image, const PngOptions& options);

}  // namespace manylight::image_io::detail
