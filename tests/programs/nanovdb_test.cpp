// SPDX-License-Identifier: Apache-2.0
// Volumes of NanoVDB files. Oracles: NanoVDB's own builder, writer and accessor; closed forms of the world.
#include "scene_file/nanovdb_grid.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "programs/program_run.hpp"
#include "programs/scratch.hpp"
#include "programs/volume_files.hpp"
#include "scene_file/load_scene.hpp"

#if defined(MANYLIGHT_HAS_NANOVDB)
#define NANOVDB_USE_ZIP
#include <nanovdb/NanoVDB.h>
// The builder takes members of a null pointer in one assertion, which the sanitizers end the test for.
#undef NANOVDB_ASSERT
#define NANOVDB_ASSERT(x)
#include <nanovdb/util/GridBuilder.h>
#include <nanovdb/util/IO.h>
#endif

namespace manylight::test::nanovdb_test {
namespace {

using scene_file::load_scene;
using scene_file::MediumDescription;
using scene_file::read_nanovdb_grid;
using scene_file::read_volume_grid;
using scene_file::SceneFileError;
using scene_file::VolumeGrid;
using testing::AllOf;
using testing::HasSubstr;

class Nanovdb : public ScratchTest {
 protected:
  [[nodiscard]] std::string error_of(const std::string& file, const std::string& bytes) const {
    const auto to = write(file, bytes);
    return message_of<SceneFileError>([&] { static_cast<void>(read_volume_grid(to)); });
  }
  /// The only medium of a scene of the version whose ball holds it.
  [[nodiscard]] MediumDescription medium_of(const std::string& inside, const std::string& version) const {
    const std::string scene = "<scene version=\"" + version +
                              "\"><sensor type=\"perspective\"/><emitter type=\"point\"/><shape type=\"sphere\">"
                              "<medium name=\"interior\" type=\"heterogeneous\">" +
                              inside + "</medium></shape></scene>";
    return load_scene(write("scene.xml", scene)).media.at(0);
  }
};

#if !defined(MANYLIGHT_HAS_NANOVDB)

TEST_F(Nanovdb, IsRefusedByBuildsWithoutIt) {
  EXPECT_THAT(error_of("a.vol", "NanoVDB0"),
              HasSubstr("a.vol: is a NanoVDB file, and this program was built without NanoVDB"));
}

#else

using nanovdb::Coord;

std::string volume(const std::string& name, const std::string& file, const std::string& inside = "") {
  return "<volume type=\"gridvolume\" name=\"" + name + "\"><string name=\"filename\" value=\"" + file + "\"/>" +
         inside + "</volume>";
}
std::string gridname(const std::string& name) { return "<string name=\"gridname\" value=\"" + name + "\"/>"; }
const std::string k_in_file_box = "<boolean name=\"use_grid_bbox\" value=\"true\"/>";
const std::string k_albedo = "<rgb name=\"albedo\" value=\"0.5\"/>";

/// The affine map of the rows, to the place given.
nanovdb::Map map_of(const std::array<std::array<double, 3>, 3>& rows, const std::array<double, 3>& place) {
  double columns[3][3];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) columns[j][i] = rows[std::size_t(i)][std::size_t(j)];
  }
  nanovdb::Map map;
  map.set(columns, columns, place.data(), 1.0);  // nobody asks for the inverse
  return map;
}
const nanovdb::Map k_scaled = map_of({{{0.5, 0, 0}, {0, 0.25, 0}, {0, 0, 2}}}, {1, -2, 8});

