#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""A renderer in binary64 written from docs/illumination.md alone, against the linear planes of the command. It shares no code and no file with it.

usage: illumination_test.py PLUMB
"""
import os
import subprocess
import sys
import tempfile
import unittest

import numpy as np

PLUMB = sys.argv.pop(1)

# A vertex is moved by at most 1/512 px along each axis, so what a sample shows is what the unmoved polygon shows within 1/256 px of it.
SNAPPED_PX = 1 / 256
# float32 carries a ray to within 64 u of its way a hit, and a curved surface spreads that by some 20; at five hits and a focal length below 100 px.
TRACED_PX = 5 * 64 * 20 * 2.0**-24 * 100
FLOAT32 = 2.0**-16                      # of a colour of size 1: 256 roundings
SQUARE = ((0, 0), (-1, -1), (1, -1), (-1, 1), (1, 1))


def dot(a, b):
    return np.sum(a * b, axis=-1, keepdims=True)


def unit(a):
    return a / np.sqrt(dot(a, a))


class Scene:
    """What the page's symbols stand for; written as TOML for the command, kept as arrays for the renderer."""

    def __init__(self, shading, **settings):
        self.settings = {"shading": shading, "size": [64, 48], "ambient": 0.3, "background": [0.1, 0.2, 0.4], **settings}
        self.camera = {"eye": [0.4, 1.2, 5.0], "at": [0, 0.1, 0], "fov": 40}
        self.materials, self.lights, self.meshes, self.objects, self.spheres, self.planes = [], [], [], [], [], []

    def material(self, **m):
        self.materials.append({"ambient": 0.1, "diffuse": 0.8, "specular": 0.0, "emission": 0.0, "shininess": 32, "density": 1.0, "reflect": 0.0, "transmit": 0.0, **m})
        return len(self.materials) - 1

    def toml(self):
        def value(v):
            if isinstance(v, bool):
                return "true" if v else "false"
            if isinstance(v, str):
                return f'"{v}"'
            if isinstance(v, dict):
                return "{ " + ", ".join(f"{k} = {value(x)}" for k, x in v.items()) + " }"
            if isinstance(v, (list, tuple, np.ndarray)):
                return "[" + ", ".join(value(x) for x in v) + "]"
            return repr(v if isinstance(v, int) else float(v))

        def table(head, entries):
            return "\n".join([head] + [f"{k} = {value(v)}" for k, v in entries.items()]) + "\n"

        named = lambda e: {**e, "material": f"m{e['material']}"}
        text = "\n".join(f"{k} = {value(v)}" for k, v in self.settings.items()) + "\n" + table("[camera]", self.camera)
        for i, m in enumerate(self.materials):
            text += table("[[material]]", {"name": f"m{i}", **m})
        for light in self.lights:
            text += table("[[light]]", light)
        for i, m in enumerate(self.meshes):
            text += table("[[mesh]]", {"name": f"b{i}", **named(m)})
        for o in self.objects:
            rows = np.eye(4)
            rows[:3] = o["matrix"]
            text += table("[[object]]", {"mesh": f"b{o['mesh']}", "transform": [{"matrix": rows.ravel()}]})
        for s in self.spheres:
            text += table("[[sphere]]", named(s))
        for p in self.planes:
            p = named(p)
            if "board" in p:
                p["board"] = {**p["board"], "material": f"m{p['board']['material']}"}
            text += table("[[plane]]", p)
        return text


def three(x):
    return np.broadcast_to(np.asarray(x, float), 3)


