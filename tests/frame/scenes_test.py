#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Every committed scene, at three sizes: device and twin leave the same planes, each pass by itself does too, and the validation layers are silent (the
command fails when they are not). Prints a row a scene. usage: scenes_test.py PLUMB SCENES"""
import hashlib
import json
import os
import subprocess
import sys

SIZES = ("333x211", "640x480", "1920x1080")
PLANES = {"coverage", "triangle", "object_id", "primitive_id", "z", "linear", "colour", "depth", "distance", "normal"}
FORMATS = (".obj", ".ply", ".stl", ".off", ".toml", ".gltf", ".glb")


def faults_of(plumb, scene, size):
    """What is wrong, one string a fault."""
    done = subprocess.run([plumb, "verify", scene, "--size", size, "--require-device", "lavapipe", "--json"], capture_output=True, text=True)
    if done.returncode != 0:
        return [f"exit {done.returncode}: {done.stderr.strip()[-400:]}"]
    report = json.loads(done.stdout)
    verify, faults = report["verify"], []
    if "validation" in done.stderr:
        faults.append(done.stderr.strip())
    if not verify["equal"]:
        faults.append("not equal")
    faults += [f"pass {p['pass']} differs" for p in verify["passes"] if not p["equal"]]
    planes = {p["name"]: p for p in verify["planes"]}
    wanted = PLANES - {"triangle"} if report["options"]["shading"] == "ray" else PLANES  # rays meet more than triangles
    if not wanted <= set(planes):
        faults.append(f"no plane {', '.join(sorted(wanted - set(planes)))}")
    faults += [f"plane {name} differs" for name, p in planes.items() if p["sha256_twin"] != p["sha256_device"]]
    width, height = map(int, size.split("x"))
    if planes["object_id"]["sha256_twin"] == hashlib.sha256(b"\xff" * (4 * width * height)).hexdigest():
        faults.append("an empty picture shows nothing")
    return faults


def main():
    plumb, folder = sys.argv[1:]
    if os.environ.get("PLUMB_VALIDATION") != "1":
        print("PLUMB_VALIDATION=1 is not set")
        return 1
    # Those of the gallery are many and small: gallery_test verifies them.
    scenes = sorted(os.path.join(at, name) for at, _, names in os.walk(folder) if os.path.basename(at) != "gallery" for name in names if name.endswith(FORMATS))
    bad = 0
    for scene in scenes:
        for size in SIZES:
            faults = faults_of(plumb, scene, size)
            bad += bool(faults)
            print(f"{os.path.relpath(scene, folder):28} {size:>9}  {'; '.join(faults) or 'equal'}", flush=True)
    print(f"scenes: {len(scenes)} scenes, {len(SIZES)} sizes, {bad} with faults")
    return 1 if bad or not scenes else 0


if __name__ == "__main__":
    sys.exit(main())