/// A grid of background 0 whose voxels in [lo, hi] have the values, those that are 0 left inactive.
template <class ValueAt>
nanovdb::GridHandle<> built(const Coord& lo, const Coord& hi, const ValueAt& value_at,
                            const nanovdb::Map& map = k_scaled, const std::string& name = "density",
                            nanovdb::ChecksumMode checksum = nanovdb::ChecksumMode::Partial) {
  nanovdb::GridBuilder<float> builder(0.0F);
  builder.setChecksum(checksum);
  builder([&](const Coord& c) { return static_cast<float>(value_at(c)); }, nanovdb::CoordBBox(lo, hi));
  return builder.getHandle(map, name);
}
/// A grid of one leaf of active values at `origin`, which `fill` fills. NanoVDB's builder takes 4 s to compile for each
/// type of values.
template <class Build, class Fill>
nanovdb::GridHandle<> one_leaf(const Coord& origin, const Fill& fill, std::size_t behind_leaf = 0) {
  using Tree = nanovdb::TreeData<3>;
  using Root = typename nanovdb::NanoRoot<Build>::DataType;
  using Upper = typename nanovdb::NanoUpper<Build>::DataType;
  using Lower = typename nanovdb::NanoLower<Build>::DataType;
  using Leaf = typename nanovdb::NanoLeaf<Build>::DataType;
  const std::size_t root_at = sizeof(nanovdb::GridData) + sizeof(Tree);
  const std::size_t upper_at = root_at + sizeof(Root) + sizeof(typename Root::Tile);
  const std::size_t size = upper_at + sizeof(Upper) + sizeof(Lower) + sizeof(Leaf) + behind_leaf;
  auto buffer = nanovdb::HostBuffer::create(size);
  std::memset(buffer.data(), 0, size);
  auto* grid = reinterpret_cast<nanovdb::GridData*>(buffer.data());
  grid->mMagic = NANOVDB_MAGIC_NUMBER;
  grid->mChecksum = ~std::uint64_t{0};
  grid->mVersion = nanovdb::Version();
  grid->mGridCount = 1;
  grid->mGridSize = size;
  grid->mMap = k_scaled;
  grid->mGridType = nanovdb::mapToGridType<Build>();
  std::strcpy(grid->mGridName, "density");
  auto* tree = reinterpret_cast<Tree*>(grid + 1);
  auto* root = reinterpret_cast<Root*>(buffer.data() + root_at);
  auto* upper = reinterpret_cast<Upper*>(buffer.data() + upper_at);
  auto* lower = reinterpret_cast<Lower*>(upper + 1);
  auto* leaf = reinterpret_cast<Leaf*>(lower + 1);
  tree->setRoot(root);
  std::fill_n(tree->mNodeCount, 3, 1U);
  root->mBBox = nanovdb::CoordBBox(origin, origin.offsetBy(7));
  root->mTableSize = 1;
  root->tile(0)->setChild(origin, reinterpret_cast<nanovdb::NanoUpper<Build>*>(upper), root);
  const std::uint32_t in_upper = nanovdb::NanoUpper<Build>::CoordToOffset(origin);
  const std::uint32_t in_lower = nanovdb::NanoLower<Build>::CoordToOffset(origin);
  upper->mChildMask.setOn(in_upper);
  upper->setChild(in_upper, lower);
  lower->mChildMask.setOn(in_lower);
  lower->setChild(in_lower, leaf);
  leaf->mBBoxMin = origin;
  leaf->mValueMask.setOn();
  fill(*leaf);
  return nanovdb::GridHandle<>(std::move(buffer));
}
nanovdb::GridHandle<> leaf_of_vectors(const Coord& origin) {
  return one_leaf<nanovdb::Vec3f>(origin, [](auto& leaf) {
    for (int n = 0; n < 512; ++n) leaf.mValues[n] = nanovdb::Vec3f(1, float(n % 7), -2);
  });
}
template <class Build>
nanovdb::GridHandle<> leaf_of_codes(const Coord& origin) {
  return one_leaf<Build>(origin, [](auto& leaf) {
    leaf.mMinimum = 0.5F;
    leaf.mQuantum = 0.125F;
    for (std::size_t i = 0; i < sizeof(leaf.mCode); ++i) {
      reinterpret_cast<unsigned char*>(leaf.mCode)[i] = static_cast<unsigned char>(37 * i);
    }
  });
}
/// Codes of 2^log_bits bits each.
nanovdb::GridHandle<> leaf_of_any_codes(const Coord& origin, unsigned log_bits) {
  const std::size_t bytes = std::size_t{64} << log_bits;
  const auto fill = [&](auto& leaf) {
    leaf.init(1, 2, static_cast<std::uint8_t>(1U << log_bits));
    leaf.mFlags = static_cast<std::uint8_t>(log_bits << 5U);
    auto* codes = reinterpret_cast<unsigned char*>(&leaf + 1);
    for (std::size_t i = 0; i < bytes; ++i) codes[i] = static_cast<unsigned char>(37 * i);
  };
  return one_leaf<nanovdb::FpN>(origin, fill, bytes);
}
/// Not negative, not the same in any two directions, 0 in places, one constant block of a leaf's size.
float bumps(const Coord& c) {
  if ((c[0] >> 3) == 0 && (c[1] >> 3) == 0 && (c[2] >> 3) == 0) return 0.75F;
  const int n = (7 * c[0] + 13 * c[1] + 29 * c[2]) & 63;
  return n < 20 ? 0.0F : static_cast<float>(n) / 64;
}
const Coord k_lo(-5, -11, -3);
const Coord k_hi(17, 9, 12);

