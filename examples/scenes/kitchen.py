#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes a kitchen in which everything that scatters light meets: gloss, smoke, cloth, milk and jade.

    examples/scenes/kitchen.py FOLDER   writes FOLDER/kitchen.xml, its meshes and its grids, 5 MB

Lengths are metres, +z is up. Skylight comes through three windows, 25 lamps are on. The same files come out of each
run, byte by byte.
"""
import math
import pathlib
import random
import struct
import sys

from generate import JADE, TAU, Mesh, Xml, add, cross, jade_figure, placed, unit


# ---- grids ----

def write_vol(path, size, box, channels, values):
    """Mitsuba's grid format: 32-bit floats, x fastest; `values` in that order, channels innermost."""
    header = b"VOL" + struct.pack("<B5i6f", 3, 1, *size, channels, *box[0], *box[1])
    path.write_bytes(header + struct.pack("<%df" % len(values), *values))


def lattice_noise(seed):
    """Smooth noise in [0, 1] with one value per unit of length."""
    def corner(x, y, z):
        return random.Random(((seed * 73856093) ^ (x * 19349663) ^ (y * 83492791) ^ (z * 2654435761))).random()
    known = {}

    def at(p):
        i = [math.floor(x) for x in p]
        f = [x - j for x, j in zip(p, i)]
        f = [x * x * (3 - 2 * x) for x in f]
        value = 0.0
        for k in range(8):
            step = (k & 1, k >> 1 & 1, k >> 2)
            key = (i[0] + step[0], i[1] + step[1], i[2] + step[2])
            if key not in known:
                known[key] = corner(*key)
            weight = 1.0
            for axis in range(3):
                weight *= f[axis] if step[axis] else 1 - f[axis]
            value += weight * known[key]
        return value
    return at


def smoke_density(size):
    """A plume that rises, widens and curls: density in [0, 1]."""
    noise = lattice_noise(3)
    values = []
    for k in range(size[2]):
        z = k / (size[2] - 1)
        for j in range(size[1]):
            for i in range(size[0]):
                x, y = 2 * i / (size[0] - 1) - 1, 2 * j / (size[1] - 1) - 1
                bend = 0.35 * z * math.sin(5 * z + 0.6)
                r = math.hypot(x - bend, y - 0.2 * z * math.cos(7 * z)) / (0.18 + 0.5 * z)
                if r > 1.3 or z > 0.98:
                    values.append(0.0)
                    continue
                p = (3 * x, 3 * y, 7 * z)
                curl = noise(p) + 0.5 * noise([2.1 * a for a in p]) + 0.25 * noise([4.3 * a for a in p])
                body = max(0.0, 1 - r * r) * (1 - z) ** 0.5
                values.append(max(0.0, min(1.0, 1.6 * body * (curl - 0.55))))
    return values


def weave_tile(size, pitch, thickness):
    """One period of a plain weave, two threads each way: densities and fiber axes, both in the tile's frame."""
    width = 2 * pitch
    densities, axes = [], []
    for k in range(size[2]):
        z = (k / (size[2] - 1) - 0.5) * thickness
        for j in range(size[1]):
            y = j / size[1] * width
            for i in range(size[0]):
                x = i / size[0] * width
                best, axis = 0.0, (1.0, 0.0, 0.0)
                for along, across, is_warp in ((y, x, True), (x, y, False)):
                    thread = math.floor(across / pitch)
                    sign = (1 if thread % 2 == 0 else -1) * (1 if is_warp else -1)
                    wave = math.pi * along / pitch
                    height = 0.23 * thickness * sign * math.cos(wave)
                    slope = -0.23 * thickness * sign * math.pi / pitch * math.sin(wave)
                    a = (across / pitch - thread - 0.5) / 0.49
                    b = (z - height) / (0.27 * thickness)
                    inside = 1 - a * a - b * b
                    if inside > best:
                        best = inside
                        run = unit((0.0, 1.0, slope) if is_warp else (1.0, 0.0, slope))
                        side = (1.0, 0.0, 0.0) if is_warp else (0.0, 1.0, 0.0)
                        up = cross(run, side)
                        # Fibers are twisted round the thread: across its radius by some 25 degrees at the rim.
                        tangent = add(tuple(-b * s for s in side), up, a)
                        axis = unit(add(run, tangent, 0.45))
                densities.append(min(1.0, 1.5 * best))
                axes.extend(axis)
    return densities, axes


# ---- the room ----

