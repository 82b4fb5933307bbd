// SPDX-License-Identifier: Apache-2.0
// Damage that the decoders underneath would take, or would be taken by.
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "image_io/image_io.hpp"
#include "programs/scratch.hpp"

namespace manylight::image_io::damaged_images_test {
namespace {

using test::bytes_of;
using test::message_of;
using test::Scratch;
using testing::HasSubstr;
using testing::Not;

std::string error_of(const std::filesystem::path& path) {
  return message_of<ImageFileError>([&] { static_cast<void>(read_image(path)); });
}

/// A grey JPEG of 8 x 8 pixels: start, one flat quantisation table, frame, two Huffman tables of one code, scan, end.
std::string tiny_jpeg(char codes_of_length_one = 1) {
  std::string jpeg("\xff\xd8\xff\xdb\x00\x43\x00", 7);
  jpeg += std::string(64, '\x10');
  jpeg += std::string("\xff\xc0\x00\x0b\x08\x00\x08\x00\x08\x01\x01\x11\x00", 13);
  for (const char table : {'\x00', '\x10'}) {
    jpeg += std::string("\xff\xc4\x00\x14", 4) + table + codes_of_length_one + std::string(15, '\0') + '\0';
  }
  return jpeg + std::string("\xff\xda\x00\x08\x01\x01\x00\x00\x3f\x00\x3f\xff\xd9", 13);
}

TEST(DamagedImages, TheTinyJpegIsSound) {
  const Scratch scratch;
  const StoredImage stored = read_stored(scratch.write("a.jpg", tiny_jpeg()));
  EXPECT_EQ(stored.image.width, 8U);
  EXPECT_NEAR(stored.image.at(3, 3).x, 128.0F / 255.0F, 1e-6F);  // no coefficient at all: the middle of the range
}

// The decoder fills what is missing of a JPEG with grey and reports success.
TEST(DamagedImages, EveryTruncationOfAJpegIsRefused) {
  const Scratch scratch;
  const std::string whole = tiny_jpeg();
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_NE(error_of(scratch.write("a.jpg", whole.substr(0, size))), "no error") << size;
  }
}

// The decoder writes past its tables where the counts of codes add up to more than 256 (seen by AddressSanitizer).
TEST(DamagedImages, HuffmanTablesWithTooManyCodesAreRefused) {
  const Scratch scratch;
  EXPECT_THAT(error_of(scratch.write("a.jpg", tiny_jpeg('\xff'))), HasSubstr("truncated or damaged image"));
}

// Random damage of every format: read, or refused in one line. Fixed seed; the sanitizers watch.
TEST(DamagedImages, RandomDamageIsNeverFatal) {
  const Scratch scratch;
  Image<float> image(9, 7);
  std::mt19937 random(5);
  for (Rgb<float>& pixel : image.pixels) pixel = Rgb<float>(static_cast<float>(random() % 100) / 50.0F);
  for (const char* name : {"a.exr", "a.pfm", "a.png"}) write_image(scratch / name, image);
  scratch.write("a.jpg", tiny_jpeg());
  for (const char* name : {"a.exr", "a.pfm", "a.png", "a.jpg"}) {
    const std::string good = bytes_of(scratch / name);
    for (int i = 0; i < 200; ++i) {
      std::string bytes = good;
      for (int k = 0; k <= i % 4; ++k) bytes[random() % bytes.size()] = static_cast<char>(random() % 256);
      EXPECT_THAT(error_of(scratch.write(std::string("bad-") + name, bytes)), Not(HasSubstr("\n"))) << name << ' ' << i;
    }
  }
}

}  // namespace
}  // namespace manylight::image_io::damaged_images_test
