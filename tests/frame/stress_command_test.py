#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""plumb stress: its margins from outside. Seeded scenes are written as files, and for each margin again with the extreme written into the file or the flags:
at half the margin `render --with-error` keeps the budget, at four times it does not. Besides: what is refused, named and reported.

usage: stress_command_test.py PLUMB SCENES [SEEDS]     without SEEDS: a handful of margins
"""
import json
import math
import os
import random
import subprocess
import sys
import tempfile
import unittest
from concurrent.futures import ThreadPoolExecutor

PLUMB, SCENES, SEEDS = None, None, 0
SIZE = (160, 120)
QUICK_AXES = ("extent", "gap", "grazing")
P99, WRONG = 1 / 255, 0.005      # the default budget, as shares of full scale and of pixels
MARGIN_HALF, MARGIN_BEYOND = 2, 4
SAME = 1e-9                      # relative: a number of the JSON that was printed and read
KINDS = ("none", "inverse", "inverse_square")


def scaled(v, f):
    return [x * f for x in v]


def plus(a, b):
    return [x + y for x, y in zip(a, b)]


def minus(a, b):
    return [x - y for x, y in zip(a, b)]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def unit(v):
    return scaled(v, 1 / math.sqrt(dot(v, v)))


def number_list(v):
    return "[" + ", ".join(repr(float(x)) for x in v) + "]"


class World:
    """A scene as numbers, to be written as a scene file and a mesh file. The object's matrix comes last and moves nothing at first."""

    def __init__(self, seed):
        rng = random.Random(seed)
        self.name = f"seed{seed}"
        bumps = [(rng.randint(1, 5), rng.randint(1, 4), rng.uniform(0, 6), rng.uniform(0.02, 0.12)) for _ in range(4)]
        radius = 10 ** rng.uniform(-2, 3)
        self.around, self.along = rng.choice(((24, 14), (18, 11), (30, 17)))
        self.points, self.normals, self.faces = [], [], []
        for j in range(self.along + 1):
            for i in range(self.around):
                a, b = 2 * math.pi * i / self.around, math.pi * j / self.along
                d = [math.sin(b) * math.cos(a), math.cos(b), math.sin(b) * math.sin(a)]
                r = radius * (1 + sum(h * math.sin(n * a + p) * math.sin(b) * math.cos(m * b) for n, m, p, h in bumps))
                self.points.append(scaled(d, r))
                self.normals.append(d)
        for j in range(self.along):
            for i in range(self.around):
                k, n = j * self.around + i, j * self.around + (i + 1) % self.around
                self.faces += [(k, n, n + self.around), (k, n + self.around, k + self.around)]
        # The poles are rows of one place; triangles without an area there are left out.
        self.faces = [f for f in self.faces if not (f[0] < self.around and f[1] < self.around) and not (min(f[1:]) >= self.along * self.around)]
        self.fov = rng.uniform(20, 50)
        toward = unit([rng.uniform(-1, 1), rng.uniform(-0.7, 0.7), rng.uniform(0.4, 1)])
        self.at = scaled(unit([rng.uniform(-1, 1) for _ in range(3)]), radius * 0.1)
        self.eye = plus(self.at, scaled(toward, radius * 1.7 / math.tan(math.radians(self.fov / 2))))
        self.near = None
        self.shininess, self.specular = rng.uniform(5, 200), rng.uniform(0.2, 0.6)
        self.lights = [{"type": "directional", "direction": plus(toward, [0.6, 0.9, 0.2]), "intensity": 0.8},
                       {"type": "point", "position": plus(self.at, scaled(unit(plus(toward, [-0.5, 0.6, 0.1])), radius * rng.uniform(3, 6))),
                        "intensity": 0.4, "attenuation": "none"}]
        self.radius, self.size = radius, SIZE
        self.matrix = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]
        self.layer = None

    # What the axes move, by their definitions in docs/stress.md.

    def distance(self):
        return math.sqrt(dot(minus(self.at, self.eye), minus(self.at, self.eye)))

    def middle(self):
        low, high = ([side(p[k] for p in self.points) for k in range(3)] for side in (min, max))
        return [a * 0.5 + b * 0.5 for a, b in zip(low, high)]

    def vertices(self, x):
        move = minus([math.copysign(x, c) for c in self.middle()], self.middle())
        self.points = [plus(p, move) for p in self.points]
        self.matrix = [[*row[:3], -m] for row, m in zip(self.matrix, move)]

    def place(self, x):
        move = minus([math.copysign(x, c) for c in self.at], self.at)
        self.matrix = [[*row[:3], row[3] + m] for row, m in zip(self.matrix, move)]
        self.eye, self.at = plus(self.eye, move), plus(self.at, move)
        for light in self.lights:
            if "position" in light:
                light["position"] = plus(light["position"], move)

    def apart(self, x):
        self.fov = math.degrees(2 * math.atan(math.tan(math.radians(self.fov / 2)) * self.distance() / x))
        self.eye = plus(self.at, scaled(unit(minus(self.eye, self.at)), x))

    def scale(self, x):
        self.matrix = [scaled(row, x) for row in self.matrix]
        self.eye, self.at = scaled(self.eye, x), scaled(self.at, x)
        for light in self.lights:
            if "position" in light:
                light["position"] = scaled(light["position"], x)

    def gap(self, x):
        keep = 1 - x
        self.layer = [[keep if k == i else 0 for k in range(3)] + [self.eye[i] * x] for i in range(3)]

    def extent(self, x):
        self.vertices(x)
        self.points.append([math.copysign(x, -c) for c in self.middle()])
        self.normals.append([0, 0, 1])
        self.faces.append((len(self.points) - 1,) * 3)

    def grazing(self, x):
        forward, far = unit(minus(self.at, self.eye)), self.distance()
        factor = 1 / math.tan(math.radians(x))
        stretched = lambda p: plus(p, scaled(forward, (factor - 1) * dot(forward, minus(p, self.eye))))
        self.matrix = [[(i == k) + (factor - 1) * forward[i] * forward[k] for k in range(3)] + [-forward[i] * (factor - 1) * dot(forward, self.eye)] for i in range(3)]
        for light in self.lights:
            if "position" in light:
                light["position"] = stretched(light["position"])
        self.fov = math.degrees(2 * math.atan(math.tan(math.radians(self.fov / 2)) / factor))
        self.at = plus(self.eye, scaled(forward, far * factor))

    def strength(self, x):
        most = max(light["intensity"] for light in self.lights)
        for light in self.lights:
            light["intensity"] *= x / most

    def lamp(self, x):
        for light in self.lights:
            if "position" in light:
                light["position"] = plus(self.at, scaled(unit(minus(light["position"], self.at)), x))

    def exponent(self, x):
        self.shininess = x

    def resolution(self, x):
        self.size = (int(x), round(SIZE[1] * x / SIZE[0]))

    def density(self, x):
        n, points, normals, faces = int(x), [], [], []
        for f in self.faces:
            first = len(points)
            a, b, c = (self.points[v] for v in f)
            na, nb, nc = (self.normals[v] for v in f)
            for i in range(n + 1):
                for j in range(i + 1):
                    points.append([((p * (n - i) + q * (i - j)) + r * j) / n for p, q, r in zip(a, b, c)])
                    normals.append(unit([p * (n - i) + q * (i - j) + r * j for p, q, r in zip(na, nb, nc)]))
            at = lambda i, j: first + i * (i + 1) // 2 + j
            for i in range(n):
                for j in range(i + 1):
                    faces.append((at(i, j), at(i + 1, j), at(i + 1, j + 1)))
                    if j < i:
                        faces.append((at(i, j), at(i + 1, j + 1), at(i, j + 1)))
        self.points, self.normals, self.faces = points, normals, faces

    def set_near(self, x):
        self.near = x

    def set_fov(self, x):
        self.fov = x

    def write(self, folder, name):
        with open(os.path.join(folder, name + ".obj"), "w", encoding="utf-8") as f:
            f.writelines("v {!r} {!r} {!r}\n".format(*map(float, p)) for p in self.points)
            f.writelines("vn {!r} {!r} {!r}\n".format(*map(float, n)) for n in self.normals)
            f.writelines("f " + " ".join(f"{v + 1}//{v + 1}" for v in face) + "\n" for face in self.faces)
        text = f"ambient = 0.2\nshading = \"phong\"\n[camera]\neye = {number_list(self.eye)}\nat = {number_list(self.at)}\nfov = {self.fov!r}\n"
        if self.near is not None:
            text += f"near = {self.near!r}\n"
        text += f"[[material]]\nname = \"m\"\nambient = 0.3\ndiffuse = [0.6, 0.4, 0.3]\nspecular = {self.specular!r}\nshininess = {self.shininess!r}\n"
        for light in self.lights:
            text += "[[light]]\n" + "".join(f"{k} = {json.dumps(v) if isinstance(v, str) else number_list(v) if isinstance(v, list) else repr(float(v))}\n"
                                            for k, v in light.items())
        text += f"[[mesh]]\nname = \"mesh\"\nfile = \"{name}.obj\"\nmaterial = \"m\"\n"
        for object_name, matrix in (("first", self.matrix), ("second", self.layer)):
            if matrix:
                rows = [*matrix, [0, 0, 0, 1]]
                text += f"[[object]]\nname = \"{object_name}\"\nmesh = \"mesh\"\ntransform = [{{ matrix = {number_list(x for row in rows for x in row)} }}]\n"
        path = os.path.join(folder, name + ".toml")
        with open(path, "w", encoding="utf-8") as f:
            f.write(text)
        return path


