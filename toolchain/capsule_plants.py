#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Makes a capsule of every planted fault of a device's side (tests/fault/plants/): its modules are built with the fault, the pictures of `plumb verify --suite`
are drawn with them until one differs, and the scene is reduced. Each capsule must be small, have few triangles, and give the same result in every replay.

usage: capsule_plants.py BUILD PROGRAM [--only REGEX] [--seconds S] [--keep FOLDER]
       BUILD: a finished build tree; PROGRAM: its capsule_plants
Exit 1: a fault that no picture shows, or a capsule that is too large; each is named.
"""
import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile

import plants
import run_plants

MOST_BYTES, MOST_TRIANGLES, REPLAYS = 1 << 20, 8, 20


def modules_of(worker, row, folder):
    """{module: path of its words} of the modules that the fault reaches."""
    worker.lay_out({row.file: plants.planted(run_plants.text_of(row.file), row)})
    found = {}
    embedded = {raw for name, raw in worker.build.module_of.items() if not os.path.basename(raw).startswith("host_")}
    for raw in sorted(embedded & worker.build.users[plants.path_of(run_plants.ROOT, row.file)]):
        stem = worker.spirv(raw)
        if stem:
            found[os.path.basename(stem)] = shutil.copy(stem + ".spv", os.path.join(folder, f"{row.name}.{os.path.basename(stem)}.spv"))
    return found


def faults_of(result):
    if result["picture"] is None:
        return [f"no picture shows it{': ' + result['what'] if 'what' in result else ''}"]
    if "bytes" not in result:
        return [result.get("what", "no capsule")]
    faults = []
    if result["bytes"] > MOST_BYTES:
        faults.append(f"{result['bytes']} bytes")
    if result["triangles"] > MOST_TRIANGLES:
        faults.append(f"{result['triangles']} triangles")
    if result["captured"] != REPLAYS:
        faults.append(f"{result['captured']} of {REPLAYS} replays are as captured")
    return faults


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("build")
    parser.add_argument("program")
    parser.add_argument("--only", default="")
    parser.add_argument("--seconds", default="30")
    parser.add_argument("--keep", default="")
    options = parser.parse_args()
    rows, faults = plants.read_all(run_plants.ROOT)
    rows = [row for row in rows if row.side == "device" and re.search(options.only, row.name)]
    if faults or not rows:
        print("\n".join(faults) or "capsule_plants: no planted faults")
        return 1
    os.environ.setdefault("VK_ICD_FILENAMES", run_plants.cached(options.build, "PLUMB_TEST_ICD"))
    build = run_plants.Build(options.build)
    worker = run_plants.Worker(build, os.path.join(build.path, "capsule_plants"), 0)
    bad = []
    with tempfile.TemporaryDirectory() as folder:
        manifest = os.path.join(folder, "manifest.json")
        with open(manifest, "w", encoding="utf-8") as f:
            json.dump([{"name": row.name, "modules": modules_of(worker, row, folder)} for row in rows], f)
        program = subprocess.Popen([options.program, manifest, options.keep or os.path.join(folder, "capsules"), options.seconds], stdout=subprocess.PIPE, text=True)
        for line in program.stdout:
            result = json.loads(line)
            wrong = faults_of(result)
            if wrong:
                bad.append(result["name"])
            said = "; ".join(wrong) or f"{result['triangles']} of {result['triangles_before']} triangles, {result['bytes']} bytes, {result['captured']} of {REPLAYS} replays"
            print(f"{result['name']}: {result['picture']}, {result.get('pass')}: {said} ({result.get('reduce_s', 0):.1f} s, {result.get('tried', 0)} pictures)", flush=True)
        if program.wait() != 0:
            bad.append(f"the program ended with {program.returncode}")
    print(f"capsule_plants: {len(rows)} planted faults, {len(bad)} without a good capsule{': ' if bad else ''}{', '.join(bad)}")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