class Renderer:
    def __init__(self, scene):
        s = self.scene = scene
        self.width, self.height = s.settings["size"]
        self.ia, self.sky = three(s.settings["ambient"]), three(s.settings["background"])
        self.shadows = s.settings.get("shadows", True)
        c = s.camera
        left = s.settings.get("handedness") == "left"
        if "distance" in c:
            self.eye, self.forward, self.right, self.up, self.focal = np.array([0, 0, -c["distance"]], float), np.array([0, 0, 1.0]), np.array([1.0, 0, 0]), np.array([0, 1.0, 0]), c["distance"]
        else:
            self.eye = np.array(c["eye"], float)
            self.forward = unit(np.array(c["at"], float) - self.eye)
            up = np.array([0, 1.0, 0])
            self.right = unit(np.cross(up, self.forward) if left else np.cross(self.forward, up))
            self.up = np.cross(self.forward, self.right) if left else np.cross(self.right, self.forward)
            self.focal = self.height / 2 / np.tan(np.radians(c["fov"]) / 2)
        self.left = left
        self.distant = s.settings.get("viewer") == "distant"
        field = lambda k: np.array([three(m[k]) for m in s.materials])
        self.ka, self.kd, self.ks, self.ke = field("ambient"), field("diffuse"), field("specular"), field("emission")
        number = lambda k: np.array([float(m[k]) for m in s.materials])
        self.n, self.density, self.reflect, self.transmit = number("shininess"), number("density"), number("reflect"), number("transmit")
        self.local = 1 - self.reflect - self.transmit
        self.finish()

    # Triangles of all objects: corners and normals in the world, material, face.
    def finish(self):
        corners, normals, faces, materials, ids, mirrors, geometric = [], [], [], [], [], [], []
        s = self.scene
        for number, o in enumerate(s.objects):
            mesh, matrix = s.meshes[o["mesh"]], np.asarray(o["matrix"], float)
            points = np.array(mesh["vertices"], float)
            normal_matrix = np.linalg.inv(matrix[:, :3]).T
            flat = [self.newell(points[f]) for f in mesh["faces"]]
            built = self.built(points, mesh["faces"], flat, mesh.get("crease", 60))
            world = points @ matrix[:, :3].T + matrix[:, 3]
            for f, face in enumerate(mesh["faces"]):
                centre = world[face].mean(axis=0)
                for k in range(1, len(face) - 1):       # the faces here are convex
                    three_ = (0, k, k + 1)
                    corners.append([world[face[i]] for i in three_])
                    normals.append([built[f][i] @ normal_matrix.T for i in three_])
                    normal = np.cross(corners[-1][1] - corners[-1][0], corners[-1][2] - corners[-1][0])
                    geometric.append(unit(normal * np.sign(np.linalg.det(matrix[:, :3]))))
                    faces.append([centre, unit(flat[f] @ normal_matrix.T)])
                    materials.append(mesh["material"])
                    ids.append(number * 1000 + f)
                    mirrors.append(np.linalg.det(matrix[:, :3]) < 0)
        self.corners, self.normals = np.array(corners).reshape(-1, 3, 3), np.array(normals).reshape(-1, 3, 3)
        self.faces, self.geometric = np.array(faces).reshape(-1, 2, 3), np.array(geometric).reshape(-1, 3)
        self.of, self.ids, self.mirrors = np.array(materials, int), np.array(ids, int), mirrors

    @staticmethod
    def newell(points):
        d = points - points[0]
        return unit(sum(np.cross(d[i], d[i + 1]) for i in range(1, len(d) - 1)))

    @staticmethod
    def built(points, faces, flat, crease):
        """Of each face the normals of its corners: the mean over the faces that smooth edges connect there, by their angles."""
        edges = {}
        for f, face in enumerate(faces):
            for i, a in enumerate(face):
                edges.setdefault(frozenset((a, face[(i + 1) % len(face)])), []).append(f)
        smooth = {(e, f, g) for e, both in edges.items() if len(both) == 2 for f, g in (both, both[::-1]) if np.degrees(np.arccos(np.clip(np.dot(flat[f], flat[g]), -1, 1))) < crease}

        def angle(f, v):
            face = faces[f]
            i = face.index(v)
            a, b = points[face[(i + 1) % len(face)]] - points[v], points[face[i - 1]] - points[v]
            return np.arccos(np.dot(unit(a), unit(b)))

        out = []
        for f, face in enumerate(faces):
            out.append([])
            for v in face:
                fan, new = {f}, [f]
                while new:
                    g = new.pop()
                    for e, a, b in smooth:
                        if a == g and v in e and b not in fan:
                            fan.add(b)
                            new.append(b)
                out[-1].append(unit(sum(flat[g] * angle(g, v) for g in sorted(fan))))
        return out

    # The point formula. p, n, v: (N, 3); m: (N,); through(light, toward, distance) is what reaches p.
    def point(self, p, n, v, m, through=None):
        colour = self.ke[m] + self.ka[m] * self.ia
        for light in self.lamps():
            toward, distance, fade = light.at(p)
            nl = dot(n, toward)
            rv = dot(2 * nl * n - toward, v)
            power = np.where(self.n[m][:, None] == 0, 1.0, np.where(rv > 0, np.maximum(rv, 1e-300) ** self.n[m][:, None], 0.0))
            reached = 1.0 if through is None else through(light, toward, distance)
            colour = colour + np.where(nl > 0, fade * light.intensity * reached * (self.kd[m] * nl + self.ks[m] * power), 0)
        return colour

    def lamps(self):
        for light in self.scene.lights:
            if light["type"] != "area":
                yield Lamp(light, light.get("position"), three(light.get("intensity", 1)))
                continue
            columns, rows = light["points"]
            for i in range(columns):
                for j in range(rows):
                    at = np.array(light["position"], float) + np.array(light["edge_u"]) * (i + 0.5) / columns + np.array(light["edge_v"]) * (j + 0.5) / rows
                    yield Lamp(light, at, three(light["intensity"]) / (columns * rows))

    def toward_eye(self, p):
        return np.broadcast_to(-self.forward, p.shape) if self.distant else unit(self.eye - p)

    # Colours and paths at places (x, y) of the picture.
    def look(self, x, y):
        shading = self.scene.settings["shading"]
        if shading != "ray":
            return self.raster(x, y, shading)
        d = unit(self.forward + self.right * ((x - self.width / 2) / self.focal)[:, None] - self.up * ((y - self.height / 2) / self.focal)[:, None])
        nowhere = np.full(len(x), -1)
        return self.trace(np.broadcast_to(self.eye, d.shape), d, nowhere, np.zeros(len(x), bool), 1, np.ones(len(x)))

    def raster(self, x, y, shading):
        best, seen = np.zeros(len(x)), np.full(len(x), -1)
        shares = np.zeros((len(x), 3))
        for t, corner in enumerate(self.corners):
            w = (corner - self.eye) @ self.forward
            assert np.all(w > 0.1), "this renderer cuts nothing"
            px = self.width / 2 + self.focal * ((corner - self.eye) @ self.right) / w
            py = self.height / 2 - self.focal * ((corner - self.eye) @ self.up) / w
            area = (px[1] - px[0]) * (py[2] - py[0]) - (px[2] - px[0]) * (py[1] - py[0])
            counter = area < 0                          # y grows downward
            front = counter ^ self.left ^ self.mirrors[t]
            if area == 0 or (not front and self.scene.settings.get("cull", True)):
                continue
            l = np.stack([((px[(i + 1) % 3] - x) * (py[(i + 2) % 3] - y) - (px[(i + 2) % 3] - x) * (py[(i + 1) % 3] - y)) / area for i in range(3)], axis=1)
            depth = l @ (1 / w)
            wins = np.all(l >= 0, axis=1) & (depth > best)
            best, seen = np.where(wins, depth, best), np.where(wins, t, seen)
            shares = np.where(wins[:, None], (l / w) / depth[:, None], shares)
        t = np.maximum(seen, 0)
        p, m = np.einsum("ni,nik->nk", shares, self.corners[t]), self.of[t]
        if shading == "unlit":
            colour = self.kd[m] + self.ke[m]
        elif shading == "flat":
            centre, normal = self.faces[t, 0], self.faces[t, 1]
            colour = self.point(centre, normal, self.toward_eye(centre), m)
        elif shading == "gouraud":
            at = [self.point(self.corners[t, i], unit(self.normals[t, i]), self.toward_eye(self.corners[t, i]), m) for i in range(3)]
            colour = sum(shares[:, [i]] * at[i] for i in range(3))
        else:
            with np.errstate(invalid="ignore"):
                colour = self.point(p, unit(np.einsum("ni,nik->nk", shares, self.normals[t])), self.toward_eye(p), m)
        return np.where((seen < 0)[:, None], self.sky, colour), np.where(seen < 0, -1, self.ids[t]).astype(np.int64)

    # Distances (rays, things) at which rays meet spheres, planes and triangles; inf: not. And the material of each.
    def meet(self, o, d, start, inside):
        s, count = self.scene, len(o)
        ways, materials, self_ = [], [], 0
        for k, ball in enumerate(s.spheres):
            f = o - np.array(ball["centre"], float)
            b, c = np.sum(f * d, axis=1), np.sum(f * f, axis=1) - ball["radius"] ** 2
            root = np.sqrt(np.maximum(b * b - c, 0))
            t = np.where(-b - root > 0, -b - root, -b + root)
            t = np.where((b * b - c >= 0) & (t > 0), t, np.inf)
            own = start == k
            ways.append(np.where(own, np.where(inside & (b < 0), -2 * b, np.inf), t))
            materials.append(np.full(count, ball["material"]))
        for k, plane in enumerate(s.planes):
            normal, u = unit(np.array(plane["normal"], float)), np.array(plane["u"], float)
            u = unit(u - normal * np.dot(u, normal))
            slope = d @ normal
            t = ((np.array(plane["point"]) - o) @ normal) / np.where(slope == 0, 1, slope)
            at = o + d * np.where(np.isfinite(t), t, 0)[:, None] - np.array(plane["point"])
            pu, pv = at @ u, at @ np.cross(u, normal)
            least, most = plane.get("u_range", (-np.inf, np.inf)), plane.get("v_range", (-np.inf, np.inf))
            met = (slope != 0) & (t > 0) & (start != len(s.spheres) + k) & (plane.get("two_sided", True) | (slope < 0))
            met &= (pu >= least[0]) & (pu <= least[1]) & (pv >= most[0]) & (pv <= most[1])
            ways.append(np.where(met, t, np.inf))
            material = np.full(count, plane["material"])
            if "board" in plane:
                side = plane["board"]["square"]
                odd = (pu < 0) ^ (np.abs(pu) % (2 * side) > side) ^ (np.abs(pv) % (2 * side) > side) ^ ((pv < 0) & (not plane["board"].get("mirrored", False)))
                material = np.where(odd, plane["board"]["material"], material)
            materials.append(material)
        first = len(s.spheres) + len(s.planes)
        weights = []
        for k, (a, b, c) in enumerate(self.corners):
            e, g = b - a, c - a
            h = np.cross(d, g)
            determinant = h @ e
            with np.errstate(divide="ignore", invalid="ignore"):
                f = o - a
                v = np.sum(f * h, axis=1) / determinant
                q = np.cross(f, e)
                w = np.sum(d * q, axis=1) / determinant
                t = (q @ g) / determinant
                met = (v >= 0) & (w >= 0) & (v + w <= 1) & (t > 0) & (start != first + k)
            ways.append(np.where(met, t, np.inf))
            materials.append(np.full(count, self.of[k]))
            weights.append(np.stack([1 - v - w, v, w], axis=1))
        return np.stack(ways, axis=1), np.stack(materials, axis=1), weights, first

    def trace(self, o, d, start, inside, depth, weight):
        s = self.scene
        if len(o) == 0:
            return np.zeros((0, 3)), np.zeros(0, np.int64)
        ways, materials, weights, first = self.meet(o, d, start, inside)
        thing = np.argmin(ways, axis=1)
        rows = np.arange(len(o))
        t = ways[rows, thing]
        colour, path = np.broadcast_to(self.sky, o.shape).copy(), np.full(len(o), 7, np.int64)
        met = np.flatnonzero(np.isfinite(t))
        o, d, t, thing, m, weight = o[met], d[met], t[met], thing[met], materials[met, thing[met]], weight[met]
        p = o + d * t[:, None]
        g, n = np.zeros_like(p), np.zeros_like(p)
        for k in np.unique(thing):
            here = thing == k
            if k < len(s.spheres):
                g[here] = (p[here] - np.array(s.spheres[k]["centre"])) / s.spheres[k]["radius"]
            elif k < first:
                g[here] = unit(np.array(s.planes[k - len(s.spheres)]["normal"], float))
            else:
                g[here] = self.geometric[k - first]
            n[here] = g[here] if k < first else unit(weights[k - first][met][here] @ unit(self.normals[k - first]))
        within = dot(d, g)[:, 0] > 0
        turn = np.where(within, -1, 1)[:, None]
        g, n = g * turn, n * turn
        code = 31 * thing.astype(np.int64) + 1000003 * within + 17 * m

        def through(light, toward, distance):
            above = (dot(n, toward) > 0) & (dot(g, toward) > 0)
            nonlocal code
            code = code * 1099511628211 + above[:, 0]
            if not self.shadows:
                return above * 1.0
            ways, materials, _, _ = self.meet(p, toward, thing, within)
            factor = self.transmit[materials]
            for k in range(len(self.corners)):
                leaves = toward @ self.geometric[k] > 0
                factor[:, first + k] = np.where((factor[:, first + k] == 0) | leaves, factor[:, first + k], 1)
            factor = np.where(ways < distance, factor, 1)
            code = code * 1099511628211 + np.sum((factor != 1) * (np.arange(factor.shape[1]) + 1) ** 2, axis=1)
            return above * np.prod(factor, axis=1, keepdims=True)

        found = self.point(p, n, -d, m, through) * self.local[m][:, None]
        # The mirrored ray's normal.
        facing = np.maximum(-dot(d, n), 0)
        mirror = d + 2 * facing * n
        below = dot(mirror, g)
        slope = np.minimum(2.0**-10, np.abs(dot(d, g)) / 2)
        with np.errstate(divide="ignore", invalid="ignore"):
            half = unit(mirror + (slope - below) * g) - d
            bent = np.where(dot(half, half) < 2.0**-36, g, unit(half))
        bent = np.where(below < slope, bent, n)
        bent = np.where(dot(n, g) <= 1 / 16, g, bent)
        mesh = (thing >= first)[:, None]
        bent = np.where(mesh, bent, n)
        k = -dot(d, bent)[:, 0]
        q = np.where(within, self.density[m], 1 / self.density[m])
        square = 1 - q * q * (1 - k * k)
        total = square <= 0
        code = code * 1099511628211 + total
        if depth < s.settings.get("max_depth", 5):
            least = s.settings.get("min_weight", 0)
            share = self.reflect[m] + np.where(total, self.transmit[m], 0)
            reflected = d + 2 * k[:, None] * bent
            root = np.sqrt(np.maximum(square, 0))
            refracted = q[:, None] * d + ((q * k - root)[:, None]) * bent
            against = dot(refracted, g)
            refracted = np.where(mesh & (against > -slope), refracted - (against + slope) * g, refracted)
            for direction, part, side, kind in ((reflected, share, within, 3), (refracted, np.where(total, 0, self.transmit[m]), ~within, 5)):
                goes = np.flatnonzero((part * weight > 0) & (part * weight >= least))
                c, below_ = self.trace(p[goes], unit(direction[goes]), thing[goes], side[goes], depth + 1, (weight * part)[goes])
                found[goes] += part[goes][:, None] * c
                code[goes] = code[goes] * 1099511628211 + below_ * kind
        colour[met], path[met] = found, code
        return colour, path