HEAD = """<?xml version="1.0" encoding="utf-8"?>
<!-- Made by kitchen.py. A kitchen of 4.6 x 4 x 2.6 m in the morning, +z is up. -->
<scene version="3.0.0">
  <default name="width" value="480"/>
  <default name="height" value="320"/>

  <integrator type="volpath">
    <integer name="max_depth" value="16"/>
  </integrator>

  <sensor type="perspective">
    <float name="fov" value="58"/>
    <string name="fov_axis" value="x"/>
    <transform name="to_world">
      <lookat origin="0.75, -1.62, 1.42" target="-0.12, 0.35, 0.86" up="0, 0, 1"/>
    </transform>
    <film type="hdrfilm">
      <integer name="width" value="$width"/>
      <integer name="height" value="$height"/>
      <rfilter type="box"/>
    </film>
  </sensor>

  <emitter type="constant">
    <rgb name="radiance" value="7, 9, 12"/>
  </emitter>

  <bsdf type="diffuse" id="plaster">
    <rgb name="reflectance" value="0.72, 0.70, 0.66"/>
  </bsdf>
  <bsdf type="diffuse" id="black">
    <rgb name="reflectance" value="0, 0, 0"/>
  </bsdf>
  <bsdf type="roughplastic" id="floor_tiles">
    <texture type="checkerboard" name="diffuse_reflectance">
      <rgb name="color0" value="0.55, 0.52, 0.47"/>
      <rgb name="color1" value="0.16, 0.17, 0.19"/>
      <transform name="to_uv">
        <scale x="7" y="6"/>
      </transform>
    </texture>
    <float name="alpha" value="0.12"/>
  </bsdf>
  <bsdf type="roughplastic" id="wall_tiles">
    <texture type="checkerboard" name="diffuse_reflectance">
      <rgb name="color0" value="0.70, 0.74, 0.72"/>
      <rgb name="color1" value="0.40, 0.56, 0.55"/>
      <transform name="to_uv">
        <scale x="20" y="3"/>
      </transform>
    </texture>
    <float name="alpha" value="0.06"/>
  </bsdf>
  <bsdf type="roughplastic" id="lacquer">
    <rgb name="diffuse_reflectance" value="0.52, 0.60, 0.50"/>
    <float name="alpha" value="0.1"/>
  </bsdf>
  <bsdf type="roughplastic" id="granite">
    <rgb name="diffuse_reflectance" value="0.06, 0.06, 0.07"/>
    <float name="alpha" value="0.05"/>
  </bsdf>
  <bsdf type="roughplastic" id="oak">
    <rgb name="diffuse_reflectance" value="0.42, 0.25, 0.12"/>
    <float name="alpha" value="0.2"/>
  </bsdf>
  <bsdf type="roughconductor" id="steel">
    <string name="material" value="Cr"/>
    <string name="distribution" value="ggx"/>
    <float name="alpha" value="0.14"/>
  </bsdf>
  <bsdf type="ward" id="brushed">
    <rgb name="diffuse_reflectance" value="0.03, 0.03, 0.03"/>
    <rgb name="specular_reflectance" value="0.6, 0.58, 0.55"/>
    <float name="alpha_u" value="0.2"/>
    <float name="alpha_v" value="0.05"/>
  </bsdf>
  <bsdf type="roughconductor" id="copper">
    <string name="material" value="Cu"/>
    <float name="alpha" value="0.1"/>
  </bsdf>
  <bsdf type="roughplastic" id="porcelain">
    <rgb name="diffuse_reflectance" value="0.76, 0.75, 0.72"/>
    <float name="alpha" value="0.08"/>
  </bsdf>
"""


def rectangle(xml, name, material, center, half_u, half_v, facing, radiance=None):
    """A rectangle whose normal is an axis: facing is one of +x, -x, +y, -y, +z, -z."""
    turn = {"+z": [], "-z": ['<rotate x="1" angle="180"/>'], "-y": ['<rotate x="1" angle="90"/>'],
            "+y": ['<rotate x="1" angle="-90"/>'],
            "+x": ['<rotate x="1" angle="90"/>', '<rotate z="1" angle="90"/>'],
            "-x": ['<rotate x="1" angle="90"/>', '<rotate z="1" angle="-90"/>']}[facing]
    xml.shape("rectangle", name, material, ['<transform name="to_world">', '  <scale x="%g" y="%g"/>' % (half_u, half_v)] +
              ["  " + line for line in turn] + ['  <translate x="%g" y="%g" z="%g"/>' % center, "</transform>"], radiance)


