// SPDX-License-Identifier: Apache-2.0
#include "image_io/image_io.hpp"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <array>
#include <bit>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

namespace manylight::image_io::image_io_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// Values that a format may spoil: negative, tiny, huge, and different in each channel and pixel.
Image<float> probe() {
  return Image<float>(3, 2, {Rgb<float>(0, 0.25F, 1), Rgb<float>(-2, 1e-30F, 3e30F), Rgb<float>(0.1F, 0.2F, 0.3F),
                             Rgb<float>(4, 5, 6), Rgb<float>(1e-3F, 65'536, 7), Rgb<float>(8, 9, 10)});
}

std::string read_file(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

void write_file(const fs::path& path, const std::string& bytes) { std::ofstream(path, std::ios::binary) << bytes; }

std::string error_of_reading(const fs::path& path) {
  try {
    (void)read_image(path);
  } catch (const ImageFileError& error) {
    return error.what();
  }
  return "nothing thrown";
}

/// Four bytes of `value`, most significant first if `is_big_endian`: by arithmetic, whatever machine runs the test.
std::string float_bytes(float value, bool is_big_endian) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  std::string bytes;
  for (int i = 0; i < 4; ++i) bytes.push_back(static_cast<char>((bits >> (is_big_endian ? 24 - 8 * i : 8 * i)) & 0xFF));
  return bytes;
}

class ImageIo : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(MANYLIGHT_SCRATCH_DIR) / testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  [[nodiscard]] fs::path path(const std::string& name) const { return folder_ / name; }
  [[nodiscard]] std::size_t files() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }

  fs::path folder_;
};

void expect_same(const Image<float>& a, const Image<float>& b) {
  ASSERT_EQ(a.width, b.width);
  ASSERT_EQ(a.height, b.height);
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    for (int c = 0; c < 3; ++c) EXPECT_EQ(a.pixels[i][c], b.pixels[i][c]) << "pixel " << i << " channel " << c;
  }
}

TEST_F(ImageIo, FloatFormatsKeepEveryBit) {
  for (const char* name : {"a.exr", "a.pfm", "UPPER.EXR"}) {
    write_image(path(name), probe());
    expect_same(read_image(path(name)), probe());
    EXPECT_FALSE(read_stored(path(name)).is_srgb_encoded);
  }
  EXPECT_EQ(files(), 3U) << "temporary files are left";
}

// Oracle: a half has 11 significant bits, so rounding to nearest changes a value by at most 2^-11 of itself.
// The file is written by OpenEXR itself with an offset data window: its corner is pixel (0, 0).
TEST_F(ImageIo, HalfExrWithOffsetDataWindow) {
  const std::array<half, 2> red{half(0.1F), half(2.0F)};
  const std::array<half, 2> green{half(0.25F), half(3.0F)};
  const std::array<half, 2> blue{half(1000.5F), half(4.0F)};
  const Imath::Box2i window(Imath::V2i(5, 7), Imath::V2i(6, 7));
  Imf::Header header(Imath::Box2i(Imath::V2i(0, 0), Imath::V2i(9, 9)), window);
  Imf::FrameBuffer buffer;
  const auto add = [&](const char* name, const std::array<half, 2>& values) {
    header.channels().insert(name, Imf::Channel(Imf::HALF));
    char* base = const_cast<char*>(reinterpret_cast<const char*>(values.data()));
    buffer.insert(name, Imf::Slice::Make(Imf::HALF, base, window, sizeof(half), 2 * sizeof(half)));
  };
  add("R", red);
  add("G", green);
  add("B", blue);
  {
    Imf::OutputFile file(path("half.exr").c_str(), header);
    file.setFrameBuffer(buffer);
    file.writePixels(1);
  }
  const Image<float> image = read_image(path("half.exr"));
  ASSERT_EQ(image.width, 2U);
  ASSERT_EQ(image.height, 1U);
  EXPECT_NEAR(image.at(0, 0).x, 0.1F, 0.1F / 2048);  // 2^-11, as above
  EXPECT_EQ(image.at(0, 0).z, 1000.5F);              // exact in half, as the following
  EXPECT_EQ(image.at(1, 0).x, 2.0F);
  EXPECT_EQ(image.at(1, 0).y, 3.0F);
  EXPECT_EQ(image.at(1, 0).z, 4.0F);
}

