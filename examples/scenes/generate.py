#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes the scenes of examples/scenes that are too large, or too round, to be written by hand.

    examples/scenes/generate.py lantern_hall FOLDER   writes FOLDER/lantern_hall.xml, its meshes and textures
    examples/scenes/generate.py cafe_table FOLDER     writes the meshes of cafe_table.xml into FOLDER
    examples/scenes/generate.py cafe_figure FOLDER    writes FOLDER/cafe_figure.xml, the café with a jade figure in place
                                                      of the metal balls, and its meshes

The meshes in examples/scenes/cafe_table are what the second command makes. Lengths are metres, +z is up. The same
files come out of each run, byte by byte.
"""
import functools
import math
import pathlib
import random
import struct
import sys
import zlib

TAU = 2 * math.pi


# ---- vectors ----

def add(a, b, s=1.0):
    return (a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2])


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def unit(a):
    length = math.sqrt(dot(a, a))
    return (a[0] / length, a[1] / length, a[2] / length)


def spline(points, t):
    """A smooth curve through `points`, t in [0, 1], the same share of t for each stretch. Knots are spaced by the roots
    of the distances (centripetal Catmull-Rom): short stretches between long ones, as at lips, make no loops."""
    at = min(max(t, 0.0), 1.0) * (len(points) - 1)
    i = min(int(at), len(points) - 2)
    x = at - i

    def step(k):  # from point k to the next one
        return math.sqrt(math.dist(points[k], points[k + 1]))

    def slope(k):
        if k == 0 or k == len(points) - 1:
            j = min(k, len(points) - 2)
            return tuple((q - p) / step(j) for p, q in zip(points[j], points[j + 1]))
        h, g = step(k - 1), step(k)
        return tuple((q - p) / h - (r - p) / (h + g) + (r - q) / g
                     for p, q, r in zip(points[k - 1], points[k], points[k + 1]))
    h = step(i)
    y = 1 - x
    return tuple((1 + 2 * x) * y * y * p + x * y * y * h * m + (1 + 2 * y) * x * x * q - x * x * y * h * n
                 for p, q, m, n in zip(points[i], points[i + 1], slope(i), slope(i + 1)))


# ---- meshes ----

class Mesh:
    """Vertices (position, normal, uv) and quadrilaterals, counterclockwise seen from where the normals point."""

    def __init__(self):
        self.vertices = []
        self.quads = []

    def grid(self, rows):
        """Rows of equal length; along a row runs u, from row to row v."""
        first, width = len(self.vertices), len(rows[0])
        self.vertices += [vertex for row in rows for vertex in row]
        for j in range(len(rows) - 1):
            for i in range(width - 1):
                a = first + j * width + i
                self.quads.append((a, a + 1, a + 1 + width, a + width))
        return self

    def surface(self, f, nu, nv):
        """f(u, v) over [0, 1]^2; normals along df/du x df/dv."""
        def normal(u, v):
            for inside in (0.0, 1e-2):  # a pole has no derivative by u
                at = v + inside * (1 if v < 0.5 else -1)
                n = cross(add(f(u + 1e-4, at), f(u - 1e-4, at), -1.0), add(f(u, at + 1e-4), f(u, at - 1e-4), -1.0))
                if dot(n, n) > 1e-26:
                    return unit(n)
            raise ValueError("a surface without a normal")
        at = [[(i / nu, j / nv) for i in range(nu + 1)] for j in range(nv + 1)]
        return self.grid([[(f(u, v), normal(u, v), (u, v)) for u, v in row] for row in at])

    def revolve(self, profile, nu, nv, flutes=0, depth=0.0):
        """Points (radius, height) turned round the z axis, from the bottom outside to the top, inside after that."""
        @functools.lru_cache(maxsize=None)
        def outline(v):
            return spline(profile, v)

        def f(u, v):
            r, z = outline(v)
            r = max(r, 0.0) * (1 - depth * (0.5 - 0.5 * math.cos(TAU * flutes * u)))
            return (r * math.cos(TAU * u), r * math.sin(TAU * u), z)
        return self.surface(f, nu, nv)

    def tube(self, path, radius, nu, is_closed=False):
        """A tube round the points of `path`; open ends are capped."""
        count = len(path)
        ends = [(path[(i - 1) % count], path[(i + 1) % count]) if is_closed else
                (path[max(i - 1, 0)], path[min(i + 1, count - 1)]) for i in range(count)]
        tangents = [unit(add(b, a, -1.0)) for a, b in ends]
        helper = min(((1, 0, 0), (0, 1, 0), (0, 0, 1)), key=lambda e: abs(dot(e, tangents[0])))
        side = unit(cross(tangents[0], helper))
        sides = []
        for t in tangents:  # carried along with as little turning as possible
            side = unit(add(side, t, -dot(side, t)))
            sides.append(side)
        twist = 0.0
        if is_closed:
            last = unit(add(side, tangents[0], -dot(side, tangents[0])))
            twist = math.atan2(dot(cross(last, sides[0]), tangents[0]), dot(last, sides[0]))
        rows = []
        for k in range(count + 1 if is_closed else count):
            c, t, n = path[k % count], tangents[k % count], sides[k % count]
            b = cross(t, n)
            turn = twist * k / count if k < count else 0.0  # the last ring is the first
            row = []
            for i in range(nu + 1):
                angle = TAU * i / nu + turn
                d = add(tuple(math.cos(angle) * x for x in n), b, math.sin(angle))
                row.append((add(c, d, radius), d, (i / nu, k / count)))
            rows.append(row)
        if not is_closed:
            for row, t, s in ((rows[0], tangents[0], -1.0), (rows[-1], tangents[-1], 1.0)):
                cap = [(p, add((0, 0, 0), t, s), uv) for p, _, uv in row]
                tip = [(path[0] if s < 0 else path[-1], n, uv) for _, n, uv in cap]
                self.grid([tip, cap] if s < 0 else [cap, tip])
        return self.grid(rows)

    def box(self, low, high):
        for axis in range(3):
            for end in (low, high):
                u, v = (axis + 1) % 3, (axis + 2) % 3
                if end is low:
                    u, v = v, u
                n = tuple((1.0 if end is high else -1.0) if k == axis else 0.0 for k in range(3))
                rows = []
                for y in (low[v], high[v]):
                    row = []
                    for x in (low[u], high[u]):
                        p = [0.0] * 3
                        p[axis], p[u], p[v] = end[axis], x, y
                        row.append((tuple(p), n, (x, y)))
                    rows.append(row)
                self.grid(rows)
        return self

    def append(self, other, move=(0.0, 0.0, 0.0)):
        first = len(self.vertices)
        self.vertices += [(add(p, move), n, uv) for p, n, uv in other.vertices]
        self.quads += [tuple(first + i for i in quad) for quad in other.quads]
        return self

    def faces(self, at=None):
        """The quadrilaterals, those with two neighbouring corners `at` the same place as triangles."""
        at = at or [p for p, _, _ in self.vertices]
        for quad in self.quads:
            face = [a for k, a in enumerate(quad) if at[a] != at[quad[k - 1]]]
            if len(face) > 2:
                yield face

    def triangle_count(self):
        return sum(len(face) - 2 for face in self.faces())

    def write(self, path):
        """Binary PLY with normals and uv."""
        faces = [struct.pack("<B%dI" % len(face), len(face), *face) for face in self.faces()]
        data = [struct.pack("<8f", *p, *n, *uv) for p, n, uv in self.vertices]
        write_ply(path, ("x", "y", "z", "nx", "ny", "nz", "u", "v"), data, "uint", faces)

    def write_small(self, path):
        """Binary PLY of welded positions only; the reader makes the normals."""
        places, index, data = {}, [], []
        for p, _, _ in self.vertices:
            key = tuple(round(x, 5) + 0.0 for x in p)
            if key not in places:
                places[key] = len(places)
                data.append(struct.pack("<3f", *key))
            index.append(places[key])
        faces = [struct.pack("<B%dH" % len(face), len(face), *(index[a] for a in face)) for face in self.faces(index)]
        write_ply(path, ("x", "y", "z"), data, "ushort", faces)


def write_ply(path, names, vertices, index_type, faces):
    lines = ["ply", "format binary_little_endian 1.0", "element vertex %d" % len(vertices)]
    lines += ["property float " + name for name in names]
    lines += ["element face %d" % len(faces), "property list uchar %s vertex_indices" % index_type, "end_header", ""]
    path.write_bytes("\n".join(lines).encode() + b"".join(vertices) + b"".join(faces))


def write_png(path, width, height, color):
    """color(x, y) is three numbers in [0, 255], sRGB-encoded."""
    rows = []
    for y in range(height):
        rows.append(b"\0" + bytes(min(max(int(c), 0), 255) for x in range(width) for c in color(x, y)))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(b"".join(rows), 9)) +
                     chunk(b"IEND", b""))


# ---- the café ----

def arc(count, f):
    return [f(i / (count - 1)) for i in range(count)]


def bent_chair(steps, nu):
    """A café chair of bent wood, its seat at 0.46 m round the z axis, its back at +y."""
    mesh = Mesh()
    mesh.revolve([(0, 0.445), (0.19, 0.445), (0.2, 0.452), (0.2, 0.462), (0.19, 0.47), (0.1, 0.466), (0, 0.462)],
                 4 * nu, 6)
    legs = 0.022
    for x in (-1, 1):
        mesh.tube(arc(steps // 2, lambda t: spline(
            [(x * 0.17, -0.2, 0.0), (x * 0.15, -0.17, 0.22), (x * 0.14, -0.13, 0.44)], t)), legs * 0.8, nu)
    # Back legs and back are one piece of wood, a second hoop stands inside.
    outer = [(-0.19, 0.24, 0.0), (-0.17, 0.18, 0.3), (-0.17, 0.17, 0.5), (-0.19, 0.22, 0.78), (-0.12, 0.25, 0.92),
             (0, 0.26, 0.95), (0.12, 0.25, 0.92), (0.19, 0.22, 0.78), (0.17, 0.17, 0.5), (0.17, 0.18, 0.3),
             (0.19, 0.24, 0.0)]
    mesh.tube(arc(2 * steps, lambda t: spline(outer, t)), legs * 0.75, nu)
    inner = [(-0.1, 0.155, 0.46), (-0.115, 0.185, 0.66), (-0.07, 0.222, 0.81), (0, 0.232, 0.845), (0.07, 0.222, 0.81),
             (0.115, 0.185, 0.66), (0.1, 0.155, 0.46)]
    mesh.tube(arc(steps, lambda t: spline(inner, t)), legs * 0.5, nu)
    mesh.tube([(0.165 * math.cos(TAU * k / steps), 0.165 * math.sin(TAU * k / steps), 0.24) for k in range(steps)],
              legs * 0.4, nu, True)
    return mesh


def cafe_table(folder):
    """Meshes of cafe_table.xml; each stands on z = 0 round the z axis."""
    cup = Mesh().revolve([(0, 0.004), (0.02, 0.004), (0.024, 0), (0.026, 0.004), (0.034, 0.02), (0.041, 0.045),
                          (0.044, 0.068), (0.0425, 0.069), (0.039, 0.045), (0.031, 0.02), (0.018, 0.009), (0, 0.008)],
                         32, 22)
    handle = [(0.041, 0, 0.058), (0.058, 0, 0.06), (0.068, 0, 0.046), (0.058, 0, 0.027), (0.037, 0, 0.025)]
    cup.tube(arc(12, lambda t: spline(handle, t)), 0.004, 6)
    saucer = Mesh().revolve([(0, 0.003), (0.035, 0.002), (0.04, 0), (0.044, 0.003), (0.062, 0.008), (0.076, 0.015),
                             (0.0765, 0.0165), (0.06, 0.011), (0.04, 0.0065), (0.028, 0.006), (0, 0.006)], 32, 20)
    stand = Mesh().revolve([(0, 0), (0.24, 0), (0.245, 0.012), (0.2, 0.03), (0.08, 0.055), (0.035, 0.11), (0.03, 0.3),
                            (0.032, 0.34), (0.045, 0.36), (0.032, 0.38), (0.028, 0.5), (0.035, 0.64), (0.12, 0.68),
                            (0.12, 0.69), (0.395, 0.69), (0.405, 0.7), (0.408, 0.712), (0.402, 0.722), (0.39, 0.723),
                            (0.386, 0.72), (0.386, 0.718)], 40, 20)
    vase = Mesh().revolve([(0, 0.003), (0.04, 0), (0.05, 0.01), (0.075, 0.06), (0.085, 0.11), (0.065, 0.17),
                           (0.032, 0.22), (0.03, 0.26), (0.045, 0.29), (0.043, 0.291), (0.026, 0.26), (0.025, 0.2)],
                          28, 22)
    shade = Mesh().revolve([(0.16, 0), (0.155, 0.03), (0.11, 0.09), (0.04, 0.13), (0.02, 0.15), (0, 0.15)], 28, 10)
    parts = {"cup": cup, "saucer": saucer, "stand": stand, "vase": vase, "shade": shade, "chair": bent_chair(16, 6)}
    for name, mesh in parts.items():
        mesh.write_small(folder / (name + ".ply"))
    return "%d meshes" % len(parts)


def jade_figure():
    """A knot on a foot, 0.2 m high: two meshes."""
    def knot(k, count=300):
        a = TAU * k / count
        r = 0.062 + 0.024 * math.cos(3 * a)
        return (r * math.cos(2 * a), 0.026 * math.sin(3 * a), 0.105 + r * math.sin(2 * a))
    foot = [(0, 0), (0.045, 0), (0.047, 0.003), (0.036, 0.008), (0.03, 0.012), (0.03, 0.016), (0, 0.017)]
    return {"jade_knot": Mesh().tube([knot(k) for k in range(300)], 0.0145, 18, True),
            "jade_foot": Mesh().revolve(foot, 40, 20)}


JADE = ['<subsurface type="exponential">', '  <rgb name="reflectance" value="0.30, 0.72, 0.38"/>',
        '  <rgb name="length" value="0.003, 0.006, 0.0035"/>', '  <float name="int_ior" value="1.6"/>', "</subsurface>"]


def cafe_figure(folder):
    cafe_table(folder)
    for name, mesh in jade_figure().items():
        mesh.write(folder / (name + ".ply"))
    text = (pathlib.Path(__file__).parent / "cafe_table.xml").read_text().replace("cafe_table/", "")
    start = text.index('  <shape type="sphere" id="metal_ball">')
    end = text.index("  <shape", text.index('id="copper_ball"'))
    figure = Xml()
    for name in jade_figure():
        figure.shape("ply", name, "black", ['<string name="filename" value="%s.ply"/>' % name] +
                     placed(-0.04, 0.08, 0.721, 20, 1.5) + JADE)
    (folder / "cafe_figure.xml").write_text(text[:start] + "\n".join(figure.lines) + "\n" + text[end:])
    return "cafe_figure.xml"


# ---- the hall ----

LANTERN_COLORS = ((1.0, 0.38, 0.07), (1.0, 0.3, 0.04), (1.0, 0.52, 0.16), (1.0, 0.6, 0.25), (1.0, 0.07, 0.03),
                  (0.05, 0.26, 1.0), (0.04, 0.8, 0.42), (0.85, 0.06, 0.42))


def vault(springing, rise, half_width, bay, bays, steps):
    """Crossing barrels over each bay, which share no vertices where they meet."""
    mesh = Mesh()
    angles = [math.pi * k / steps for k in range(steps + 1)]
    for b in range(bays):
        y0 = bay * (b + 0.5)
        for along in (True, False):  # the barrel along the hall, then the one across it
            index = {}

            def vertex(i, j):
                if (i, j) not in index:
                    a = angles[i] if along else angles[j]
                    x, y = -half_width * math.cos(angles[i]), y0 - bay / 2 * math.cos(angles[j])
                    reach = half_width if along else bay / 2
                    inward = (math.cos(a) / reach, -math.sin(a) / rise)
                    n = unit((inward[0], 0.0, inward[1]) if along else (0.0, inward[0], inward[1]))
                    index[(i, j)] = len(mesh.vertices)
                    mesh.vertices.append(((x, y, springing + rise * math.sin(a)), n, (x, y)))
                return index[(i, j)]
            for i in range(steps):
                for j in range(steps):
                    # The height is the larger of the two; the barrels meet where i = j and where i + j = steps.
                    a, c, d, e = (i, j), (i, j + 1), (i + 1, j + 1), (i + 1, j)
                    halves = ((a, c, d), (a, d, e)) if (i < steps / 2) == (j < steps / 2) else ((a, c, e), (c, d, e))
                    for half in halves:
                        p = sum(k[0] for k in half) / 3
                        q = sum(k[1] for k in half) / 3
                        is_along = math.sin(math.pi * p / steps) >= math.sin(math.pi * q / steps)
                        if is_along == along:
                            mesh.quads.append(tuple(vertex(*k) for k in half))
    return mesh


def stone_color():
    """Slabs of 1/8 of the picture, each of its own shade, with dark joints."""
    shades = random.Random(11)
    slabs = [[(0.8 + 0.4 * shades.random(), shades.random()) for _ in range(8)] for _ in range(8)]
    grain = random.Random(12)

    def color(x, y):
        row = y // 32
        at = (x + 16 * (row % 2)) % 256
        if y % 32 < 2 or at % 32 < 2:
            return (62, 52, 46)
        light, hue = slabs[row][at // 32]
        light *= 0.94 + 0.06 * math.sin(0.21 * x + 9 * hue) * math.sin(0.13 * y + 5 * hue) + 0.05 * grain.random()
        return (light * (150 + 26 * hue), light * 138, light * (128 - 26 * hue))
    return color


def weave_color(x, y):
    """Lozenges in a border of stripes."""
    edge = min(x, 127 - x)
    if edge < 6 or 10 <= edge < 13:
        return (212, 172, 84)
    lozenge = (abs(x % 32 - 16) + abs(y % 32 - 16))
    if lozenge < 5:
        return (224, 196, 128)
    if lozenge < 10:
        return (36, 62, 104)
    return (150, 34, 36) if lozenge < 17 else (112, 22, 32)


class Xml:
    """Elements, one a line."""

    def __init__(self):
        self.lines = []

    def put(self, text, *values):
        self.lines.append(text % values if values else text)

    def shape(self, kind, name, material, inside, radiance=None):
        self.put('  <shape type="%s" id="%s">', kind, name)
        for line in inside:
            self.put("    " + line)
        self.put('    <ref id="%s"/>', material)
        if radiance:
            self.put('    <emitter type="area">')
            self.put('      <rgb name="radiance" value="%s"/>', ", ".join("%.4g" % x for x in radiance))
            self.put("    </emitter>")
        self.put("  </shape>")


def placed(x, y, z, turn=0.0, scale=1.0):
    """The lines of a transform."""
    lines = ['<transform name="to_world">']
    if scale != 1.0:
        lines.append('  <scale value="%.4g"/>' % scale)
    if turn != 0.0:
        lines.append('  <rotate z="1" angle="%.5g"/>' % turn)
    return lines + ['  <translate x="%.5g" y="%.5g" z="%.5g"/>' % (x, y, z), "</transform>"]


HALL_HEAD = """<?xml version="1.0" encoding="utf-8"?>
<!-- Made by generate.py. A vaulted hall of 8 x 16 x 6 m at night, +z is up, lit by strings of coloured lanterns. -->
<scene version="3.0.0">
  <default name="width" value="480"/>
  <default name="height" value="300"/>

  <integrator type="path">
    <integer name="max_depth" value="10"/>
  </integrator>

  <sensor type="perspective">
    <float name="fov" value="68"/>
    <string name="fov_axis" value="x"/>
    <transform name="to_world">
      <lookat origin="1.15, 0.6, 1.7" target="-0.2, 8, 2.3" up="0, 0, 1"/>
    </transform>
    <film type="hdrfilm">
      <integer name="width" value="$width"/>
      <integer name="height" value="$height"/>
      <rfilter type="box"/>
    </film>
  </sensor>

  <bsdf type="roughdiffuse" id="plaster">
    <rgb name="reflectance" value="0.72, 0.66, 0.57"/>
    <float name="alpha" value="0.3"/>
  </bsdf>
  <bsdf type="diffuse" id="sandstone">
    <rgb name="reflectance" value="0.58, 0.46, 0.34"/>
  </bsdf>
  <bsdf type="diffuse" id="wire">
    <rgb name="reflectance" value="0.05, 0.05, 0.05"/>
  </bsdf>
  <bsdf type="diffuse" id="paper">
    <rgb name="reflectance" value="0.3, 0.3, 0.3"/>
  </bsdf>
  <bsdf type="roughplastic" id="slabs">
    <texture type="bitmap" name="diffuse_reflectance">
      <string name="filename" value="stone.png"/>
      <transform name="to_uv">
        <scale x="2" y="4"/>
      </transform>
    </texture>
    <float name="alpha" value="0.15"/>
  </bsdf>
  <bsdf type="twosided" id="banner_cloth">
    <bsdf type="diffuse">
      <texture type="bitmap" name="reflectance">
        <string name="filename" value="weave.png"/>
        <transform name="to_uv">
          <scale x="1" y="2"/>
        </transform>
      </texture>
    </bsdf>
  </bsdf>
  <bsdf type="twosided" id="table_cloth">
    <bsdf type="diffuse">
      <texture type="checkerboard" name="reflectance">
        <rgb name="color0" value="0.74, 0.70, 0.62"/>
        <rgb name="color1" value="0.22, 0.34, 0.50"/>
        <transform name="to_uv">
          <scale x="5" y="14"/>
        </transform>
      </texture>
    </bsdf>
  </bsdf>
  <bsdf type="roughplastic" id="oak">
    <rgb name="diffuse_reflectance" value="0.32, 0.17, 0.08"/>
    <float name="alpha" value="0.25"/>
  </bsdf>
  <bsdf type="roughconductor" id="brass">
    <rgb name="eta" value="0.44, 0.53, 1.09"/>
    <rgb name="k" value="3.7, 2.77, 1.83"/>
    <string name="distribution" value="ggx"/>
    <float name="alpha" value="0.15"/>
  </bsdf>
  <bsdf type="ward" id="brushed_steel">
    <rgb name="diffuse_reflectance" value="0.05, 0.05, 0.05"/>
    <rgb name="specular_reflectance" value="0.65, 0.65, 0.68"/>
    <float name="alpha_u" value="0.22"/>
    <float name="alpha_v" value="0.06"/>
  </bsdf>
  <bsdf type="phong" id="red_lacquer">
    <rgb name="diffuse_reflectance" value="0.48, 0.05, 0.04"/>
    <rgb name="specular_reflectance" value="0.15, 0.15, 0.15"/>
    <float name="exponent" value="120"/>
  </bsdf>
  <bsdf type="plastic" id="blue_glaze">
    <rgb name="diffuse_reflectance" value="0.04, 0.16, 0.40"/>
  </bsdf>
  <bsdf type="dielectric" id="glass"/>