class Lamp:
    def __init__(self, light, position, intensity):
        self.light, self.position, self.intensity = light, position, intensity

    def at(self, p):
        if self.light["type"] == "directional":
            return np.broadcast_to(unit(np.array(self.light["direction"], float)), p.shape), np.inf, 1.0
        toward = np.array(self.position, float) - p
        distance = np.sqrt(dot(toward, toward))
        fade = {"none": 1.0, "1/d": 1 / distance, "1/d^2": 1 / distance**2}[self.light.get("attenuation", "none")]
        return toward / distance, distance, fade


def identity(*at):
    return np.hstack([np.eye(3), np.array(at, float)[:, None]])


def turned(degrees, scale, at):
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.hstack([np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]) @ np.diag(scale), np.array(at, float)[:, None]])


BOX = ([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])


def globe(columns, rows):
    """A ball of triangles and quadrilaterals, outward counter-clockwise."""
    points, faces = [[0.0, 1.0, 0.0]], []
    for j in range(1, rows):
        for i in range(columns):
            a, b = np.pi * j / rows, 2 * np.pi * i / columns
            points.append([np.sin(a) * np.cos(b), np.cos(a), -np.sin(a) * np.sin(b)])
    points.append([0.0, -1.0, 0.0])
    ring = lambda j, i: 1 + (j - 1) * columns + i % columns
    for i in range(columns):
        faces.append([0, ring(1, i), ring(1, i + 1)])
        faces += [[ring(j, i), ring(j + 1, i), ring(j + 1, i + 1), ring(j, i + 1)] for j in range(1, rows - 1)]
        faces.append([ring(rows - 1, i), len(points) - 1, ring(rows - 1, i + 1)])
    return np.array(points).astype(np.float32).astype(float).tolist(), faces


