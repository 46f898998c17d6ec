#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""SHA-256 of every plane of every committed scene, drawn by device and twin, and of chosen scenes in every mode whose verdict is bits (docs/accuracy.md).

usage: scene_hashes.py PLUMB                  prints the table; exit 1 when device and twin differ anywhere, 4 when the device is not lavapipe
       scene_hashes.py PLUMB --write          writes scenes/hashes.txt
       scene_hashes.py PLUMB --check          compares with scenes/hashes.txt and names each plane that differs
       scene_hashes.py --compare A B          compares two printed tables
       scene_hashes.py --self-test            exit 1 when a change of a table goes unnoticed
"""
import json
import os
import queue
import subprocess
import sys
import threading

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
TABLE = os.path.join(ROOT, "scenes", "hashes.txt")
FORMATS = (".obj", ".ply", ".stl", ".off", ".toml", ".gltf", ".glb")
SIZE = ["--size", "320x240"]
DIGITS = 16  # of 64: enough to tell pictures apart, `plumb verify` prints all
HEAD = f"""# The first {DIGITS} digits of the SHA-256 of each plane, of device and twin alike, as `plumb verify ARGUMENTS {' '.join(SIZE)}` prints them. They are bits: whatever machine,
# driver, shader compiler and C++ compiler drew them. `python3 toolchain/scene_hashes.py build/release/plumb --write` makes this file, `--check` compares.
"""
MODES = {
    "scenes/suzanne.toml scenes/cornell.toml scenes/mug.toml scenes/apple/apple.ply scenes/procedural/slivers.stl": """
        --shading unlit|--shading flat|--shading gouraud|--shading phong|--shading ray|--shading wire|--shading wire --wire culled|--shading wire --wire solid
        --samples 4|--samples 16|--cull off|--encode linear|--background transparent|--viewer distant""",
    "scenes/suzanne.toml scenes/cornell.toml scenes/pyramid.toml": """
        --trade specular=schlick|--trade light-vector=vertex|--trade light-vector=face|--trade light-vector=scene|--trade interpolation=affine
        --trade depth=standard-32|--trade depth=24|--trade depth=16|--trade subpixel=4|--trade transform=fp64|--trade transform=block-integer
        --trade normals=as-interpolated|--trade rate=1/2""",
    "scenes/pyramid.toml scenes/cylinder.toml scenes/teapot.toml scenes/gallery/polygons.toml scenes/gallery/intersecting.toml": """
        --fill notes|--fill exact|--shading wire --edges polygons""",
    "scenes/four-spheres.toml scenes/mirrors.toml": """
        --sampling centre|--sampling corners|--sampling adaptive|--samples 4|--max-depth 2|--min-weight 0.1|--jitter reflect=0.05,shadow=0.1 --seed 7""",
    "scenes/four-spheres.toml": "--sampling random --seed 7",
}


def scenes():
    for folder, folders, names in os.walk(os.path.join(ROOT, "scenes")):
        folders.sort()
        for name in sorted(names):
            if name.endswith(FORMATS):
                yield os.path.relpath(os.path.join(folder, name), ROOT)


def rows():
    """Arguments of `plumb verify` but for the size, one string a row."""
    found = list(scenes())
    for files, modes in MODES.items():
        found += [f"{file} {mode.strip()}" for file in files.split() for line in modes.strip().splitlines() for mode in line.split("|")]
    return found


def planes_of(plumb, row):
    """(lines of the table, faults, the device's report) of one row."""
    done = subprocess.run([plumb, "verify", *row.split(), *SIZE, "--json", "--require-device", "lavapipe"], cwd=ROOT, capture_output=True, text=True)
    try:
        report = json.loads(done.stdout)
    except ValueError:
        return [], [f"{row}: exit {done.returncode}: {done.stderr.strip()[-300:]}"], {"exit": done.returncode}
    lines, faults = [], []
    if report["verify"]["bound"] is not None:
        faults.append(f"{row}: this picture is bounded, not bits: it has no place in the table")
    for plane in report["verify"]["planes"]:
        if plane["sha256_twin"] != plane["sha256_device"]:
            faults.append(f"{row}: {plane['name']}: device and twin differ")
        lines.append(f"{plane['sha256_device'][:DIGITS]} {plane['name']}")
    if done.returncode and not faults:
        faults.append(f"{row}: exit {done.returncode}: {done.stderr.strip()[-300:]}")
    return lines, faults, report["device"]


def drawn(plumb):
    """(the table, faults, the device's report) of all rows, by as many processes as there are processors."""
    waiting, results = queue.Queue(), {}
    for row in rows():
        waiting.put(row)

    def work():
        while True:
            try:
                row = waiting.get_nowait()
            except queue.Empty:
                return
            results[row] = planes_of(plumb, row)
    threads = [threading.Thread(target=work) for _ in range(os.cpu_count() or 1)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    text, faults, device = HEAD, [], {}
    for row in rows():
        lines, wrong, device = results[row]
        text += f"\n{row}\n" + "".join(f"  {line}\n" for line in lines)
        faults += wrong
    return text, faults, device


def read(text):
    """{(row, plane): hash}"""
    found, row = {}, None
    for line in text.splitlines():
        if line.startswith("  "):
            digits, plane = line.split()
            found[row, plane] = digits
        elif line and not line.startswith("#"):
            row = line
    return found


def differences(ours, theirs):
    """One line a plane that differs or stands on one side only."""
    lines = []
    for key in dict.fromkeys(list(ours) + list(theirs)):
        a, b = ours.get(key, "absent"), theirs.get(key, "absent")
        if a != b:
            lines.append(f"{key[0]}: {key[1]}: {a} and {b}")
    return lines


def judged(ours, theirs, between):
    if not ours or not theirs:
        print(f"scene_hashes: no planes to compare {between}")
        return 1
    wrong = differences(ours, theirs)
    for line in wrong:
        print(line)
    print(f"scene_hashes: {len({row for row, _ in ours})} pictures, {len(ours)} planes, {len(wrong)} differ {between}")
    return 1 if wrong else 0


def self_test():
    table = HEAD + "\na.toml --samples 4\n  00ff coverage\n  11ee colour\n\nb.ply\n  22dd colour\n"
    changed = {"one digit": table.replace("11ee", "11ef"), "a plane is gone": table.replace("  00ff coverage\n", ""), "a picture is gone": table[:table.index("\nb.ply")],
               "a plane more": table + "  33cc z\n", "two planes change places": table.replace("00ff", "x").replace("11ee", "00ff").replace("x", "11ee"),
               "other arguments": table.replace("--samples 4", "--samples 16")}
    wrong = [claim for claim, text in changed.items() if not differences(read(table), read(text)) or not differences(read(text), read(table))]
    if differences(read(table), read(table)) or len(read(table)) != 3:
        wrong.append("the same table")
    wrong += [f"{row} names no file" for row in rows() if not os.path.isfile(os.path.join(ROOT, row.split()[0]))]
    for line in wrong:
        print(line)
    print(f"scene_hashes --self-test: {len(changed)} changes, {len(wrong)} wrong answers")
    return 1 if wrong else 0


def text_of(path):
    with open(path, encoding="utf-8") as f:
        return f.read()


def main():
    words = sys.argv[1:]
    if words == ["--self-test"]:
        return self_test()
    if len(words) == 3 and words[0] == "--compare":
        return judged(read(text_of(words[1])), read(text_of(words[2])), f"between {words[1]} and {words[2]}")
    if not 1 <= len(words) <= 2 or words[0].startswith("-") or words[1:] not in ([], ["--write"], ["--check"]):
        print(__doc__[__doc__.index("usage:"):].rstrip(), file=sys.stderr)
        return 2
    text, faults, device = drawn(os.path.abspath(words[0]))
    for fault in faults:
        print(fault, file=sys.stderr)
    if faults:
        return 4 if device.get("exit") == 4 else 1
    if words[1:] == ["--check"]:
        status = judged(read(text_of(TABLE)), read(text), f"between scenes/hashes.txt and {device['name']}, {device['driverInfo']}")
        if status:
            print("Where a picture was meant to change: python3 toolchain/scene_hashes.py build/release/plumb --write")
        return status
    if words[1:] == ["--write"]:
        with open(TABLE, "w", encoding="utf-8") as f:
            f.write(text)
    else:
        sys.stdout.write(text)
        print(f"{device['name']}, {device['driverInfo']}", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
