#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Vulkan calls that fail: each fallible entry point, with each result, once and from then on, at its n-th call. A picture either has the bytes of a run
without a fault, or there is no file and an exit code that says so. Nothing crashes, hangs or leaves a part of a file behind.

usage: vulkan_faults_test.py PLUMB_FAULTS [--long]    plain: n drawn from the calls of a run; --long: every n
"""
import concurrent.futures
import hashlib
import os
import random
import subprocess
import sys
import tempfile

PROGRAM = os.path.abspath(sys.argv[1])
LONG = "--long" in sys.argv or os.environ.get("PLUMB_LONG") == "1"
SCENE = os.path.abspath(os.path.join(os.path.dirname(__file__), "../../scenes/pyramid.toml"))
# VK_ERROR_OUT_OF_HOST_MEMORY, _OUT_OF_DEVICE_MEMORY, _INITIALIZATION_FAILED, _DEVICE_LOST, _UNKNOWN; and VK_TIMEOUT, VK_NOT_READY of what waits.
RESULTS, WAITS = (-1, -2, -3, -4, -13), {"vkWaitForFences": 2, "vkGetQueryPoolResults": 1}
ENDS = (4, 5)  # no device, or render failed
USUAL, LARGE = "40x30", "640x480"  # a wait that fails at once leaves work in flight only where there is enough of it
SIZE = {"vkWaitForFences": LARGE}
TIMEOUT_S = 60


def run(folder, fault, size=USUAL):
    """(exit code, digest of the picture or None, names left in the folder, what was said, {entry: (calls, failed)})"""
    report = os.path.join(folder, "calls")
    picture = os.path.join(folder, "a.png")
    # Validation would see the calls that were not made.
    environment = dict(os.environ, PLUMB_VULKAN_FAULT=fault, PLUMB_VULKAN_CALLS=report, PLUMB_VALIDATION="0")
    try:
        done = subprocess.run([PROGRAM, "render", SCENE, "--size", size, "--shading", "phong", "-o", picture], capture_output=True, text=True,
                              env=environment, timeout=TIMEOUT_S)
        code, said = done.returncode, done.stderr
    except subprocess.TimeoutExpired:
        code, said = "hangs", ""
    counted = {}
    if os.path.exists(report):
        with open(report, encoding="utf-8") as f:
            counted = {name: (int(all_), int(failed)) for name, all_, failed in map(str.split, f)}
        os.remove(report)
    digest = None
    if os.path.exists(picture):
        with open(picture, "rb") as f:
            digest = hashlib.sha256(f.read()).hexdigest()
        os.remove(picture)
    left = os.listdir(folder)
    for name in left:
        os.remove(os.path.join(folder, name))
    return code, digest, left, said, counted


def main():
    base = tempfile.TemporaryDirectory()
    with tempfile.TemporaryDirectory() as folder:
        code, want, _, said, counted = run(folder, "all:0:0:once")
    if code != 0 or want is None or len(counted) < 20:
        print(f"without a fault: exit {code}, {len(counted)} entry points watched: {said}")
        return 1
    wanted = {USUAL: want}
    with tempfile.TemporaryDirectory() as folder:
        wanted[LARGE] = run(folder, "", LARGE)[1]
    choice = random.Random(20)
    jobs = []
    for entry, (calls, _) in sorted(counted.items()):
        for result in RESULTS + ((WAITS[entry],) if entry in WAITS else ()):
            for mode in ("once", "sticky"):
                numbers = range(1, calls + 1) if LONG else [choice.randint(1, calls)] if calls else []
                jobs += [(entry, number, result, mode) for number in numbers]
    never = sorted(name for name, (calls, _) in counted.items() if calls == 0)

    def judge(job):
        entry, number, result, mode = job
        fault = f"{entry}:{number}:{result}:{mode}"
        with tempfile.TemporaryDirectory(dir=base.name) as folder:
            code, digest, left, said, count = run(folder, fault, SIZE.get(entry, USUAL))
        fired = count.get(entry, (0, 0))[1]
        wrong = []
        if isinstance(code, str) or code < 0:
            wrong.append(f"ends by {code}")
        elif code == 0 and digest != wanted[SIZE.get(entry, USUAL)]:
            wrong.append("exit 0 with other bytes" if digest else "exit 0 without a picture")
        elif code != 0 and digest is not None:
            wrong.append(f"exit {code} with a picture")
        elif code not in (0,) + ENDS:
            wrong.append(f"exit {code}")
        if left:
            wrong.append(f"leaves {', '.join(left)}")
        if fired == 0 and not wrong:
            wrong.append("the fault never came")
        return fault, wrong, said, code

    faults, ends = 0, {}
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for fault, wrong, said, code in pool.map(judge, jobs):
            ends[code] = ends.get(code, 0) + 1
            if wrong:
                faults += 1
                print(f"{fault}: {'; '.join(wrong)}: {said.strip()[-200:]}", flush=True)
    print(f"vulkan_faults: {len(jobs)} faults at {len(counted) - len(never)} entry points, ends {ends}, {faults} wrong"
          + (f"; never called: {', '.join(never)}" if never else ""))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