// Oracle: bytes put together by hand from the format's description; rows run from the bottom to the top.
TEST_F(ImageIo, PfmOfBothByteOrders) {
  for (const bool is_big_endian : {false, true}) {
    std::string bytes = std::string("PF\n1 2\n") + (is_big_endian ? "1.0\n" : "-1.0\n");
    for (const float value : {4.0F, 5.0F, 6.0F, 1.0F, 2.0F, 3.0F}) bytes += float_bytes(value, is_big_endian);
    write_file(path("a.pfm"), bytes);
    expect_same(read_image(path("a.pfm")), Image<float>(1, 2, {Rgb<float>(1, 2, 3), Rgb<float>(4, 5, 6)}));
  }
}

TEST_F(ImageIo, GreyPfmFillsThreeChannels) {
  write_file(path("a.pfm"), "Pf\n2 1\n-1.0\n" + float_bytes(0.5F, false) + float_bytes(7.0F, false));
  expect_same(read_image(path("a.pfm")), Image<float>(2, 1, {Rgb<float>(0.5F), Rgb<float>(7.0F)}));
}

// Oracle: IEC 61966-2-1: linear 0.5 is 0.735357 encoded, 187.5 of 255, stored as 188; the toe is a line of slope 12.92.
TEST_F(ImageIo, PngIsSrgb) {
  EXPECT_NEAR(linear_to_srgb(0.5F), 0.735357F, 1e-6F);   // six digits given
  EXPECT_NEAR(srgb_to_linear(0.5F), 0.214041F, 1e-6F);   // six digits given
  EXPECT_NEAR(linear_to_srgb(0.001F), 0.01292F, 1e-8F);  // two ulp
  write_image(path("a.png"), Image<float>(2, 1, {Rgb<float>(0.5F, 0, 1), Rgb<float>(7, -1, 0.25F)}));
  const StoredImage stored = read_stored(path("a.png"));
  EXPECT_TRUE(stored.is_srgb_encoded);
  EXPECT_NEAR(stored.image.at(0, 0).x, 188.0F / 255.0F, 1e-6F);  // float rounding
  EXPECT_EQ(stored.image.at(0, 0).y, 0.0F);
  EXPECT_EQ(stored.image.at(0, 0).z, 1.0F);
  EXPECT_EQ(stored.image.at(1, 0).x, 1.0F) << "above 1 is clamped";
  EXPECT_EQ(stored.image.at(1, 0).y, 0.0F) << "negative is clamped";
  const Image<float> linear = read_image(path("a.png"));
  EXPECT_NEAR(linear.at(0, 0).x, 0.5F, 0.005F);  // half a step of 1/255 times the curve's slope of 1.6 is 0.0031
}

// Oracle: one stop doubles.
TEST_F(ImageIo, PngExposure) {
  write_image(path("a.png"), Image<float>(1, 1, Rgb<float>(0.25F)), {.exposure = 1.0F});
  EXPECT_NEAR(read_stored(path("a.png")).image.at(0, 0).x, 188.0F / 255.0F, 1e-6F);  // float rounding
}

TEST_F(ImageIo, PngOfNotANumberIsBlack) {
  write_image(path("a.png"), Image<float>(1, 1, Rgb<float>(std::numeric_limits<float>::quiet_NaN())));
  EXPECT_EQ(read_stored(path("a.png")).image.at(0, 0).x, 0.0F);
}