/// Values at all indices equal those that NanoVDB's accessor reads: all bits, or, of codes, to the rounding of
/// minimum + quantum * code, which the compiler may fuse in one place and not in the other.
template <class Value, class Build>
void expect_accessors_values(const std::filesystem::path& file, const nanovdb::GridHandle<>& handle) {
  const auto* grid = handle.template grid<Build>();
  ASSERT_NE(grid, nullptr);
  const VolumeGrid read = read_volume_grid(file);
  const auto box = grid->indexBBox();
  for (std::uint32_t axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(read.size[axis], static_cast<std::uint32_t>(box.dim()[axis]));
  }
  ASSERT_EQ(read.values.size(), read.sample_count() * read.channels);
  ASSERT_TRUE(read.from_samples);
  const auto first = grid->indexToWorld(nanovdb::Vec3d(box.min()[0], box.min()[1], box.min()[2]));
  for (int axis = 0; axis < 3; ++axis) EXPECT_EQ((*read.from_samples)[3][axis], first[axis]);
  const auto accessor = grid->getAccessor();
  std::size_t i = 0;
  std::size_t wrong = 0;
  for (int z = box.min()[2]; z <= box.max()[2]; ++z) {
    for (int y = box.min()[1]; y <= box.max()[1]; ++y) {
      for (int x = box.min()[0]; x <= box.max()[0]; ++x) {
        const Value value = accessor.getValue(Coord(x, y, z));
        if constexpr (std::is_same_v<Value, nanovdb::Vec3f>) {
          for (int c = 0; c < 3; ++c) wrong += read.values[i++] != value[c];
        } else {
          const auto expected = static_cast<float>(value);
          const float allowed = std::is_same_v<Value, Build> ? 0 : std::numeric_limits<float>::epsilon() * expected;
          wrong += !(std::abs(read.values[i++] - expected) <= allowed);
        }
      }
    }
  }
  EXPECT_EQ(wrong, 0U) << "of " << read.values.size();
}
template <class Value, class Build = Value>
void expect_reads(const std::filesystem::path& file, const nanovdb::GridHandle<>& handle) {
  for (const auto codec : {nanovdb::io::Codec::NONE, nanovdb::io::Codec::ZIP}) {
    nanovdb::io::writeGrid(file.string(), handle, codec);
    expect_accessors_values<Value, Build>(file, handle);
  }
}

// Planted bug seen to fail: tiles of the lower level left out.
TEST_F(Nanovdb, ReadsWhatTheAccessorReads) { expect_reads<float>(path("a.nvdb"), built(k_lo, k_hi, bumps)); }