LIGHTS = [
    {"type": "directional", "direction": [1, 2, 2], "intensity": [0.5, 0.45, 0.4]},
    {"type": "point", "position": [-2, 3, 3], "intensity": [3, 2.5, 2], "attenuation": "1/d"},
    {"type": "point", "position": [2, 1, 2], "intensity": 1.5, "attenuation": "1/d^2"},
]


def bodies(shading, **settings):
    s = Scene(shading, **settings)
    s.lights = list(LIGHTS)
    red = s.material(ambient=[0.2, 0.05, 0.05], diffuse=[0.7, 0.2, 0.1], specular=0.4, shininess=20, emission=[0, 0, 0.05])
    step = s.material(diffuse=0.5, specular=[0.1, 0.2, 0.1], shininess=0)
    s.meshes = [{"vertices": globe(9, 6)[0], "faces": globe(9, 6)[1], "material": red}, {"vertices": BOX[0], "faces": BOX[1], "material": step}]
    s.objects = [{"mesh": 0, "matrix": turned(25, [0.9, 0.45, 1.2], [-0.6, 0.2, 0])}, {"mesh": 1, "matrix": turned(35, [0.4, 0.6, -0.3], [1.1, -0.2, -0.4])}]
    return s


def traced(**settings):
    s = Scene("ray", max_depth=5, **settings)
    s.lights = [dict(light) for light in LIGHTS[:2]]
    board, other = s.material(diffuse=[0.7, 0.1, 0.1], reflect=0.2), s.material(diffuse=0.7)
    s.planes = [{"point": [0, -1, 0], "normal": [0, 1, 0], "u": [1, 0, 0], "u_range": [-4, 4], "v_range": [-6, 3], "material": board, "board": {"square": 0.9, "material": other}}]
    return s


