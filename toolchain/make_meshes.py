#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes the procedural meshes of scenes/procedural/, each to show something a reader or a pass must get right.

Coordinates are rounded to six decimals and then to float32, so that every machine writes the same bytes and every format
states the same numbers. +Y is up, the front is +Z, faces are counter-clockwise seen from outside.

usage: make_meshes.py [FOLDER]      (default: scenes/procedural beside this script)
       make_meshes.py --check       exit 1 when the committed files differ from what would be written
"""
import math
import os
import struct
import sys
import tempfile


def float32(x):
    return struct.unpack("<f", struct.pack("<f", round(x, 6)))[0] + 0.0


class Mesh:
    def __init__(self):
        self.vertices, self.faces, self.known = [], [], {}

    def vertex(self, x, y, z):
        p = (float32(x), float32(y), float32(z))
        if p not in self.known:
            self.known[p] = len(self.vertices)
            self.vertices.append(p)
        return self.known[p]

    def face(self, *corners):
        self.faces.append(tuple(corners))


def icosphere(level):
    """A closed surface of nearly equal triangles; its normals are known: the positions."""
    t = (1 + math.sqrt(5)) / 2
    points = [(-1, t, 0), (1, t, 0), (-1, -t, 0), (1, -t, 0), (0, -1, t), (0, 1, t),
              (0, -1, -t), (0, 1, -t), (t, 0, -1), (t, 0, 1), (-t, 0, -1), (-t, 0, 1)]
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6), (7, 1, 8),
             (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]

    def unit(p):
        length = math.sqrt(sum(c * c for c in p))
        return tuple(c / length for c in p)

    points = [unit(p) for p in points]
    for _ in range(level):
        middles, finer = {}, []

        def middle(a, b):
            key = (min(a, b), max(a, b))
            if key not in middles:
                middles[key] = len(points)
                points.append(unit(tuple((x + y) / 2 for x, y in zip(points[a], points[b]))))
            return middles[key]

        for a, b, c in faces:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            finer += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        faces = finer
    mesh = Mesh()
    for face in faces:
        mesh.face(*(mesh.vertex(*points[i]) for i in face))
    return mesh


def torus(around, tube):
    """Smooth, with a hole and a curvature of both signs; the same in four formats."""
    mesh = Mesh()

    def point(i, j):
        u, v = 2 * math.pi * (i % around) / around, 2 * math.pi * (j % tube) / tube
        r = 1 + 0.4 * math.cos(v)
        return mesh.vertex(r * math.cos(u), 0.4 * math.sin(v), -r * math.sin(u))

    for i in range(around):
        for j in range(tube):
            a, b, c, d = point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)
            mesh.face(a, b, c)
            mesh.face(a, c, d)
    return mesh


def gear(teeth):
    """Two concave faces of 4 * teeth corners, and creases of many angles."""
    mesh = Mesh()
    outline = []
    for i in range(teeth):
        for share, radius in ((0.0, 0.8), (0.2, 1.0), (0.45, 1.0), (0.65, 0.8)):
            angle = 2 * math.pi * (i + share) / teeth
            outline.append((radius * math.cos(angle), radius * math.sin(angle)))
    n = len(outline)
    front = [mesh.vertex(x, y, 0.15) for x, y in outline]
    back = [mesh.vertex(x, y, -0.15) for x, y in outline]
    mesh.face(*front)
    mesh.face(*reversed(back))
    for i in range(n):
        mesh.face(front[i], back[i], back[(i + 1) % n], front[(i + 1) % n])
    return mesh


def menger(level):
    """Axis-parallel quads only: shared edges, equal depths, and right angles at every edge."""
    n = 3 ** level

    def solid(cell):
        if any(c < 0 or c >= n for c in cell):
            return False
        for _ in range(level):
            if sum(c % 3 == 1 for c in cell) >= 2:
                return False
            cell = tuple(c // 3 for c in cell)
        return True

    mesh = Mesh()
    sides = [((1, 0, 0), [(1, 0, 0), (1, 1, 0), (1, 1, 1), (1, 0, 1)]), ((-1, 0, 0), [(0, 0, 0), (0, 0, 1), (0, 1, 1), (0, 1, 0)]),
             ((0, 1, 0), [(0, 1, 0), (0, 1, 1), (1, 1, 1), (1, 1, 0)]), ((0, -1, 0), [(0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1)]),
             ((0, 0, 1), [(0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]), ((0, 0, -1), [(0, 0, 0), (0, 1, 0), (1, 1, 0), (1, 0, 0)])]
    for x in range(n):
        for y in range(n):
            for z in range(n):
                if not solid((x, y, z)):
                    continue
                for (dx, dy, dz), corners in sides:
                    if not solid((x + dx, y + dy, z + dz)):
                        mesh.face(*(mesh.vertex(*((c + o) / n * 2 - 1 for c, o in zip((x, y, z), corner))) for corner in corners))
    return mesh


def slivers(blades):
    """A cone of needles (aspect about 1 : 160 at the tip), and above it strips whose widths go down by tens to 1e-5."""
    mesh = Mesh()
    tip = mesh.vertex(0, 0.5, 0)
    rim = [mesh.vertex(math.cos(2 * math.pi * i / blades), -0.5, -math.sin(2 * math.pi * i / blades)) for i in range(blades)]
    for i in range(blades):
        mesh.face(tip, rim[i], rim[(i + 1) % blades])
    for k in range(1, 6):
        y, half = 0.5 + 0.1 * k, 10.0 ** -k / 2
        a, b = mesh.vertex(-0.8, y - half, 0), mesh.vertex(0.8, y - half, 0)
        c, d = mesh.vertex(0.8, y + half, 0), mesh.vertex(-0.8, y + half, 0)
        mesh.face(a, b, c)
        mesh.face(a, c, d)
    return mesh


class Chance:
    """A congruential generator of our own, so that the files are the same everywhere."""
    def __init__(self, seed):
        self.state = seed

    def __call__(self, low, high):
        self.state = (self.state * 6364136223846793005 + 1442695040888963407) % 2**64
        return low + (high - low) * (self.state >> 11) / 2**53


def canopy(leaves):
    """Leaves above a clearing, -4 to 4 each way and 3 to 3.6 up: quadrilaterals about half a unit long."""
    mesh, chance = Mesh(), Chance(7)
    for _ in range(leaves):
        x, y, z, angle, long, wide = chance(-4.5, 4.5), chance(3, 3.6), chance(-4.5, 4.5), chance(0, 6.28), chance(0.3, 0.6), chance(0.15, 0.3)
        c, s = math.cos(angle), math.sin(angle)
        mesh.face(*(mesh.vertex(x + a * c - b * s, y + 0.6 * a, z + a * s + b * c) for a, b in ((-long, 0), (0, wide), (long, 0), (0, -wide))))
    return mesh


def dapples(side, spots):
    """The clearing's ground as squares, light ones and dark ones: spots thrown at random. No tree is asked."""
    chance, discs = Chance(11), []
    for _ in range(spots):
        discs.append((chance(-4.2, 4.2), chance(-4.2, 4.2), chance(0.2, 0.5)))
    light, dark = Mesh(), Mesh()
    for i in range(side):
        for j in range(side):
            x, z, size = -4 + 8 * i / side, -4 + 8 * j / side, 8 / side
            centre = (x + size / 2, z + size / 2)
            shaded = any((centre[0] - a) ** 2 + (centre[1] - b) ** 2 < r * r for a, b, r in discs)
            mesh = dark if shaded else light
            mesh.face(*(mesh.vertex(px, 0, pz) for px, pz in ((x, z), (x, z + size), (x + size, z + size), (x + size, z))))
    return light, dark