TEST_F(Nanovdb, ReadsOtherTypes) {
  const Coord origin(-8, 4096, 64);
  const auto doubles = [](auto& leaf) {
    for (int n = 0; n < 512; ++n) leaf.mValues[n] = 1.0 / (1 + n);
  };
  expect_reads<double>(path("a.nvdb"), one_leaf<double>(origin, doubles));
  expect_reads<nanovdb::Vec3f>(path("a.nvdb"), leaf_of_vectors(origin));
  expect_reads<float, nanovdb::Fp4>(path("a.nvdb"), leaf_of_codes<nanovdb::Fp4>(origin));
  expect_reads<float, nanovdb::Fp8>(path("a.nvdb"), leaf_of_codes<nanovdb::Fp8>(origin));
  expect_reads<float, nanovdb::Fp16>(path("a.nvdb"), leaf_of_codes<nanovdb::Fp16>(origin));
  for (const unsigned log_bits : {0U, 1U, 2U, 3U, 4U}) {
    expect_reads<float, nanovdb::FpN>(path("a.nvdb"), leaf_of_any_codes(origin, log_bits));
  }
  EXPECT_FLOAT_EQ(read_volume_grid(path("a.nvdb")).values.at(64), 1 + 0x6F4A / 65535.0F) << "(0, 0, 1): bytes 2, 3";
}

/// 2 + x / 8 + y / 2 + z / 16 of the world, at a voxel's middle.
float ramp(const nanovdb::Map& map, const Coord& c) {
  const auto w = map.applyMap(nanovdb::Vec3d(c[0], c[1], c[2]));
  return static_cast<float>(4 + w[0] / 8 + w[1] / 2 + w[2] / 16);
}

// Closed form: a linear function survives trilinear interpolation, wherever samples lie.
// Planted bugs seen to fail: the box of at_vertices for at_centers, the lowest index left out of the map.
TEST_F(Nanovdb, LiesWhereItsMapSays) {
  nanovdb::io::writeGrid(path("ramp.nvdb").string(),
                         built(Coord(-2, 3, 1), Coord(2, 7, 4), [](const Coord& c) { return ramp(k_scaled, c); }));
  const auto old = medium_of(volume("density", "ramp.nvdb") + k_albedo, "0.6.0");
  const auto later = medium_of(volume("sigma_t", "ramp.nvdb", k_in_file_box) + k_albedo, "3.0.0");
  // Voxels' middles: x = 0 to 2, y = -1.25 to -0.25, z = 10 to 16.
  for (const MediumDescription* medium : {&old, &later}) {
    for (const Vec3<float> p :
         {Vec3<float>(0.1F, -1.2F, 10.5F), Vec3<float>(1.7F, -0.3F, 15), Vec3<float>(1, -1, 12)}) {
      EXPECT_NEAR(medium->density->eval(p), 4 + p.x / 8 + p.y / 2 + p.z / 16, 1e-5F);  // float interpolation
    }
    EXPECT_EQ(medium->density->eval({2.3F, -1, 12}), 0);
    EXPECT_EQ(medium->density->eval({1, -1.4F, 12}), 0);
  }
  EXPECT_EQ(old.density->eval({2.1F, -1, 12}), 0) << "ends at the last sample";
  EXPECT_NEAR(later.density->eval({2.1F, -1, 12}), 4.5F, 1e-5F) << "goes on for half a voxel; rounding of float";
}