def with_spheres():
    s = traced()
    metal = s.material(diffuse=[0.2, 0.3, 0.6], specular=0.6, shininess=60, reflect=0.6)
    glass = s.material(ambient=0.02, diffuse=0.05, specular=0.5, shininess=90, reflect=0.1, transmit=0.8, density=1.5)
    air = s.material(diffuse=0.05, reflect=0.15, transmit=0.75, density=0.6)
    s.spheres = [{"centre": [-1.1, -0.2, -0.5], "radius": 0.8, "material": metal}, {"centre": [0.7, -0.3, 0.6], "radius": 0.7, "material": glass}, {"centre": [0.2, 0.9, 0.2], "radius": 0.4, "material": air}]
    s.planes.append({"point": [0, 0, -3], "normal": [0.1, 0, 1], "u": [1, 0, 0], "two_sided": False, "material": metal})
    return s


def with_mesh(**material):
    s = traced()
    m = s.material(**{"diffuse": [0.3, 0.5, 0.2], "specular": 0.4, "shininess": 30, **material})
    s.meshes = [{"vertices": globe(8, 6)[0], "faces": globe(8, 6)[1], "material": m}]
    s.objects = [{"mesh": 0, "matrix": turned(20, [1.0, 0.8, 1.1], [0.1, 0.1, 0.2])}]
    return s