MOVES = {"vertices": World.vertices, "extent": World.extent, "place": World.place, "apart": World.apart, "size": World.scale, "fov": World.set_fov, "near": World.set_near, "gap": World.gap,
         "grazing": World.grazing, "exponent": World.exponent, "light-distance": World.lamp, "light-strength": World.strength, "resolution": World.resolution,
         "density": World.density}


class Stress(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory(prefix="plumb-stress-")
        cls.folder = cls.temporary.name

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def run_plumb(self, code, *words):
        done = subprocess.run([PLUMB, *words], cwd=self.folder, stdin=subprocess.DEVNULL, capture_output=True, timeout=900, check=False)
        self.assertEqual(done.returncode, code, (words, done.stderr[-2000:]))
        return done

    def margins(self, path, *words, code=0):
        return json.loads(self.run_plumb(code, "stress", path, "--size", "{}x{}".format(*SIZE), *words, "--json").stdout)["stress"]

    def keeps(self, world, name):
        """Whether a picture of the file keeps the default budget."""
        path = world.write(self.folder, name)
        done = subprocess.run([PLUMB, "render", path, "--size", "{}x{}".format(*world.size), "--with-error", "--json", "-q", "-o", name + ".png"], cwd=self.folder,
                              stdin=subprocess.DEVNULL, capture_output=True, timeout=300, check=False)
        self.assertEqual(done.returncode, 0, (name, done.stderr))
        error = json.loads(done.stdout)["error"]
        return error["p99"] <= P99 and error["wrongPrimitiveShare"] <= WRONG, (error["p99"] * 255, error["wrongPrimitiveShare"])

    def check_seed(self, seed, axes):
        """Names of the claims that do not hold, and how many were asked."""
        world = World(seed)
        report = self.margins(world.write(self.folder, world.name), *(("--axis", ",".join(axes)) if axes else ("--limit", "30min")))
        wrong, asked = [], 0
        for axis in report["axes"]:
            if not axis["applies"] or axis["axis"] not in MOVES:
                continue
            planned, up = axis["planned"], axis["rises"]
            self.assertIn(planned["end"], ("breaks", "holds"), axis)
            present = axis["present"]
            half = planned["within"] / MARGIN_HALF if up else planned["within"] * MARGIN_HALF
            if axis["unit"] in ("pixels", "parts of an edge"):
                half = math.floor(half)
            claims = []
            if present is None or (half > present if up else half < present):
                claims.append((half, True))
            if planned["end"] == "breaks":
                claims.append((planned["within"] * MARGIN_BEYOND if up else planned["within"] / MARGIN_BEYOND, False))
            reach = max(t["value"] for t in planned["tried"]) if up else min(t["value"] for t in planned["tried"])
            for number, (value, within) in enumerate(claims):
                if not within and (value > reach * (1 + SAME) if up else value < reach * (1 - SAME)):
                    continue  # further than the axis goes
                if not within and next((t["outcome"] for t in planned["tried"] if abs(t["value"] - value) <= SAME * abs(value)), "") != "beyond":
                    continue  # nothing can be told there, and the report says so
                moved = World(seed)
                MOVES[axis["axis"]](moved, value)
                kept, figures = self.keeps(moved, f"{world.name}-{axis['axis']}-{up:d}{number}")
                asked += 1
                if kept != within:
                    wrong.append(f"{world.name} {axis['title']} at {value:.6g}: {'beyond' if within else 'within'} {figures}, margin {planned['within']:.6g}")
        return wrong, asked

    def check_margins(self, seeds, axes):
        with ThreadPoolExecutor(2) as pool:
            found = list(pool.map(lambda seed: self.check_seed(seed, axes), seeds))
        wrong, asked = [w for ws, _ in found for w in ws], sum(n for _, n in found)
        print(f"{len(found)} scenes, {asked} claims checked from outside, {len(wrong)} do not hold")
        self.assertEqual(wrong, [])
        self.assertGreaterEqual(asked, len(found) * (len(axes) or 20))

    def test_a_scene_beyond_is_1_and_its_axis_is_named(self):
        path = World(1).write(self.folder, "beyond")
        with open(path, encoding="utf-8") as f:
            text = f.read()
        # A mirror that is followed once lacks light; more rays bring it back.
        with open(path, "w", encoding="utf-8") as f:
            f.write(text.replace("shading = \"phong\"", "shading = \"ray\"\nmax_depth = 1").replace("specular =", "reflect = 0.5\nspecular =") +
                    "[[plane]]\npoint = {}\nnormal = [0, 1, 0]\nmaterial = \"m\"\n".format(number_list([0, -10 * World(1).radius, 0])))
        report = self.margins(path, "--axis", "depth,near", code=1)
        self.assertEqual(report["itself"]["outcome"], "beyond")
        falling, rising = (next(a for a in report["axes"] if a["axis"] == "depth" and a["rises"] == rises) for rises in (False, True))
        self.assertEqual(falling["planned"]["end"], "passed")
        self.assertGreater(falling["planned"]["within"], 1)
        self.assertEqual(rising["planned"]["end"], "other")
        self.assertIn("near plane", next(a for a in report["axes"] if a["axis"] == "near")["absent"])
        said = self.run_plumb(1, "stress", path, "--size", "160x120", "--axis", "depth").stdout.decode()
        self.assertRegex(said, r"depth of rays, falling: is passed: within down to \d+ rays \(you are at 1\)")

    def test_refusals(self):
        path = World(1).write(self.folder, "refused")
        for code, words, says in ((2, ["--axis", "speed"], "accepted: vertices, extent, place,"), (2, ["--shading", "wire"], "no truth"),
                                  (2, ["--error", "0.1:p99"], "rounding to bytes"), (2, ["--size", "12x9"], "give a larger --size"),
                                  (2, ["--view", "front", "--view", "top"], "one viewpoint"), (2, ["--limit", "0s"], "--limit")):
            done = self.run_plumb(code, "stress", path, *words)
            self.assertIn(says, done.stderr.decode(), words)
            self.assertEqual(done.stdout, b"")

    def test_progress_has_the_time_left_and_a_limit_cuts(self):
        path = World(1).write(self.folder, "slow")
        done = self.run_plumb(0, "stress", path, "--size", "160x120", "--axis", "near", "--progress", "json")
        lines = [json.loads(line) for line in done.stderr.decode().splitlines()]
        self.assertEqual(lines[-1]["progress"], 1)
        self.assertTrue(any(line["left_s"] is not None for line in lines) or lines[-1]["elapsed_s"] < 1, lines[-3:])
        cut = self.margins(path, "--limit", "1ms", "--axis", "near,fov")
        self.assertEqual({a["planned"]["end"] for a in cut["axes"]}, {"cut"})

    def test_margins_hold_from_outside(self):
        self.check_margins(range(1, SEEDS + 1) if SEEDS else (1,), () if SEEDS else QUICK_AXES)


if __name__ == "__main__":
    PLUMB, SCENES = (os.path.abspath(path) for path in sys.argv[1:3])
    SEEDS = int(sys.argv[3]) if len(sys.argv) > 3 else 0
    unittest.main(argv=sys.argv[:1])
