// SPDX-License-Identifier: Apache-2.0
// Oracle: files written here, byte by byte.
#include "scene_file/volume_grid.hpp"

#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "manylight/media/grid_volume.hpp"
#include "programs/scratch.hpp"
#include "programs/volume_files.hpp"

namespace manylight::scene_file::volume_grid_test {
namespace {

using test::message_of;
using test::put;
using test::Scratch;
using testing::HasSubstr;

std::string header(std::int32_t type, std::int32_t channels) {
  std::string file = "VOL\3";
  for (const std::int32_t n : {type, 4, 3, 2, channels}) put(file, n);
  for (const float x : {-1.0F, 0.0F, 2.0F, 1.0F, 3.0F, 2.5F}) put(file, x);
  return file;
}
/// 4 x 3 x 2 samples, number i holds i / 4.
std::string floats(std::int32_t channels = 1) {
  std::string file = header(1, channels);
  for (int i = 0; i < 24 * channels; ++i) put(file, static_cast<float>(i) / 4);
  return file;
}

std::string error_of(const std::string& bytes) {
  const Scratch scratch;
  const auto path = scratch.write("a.vol", bytes);
  return message_of<SceneFileError>([&] { static_cast<void>(read_volume_grid(path)); });
}
/// The file with four bytes at `at` replaced.
template <class T>
std::string patched(std::size_t at, T value, std::string file = floats()) {
  std::memcpy(file.data() + at, &value, sizeof(T));
  return file;
}

TEST(VolumeGrid, ReadsFloatsWithXFastest) {
  const Scratch scratch;
  const VolumeGrid grid = read_volume_grid(scratch.write("a.vol", floats()));
  EXPECT_EQ(grid.size, (std::array<std::uint32_t, 3>{4, 3, 2}));
  EXPECT_EQ(grid.channels, 1U);
  EXPECT_EQ(grid.box.lo, Vec3<float>(-1, 0, 2));
  EXPECT_EQ(grid.box.hi, Vec3<float>(1, 3, 2.5F));
  ASSERT_EQ(grid.values.size(), 24U);
  EXPECT_EQ(grid.values[1 + 4 * (2 + 3 * 1)], 21.0F / 4);
  GridPlacement<float> placement;
  placement.box = grid.box;
  const GridVolume<float> volume(grid.size, LargeVector<float>(grid.values.begin(), grid.values.end()), placement);
  EXPECT_FLOAT_EQ(volume.eval({-1, 0, 2}), 0.0F);
  EXPECT_FLOAT_EQ(volume.eval({1, 0, 2}), 0.75F);
  EXPECT_FLOAT_EQ(volume.eval({-1, 3, 2}), 2.0F);
  EXPECT_FLOAT_EQ(volume.eval({1, 3, 2.5F}), 23.0F / 4);
}

TEST(VolumeGrid, ReadsThreeChannelsOfAnySign) {
  const Scratch scratch;
  const VolumeGrid grid = read_volume_grid(scratch.write("a.vol", patched(48 + 4 * 4, -2.5F, floats(3))));
  EXPECT_EQ(grid.channels, 3U);
  ASSERT_EQ(grid.values.size(), 72U);
  EXPECT_EQ(grid.values[4], -2.5F);
  EXPECT_EQ(grid.values[71], 71.0F / 4);
}

TEST(VolumeGrid, ReadsBytesAsFractions) {
  const Scratch scratch;
  std::string file = header(3, 1);
  for (int i = 0; i < 24; ++i) file += static_cast<char>(i == 5 ? 255 : i);
  const VolumeGrid grid = read_volume_grid(scratch.write("a.vol", file));
  EXPECT_EQ(grid.values[5], 1.0F);
  EXPECT_FLOAT_EQ(grid.values[17], 17.0F / 255);
}

// IEEE 754 binary16: 1, -2, the largest 65504, the smallest normal 2^-14, the smallest of all 2^-24, 1/3 rounded.
TEST(VolumeGrid, ReadsHalves) {
  const Scratch scratch;
  const std::vector<std::pair<std::uint16_t, float>> known{{0x3C00, 1.0F},     {0xC000, -2.0F},
                                                           {0x7BFF, 65504.0F}, {0x0400, 0x1p-14F},
                                                           {0x0001, 0x1p-24F}, {0x3555, 0.333251953125F}};
  std::string file = header(2, 1);
  for (std::size_t i = 0; i < 24; ++i) put(file, i < known.size() ? known[i].first : std::uint16_t{0});
  const VolumeGrid grid = read_volume_grid(scratch.write("a.vol", file));
  for (std::size_t i = 0; i < known.size(); ++i) EXPECT_EQ(grid.values[i], known[i].second);
  file[48] = 0;
  file[49] = 0x7C;
  EXPECT_THAT(error_of(file), HasSubstr("value 0: is inf, allowed: finite"));
}

// Planted bug seen to fail: data longer than stated accepted.
TEST(VolumeGrid, RefusesTruncatedFilesAndTrailingBytes) {
  const std::string whole = floats();
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_NE(error_of(whole.substr(0, size)), "no error") << "cut to " << size;
  }
  EXPECT_EQ(error_of(whole), "no error");
  EXPECT_THAT(error_of(whole.substr(0, 20)), HasSubstr("header: is 20 bytes long, allowed: 48"));
  EXPECT_THAT(error_of(whole.substr(0, 100)), HasSubstr("data: is 52 bytes long, allowed: 96 for the resolution"));
  EXPECT_THAT(error_of(whole + 'x'), HasSubstr("data: is 97 bytes long, allowed: 96"));
}

TEST(VolumeGrid, NamesFileFieldValueAndRange) {
  const std::string version = error_of(patched(3, '\2'));
  EXPECT_THAT(version, HasSubstr("a.vol: version: is 2, allowed: 3"));
  EXPECT_THAT(error_of("<?xml version='1.0'?>"), HasSubstr("a.vol: is not a .vol grid file"));
  EXPECT_THAT(error_of(patched(4, 4)), HasSubstr("type: is 4, allowed: 1 (float32), 2 (float16), 3 (bytes)"));
  EXPECT_THAT(error_of(patched(8, 0)), HasSubstr("resolution along x: is 0, allowed: 1 to 65536"));
  EXPECT_THAT(error_of(patched(16, -7)), HasSubstr("resolution along z: is -7"));
  EXPECT_THAT(error_of(patched(12, 70000)), HasSubstr("resolution along y: is 70000"));
  EXPECT_THAT(error_of(patched(12, 60000)), HasSubstr("data: is 96 bytes long")) << "nothing is allocated for it";
  EXPECT_THAT(error_of(patched(20, 2)), HasSubstr("number of channels: is 2, allowed: 1 or 3"));
  EXPECT_THAT(error_of(patched(28, std::nanf(""))), HasSubstr("bounding box along y, lower end: is nan"));
  EXPECT_THAT(error_of(patched(44, 2.0F)),
              HasSubstr("bounding box along z, upper end: is 2, allowed: finite and above"));
  EXPECT_THAT(error_of(patched(48 + 4 * 9, std::nanf(""))), HasSubstr("value 9: is nan, allowed: finite"));
}

// Any one byte wrong: an error or a grid, but neither a crash nor another kind of exception.
TEST(VolumeGrid, DamagedBytesDoNoHarm) {
  const Scratch scratch;
  const std::string whole = floats();
  for (std::size_t at = 0; at < whole.size(); ++at) {
    for (const char c : {'\0', '\x7f', '\xff'}) {
      std::string damaged = whole;
      damaged[at] = c;
      const auto path = scratch.write("a.vol", damaged);
      EXPECT_NO_FATAL_FAILURE(
          static_cast<void>(message_of<SceneFileError>([&] { EXPECT_EQ(read_volume_grid(path).values.size(), 24U); })));
    }
  }
}

}  // namespace
}  // namespace manylight::scene_file::volume_grid_test