def number(x):
    return "%.9g" % x   # nine digits give back the same float32


def write_obj(mesh, material=None):
    lines = ["# Written by toolchain/make_meshes.py"]
    if material:
        lines += ["mtllib " + material[0], "usemtl " + material[1]]
    lines += ["v " + " ".join(map(number, p)) for p in mesh.vertices]
    lines += ["f " + " ".join(str(i + 1) for i in f) for f in mesh.faces]
    return ("\n".join(lines) + "\n").encode()


def write_off(mesh):
    lines = ["OFF", "# Written by toolchain/make_meshes.py", "%d %d 0" % (len(mesh.vertices), len(mesh.faces))]
    lines += [" ".join(map(number, p)) for p in mesh.vertices]
    lines += [" ".join(map(str, (len(f),) + f)) for f in mesh.faces]
    return ("\n".join(lines) + "\n").encode()


def write_ply(mesh, order):
    header = ["ply", "format binary_%s_endian 1.0" % order, "comment Written by toolchain/make_meshes.py",
              "element vertex %d" % len(mesh.vertices), "property float x", "property float y", "property float z",
              "element face %d" % len(mesh.faces), "property list uchar int vertex_indices", "end_header"]
    sign = "<" if order == "little" else ">"
    body = b"".join(struct.pack(sign + "3f", *p) for p in mesh.vertices)
    body += b"".join(struct.pack(sign + "B%di" % len(f), len(f), *f) for f in mesh.faces)
    return ("\n".join(header) + "\n").encode() + body