"""

LENGTH, HALF_WIDTH, BAY, BAYS = 16.0, 4.0, 4.0, 4
SPRINGING, RISE = 3.2, 2.6


def hall_architecture(meshes, xml):
    meshes["vault"] = vault(SPRINGING, RISE, HALF_WIDTH, BAY, BAYS, 40)
    ribs = Mesh()
    for k in range(BAYS + 1):
        ribs.tube(arc(49, lambda t: (-HALF_WIDTH * math.cos(math.pi * t), BAY * k,
                                     SPRINGING + RISE * math.sin(math.pi * t))), 0.13, 12)
    for k in range(BAYS):
        for s in (-1, 1):
            ribs.tube(arc(49, lambda t: (-HALF_WIDTH * math.cos(math.pi * t),
                                         BAY * (k + 0.5) - s * BAY / 2 * math.cos(math.pi * t),
                                         SPRINGING + RISE * math.sin(math.pi * t))), 0.07, 10)
    meshes["ribs"] = ribs
    meshes["column"] = Mesh().revolve(
        [(0.44, 0), (0.44, 0.2), (0.42, 0.24), (0.36, 0.28), (0.36, 0.34), (0.29, 0.4), (0.28, 0.9), (0.272, 1.6),
         (0.262, 2.2), (0.255, 2.7), (0.27, 2.76), (0.27, 2.8), (0.3, 2.9), (0.4, 3.04), (0.42, 3.1), (0.42, 3.22)],
        64, 30, 16, 0.06)
    xml.shape("rectangle", "floor", "slabs", ['<transform name="to_world">', '  <scale x="4" y="8"/>',
                                              '  <translate y="8"/>', "</transform>"])
    for name, angle, x, y, half in (("left", 90, -4, 8, 8), ("right", -90, 4, 8, 8), ("near", 180, 0, 0, 4),
                                    ("far", 0, 0, 16, 4)):
        xml.shape("rectangle", "wall_" + name, "plaster", [
            '<transform name="to_world">', '  <scale x="%g" y="3"/>' % half, '  <rotate x="1" angle="90"/>',
            '  <rotate z="1" angle="%g"/>' % angle, '  <translate x="%g" y="%g" z="3"/>' % (x, y), "</transform>"])
    xml.shape("ply", "vault", "plaster", ['<string name="filename" value="vault.ply"/>'])
    xml.shape("ply", "ribs", "sandstone", ['<string name="filename" value="ribs.ply"/>'])
    for k in range(BAYS + 1):
        for side, x in (("left", -3.8), ("right", 3.8)):
            xml.shape("ply", "column_%s_%d" % (side, k), "sandstone",
                      ['<string name="filename" value="column.ply"/>'] + placed(x, BAY * k, 0))


def hall_lanterns(meshes, xml):
    """22 strings of 10 globes from wall to wall, and 8 folded paper lanterns above the table."""
    pick = random.Random(5)
    wires, caps = Mesh(), Mesh()
    cap = Mesh().revolve([(0.05, 0), (0.045, 0.012), (0.02, 0.03), (0, 0.035)], 10, 3)
    for k in range(22):
        y0 = 2.3 + 0.6 * k
        y1 = y0 + (0.5 if k % 2 else -0.3)
        sag = 0.35 + 0.4 * pick.random()

        def hang(t):
            return (-3.75 + 7.5 * t, y0 + (y1 - y0) * t, 3.7 - sag * 4 * t * (1 - t))
        wires.tube(arc(31, hang), 0.008, 5)
        for j in range(10):
            radius = 0.075 + 0.04 * pick.random()
            x, y, z = hang((j + 0.5 + 0.3 * (pick.random() - 0.5)) / 10)
            z -= radius + 0.04
            caps.append(cap, (x, y, z + radius - 0.008))
            power = (0.7 + 0.6 * pick.random()) * 8
            color = LANTERN_COLORS[pick.randrange(len(LANTERN_COLORS))]
            xml.shape("sphere", "lantern_%d_%d" % (k, j), "paper",
                      ['<point name="center" x="%.4f" y="%.4f" z="%.4f"/>' % (x, y, z),
                       '<float name="radius" value="%.4f"/>' % radius], [power * c for c in color])
    meshes["wires"], meshes["caps"] = wires, caps
    xml.shape("ply", "wires", "wire", ['<string name="filename" value="wires.ply"/>'])
    xml.shape("ply", "caps", "brass", ['<string name="filename" value="caps.ply"/>'])

    def folded(u, v):
        a = math.pi * (0.06 + 0.88 * v)
        r = 0.2 * math.sin(a) * (1 + 0.05 * math.cos(TAU * 12 * v))
        return (r * math.cos(TAU * u), r * math.sin(TAU * u), -0.17 * math.cos(a))
    meshes["paper_lantern"] = Mesh().surface(folded, 20, 36)
    for k in range(8):
        x, y = (-0.55, 0.55)[k % 2] - 0.3, 4.0 + 1.15 * k
        xml.shape("ply", "paper_lantern_%d" % k, "paper",
                  ['<string name="filename" value="paper_lantern.ply"/>'] + placed(x, y, 2.25 + 0.25 * (k % 3)),
                  (2.4, 1.25, 0.45))


def hall_furniture(meshes, xml):
    def ply(name, mesh, material, *place):
        lines = ['<string name="filename" value="%s.ply"/>' % mesh]
        xml.shape("ply", name, material, lines + (placed(*place) if place else []))

    def cloth(u, v):  # flat on the table, in folds where it hangs
        across, y = (u - 0.5) * 2.3, 3.6 + 6.4 * v
        hang = max(abs(across) - 0.6, 0.0)
        fold = min(hang / 0.3, 1.0)
        x = math.copysign(min(abs(across), 0.6) + 0.12 * hang + 0.035 * fold * math.sin(26 * v * math.pi), across)
        return (x - 0.3, y, 0.76 - hang + 0.004 * math.sin(40 * v) * math.cos(9 * u))
    meshes["cloth"] = Mesh().surface(cloth, 40, 180)
    ply("cloth", "cloth", "table_cloth")
    top = Mesh().box((-0.88, 3.62, 0.7), (0.28, 9.98, 0.752))
    for y in (3.9, 6.8, 9.7):
        leg = [(0.1, 0), (0.1, 0.04), (0.05, 0.1), (0.075, 0.35), (0.05, 0.6), (0.09, 0.7)]
        top.append(Mesh().revolve(leg, 20, 20), (-0.3, y, 0))
    meshes["table"] = top
    ply("table", "table", "oak")
    meshes["stool"] = Mesh().revolve(
        [(0, 0), (0.2, 0), (0.21, 0.02), (0.13, 0.06), (0.05, 0.12), (0.06, 0.22), (0.04, 0.34), (0.1, 0.4),
         (0.19, 0.42), (0.205, 0.45), (0.19, 0.475), (0.08, 0.48), (0, 0.48)], 32, 26)
    meshes["chair"] = bent_chair(20, 8)
    for k in range(5):
        ply("stool_%d" % k, "stool", "red_lacquer", -1.45 - 0.08 * (k % 2), 4.3 + 1.25 * k, 0)
        ply("chair_%d" % k, "chair", "oak", 0.98 + 0.1 * (k % 2), 4.1 + 1.2 * k, 0, -90 + 24 * (k % 3 - 1))

    bowl = [(0, 0), (0.1, 0), (0.11, 0.01), (0.06, 0.03), (0.13, 0.08), (0.19, 0.15), (0.2, 0.19), (0.19, 0.19),
            (0.12, 0.1), (0, 0.06)]
    meshes["bowl"] = Mesh().revolve(bowl, 40, 30)
    amphora = [(0, 0), (0.09, 0), (0.1, 0.02), (0.17, 0.16), (0.2, 0.32), (0.15, 0.48), (0.07, 0.58), (0.06, 0.66),
               (0.1, 0.72), (0.095, 0.725), (0.05, 0.66), (0, 0.6)]
    meshes["amphora"] = Mesh().revolve(amphora, 40, 44)
    flask = [(0, 0), (0.07, 0), (0.085, 0.015), (0.1, 0.08), (0.07, 0.15), (0.025, 0.2), (0.02, 0.28), (0.03, 0.31),
             (0.02, 0.32), (0, 0.318)]
    meshes["flask"] = Mesh().revolve(flask, 32, 36)
    for k, y in enumerate((4.4, 6.2, 8.3)):
        ply("bowl_%d" % k, "bowl", ("brass", "blue_glaze", "brass")[k], -0.5, y, 0.762)
        ply("flask_%d" % k, "flask", "glass", 0.02, y - 0.3, 0.762)
    ply("amphora_near", "amphora", "blue_glaze", -2.55, 3.1, 0, 0, 1.25)
    ply("amphora_mid", "amphora", "brass", -3.1, 6.1, 0, 0, 1.4)
    ply("amphora_far", "amphora", "red_lacquer", 2.9, 9.4, 0, 0, 1.5)

    def knot(k, count=360):
        a = TAU * k / count
        r = 0.34 + 0.13 * math.cos(3 * a)
        return (r * math.cos(2 * a), 0.13 * math.sin(3 * a), r * math.sin(2 * a))
    meshes["knot"] = Mesh().tube([knot(k) for k in range(360)], 0.065, 20, True)
    meshes["pedestal"] = Mesh().revolve([(0.3, 0), (0.3, 0.06), (0.22, 0.1), (0.2, 0.5), (0.22, 0.8), (0.28, 0.86),
                                         (0.28, 0.9), (0, 0.9)], 48, 28, 12, 0.08)
    ply("pedestal", "pedestal", "sandstone", 2.3, 5.0, 0)
    ply("knot", "knot", "brushed_steel", 2.3, 5.0, 1.44, 20)

    def banner(u, v):
        return (0.09 * math.sin(TAU * 1.5 * u + 2 * v) * (0.35 + v), 1.1 * (u - 0.5), -2.3 * v)
    meshes["banner"] = Mesh().surface(banner, 40, 36)
    meshes["rod"] = Mesh().tube([(0, -0.65, 0.02), (0, 0.65, 0.02)], 0.025, 12)
    for k in range(BAYS):
        for side, x, turn in (("left", -3.72, 0), ("right", 3.72, 180)):
            ply("banner_%s_%d" % (side, k), "banner", "banner_cloth", x, BAY * (k + 0.5), 3.35, turn)
            ply("rod_%s_%d" % (side, k), "rod", "brass", x, BAY * (k + 0.5), 3.35, turn)
    ply("banner_far", "banner", "banner_cloth", 0, 15.75, 3.35, -90)


def lantern_hall(folder):
    meshes, xml = {}, Xml()
    hall_architecture(meshes, xml)
    hall_lanterns(meshes, xml)
    hall_furniture(meshes, xml)
    for name, mesh in meshes.items():
        mesh.write(folder / (name + ".ply"))
    write_png(folder / "stone.png", 256, 256, stone_color())
    write_png(folder / "weave.png", 128, 128, weave_color)
    (folder / "lantern_hall.xml").write_text(HALL_HEAD + "\n".join(xml.lines) + "\n</scene>\n")
    lamps = sum("<emitter" in line for line in xml.lines)
    triangles = 0
    for line in xml.lines:
        triangles += 2 * line.startswith('  <shape type="rectangle"')
        if '"filename"' in line:
            triangles += meshes[line.split('"')[-2][:-4]].triangle_count()
    return "lantern_hall.xml with %d lamps and %d triangles" % (lamps, triangles)


SCENES = {"cafe_table": cafe_table, "cafe_figure": cafe_figure, "lantern_hall": lantern_hall}


def main(arguments):
    if len(arguments) != 2 or arguments[0] not in SCENES:
        print("usage: generate.py %s FOLDER" % "|".join(SCENES), file=sys.stderr)
        return 2
    folder = pathlib.Path(arguments[1])
    try:
        folder.mkdir(parents=True, exist_ok=True)
        print("%s: %s" % (folder, SCENES[arguments[0]](folder)))
    except OSError as error:
        print("generate.py: %s: %s" % (folder, error.strerror), file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
