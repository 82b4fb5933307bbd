// SPDX-License-Identifier: Apache-2.0
// The one place that knows whether NanoVDB was there when this was built.
#include "scene_file/nanovdb_grid.hpp"

#if !defined(MANYLIGHT_HAS_NANOVDB)

namespace manylight::scene_file {

VolumeGrid read_nanovdb_grid(const std::filesystem::path& path, const std::string& /*data*/,
                             const std::optional<std::string>& /*gridname*/) {
  throw SceneFileError(path.string(), 0, "",
                       "is a NanoVDB file, and this program was built without NanoVDB (Debian: libnanovdb-dev)");
}

}  // namespace manylight::scene_file

#else

#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>

#include <glm/matrix.hpp>

#include "scene_file/nanovdb_tree.hpp"

namespace manylight::scene_file {

namespace {

std::string text_of(const nanovdb::Coord& c) {
  return "(" + std::to_string(c[0]) + ", " + std::to_string(c[1]) + ", " + std::to_string(c[2]) + ")";
}

void check_extent(const std::filesystem::path& path, const nanovdb::CoordBBox& active, VolumeGrid& grid) {
  if (active.empty()) throw SceneFileError(path.string(), 0, "grid", "is empty, allowed: one with active values");
  constexpr std::int64_t k_side = VolumeGrid::k_largest_side;
  for (std::uint32_t axis = 0; axis < 3; ++axis) {
    const std::int64_t n = std::int64_t{active.max()[axis]} - active.min()[axis] + 1;
    if (n > k_side) {
      fail_field(path, std::string("extent of active values along ") + "xyz"[axis], n,
                 "1 to " + std::to_string(k_side));
    }
    grid.size[axis] = static_cast<std::uint32_t>(n);
  }
  if (grid.sample_count() * grid.channels > k_largest_nanovdb_grid) {
    const auto& n = grid.size;
    fail_field(path, "number of samples",
               std::to_string(n[0]) + " x " + std::to_string(n[1]) + " x " + std::to_string(n[2]) + " from " +
                   text_of(active.min()) + " to " + text_of(active.max()),
               std::to_string(k_largest_nanovdb_grid / grid.channels) + " in all");
  }
}

/// NanoVDB's map M takes an index to the world of its file, and an index is where a voxel's value stands, its middle.
/// Sample (i, j, k) has the index min + (i, j, k): M * translation(min), in double, as min may be far from 0.
Mat4<double> map_of(const std::filesystem::path& path, const nanovdb::GridData& header, const nanovdb::Coord& min) {
  Mat4<double> m(1.0);
  for (int row = 0; row < 3; ++row) {
    m[3][row] = header.mMap.mVecD[row];
    for (int column = 0; column < 3; ++column) m[column][row] = header.mMap.mMatD[3 * row + column];
  }
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 3; ++row) {
      const std::string entry = "row " + std::to_string(row) + " column " + std::to_string(column);
      if (!std::isfinite(m[column][row])) fail_field(path, "map of the grid, " + entry, m[column][row], "finite");
    }
  }
  const double determinant = glm::determinant(glm::dmat3(m));
  if (!std::isfinite(determinant) || determinant == 0.0) {
    fail_field(path, "determinant of the grid's map", determinant, "finite and not 0");
  }
  m[3] += m[0] * double(min[0]) + m[1] * double(min[1]) + m[2] * double(min[2]);
  return m;
}

float channel(float value, std::uint32_t /*index*/) { return value; }
float channel(double value, std::uint32_t /*index*/) { return static_cast<float>(value); }
float channel(const nanovdb::Vec3f& value, std::uint32_t index) { return value[static_cast<int>(index)]; }

