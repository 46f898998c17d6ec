#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Meshes at a map's coordinates through the command: digits of bounds, error figures that start from the file, and warnings where float32 cannot hold a
mesh. usage: far_command_test.py PLUMB"""
import json
import math
import os
import re
import subprocess
import sys
import tempfile

MAP = (412345.67, 5287654.32, 412.44)
WITHIN = 0.005          # of a bound, in the units of the file, which has four decimals
MOST_WRONG = 0.01       # share of wrong faces

faults = []


def check(holds, what):
    if not holds:
        faults.append(what)


def run(plumb, *words):
    return subprocess.run([plumb, *words], capture_output=True, text=True)


def wave(at, cells=16, size=0.32, height=0.0584):
    """A square of hills, centimetres of detail, as text of an OBJ."""
    lines = []
    for j in range(cells + 1):
        for i in range(cells + 1):
            z = height * math.sin(2.1 * i / cells * math.pi) * math.cos(1.3 * j / cells * math.pi)
            lines.append(f"v {at[0] + size * i / cells:.4f} {at[1] + size * j / cells:.4f} {at[2] + z:.4f}")
    for j in range(cells):
        for i in range(cells):
            a = j * (cells + 1) + i + 1
            lines.append(f"f {a} {a + 1} {a + cells + 2} {a + cells + 1}")
    return "\n".join(lines) + "\n"


def bounds_in_words(text):
    found = re.search(r"mesh '.*bounds \(([^)]*)\) to \(([^)]*)\)", text)
    return [[float(x) for x in side.split(",")] for side in found.groups()] if found else None


def test_digits(plumb):
    near, far = (run(plumb, "info", name, "--json") for name in ("near.obj", "far.obj"))
    check(near.returncode == far.returncode == 0, "info fails")
    a, b = (json.loads(r.stdout) for r in (near, far))
    check(b["meshes"][0]["degenerate_faces"] == 0, f"{b['meshes'][0]['degenerate_faces']} degenerate faces")
    check(a["meshes"][0]["positions"] == b["meshes"][0]["positions"], "positions are lost")
    words = bounds_in_words(run(plumb, "info", "far.obj").stdout)
    for box in (b["meshes"][0]["bounds"], b["bounds"], dict(zip(("min", "max"), words))):
        for side in ("min", "max"):
            for i in range(3):
                want = a["meshes"][0]["bounds"][side][i] + MAP[i]
                check(abs(box[side][i] - want) <= WITHIN, f"bound {side}[{i}] is {box[side][i]!r}, not {want}")
    check(bounds_in_words(run(plumb, "info", "near.obj").stdout)[1][0] == 0.32, "a near bound has digits that it has not")


def test_pictures(plumb):
    for device in ("twin", "auto"):
        covered = 0
        for name in ("near", "far"):
            done = run(plumb, "render", f"{name}.obj", "--up", "+Z", "--size", "240x200", "--device", device, "--json", "-o", f"{name}.png")
            check(done.returncode == 0, f"{name}: {done.stderr}")
            covered = json.loads(done.stdout)["image"]["covered_pixels"]
        plane = json.loads(run(plumb, "diff", "near.png", "far.png", "--json").stdout)["planes"][0]
        check(covered > 3000 and plane["differing"] <= MOST_WRONG * covered, f"{device}: {plane['differing']} of {covered} pixels differ, by at most {plane['max']}")


def test_error(plumb):
    done = run(plumb, "render", "far.obj", "--up", "+Z", "--size", "240x200", "--with-error", "--json", "-o", "e.png")
    check(done.returncode == 0, done.stderr)
    report = json.loads(done.stdout)
    check(report["error"]["pixels"] > 3000, "hardly anything is seen")
    check(report["error"]["wrongPrimitiveShare"] <= MOST_WRONG, f"{report['error']['wrongPrimitiveShare']:.2%} of the faces are wrong")
    check(not report["scene"]["warnings"], f"warned for nothing: {report['scene']['warnings']}")


def test_warning(plumb):
    """A mesh of 2 10^8 with hills of centimetres at one end: no origin helps."""
    text = wave((1e8, 5, 0))
    corner = text.count("\nv ") + 1
    text += "v -1e8 0 0\nv -1e8 1 0\nv -99999999 0 0\n" + f"f {corner + 1} {corner + 2} {corner + 3}\n"
    with open("huge.obj", "w") as file:
        file.write(text)
    view = ("--eye", "100000000.16,5.16,1", "--at", "100000000.16,5.16,0", "--size", "80x60", "--device", "twin")
    done = run(plumb, "render", "huge.obj", *view, "--json", "-o", "h.png")
    check(done.returncode == 0, done.stderr)
    told = [w for w in json.loads(done.stdout)["scene"]["warnings"] if "object 'huge': float32 may move a vertex in this view by up to" in w]
    check(len(told) == 1 and "px" in told[0], f"not told in JSON: {done.stdout[:400]}")
    check("plumb: warning: object 'huge': float32 may move" in done.stderr, f"not told on standard error: {done.stderr}")
    explained = run(plumb, "render", "huge.obj", *view, "--explain")
    check("float32 may move" in explained.stderr, "not told with --explain alone")
    turned = run(plumb, "render", "huge.obj", "--view", "top", "--size", "80x60", "--device", "twin", "-o", "t.png")
    check(turned.returncode == 0 and "float32 may move" not in turned.stderr, f"told of a view that shows all of it: {turned.stderr}")


def main():
    plumb = os.path.abspath(sys.argv[1])
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for name, at in (("near", (0, 0, 0)), ("far", MAP)):
            with open(f"{name}.obj", "w") as file:
                file.write(wave(at))
        for test in (test_digits, test_pictures, test_error, test_warning):
            before = len(faults)
            test(plumb)
            print(f"{test.__name__}: {'ok' if len(faults) == before else 'FAILED'}", flush=True)
        os.chdir("/")
    for fault in faults:
        print(fault)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
