// SPDX-License-Identifier: Apache-2.0
// <volume> elements.
#include "scene_file/volumes.hpp"

#include <cmath>
#include <string>

#include <glm/matrix.hpp>

namespace manylight::scene_file {

namespace {

/// Where the file says that its samples lie. A .vol file states the box of the grid. An .nvdb file states the place of
/// each sample, by an affine map that may turn and shear; the box is then one of sample numbers, and the map becomes
/// part of `to_world`. Sample i lies in the middle of the i-th of n cells, [i - 1/2, i + 1/2], which fill
/// [-1/2, n - 1/2]; or it lies at the lower end of the i-th of n - 1 cells, which fill [0, n - 1].
void place_by_file(Volume& volume) {
  const VolumeGrid& grid = *volume.grid;
  GridPlacement<float>& placement = volume.placement;
  if (!grid.from_samples) {
    placement.box = grid.box;
    return;
  }
  const float outer = placement.samples == GridSamples::at_centers ? 0.5F : 0.0F;
  placement.box = {Vec3<float>(-outer), Vec3<float>(grid.size[0], grid.size[1], grid.size[2]) - 1.0F + outer};
  placement.to_world = Mat4<float>(Mat4<double>(placement.to_world) * *grid.from_samples);
  volume.to_grid_frame = glm::inverse(glm::dmat3(*grid.from_samples));
}

/// Places the grid before `to_world`, which is set. Versions 0.x: as the file says, or in the box that `min` and `max`
/// give; later ones: in the unit cube, or as the file says.
void place_grid(const Context& context, Properties& p, Volume& volume) {
  if (context.document.major_version >= 2) {
    if (p.flag("use_grid_bbox", false)) place_by_file(volume);
    return;
  }
  const auto lo = p.vector("min");
  const auto hi = p.vector("max");
  if (lo.has_value() != hi.has_value()) fail(p.element(), "needs either both min and max, or none of them");
  if (!lo) return place_by_file(volume);
  for (int axis = 0; axis < 3; ++axis) {
    if ((*hi)[axis] > (*lo)[axis]) continue;
    fail(p.element(), std::string("max is ") + std::to_string((*hi)[axis]) + " along " + "xyz"[axis] +
                          ", allowed: above min, " + std::to_string((*lo)[axis]));
  }
  volume.placement.box = {*lo, *hi};
}

void require_text(Properties& p, const char* name, const std::string& allowed) {
  const std::string value = p.text(name).value_or(allowed);
  if (value != allowed) fail(p.element(), std::string(name) + " '" + value + "' is not supported, allowed: " + allowed);
}

Volume parse_grid(Context& context, Properties& p) {
  Volume volume;
  volume.element = &p.element();
  const auto name = p.text("filename");
  if (!name) fail(p.element(), "needs a filename");
  volume.grid = read_volume_grid(context.document.resolve(p.element(), *name), p.text("gridname"));
  // Versions 0.x have the outer samples on the faces of the box, later ones in the middle of the outer cells.
  volume.placement.samples = context.document.major_version >= 2 ? GridSamples::at_centers : GridSamples::at_vertices;
  volume.placement.to_world = take_transform(p, "to_world");
  place_grid(context, p, volume);
  if (const auto copies = p.vector("copies")) {
    for (int axis = 0; axis < 3; ++axis) {
      const float n = (*copies)[axis];
      if (!(n >= 1 && n <= 65536 && n == std::floor(n))) {
        fail(p.element(), "copies must be whole numbers, allowed: 1 to 65536 along each axis");
      }
      volume.placement.copies[static_cast<std::size_t>(axis)] = static_cast<std::uint32_t>(n);
    }
  }
  require_text(p, "filter_type", "trilinear");
  require_text(p, "wrap_mode", "clamp");
  p.ignore({"send_data", "raw", "accel"});
  return volume;
}

template <class Grid, class Make>
Grid checked_grid(const Volume& volume, const Make& make) {
  try {
    return make();
  } catch (const ParameterError& error) {
    fail(*volume.element, error.what());
  }
}

}  // namespace

Volume parse_volume(Context& context, const Element& element) {
  Volume volume;
  volume.element = volume.value = &element;
  if (element.tag != "volume") return volume;
  const std::string& type = element.get("type");
  Properties p(element, context.names);
  if (type == "gridvolume") {
    volume = parse_grid(context, p);
  } else if (type == "constvolume") {
    volume.value = p.take("value");
    if (volume.value == nullptr) fail(element, "needs a value");
    volume.placement.to_world = take_transform(p, "to_world");
  } else {
    fail(element, "unknown volume; supported are constvolume and gridvolume");
  }
  p.finish();
  return volume;
}

std::optional<Volume> take_volume(Context& context, Properties& properties, const char* name) {
  const Element* child = properties.take(name);
  if (child == nullptr) return std::nullopt;
  return parse_volume(context, *child);
}

Rgb<float> constant_color(const Context& context, const Volume& volume) {
  if (volume.grid) fail(*volume.element, "is a grid, allowed: one value for all places");
  return parse_color(context, *volume.value, SpectrumRole::ratio);
}

GridVolume<float> density_grid(const Volume& volume) {
  if (volume.grid->channels != 1) fail(*volume.element, "has 3 channels, allowed: 1, a density without colour");
  return checked_grid<GridVolume<float>>(volume, [&] {
    const auto& values = volume.grid->values;
    return GridVolume<float>(volume.grid->size, GridVolume<float>::Samples(values.begin(), values.end()),
                             volume.placement);
  });
}

GridVolume<float, Rgb<float>> albedo_grid(const Volume& volume) {
  using Grid = GridVolume<float, Rgb<float>>;
  const VolumeGrid& file = *volume.grid;
  Grid::Samples samples;
  samples.reserve(file.sample_count());
  for (std::size_t i = 0; i < file.sample_count(); ++i) {
    const float* v = &file.values[i * file.channels];
    samples.push_back(file.channels == 1 ? Rgb<float>(v[0]) : Rgb<float>(v[0], v[1], v[2]));
  }
  Grid grid = checked_grid<Grid>(volume, [&] { return Grid(file.size, std::move(samples), volume.placement); });
  if (grid.maximum() > 1.0F) fail(*volume.element, "reaches " + std::to_string(grid.maximum()) + ", allowed: 0 to 1");
  return grid;
}

std::vector<Vec3<float>> fiber_axes(const Volume& axes, const Volume& density) {
  const std::size_t count = density.grid->sample_count();
  if (!axes.grid) {
    if (axes.value->tag != "vector" && axes.value->tag != "point") {
      fail(*axes.value, "wrong kind of property, expected <vector> or <point>");
    }
    const Vec3<float> axis = parse_vector(*axes.value, 0.0F);
    if (!(glm::dot(axis, axis) > 0)) fail(*axes.value, "direction is 0, allowed: any other");
    return std::vector<Vec3<float>>(count, glm::inverse(glm::mat3(density.placement.to_world)) * axis);
  }
  const VolumeGrid& file = *axes.grid;
  if (file.channels != 3) fail(*axes.element, "has 1 channel, allowed: 3, directions");
  const bool is_alike = file.size == density.grid->size && axes.placement.to_world == density.placement.to_world &&
                        axes.placement.box.lo == density.placement.box.lo &&
                        axes.placement.box.hi == density.placement.box.hi;
  if (!is_alike) fail(*axes.element, "differs from the density in resolution, box or to_world, allowed: the same");
  std::vector<Vec3<float>> result;
  result.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3<double> axis(file.values[3 * i], file.values[3 * i + 1], file.values[3 * i + 2]);
    result.emplace_back(axes.to_grid_frame * axis);
  }
  return result;
}

}  // namespace manylight::scene_file