/// The numbers of a box of voxels, those of other places left out.
template <class Value>
class DenseValues {
 public:
  DenseValues(const std::filesystem::path& path, const nanovdb::CoordBBox& box, const Value& background,
              VolumeGrid& grid)
      : path_(path), box_(box), grid_(grid) {
    grid.values.resize(grid.sample_count() * grid.channels);
    set(box, [&](const nanovdb::Coord&) { return background; });
  }
  template <class ValueAt>
  void set(const nanovdb::Coord& origin, std::int32_t side, const ValueAt& value_at) {
    nanovdb::CoordBBox cube(origin, origin.offsetBy(side - 1));
    cube.intersect(box_);
    set(cube, value_at);
  }
  /// Throws SceneFileError.
  void check() const {
    for (std::size_t i = 0; i < grid_.values.size(); ++i) {
      if (std::isfinite(grid_.values[i])) continue;
      const std::size_t voxel = i / grid_.channels;
      const std::size_t row = grid_.size[0];
      const std::size_t slice = row * grid_.size[1];
      const nanovdb::Coord at(static_cast<std::int32_t>(voxel % row), static_cast<std::int32_t>(voxel % slice / row),
                              static_cast<std::int32_t>(voxel / slice));
      fail_field(path_, "value at " + text_of(box_.min() + at), grid_.values[i], "finite");
    }
  }

 private:
  template <class ValueAt>
  void set(const nanovdb::CoordBBox& part, const ValueAt& value_at) {
    for (std::int32_t z = part.min()[2]; z <= part.max()[2]; ++z) {
      for (std::int32_t y = part.min()[1]; y <= part.max()[1]; ++y) {
        const auto k = static_cast<std::size_t>(z - box_.min()[2]);
        const auto j = static_cast<std::size_t>(y - box_.min()[1]);
        const auto i = static_cast<std::size_t>(part.min()[0] - box_.min()[0]);
        float* to = grid_.values.data() + ((k * grid_.size[1] + j) * grid_.size[0] + i) * grid_.channels;
        for (std::int32_t x = part.min()[0]; x <= part.max()[0]; ++x) {
          const Value value = value_at(nanovdb::Coord(x, y, z));
          for (std::uint32_t c = 0; c < grid_.channels; ++c) *to++ = channel(value, c);
        }
      }
    }
  }

  const std::filesystem::path& path_;
  nanovdb::CoordBBox box_;
  VolumeGrid& grid_;
};

template <class Build>
VolumeGrid dense(const std::filesystem::path& path, const StoredNanovdbGrid& stored) {
  using Tree = NanovdbTree<Build>;
  using Value = typename Tree::Value;
  const Tree tree(path, stored);
  VolumeGrid grid;
  grid.channels = std::is_same_v<Value, nanovdb::Vec3f> ? 3 : 1;
  check_extent(path, tree.active(), grid);
  grid.from_samples = map_of(path, tree.header(), tree.active().min());
  DenseValues<Value> values(path, tree.active(), tree.background(), grid);
  for (const auto& tile : tree.tiles()) {
    values.set(tile.origin, tile.side, [&](const nanovdb::Coord&) { return tile.value; });
  }
  for (const auto& place : tree.leaves()) {
    values.set(place.origin, static_cast<std::int32_t>(Tree::Leaf::DIM),
               [&](const nanovdb::Coord& c) { return place.leaf->getValue(Tree::Leaf::CoordToOffset(c)); });
  }
  values.check();
  return grid;
}

}  // namespace

VolumeGrid read_nanovdb_grid(const std::filesystem::path& path, const std::string& data,
                             const std::optional<std::string>& gridname) {
  const StoredNanovdbGrid stored = unpack_nanovdb_grid(path, data, gridname);
  switch (stored.type) {
    case nanovdb::GridType::Float:
      return dense<float>(path, stored);
    case nanovdb::GridType::Double:
      return dense<double>(path, stored);
    case nanovdb::GridType::Vec3f:
      return dense<nanovdb::Vec3f>(path, stored);
    case nanovdb::GridType::Fp4:
      return dense<nanovdb::Fp4>(path, stored);
    case nanovdb::GridType::Fp8:
      return dense<nanovdb::Fp8>(path, stored);
    case nanovdb::GridType::Fp16:
      return dense<nanovdb::Fp16>(path, stored);
    case nanovdb::GridType::FpN:
      return dense<nanovdb::FpN>(path, stored);
    default:
      break;
  }
  const bool is_known = stored.type < nanovdb::GridType::End;
  fail_field(path, "type of grid '" + stored.name + "'",
             is_known ? nanovdb::toStr(stored.type) : std::to_string(static_cast<std::uint32_t>(stored.type)),
             "float, double, Vec3f, Fp4, Fp8, Fp16, FpN");
}

}  // namespace manylight::scene_file

#endif
