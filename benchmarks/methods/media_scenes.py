#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes small scenes of one phenomenon each, for tables of what the methods leave out.

    benchmarks/methods/media_scenes.py FOLDER

smoke_box, cloth_patch, milk_glass, jade_slab_thin and jade_slab_thick, each in a grey box of 1 m, open to the camera,
with a lamp of 0.3 x 0.3 m below its ceiling; +z is up. The slabs are lit from behind as well and fill the image.
"""
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "examples/scenes"))
from generate import JADE, Mesh  # noqa: E402
from kitchen import smoke_density, weave_tile, write_vol  # noqa: E402

HEAD = """<?xml version="1.0" encoding="utf-8"?>
<scene version="3.0.0">
  <default name="width" value="160"/>
  <default name="height" value="160"/>
  <integrator type="volpath"><integer name="max_depth" value="16"/></integrator>
  <sensor type="perspective">
    <float name="fov" value="{fov}"/>
    <transform name="to_world"><lookat origin="{origin}" target="{target}" up="0, 0, 1"/></transform>
    <film type="hdrfilm">
      <integer name="width" value="$width"/><integer name="height" value="$height"/><rfilter type="box"/>
    </film>
  </sensor>
  <bsdf type="diffuse" id="grey"><rgb name="reflectance" value="0.7, 0.7, 0.7"/></bsdf>
  <bsdf type="diffuse" id="red"><rgb name="reflectance" value="0.6, 0.15, 0.1"/></bsdf>
  <bsdf type="diffuse" id="black"><rgb name="reflectance" value="0, 0, 0"/></bsdf>