TEST_F(Nanovdb, MapsMayTurnAndShear) {
  const nanovdb::Map map = map_of({{{0, -0.5, 0.125}, {0.25, 0, 0}, {0, 0, 0.5}}}, {3, 1, 0});
  nanovdb::io::writeGrid(path("ramp.nvdb").string(),
                         built(
                             Coord(0, 0, 0), Coord(8, 4, 4), [&](const Coord& c) { return ramp(map, c); }, map));
  const std::string moved = "<transform name=\"to_world\"><scale value=\"2\"/><translate x=\"-6\"/></transform>";
  const auto medium = medium_of(volume("density", "ramp.nvdb", moved) + k_albedo, "0.6.0");
  for (const Coord c : {Coord(0, 0, 0), Coord(8, 4, 4), Coord(3, 1, 2), Coord(5, 4, 1)}) {
    const auto w = map.applyMap(nanovdb::Vec3d(c[0] * 0.9 + 0.1, c[1] * 0.9 + 0.1, c[2] * 0.9 + 0.1));
    const Vec3<float> p(float(2 * w[0] - 6), float(2 * w[1]), float(2 * w[2]));
    EXPECT_NEAR(medium.density->eval(p), 4 + w[0] / 8 + w[1] / 2 + w[2] / 16, 1e-5);  // float interpolation
  }
}

// Directions are of the frame of the file: not turned by the map, which is of the places alone.
// Planted bug seen to fail: taken as of the frame of indices.
TEST_F(Nanovdb, FibersKeepTheirDirections) {
  const auto map = map_of({{{0, -0.5, 0}, {0.25, 0, 0}, {0, 0, 0.5}}}, {3, 1, 0});
  auto axes = leaf_of_vectors(Coord(0));
  reinterpret_cast<nanovdb::GridData*>(axes.data())->mMap = map;
  nanovdb::io::writeGrid(path("axes.nvdb").string(), axes);
  nanovdb::io::writeGrid(path("cloth.nvdb").string(), built(
                                                          Coord(0), Coord(7), [](const Coord&) { return 1; }, map));
  const auto medium = medium_of(volume("density", "cloth.nvdb") + volume("orientation", "axes.nvdb") + k_albedo +
                                    "<phase type=\"microflake\"><float name=\"stddev\" value=\"0.2\"/></phase>",
                                "0.6.0");
  ASSERT_EQ(medium.axes.size(), 512U);
  const Vec3<float> turned = medium.density->lattice().to_world_direction(medium.axes[2 * 64]);  // number 2 of the leaf
  const Vec3<float> expected = Vec3<float>(1, 2, -2) / 3.0F;
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(turned[i], expected[i], 1e-6F);  // a few roundings of floats
}

// The same samples as .vol and as .nvdb, under another name: bit for bit the same field, in a version's own box too.
TEST_F(Nanovdb, EqualsTheSameVol) {
  const auto handle = built(Coord(0), Coord(5, 4, 3), [](const Coord& c) { return bumps(c + Coord(9)) + 1; });
  nanovdb::io::writeGrid(path("a.vol").string(), handle);
  std::vector<float> values;
  for (int z = 0; z < 4; ++z) {
    for (int y = 0; y < 5; ++y) {
      for (int x = 0; x < 6; ++x) values.push_back(bumps(Coord(x + 9, y + 9, z + 9)) + 1);
    }
  }
  // k_scaled takes the cells' outer faces there, and all of it is exact in floats.
  write("b.vol", volume_file({6, 5, 4}, 1, {0.75F, -2.125F, 7, 3.75F, -0.875F, 15}, values));
  for (const std::string& inside : {std::string(), k_in_file_box}) {
    const auto a = medium_of(volume("sigma_t", "a.vol", inside), "3.0.0");
    const auto b = medium_of(volume("sigma_t", "b.vol", inside), "3.0.0");
    for (std::size_t i = 0; i < values.size(); ++i) EXPECT_EQ(a.density->sample(i), values[i]);
    for (int i = 0; i < 100; ++i) {
      const auto t = static_cast<float>(i) / 100;
      const Vec3<float> p =
          inside.empty() ? Vec3<float>(t, 1 - t, t * t) : Vec3<float>(1 + 2 * t, t - 2, 8 + 6 * t * t);
      EXPECT_GT(b.density->eval(p), 0);
      EXPECT_EQ(a.density->eval(p), b.density->eval(p));
    }
  }
}