// However a file is cut off, reading it is an error that names it, never a crash or a half-filled image. Every
// fifth length of a file of a few hundred bytes: odd, so that four-byte fields are cut at all their places.
TEST_F(ImageIo, TruncatedFiles) {
  for (const char* name : {"a.exr", "a.pfm", "a.png"}) {
    write_image(path(name), probe());
    const std::string bytes = read_file(path(name));
    const std::size_t kept = std::string(name) == "a.png" ? 4 : 0;  // the checksum of the end marker
    for (std::size_t length = 0; length + kept < bytes.size(); length += 5) {
      write_file(path(std::string("cut_") + name), bytes.substr(0, length));
      ASSERT_THAT(error_of_reading(path(std::string("cut_") + name)), HasSubstr("cut_")) << "length " << length;
    }
  }
}

TEST_F(ImageIo, WhatIsNoImage) {
  EXPECT_THAT(error_of_reading(path("missing.exr")), HasSubstr("missing.exr: no such file"));
  EXPECT_THAT(error_of_reading(folder_), HasSubstr("is a folder"));
  write_file(path("text.png"), "hello");
  EXPECT_THAT(error_of_reading(path("text.png")), HasSubstr("not an image of a supported kind"));
  write_file(path("huge.pfm"), "PF\n60000 60000\n-1.0\n");
  EXPECT_THAT(error_of_reading(path("huge.pfm")), HasSubstr("impossible image size 60000 x 60000"));
  write_file(path("negative.pfm"), "PF\n-1 1\n-1.0\n");
  EXPECT_THAT(error_of_reading(path("negative.pfm")), HasSubstr("impossible image size -1 x 1"));
  write_file(path("scale.pfm"), "PF\n1 1\n0\n............");
  EXPECT_THAT(error_of_reading(path("scale.pfm")), HasSubstr("damaged PFM header"));
}

TEST_F(ImageIo, WhatCannotBeWritten) {
  EXPECT_THROW(write_image(path("a.gif"), probe()), ImageFileError);
  EXPECT_THROW(write_image(path("none"), probe()), ImageFileError);
  EXPECT_THROW(write_image(path("empty.exr"), Image<float>()), ImageFileError);
  for (const char* name : {"nowhere/a.exr", "nowhere/a.pfm", "nowhere/a.png"}) {
    EXPECT_THROW(write_image(path(name), probe()), ImageFileError) << name;
    EXPECT_THROW(check_writable(path(name)), ImageFileError) << name;
  }
  EXPECT_THROW(check_writable(path("a.gif")), ImageFileError);
  EXPECT_NO_THROW(check_writable(path("a.exr")));
  EXPECT_EQ(files(), 0U) << "a failed or probing write leaves nothing behind";
}

// A disk that is full: no file may grow beyond 64 bytes, which binds the super-user too.
class FullDisk {
 public:
  FullDisk() : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit tiny{64, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &tiny);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;
  ~FullDisk() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  rlimit before_{};
  void (*handler_)(int);
};

// Planted bug seen to fail here: written in place, without the temporary file.
TEST_F(ImageIo, AFailedWriteKeepsTheOldFile) {
  for (const char* name : {"a.exr", "a.pfm", "a.png"}) {
    write_image(path(name), probe());
    const std::string before = read_file(path(name));
    {
      const FullDisk full;
      EXPECT_THROW(write_image(path(name), Image<float>(64, 64, Rgb<float>(1))), ImageFileError) << name;
    }
    EXPECT_EQ(read_file(path(name)), before) << name;
    fs::remove(path(name));
    EXPECT_EQ(files(), 0U) << "a temporary file is left";
  }
}

TEST_F(ImageIo, AFolderIsNotReplaced) {
  fs::create_directories(path("a.exr") / "inside");
  EXPECT_THROW(write_image(path("a.exr"), probe()), ImageFileError);
  EXPECT_THROW(check_writable(path("a.exr")), ImageFileError);
  EXPECT_TRUE(fs::is_directory(path("a.exr") / "inside"));
  EXPECT_EQ(files(), 1U) << "a temporary file is left";
}

}  // namespace
}  // namespace manylight::image_io::image_io_test
