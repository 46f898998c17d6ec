#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What certificates cost: the same pictures with --with-error alone and with --aov error,certified, in turns, whole commands from start to end. Prints the medians and
their ratio. The colours of both must be the same bytes.

usage: certified_cost.py PLUMB SCENES [ROUNDS]      exit 1 when a command fails or a colour differs
"""
import os
import statistics
import subprocess
import sys
import tempfile
import time

PLUMB, SCENES = sys.argv[1:3]
ROUNDS = int(sys.argv[3]) if len(sys.argv) > 3 else 11
PICTURES = (("suzanne.toml", "phong"), ("still-life.toml", "phong"), ("mirrors.toml", "ray"), ("four-spheres.toml", "ray"))

with tempfile.TemporaryDirectory() as folder:
    def seconds(scene, shading, planes, name):
        begin = time.monotonic()
        subprocess.run([PLUMB, "render", os.path.join(SCENES, scene), "--shading", shading, "--with-error", "--aov", planes, "-q", "-o", os.path.join(folder, name + "_{aov}.npy")], check=True)
        return time.monotonic() - begin

    def colour(name):
        with open(os.path.join(folder, name + "_color.npy"), "rb") as file:
            return file.read()

    print(f"{'scene':<20} {'--with-error':>14} {'with both planes':>18} {'ratio':>7}   medians of {ROUNDS} rounds, seconds")
    for scene, shading in PICTURES:
        plain, certified = [], []
        for _ in range(ROUNDS):
            plain.append(seconds(scene, shading, "color", "a"))
            certified.append(seconds(scene, shading, "color,error,certified", "b"))
            if colour("a") != colour("b"):
                sys.exit(f"{scene}: the colours differ")
        ratio = statistics.median(b / a for a, b in zip(plain, certified))
        print(f"{scene:<20} {statistics.median(plain):>14.3f} {statistics.median(certified):>18.3f} {ratio:>7.3f}")