def ply(xml, name, mesh, material, *place, inside=()):
    xml.shape("ply", name, material, ['<string name="filename" value="%s.ply"/>' % mesh] +
              (placed(*place) if place else []) + list(inside))


X, Y, Z = 2.3, 2.0, 2.6  # half width, half depth, height


def room(meshes, xml):
    rectangle(xml, "floor", "floor_tiles", (0, 0, 0), X, Y, "+z")
    rectangle(xml, "ceiling", "plaster", (0, 0, Z), X, Y, "-z")
    rectangle(xml, "wall_right", "plaster", (X, 0, Z / 2), Y, Z / 2, "-x")
    rectangle(xml, "wall_near", "plaster", (0, -Y, Z / 2), X, Z / 2, "+y")
    rectangle(xml, "wall_far", "plaster", (0, Y, Z / 2), X, Z / 2, "-y")
    # Three windows in the left wall, which is 12 cm thick there.
    wall = Mesh()
    edges = [-Y, -1.5, -0.7, -0.4, 0.4, 0.7, 1.5, Y]
    for k in range(0, 8, 2):
        wall.box((-X - 0.12, edges[k], 0), (-X, edges[k + 1], Z))
    for k in range(1, 7, 2):
        wall.box((-X - 0.12, edges[k], 0), (-X, edges[k + 1], 0.95))
        wall.box((-X - 0.12, edges[k], 2.15), (-X, edges[k + 1], Z))
    meshes["wall_left"] = wall
    ply(xml, "wall_left", "wall_left", "plaster")
    frames = Mesh()
    for k in range(1, 7, 2):
        low, high = edges[k], edges[k + 1]
        for y in (low, (low + high) / 2, high):
            frames.box((-X - 0.07, y - 0.02, 0.95), (-X - 0.03, y + 0.02, 2.15))
        for z in (0.95, 1.55, 2.15):
            frames.box((-X - 0.07, low, z - 0.02), (-X - 0.03, high, z + 0.02))
    meshes["frames"] = frames
    ply(xml, "frames", "frames", "porcelain")


def counter(meshes, xml):
    cabinets = Mesh()
    for k in range(6):
        low = -X + 0.05 + k * 0.75
        cabinets.box((low, 1.42, 0.1), (low + 0.73, 1.99, 0.86))
        if k not in (3, 4):
            cabinets.box((low, 1.66, 1.5), (low + 0.73, 1.99, 2.2))
    meshes["cabinets"] = cabinets
    ply(xml, "cabinets", "cabinets", "lacquer")
    knobs = Mesh()
    knob = Mesh().revolve([(0, 0), (0.008, 0), (0.006, 0.012), (0.016, 0.02), (0.012, 0.03), (0, 0.032)], 14, 8)
    for k in range(6):
        x = -X + 0.05 + k * 0.75 + 0.66
        turned = Mesh()
        turned.vertices = [((p[0], -p[2], p[1]), (n[0], -n[2], n[1]), uv) for p, n, uv in knob.vertices]
        turned.quads = list(knob.quads)
        knobs.append(turned, (x, 1.42, 0.76))
        if k not in (3, 4):
            knobs.append(turned, (x, 1.66, 1.58))
    meshes["knobs"] = knobs
    ply(xml, "knobs", "knobs", "copper")
    top = Mesh().box((-X, 1.38, 0.86), (X, 2.0, 0.9))
    meshes["counter"] = top
    ply(xml, "counter", "counter", "granite")
    rectangle(xml, "splash", "wall_tiles", (0, Y - 0.005, 1.2), X, 0.3, "-y")

    def hood(u, v):
        r = 0.38 - 0.24 * math.sin(1.5 * v)
        a = TAU * (u + 0.125)
        s = 1 / max(abs(math.cos(a)), abs(math.sin(a)))
        return (r * s * math.cos(a), 0.75 * r * s * math.sin(a), 0.5 * v)
    meshes["hood"] = Mesh().surface(hood, 48, 12)
    ply(xml, "hood", "hood", "brushed", 0.35, 1.72, 1.62)
    chimney = Mesh().box((0.21, 1.62, 2.1), (0.49, 1.99, 2.6))
    meshes["chimney"] = chimney
    ply(xml, "chimney", "chimney", "brushed")
    meshes["pot"] = Mesh().revolve([(0, 0), (0.12, 0), (0.128, 0.008), (0.13, 0.02), (0.13, 0.15), (0.136, 0.152),
                                    (0.136, 0.158), (0.125, 0.158), (0.124, 0.02), (0.1, 0.01), (0, 0.01)], 48, 30)
    ply(xml, "pot", "pot", "steel", 0.35, 1.66, 0.901)
    xml.shape("disk", "soup", "oak", ['<transform name="to_world">', '  <scale value="0.124"/>',
                                      '  <translate x="0.35" y="1.66" z="1.0"/>', "</transform>"])
    meshes["kettle"] = Mesh().revolve([(0, 0), (0.09, 0), (0.1, 0.01), (0.11, 0.06), (0.09, 0.13), (0.045, 0.17),
                                       (0.04, 0.18), (0.012, 0.185), (0.02, 0.2), (0.014, 0.215), (0, 0.217)], 40, 30)
    ply(xml, "kettle", "kettle", "copper", 0.75, 1.62, 0.901)
    tap = Mesh().tube([(0, 0.25, 0), (0, 0.25, 0.2), (0, 0.22, 0.28), (0, 0.14, 0.31), (0, 0.05, 0.28), (0, 0.03, 0.22)],
                      0.014, 16)
    meshes["tap"] = tap
    ply(xml, "tap", "tap", "steel", -0.9, 1.66, 0.9)
    bowl = Mesh().revolve([(0, 0.006), (0.04, 0), (0.045, 0.008), (0.1, 0.05), (0.12, 0.085), (0.117, 0.087),
                           (0.09, 0.05), (0.04, 0.014), (0, 0.012)], 36, 18)
    meshes["bowl"] = bowl
    for k in range(3):
        ply(xml, "bowl_%d" % k, "bowl", "porcelain", -1.55 - 0.01 * k, 1.7, 0.901 + 0.018 * k)