def facet_normal(points):
    a, b, c = points[:3]
    u, v = [q - p for p, q in zip(a, b)], [q - p for p, q in zip(a, c)]
    n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
    length = math.sqrt(sum(x * x for x in n))
    return [float32(x / length) for x in n]


def write_stl_binary(mesh):
    body = b"Written by toolchain/make_meshes.py".ljust(80, b" ") + struct.pack("<I", len(mesh.faces))
    for f in mesh.faces:
        points = [mesh.vertices[i] for i in f]
        body += struct.pack("<12fH", *facet_normal(points), *(c for p in points for c in p), 0)
    return body


def write_stl_ascii(mesh, name):
    lines = ["solid " + name]
    for f in mesh.faces:
        points = [mesh.vertices[i] for i in f]
        lines += ["facet normal " + " ".join(map(number, facet_normal(points))), " outer loop"]
        lines += ["  vertex " + " ".join(map(number, p)) for p in points]
        lines += [" endloop", "endfacet"]
    return ("\n".join(lines + ["endsolid " + name]) + "\n").encode()


BRASS = b"""# Written by toolchain/make_meshes.py
newmtl brass
Ka 0.6 0.45 0.15
Kd 0.6 0.45 0.15
Ks 0.5 0.45 0.3
Ns 60
illum 2
"""


def files():
    ring = torus(48, 24)
    light, dark = dapples(64, 90)
    return {
        "../gallery/canopy.off": write_off(canopy(240)),
        "../gallery/dapple-light.off": write_off(light),
        "../gallery/dapple-dark.off": write_off(dark),
        "icosphere.ply": write_ply(icosphere(4), "little"),
        "torus.obj": write_obj(ring),
        "torus.off": write_off(ring),
        "torus.ply": write_ply(ring, "big"),
        "torus.stl": write_stl_binary(ring),
        "gear.obj": write_obj(gear(24), ("gear.mtl", "brass")),
        "gear.mtl": BRASS,
        "menger.off": write_off(menger(2)),
        "slivers.stl": write_stl_ascii(slivers(1000), "slivers"),
    }


def main():
    check = sys.argv[1:] == ["--check"]
    folder = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "scenes", "procedural")
    if not check and len(sys.argv) > 1:
        folder = sys.argv[1]
    different = []
    for name, data in files().items():
        path = os.path.join(folder, name if len(sys.argv) == 1 or check else os.path.basename(name))
        if check:
            with open(path, "rb") as file:
                if file.read() != data:
                    different.append(name)
            continue
        with tempfile.NamedTemporaryFile(dir=folder, delete=False) as file:
            file.write(data)
        os.chmod(file.name, 0o644)
        os.replace(file.name, path)
    for name in different:
        print("differs from what make_meshes.py writes: " + name)
    return 1 if different else 0


if __name__ == "__main__":
    sys.exit(main())