TEST_F(Nanovdb, GridsAreChosenByName) {
  const auto constant = [](float value) { return [=](const Coord&) { return value; }; };
  std::vector<nanovdb::GridHandle<>> grids;
  grids.push_back(built(Coord(0), Coord(1), constant(1), k_scaled, "heat"));
  grids.push_back(built(Coord(0), Coord(1), constant(2), k_scaled, "density"));
  grids.push_back(built(Coord(0), Coord(1), constant(3), k_scaled, "soot"));
  nanovdb::io::writeGrids(path("three.nvdb").string(), grids, nanovdb::io::Codec::ZIP);
  EXPECT_EQ(read_volume_grid(path("three.nvdb")).values.at(0), 2);
  EXPECT_EQ(read_volume_grid(path("three.nvdb"), "soot").values.at(0), 3);
  EXPECT_EQ(medium_of(volume("sigma_t", "three.nvdb", gridname("heat")), "3.0.0").density->maximum(), 1);
  const auto error = [&](const std::optional<std::string>& name) {
    return message_of<SceneFileError>([&] { static_cast<void>(read_volume_grid(path("three.nvdb"), name)); });
  };
  EXPECT_THAT(error("ash"), HasSubstr("gridname: is 'ash', allowed: 'heat', 'density', 'soot'"));
  grids.erase(grids.begin() + 1);
  nanovdb::io::writeGrids(path("three.nvdb").string(), grids);
  EXPECT_THAT(error(std::nullopt), HasSubstr("is not given, and no grid is called 'density', allowed: 'heat', 'soot'"));
  write("b.vol", volume_file({2, 1, 1}, 1, {0, 0, 0, 1, 1, 1}, {1, 2}));
  EXPECT_THAT(message_of<SceneFileError>([&] { static_cast<void>(read_volume_grid(path("b.vol"), "soot")); }),
              HasSubstr("b.vol: gridname: is 'soot', allowed: none"));
}

/// Where things are in a file of one grid called "density".
constexpr std::size_t k_meta_at = 16;
constexpr std::size_t k_grid_at = 16 + 176 + 8;
constexpr std::size_t k_tree_at = k_grid_at + 672;
constexpr std::size_t k_upper_at = k_tree_at + 64 + 64 + 32;  // behind the root and its one tile

class DamagedNanovdb : public Nanovdb {
 protected:
  /// A leaf and a tile, with checksums of all.
  std::string whole_file(nanovdb::io::Codec codec = nanovdb::io::Codec::NONE) const {
    nanovdb::io::writeGrid(path("a.nvdb").string(),
                           built(Coord(0), Coord(9, 7, 7), bumps, k_scaled, "density", nanovdb::ChecksumMode::Full),
                           codec);
    return bytes_of(path("a.nvdb"));
  }
  std::string error_of(const std::string& bytes) const {
    return message_of<SceneFileError>([&] { static_cast<void>(read_nanovdb_grid("a.nvdb", bytes, std::nullopt)); });
  }
  template <class T>
  static std::string patched(std::string bytes, std::size_t at, T value) {
    std::memcpy(bytes.data() + at, &value, sizeof(T));
    return bytes;
  }
  static std::string without_checksum(std::string bytes) {
    return patched(std::move(bytes), k_grid_at + 8, ~std::uint64_t{0});
  }
};