def lamps(xml):
    """12 in the ceiling, 8 below the cabinets, 5 over the table."""
    for k in range(12):
        x, y = -1.7 + 1.13 * (k % 4), -1.4 + 1.2 * (k // 4)
        xml.shape("disk", "ceiling_lamp_%d" % k, "black",
                  ['<transform name="to_world">', '  <scale value="0.04"/>', '  <rotate x="1" angle="180"/>',
                   '  <translate x="%g" y="%g" z="2.595"/>' % (x, y), "</transform>"], (34, 27, 19))
    for k, x in enumerate((-2.1, -1.85, -1.35, -1.1, -0.6, -0.35, 1.65, 1.95)):
        rectangle(xml, "strip_%d" % k, "black", (x, 1.8, 1.498), 0.1, 0.012, "-z", (42, 35, 26))
    for k in range(5):
        xml.shape("sphere", "pendant_%d" % k, "black",
                  ['<point name="center" x="%g" y="%g" z="%g"/>' % (-0.62 + 0.31 * k, 0.18, 1.78 + 0.05 * (k % 2)),
                   '<float name="radius" value="0.035"/>'], (15, 10, 5.5))


def table(meshes, xml):
    top = Mesh().box((-0.85, -0.4, 0.72), (0.85, 0.6, 0.755))
    for x in (-0.78, 0.78):
        for y in (-0.33, 0.53):
            top.box((x - 0.035, y - 0.035, 0), (x + 0.035, y + 0.035, 0.72))
    meshes["table"] = top
    ply(xml, "table", "table", "oak")
    meshes["plate"] = Mesh().revolve([(0, 0.004), (0.06, 0.003), (0.065, 0), (0.07, 0.004), (0.11, 0.014), (0.125, 0.018),
                                      (0.124, 0.021), (0.1, 0.014), (0.07, 0.009), (0, 0.008)], 48, 22)
    ply(xml, "plate", "plate", "porcelain", 0.42, 0.05, 0.756)
    # Milk fills its glass to the rim: the glass is the smooth boundary of what scatters inside.
    meshes["milk"] = Mesh().revolve([(0, 0), (0.026, 0), (0.029, 0.003), (0.0315, 0.05), (0.034, 0.11), (0.0335, 0.114),
                                     (0.028, 0.115), (0, 0.115)], 48, 36)
    ply(xml, "milk", "milk", "black", 0.16, -0.08, 0.756, inside=[
        '<subsurface type="exponential">', '  <rgb name="reflectance" value="0.93, 0.90, 0.82"/>',
        '  <rgb name="length" value="0.007, 0.006, 0.004"/>', '  <float name="int_ior" value="1.35"/>', "</subsurface>"])

    meshes.update(jade_figure())
    for part in jade_figure():
        ply(xml, part, part, "black", -0.2, 0.12, 0.756, 25, inside=JADE)


CLOTH_SIZE, CLOTH_PITCH, CLOTH_THICKNESS = (0.42, 0.30), 0.0012, 0.0016
CLOTH_COPIES = [round(side / (2 * CLOTH_PITCH)) for side in CLOTH_SIZE]


def media(folder, xml):
    size = (48, 48, 72)
    write_vol(folder / "smoke.vol", size, ((0, 0, 0), (1, 1, 1)), 1, smoke_density(size))
    box = '<transform name="to_world"><scale x="0.34" y="0.34" z="0.62"/><translate x="0.18" y="1.49" z="1.0"/></transform>'
    xml.put('  <shape type="cube" id="smoke">')
    xml.put('    <transform name="to_world"><scale x="0.17" y="0.17" z="0.31"/><translate x="0.35" y="1.66" z="1.31"/></transform>')
    xml.put('    <bsdf type="null"/>')
    xml.put('    <medium type="heterogeneous" name="interior">')
    xml.put('      <volume type="gridvolume" name="density"><string name="filename" value="smoke.vol"/>%s</volume>', box)
    xml.put('      <volume type="constvolume" name="albedo"><rgb name="value" value="0.93, 0.93, 0.95"/></volume>')
    xml.put('      <float name="scale" value="28"/>')
    xml.put('      <phase type="hg"><float name="g" value="0.5"/></phase>')
    xml.put("    </medium>")
    xml.put("  </shape>")

    tile = (40, 40, 28)
    densities, axes = weave_tile(tile, CLOTH_PITCH, CLOTH_THICKNESS)
    write_vol(folder / "weave_density.vol", tile, ((0, 0, 0), (1, 1, 1)), 1, densities)
    write_vol(folder / "weave_axis.vol", tile, ((0, 0, 0), (1, 1, 1)), 3, axes)
    width, depth = (2 * CLOTH_PITCH * copies for copies in CLOTH_COPIES)
    low = (-0.36, -0.31, 0.7556)
    box = ('<transform name="to_world"><scale x="%.6g" y="%.6g" z="%.6g"/><translate x="%g" y="%g" z="%g"/></transform>'
           % (width, depth, CLOTH_THICKNESS, *low))
    copies = '<point name="copies" x="%d" y="%d" z="1"/>' % tuple(CLOTH_COPIES)
    xml.put('  <shape type="cube" id="cloth">')
    xml.put('    <transform name="to_world"><scale x="%.6g" y="%.6g" z="%.6g"/><translate x="%.6g" y="%.6g" z="%.6g"/></transform>',
            width / 2, depth / 2, CLOTH_THICKNESS / 2, low[0] + width / 2, low[1] + depth / 2, low[2] + CLOTH_THICKNESS / 2)
    xml.put('    <bsdf type="null"/>')
    xml.put('    <medium type="heterogeneous" name="interior">')
    for name, file in (("density", "weave_density"), ("orientation", "weave_axis")):
        xml.put('      <volume type="gridvolume" name="%s"><string name="filename" value="%s.vol"/>%s%s</volume>', name, file,
                copies, box)
    xml.put('      <volume type="constvolume" name="albedo"><rgb name="value" value="0.90, 0.50, 0.32"/></volume>')
    xml.put('      <float name="scale" value="14000"/>')
    xml.put('      <phase type="microflake"><float name="stddev" value="0.2575"/></phase>')
    xml.put("    </medium>")
    xml.put("  </shape>")
    return tile


def kitchen(folder):
    meshes, xml = {}, Xml()
    room(meshes, xml)
    counter(meshes, xml)
    lamps(xml)
    table(meshes, xml)
    tile = media(folder, xml)
    for name, mesh in meshes.items():
        mesh.write(folder / (name + ".ply"))
    (folder / "kitchen.xml").write_text(HEAD + "\n".join(xml.lines) + "\n</scene>\n")
    voxels = tile[0] * CLOTH_COPIES[0] * tile[1] * CLOTH_COPIES[1] * tile[2]
    return "kitchen.xml with %d lamps, %d triangles and a cloth of %.1e voxels" % (
        sum("<emitter" in line for line in xml.lines), sum(mesh.triangle_count() for mesh in meshes.values()), voxels)


def main(arguments):
    if len(arguments) != 1:
        print("usage: kitchen.py FOLDER", file=sys.stderr)
        return 2
    folder = pathlib.Path(arguments[0])
    try:
        folder.mkdir(parents=True, exist_ok=True)
        print("%s: %s" % (folder, kitchen(folder)))
    except OSError as error:
        print("kitchen.py: %s: %s" % (folder, error.strerror), file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