class Illumination(unittest.TestCase):
    def drawn(self, scene, *flags):
        with tempfile.TemporaryDirectory() as folder:
            path, out = os.path.join(folder, "s.toml"), os.path.join(folder, "s.npy")
            with open(path, "w") as file:
                file.write(scene.toml())
            run = subprocess.run([PLUMB, "render", path, "--aov", "linear", "-o", out, "-q", *flags], capture_output=True, text=True)
            self.assertEqual(run.returncode, 0, run.stderr + scene.toml())
            return np.load(out).astype(float)

    def agree(self, scene, side=1, judged=0.5):
        """Every channel lies between what the renderer sees beside the samples; pixels whose path is another beside them are left out."""
        beside = TRACED_PX if scene.settings["shading"] == "ray" else SNAPPED_PX
        got = self.drawn(scene, "--samples", str(side * side))
        renderer = Renderer(scene)
        low, high, plain = np.zeros_like(got), np.zeros_like(got), np.zeros_like(got)
        clear = np.ones(got.shape[:2], bool)
        for j in range(side):
            for i in range(side):
                x, y = np.meshgrid(np.arange(renderer.width) + (i + 0.5) / side, np.arange(renderer.height) + (j + 0.5) / side)
                seen = [renderer.look((x + beside * dx).ravel(), (y + beside * dy).ravel()) for dx, dy in SQUARE]
                colours = np.stack([c for c, _ in seen]).reshape(len(SQUARE), *got.shape)
                paths = np.stack([p for _, p in seen]).reshape(len(SQUARE), *got.shape[:2])
                clear &= np.all(paths == paths[0], axis=0)
                low += colours.min(axis=0) / side**2
                high += colours.max(axis=0) / side**2
                plain += colours[0] / side**2
        room = FLOAT32 * np.maximum(1, np.abs(plain))
        outside = np.maximum(low - room - got, got - high - room).max(axis=2)
        share = clear.mean()
        wrong = np.argwhere((outside > 0) & clear)
        off = np.abs(got - plain).max(axis=2)[clear].max()
        print(f"{self.id().split('.')[-1]}: {share:.1%} of the pixels judged, {len(wrong)} outside, {off:.2g} off at most", flush=True)
        self.assertGreater(share, judged, "too few pixels lie away from edges")
        self.assertGreater(np.abs(plain - renderer.sky).max(axis=2).astype(bool).mean(), 0.1, "nothing is seen")
        self.assertEqual(len(wrong), 0, [f"({x}, {y}): {got[y, x]} for {plain[y, x]}, {low[y, x]} to {high[y, x]}" for y, x in wrong[:5]])

    def test_unlit(self):
        self.agree(bodies("unlit"))

    def test_flat(self):
        self.agree(bodies("flat"))

    def test_gouraud(self):
        self.agree(bodies("gouraud"))

    def test_phong(self):
        self.agree(bodies("phong"))

    def test_phong_with_four_samples(self):
        self.agree(bodies("phong"), side=2)

    def test_phong_from_behind(self):
        self.agree(bodies("phong", cull=False))

    def test_phong_of_a_distant_viewer(self):
        self.agree(bodies("phong", viewer="distant"))

    def test_phong_in_a_left_handed_world(self):
        s = bodies("phong", handedness="left")
        s.camera = {"distance": 120.0}
        for o in s.objects:
            o["matrix"] = np.diag([20.0, 20, -20]) @ o["matrix"]
        self.agree(s)

    def test_an_area_light(self):
        s = bodies("phong")
        s.lights = [{"type": "area", "position": [-2, 3, 1], "edge_u": [2, 0, 0], "edge_v": [0, 0, 2], "points": [3, 2], "intensity": 6, "attenuation": "1/d^2"}]
        self.agree(s)

    def test_rays_of_spheres_and_planes(self):
        self.agree(with_spheres())

    def test_rays_of_an_opaque_mesh(self):
        self.agree(with_mesh())

    def test_rays_without_shadows(self):
        s = with_mesh()
        s.settings["shadows"] = False
        self.agree(s)

    def test_rays_of_a_mirroring_mesh(self):
        self.agree(with_mesh(reflect=0.6))

    def test_rays_of_smooth_glass(self):
        self.agree(with_mesh(reflect=0.1, transmit=0.8, density=1.4), judged=0.3)

    def test_rays_of_a_smooth_bubble(self):
        self.agree(with_mesh(reflect=0.1, transmit=0.8, density=0.7), judged=0.3)

    def test_a_mistake_is_noticed(self):
        """The renderer with another formula is not taken for right."""
        for change in ("n", "kd", "density", "reflect"):
            scene = with_spheres()
            right = Renderer(scene)
            wrong = Renderer(scene)
            setattr(wrong, change, getattr(wrong, change) * 1.02)
            x, y = np.meshgrid(np.arange(right.width) + 0.5, np.arange(right.height) + 0.5)
            a, b = right.look(x.ravel(), y.ravel())[0], wrong.look(x.ravel(), y.ravel())[0]
            self.assertGreater(np.mean(np.abs(a - b).max(axis=1) > 4 * FLOAT32), 0.02, change)


if __name__ == "__main__":
    unittest.main(verbosity=2)