TEST_F(DamagedNanovdb, NamesFileFieldValueAndRange) {
  const std::string whole = whole_file();
  EXPECT_EQ(error_of(whole), "no error");
  EXPECT_EQ(error_of(patched(patched(whole, 7, '2'), k_grid_at + 7, '1')), "no error") << "as OpenVDB 11 writes";
  EXPECT_THAT(error_of(patched(whole, 7, '1')),
              HasSubstr("a.nvdb: magic: is 'NanoVDB1', allowed: NanoVDB0 or NanoVDB2"));
  EXPECT_THAT(error_of(patched(whole, 8, 29U << 21U)), HasSubstr("a.nvdb: version: is 29, allowed: 32"));
  EXPECT_THAT(error_of(patched(whole, 14, std::uint16_t{2})), HasSubstr("compression: is BLOSC, allowed: none or ZIP"));
  EXPECT_THAT(error_of(patched(whole, 14, std::uint16_t{7})), HasSubstr("compression: is 7, allowed: none or ZIP"));
  EXPECT_THAT(error_of(patched(whole, 12, std::uint16_t{0})), HasSubstr("magic: is '"));
  EXPECT_THAT(error_of(patched(whole, k_meta_at + 32, 4U)),
              HasSubstr("type of grid 'density': is int32, allowed: float"));
  EXPECT_THAT(error_of(patched(whole, k_meta_at + 32, 77U)), HasSubstr("type of grid 'density': is 77"));
  EXPECT_THAT(error_of(patched(whole, k_meta_at + 32, 2U)),
              HasSubstr("grid 'density': is damaged: wrong type of values"));
  EXPECT_THAT(error_of(patched(whole, k_meta_at, std::uint64_t{1} << 60U)), HasSubstr("grid 'density': is "));
  EXPECT_THAT(error_of(patched(whole, k_grid_at + 300, '\1')), HasSubstr("is damaged: wrong checksum"));
  EXPECT_THAT(error_of(patched(whole, whole.size() - 4, 7.0F)), HasSubstr("is damaged: wrong checksum")) << "of nodes";
  const std::string packed = whole_file(nanovdb::io::Codec::ZIP);
  EXPECT_THAT(error_of(patched(packed, k_meta_at, std::uint64_t{0})), HasSubstr("is damaged: its bytes cannot be"));
  EXPECT_THAT(error_of(patched(packed, k_meta_at, std::uint64_t{1} << 40U)), HasSubstr("bytes long, allowed: at most"));
  const std::string unsigned_file = without_checksum(whole);
  EXPECT_EQ(error_of(unsigned_file), "no error");
  EXPECT_THAT(error_of(patched(unsigned_file, k_grid_at + 296 + 88, std::nan(""))),
              HasSubstr("map of the grid, row 0 column 0: is nan, allowed: finite"));
  EXPECT_THAT(error_of(patched(unsigned_file, k_grid_at + 296 + 88, 0.0)),
              HasSubstr("determinant of the grid's map: is 0, allowed: finite and not 0"));
  EXPECT_THAT(error_of(patched(unsigned_file, k_tree_at + 24, std::uint64_t{96})), HasSubstr("is damaged: wrong "));
  EXPECT_THAT(error_of(patched(unsigned_file, k_tree_at + 32, 2U)), HasSubstr("is damaged: wrong number of nodes"));
}

TEST_F(DamagedNanovdb, GridsMustHaveFiniteValuesAndSomeExtent) {
  const auto error = [&](const nanovdb::GridHandle<>& handle) {
    nanovdb::io::writeGrid(path("b.nvdb").string(), handle);
    return error_of(bytes_of(path("b.nvdb")));
  };
  const auto with = [](const Coord& place, float value) {
    return built(place, place, [=](const Coord&) { return value; });
  };
  EXPECT_THAT(error(with(Coord(4, -5, 6), INFINITY)), HasSubstr("value at (4, -5, 6): is inf, allowed: finite"));
  EXPECT_THAT(error(with(Coord(0), 0.0F)), HasSubstr("grid: is empty, allowed: one with active values"));
  const auto far = [](const Coord& second) {
    nanovdb::GridBuilder<float> builder(0.0F);
    auto accessor = builder.getAccessor();
    accessor.setValue(Coord(0), 1.0F);
    accessor.setValue(second, 1.0F);
    return builder.getHandle(k_scaled, "density");
  };
  EXPECT_THAT(error(far(Coord(-1, 65536, 0))), HasSubstr("active values along y: is 65537, allowed: 1 to 65536"));
  EXPECT_THAT(error(far(Coord(1023, 1023, -1024))),
              HasSubstr("number of samples: is 1024 x 1024 x 1025 from (0, 0, -1024) to (1023, 1023, 0), allowed: "
                        "1073741824 in all"));
  nanovdb::io::writeGrid(path("negative.nvdb").string(), with(Coord(0), -1.0F));
  EXPECT_THAT(
      message_of<SceneFileError>([&] { static_cast<void>(medium_of(volume("sigma_t", "negative.nvdb"), "3.0.0")); }),
      AllOf(HasSubstr("scene.xml:1"), HasSubstr("grid value 0 at (0, 0, 0) is -1, allowed: finite and >= 0")));
  EXPECT_THAT(Nanovdb::error_of("a.nvdb", std::string(" BDV\0\0\0\0", 8)), HasSubstr("is an OpenVDB file"));
  EXPECT_THAT(Nanovdb::error_of("a.nvdb", "nothing"), HasSubstr("is not a .vol grid file, nor .nvdb"));
}