"""


def rectangle(material, place, radiance=None):
    emitter = "" if radiance is None else '<emitter type="area"><rgb name="radiance" value="%g"/></emitter>' % radiance
    return ('  <shape type="rectangle"><transform name="to_world">%s</transform><ref id="%s"/>%s</shape>'
            % (place, material, emitter))


def box(lamp):
    """Floor, ceiling, three walls and the lamp, which looks down."""
    half, down = '<scale value="0.5"/>', '<rotate x="1" angle="180"/>'
    return [
        rectangle("grey", half + '<translate x="0" y="0" z="0"/>'),
        rectangle("grey", half + down + '<translate x="0" y="0" z="1"/>'),
        rectangle("grey", half + '<rotate x="1" angle="90"/><translate x="0" y="0.5" z="0.5"/>'),
        rectangle("red", half + '<rotate y="1" angle="90"/><translate x="-0.5" y="0" z="0.5"/>'),
        rectangle("grey", half + '<rotate y="1" angle="-90"/><translate x="0.5" y="0" z="0.5"/>'),
        rectangle("black", '<scale value="0.15"/>' + down + '<translate x="0" y="0" z="0.99"/>', lamp)]


def grid_box(low, size):
    return ('<transform name="to_world"><scale x="%g" y="%g" z="%g"/><translate x="%g" y="%g" z="%g"/></transform>'
            % (*size, *low))


def medium_cube(low, size, inside):
    """A box of a medium without a surface of its own."""
    place = tuple(s / 2 for s in size) + tuple(a + s / 2 for a, s in zip(low, size))
    return ['  <shape type="cube"><transform name="to_world"><scale x="%g" y="%g" z="%g"/>'
            '<translate x="%g" y="%g" z="%g"/></transform><bsdf type="null"/>' % place,
            '    <medium type="heterogeneous" name="interior">', *inside, "    </medium>", "  </shape>"]


def volume(name, file, place, copies=""):
    return ('      <volume type="gridvolume" name="%s"><string name="filename" value="%s"/>%s%s</volume>'
            % (name, file, copies, place))


def albedo(value):
    return '      <volume type="constvolume" name="albedo"><rgb name="value" value="%s"/></volume>' % value


def smoke(folder):
    size = (32, 32, 48)
    write_vol(folder / "smoke.vol", size, ((0, 0, 0), (1, 1, 1)), 1, smoke_density(size))
    low, extent = (-0.3, -0.3, 0.05), (0.6, 0.6, 0.85)
    return medium_cube(low, extent, [
        volume("density", "smoke.vol", grid_box(low, extent)),
        albedo("0.9, 0.9, 0.92"),
        '      <float name="scale" value="90"/>', '      <phase type="hg"><float name="g" value="0.5"/></phase>'])


def cloth(folder):
    """A tilted patch would need a rotated grid; it lies on the floor, seen close and low."""
    pitch, thickness, tile = 0.0024, 0.0032, (24, 24, 20)
    densities, axes = weave_tile(tile, pitch, thickness)
    write_vol(folder / "weave_density.vol", tile, ((0, 0, 0), (1, 1, 1)), 1, densities)
    write_vol(folder / "weave_axis.vol", tile, ((0, 0, 0), (1, 1, 1)), 3, axes)
    n = 60
    low, extent = (-pitch * n, -0.3, 0.004), (2 * pitch * n, 2 * pitch * n, thickness)
    copies = '<point name="copies" x="%d" y="%d" z="1"/>' % (n, n)
    return medium_cube(low, extent, [
        volume("density", "weave_density.vol", grid_box(low, extent), copies),
        volume("orientation", "weave_axis.vol", grid_box(low, extent), copies),
        albedo("0.9, 0.5, 0.32"),
        '      <float name="scale" value="7000"/>',
        '      <phase type="microflake"><float name="stddev" value="0.2575"/></phase>'])


def milk(folder):
    """Milk up to the rim of a glass: a smooth boundary, scattering inside."""
    Mesh().revolve([(0, 0), (0.09, 0), (0.1, 0.01), (0.11, 0.2), (0.12, 0.4), (0.118, 0.41), (0.1, 0.412), (0, 0.412)],
                   40, 30).write(folder / "milk.ply")
    return ['  <shape type="ply"><string name="filename" value="milk.ply"/><ref id="black"/>',
            '    <transform name="to_world"><translate x="0" y="-0.1" z="0.001"/></transform>',
            '    <subsurface type="exponential"><rgb name="reflectance" value="0.93, 0.90, 0.82"/>',
            '      <rgb name="length" value="0.03, 0.025, 0.018"/><float name="int_ior" value="1.35"/></subsurface>',
            "  </shape>"]


def slab(thickness):
    """Upright, from wall to wall nearly, a second lamp behind it."""
    jade = ["    " + line for line in JADE]
    behind = '<scale value="0.1"/><rotate x="1" angle="90"/><translate x="0" y="0.45" z="0.45"/>'

    def make(_folder):
        return ['  <shape type="cube"><transform name="to_world"><scale x="0.35" y="%g" z="0.35"/>'
                '<translate x="0" y="0" z="0.45"/></transform><ref id="black"/>' % (thickness / 2), *jade, "  </shape>",
                rectangle("black", behind, 20)]
    return make


# name: what is in the box, radiance of its lamp, where the camera stands, what it looks at, its field of view
SCENES = {
    "smoke_box": (smoke, 10, "0, -1.9, 0.5", "0, 0, 0.5", 40),
    "cloth_patch": (cloth, 10, "0, -0.75, 0.3", "0, -0.17, 0", 22),
    "milk_glass": (milk, 10, "0, -1.0, 0.45", "0, -0.1, 0.22", 32),
    "jade_slab_thin": (slab(0.01), 10, "0, -1.4, 0.5", "0, 0, 0.45", 26),
    "jade_slab_thick": (slab(0.12), 10, "0, -1.4, 0.5", "0, 0, 0.45", 26),
}


def main(arguments):
    if len(arguments) != 1 or arguments[0].startswith("-"):
        print("usage: media_scenes.py FOLDER", file=sys.stderr)
        return 2
    folder = pathlib.Path(arguments[0])
    folder.mkdir(parents=True, exist_ok=True)
    for name, (make, lamp, origin, target, fov) in SCENES.items():
        lines = [HEAD.format(origin=origin, target=target, fov=fov), *box(lamp), *make(folder), "</scene>", ""]
        (folder / (name + ".xml")).write_text("\n".join(lines))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
