#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Tessellates the teapot's bicubic patches: scenes/teapot/patches.txt -> scenes/teapot/teapot.obj. Points and normals are those of the patches, evaluated in binary64;
points that patches share are one, to six decimals, so that neighbours meet without a crack.

usage: make_teapot.py [--check] [STEPS]     STEPS a side of a patch, 1 to 64 (10); --check compares with the committed file instead of writing it
"""
import math
import os
import sys

FOLDER = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "scenes", "teapot")


def read_patches(path):
    """[(name, 16 points)], copies made."""
    patches, points = [], []
    with open(path, encoding="ascii") as lines:
        for line in lines:
            word, *rest = line.split()
            if word == "patch":
                patches.append((rest[0], int(rest[1]), [int(i) for i in rest[2:]]))
            elif word == "point":
                x, y, z = (float(word) for word in rest)
                # freeglut moves two points of the lid off the axis by 0.002, to have a normal there; here they lie on it.
                points.append((0.0, 0.0, z) if math.hypot(x, y) <= 0.002 else (x, y, z))
    out = []
    for name, copies, indices in patches:
        grid = [points[i] for i in indices]
        for copy in range(copies):
            if copies == 4:
                turned = [turn(p, copy) for p in grid]
            elif copy == 0:
                turned = grid
            else:  # mirrored, with its rows reversed so that it keeps its outside
                turned = [(x, -y, z) for row in range(4) for x, y, z in reversed(grid[4 * row:4 * row + 4])]
            out.append((name, turned))
    return out


def turn(p, quarters):
    x, y, z = p
    for _ in range(quarters):
        x, y = -y, x
    return (x, y, z)


def bernstein(t):
    s = 1 - t
    return (s * s * s, 3 * s * s * t, 3 * s * t * t, t * t * t)


def slopes(t):
    s = 1 - t
    return (-3 * s * s, 3 * s * s - 6 * s * t, 6 * s * t - 3 * t * t, 3 * t * t)


def added(terms):
    """The terms added from the first to the last, each sum rounded. The sum() of Python 3.12 and later rounds once, so its last bits differ."""
    total = 0.0
    for term in terms:
        total += term
    return total


def combined(grid, rows, columns):
    return tuple(added(rows[i] * columns[j] * grid[4 * i + j][k] for i in range(4) for j in range(4)) for k in range(3))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def normal_at(grid, u, v):
    """Unit normal; where a side of the patch is one point, that of a place close by."""
    for nudge in (0.0, 1e-4, 1e-3):
        s, t = abs(u - nudge), abs(v - nudge)
        n = cross(combined(grid, bernstein(s), slopes(t)), combined(grid, slopes(s), bernstein(t)))
        length = math.sqrt(added(x * x for x in n))
        if length > 1e-6:
            return tuple(x / length for x in n)
    raise ValueError(f"no normal at ({u}, {v})")


def tessellate(patches, steps):
    """OBJ text, Y up."""
    places, place_of, normals, normal_of, faces = [], {}, [], {}, []

    def number(value, known, listed, decimals):
        key = tuple(round(x, decimals) + 0.0 for x in value)  # + 0.0: no -0
        if key not in known:
            known[key] = len(listed) + 1
            listed.append(key)
        return known[key]

    for name, grid in patches:
        corner = {}
        for i in range(steps + 1):
            for j in range(steps + 1):
                u, v = i / steps, j / steps
                x, y, z = combined(grid, bernstein(u), bernstein(v))
                nx, ny, nz = normal_at(grid, u, v)
                if math.hypot(x, y) < 1e-9 and abs(nz) > 0.9:  # on the axis four patches meet, and none of them knows the other's side
                    nx, ny, nz = 0.0, 0.0, math.copysign(1.0, nz)
                corner[i, j] = (number((x, z, -y), place_of, places, 6), number((nx, nz, -ny), normal_of, normals, 5))
        faces.append(f"g {name}")
        for i in range(steps):
            for j in range(steps):
                around = [corner[i, j], corner[i, j + 1], corner[i + 1, j + 1], corner[i + 1, j]]
                kept = [c for k, c in enumerate(around) if c[0] != around[k - 1][0]]
                if len({c[0] for c in kept}) >= 3:
                    faces.append("f " + " ".join(f"{p}//{n}" for p, n in kept))
    lines = ["# Newell's teapot, tessellated by toolchain/make_teapot.py from patches.txt; LICENSE beside this file."]
    lines += ["v " + " ".join(f"{x:.6f}".rstrip("0").rstrip(".") for x in p) for p in places]
    lines += ["vn " + " ".join(f"{x:.5f}".rstrip("0").rstrip(".") for x in n) for n in normals]
    return "\n".join(lines + faces) + "\n"


def main():
    words = sys.argv[1:]
    check = "--check" in words
    numbers = [w for w in words if w != "--check"]
    if len(numbers) > 1 or any(not n.isdigit() or not 1 <= int(n) <= 64 for n in numbers):
        print(__doc__.strip().split("\n\n")[-1], file=sys.stderr)
        return 2
    text = tessellate(read_patches(os.path.join(FOLDER, "patches.txt")), int(numbers[0]) if numbers else 10)
    path = os.path.join(FOLDER, "teapot.obj")
    if check:
        with open(path, encoding="ascii") as file:
            same = file.read() == text
        print("teapot.obj is what make_teapot.py makes" if same else "teapot.obj differs from what make_teapot.py makes")
        return 0 if same else 1
    with open(path, "w", encoding="ascii") as file:
        file.write(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