TEST_F(DamagedNanovdb, TruncatedFilesAreRefused) {
  for (const auto codec : {nanovdb::io::Codec::NONE, nanovdb::io::Codec::ZIP}) {
    const std::string whole = whole_file(codec);
    for (std::size_t size = 8; size < whole.size(); size += size < k_tree_at + 200 ? 1 : 4001) {
      EXPECT_NE(error_of(whole.substr(0, size)), "no error") << "cut to " << size;
    }
    EXPECT_THAT(error_of(whole.substr(0, 100)), HasSubstr("grid directory: is 84 bytes long, allowed: 176"));
    EXPECT_THAT(error_of(whole + 'x'), HasSubstr("header: is 1 bytes long, allowed: 16"));
    EXPECT_NE(error_of(whole.substr(0, whole.size() - 1)), "no error");
  }
}

// Any byte wrong: an error or a grid, but neither a crash nor another kind of exception; with the checksum an error,
// but for bytes of the envelope that nobody asks. Without it, the bytes of the tree are believed as far as they go.
// Planted bugs seen to fail, with sanitizers: no check of offsets, any width of FpN read.
TEST_F(DamagedNanovdb, DamagedBytesDoNoHarm) {
  std::string bytes = whole_file();
  const auto damage = [&](std::size_t at, char c) {
    const char kept = std::exchange(bytes[at], static_cast<char>(bytes[at] ^ c));
    const std::string error = error_of(bytes);
    bytes[at] = kept;
    return error;
  };
  for (std::size_t at = 0; at < k_tree_at + 400; ++at) {
    const std::string error = damage(at, '\x81');
    const bool is_version = at == k_grid_at + 17 || at == k_grid_at + 18;  // later ones count otherwise
    if (at >= k_grid_at + 8 && !is_version) {
      EXPECT_NE(error, "no error") << at;
    }
  }
  bytes = without_checksum(bytes);
  for (std::size_t at = 0; at < k_upper_at; ++at) damage(at, '\x90');
  // From the mask of the upper node's children on: one of its values more may be gigabytes to fill.
  for (std::size_t at = k_upper_at + 32 + 4096; at < bytes.size(); at += 509) damage(at, '\xff');  // a prime
  nanovdb::io::writeGrid(path("n.nvdb").string(), leaf_of_any_codes(Coord(0), 2));
  bytes = bytes_of(path("n.nvdb"));
  for (const char width : {'\x20', '\xe0'})
    EXPECT_THAT(damage(bytes.size() - 256 - 96 + 15, width), HasSubstr("width"));
  bytes = whole_file(nanovdb::io::Codec::ZIP);
  for (std::size_t at = 16; at < bytes.size(); at += at < k_grid_at + 16 ? 1 : 97) damage(at, '\x81');
}

#endif

}  // namespace
}  // namespace manylight::test::nanovdb_test
