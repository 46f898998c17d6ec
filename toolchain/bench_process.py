#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Whole processes, interleaved: plumb and POV-Ray draw the scene of the notes' C program, from file to PNG. Prints JSON.

usage: bench_process.py PLUMB [--repeat N]
"""
import json
import os
import shutil
import statistics
import sys
import tempfile
import time

ROOT = os.path.abspath(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
SIZE = 1200
# scenes/notes-spheres.toml in POV-Ray's words; left-handed both. The board's squares are those of the notes, mirrored at z = 0, which no ray reaches.
POV = """#version 3.7;
global_settings { assumed_gamma 1.0 max_trace_level 5 ambient_light rgb 1 }
background { rgb <150/255, 150/255, 1> }
camera { location <0, 0, -800> direction <0, 0, 800> right <1200, 0, 0> up <0, 1200, 0> }
#declare Mirror = finish { ambient 0.3 diffuse 0 reflection { 0.7 } }
sphere { <0, -400, 600>, 100 pigment { rgb <120/255, 180/255, 0> } finish { Mirror } }
sphere { <-200, -300, 1000>, 250 pigment { rgb <200/255, 100/255, 100/255> } finish { Mirror } }
polygon { 5, <-1e5, -500, 0>, <1e5, -500, 0>, <1e5, -500, 8000>, <-1e5, -500, 8000>, <-1e5, -500, 0>
  pigment { checker rgb <1, 0, 0>, rgb <1, 1, 1> scale 200 translate <0, -500, 0> } finish { ambient 1 diffuse 0 } }
"""


def run(command):
    """Seconds and largest resident MiB of a process that must succeed."""
    with open(os.devnull, "wb") as null:
        start = time.monotonic()
        pid = os.posix_spawnp(command[0], command, os.environ, file_actions=[(os.POSIX_SPAWN_DUP2, null.fileno(), 1), (os.POSIX_SPAWN_DUP2, null.fileno(), 2)])
        _, status, usage = os.wait4(pid, 0)
        seconds = time.monotonic() - start
    if os.waitstatus_to_exitcode(status) != 0:
        sys.exit(f"bench_process.py: {' '.join(command)} ended with {os.waitstatus_to_exitcode(status)}")
    return seconds, usage.ru_maxrss / 1024


def spread(values):
    values = sorted(values)
    deciles = statistics.quantiles(values, n=10, method="inclusive")
    return {"median": statistics.median(values), "p10": deciles[0], "p90": deciles[-1], "least": values[0], "count": len(values)}


def main():
    arguments = sys.argv[1:]
    if not arguments or (len(arguments) > 1 and (len(arguments) != 3 or arguments[1] != "--repeat")):
        sys.exit(__doc__.strip())
    repeat = max(3, int(arguments[2]) // 5) if len(arguments) == 3 else 10
    report = {"bench": "process", "ways": [], "absent": []}
    with tempfile.TemporaryDirectory() as folder:
        pov = os.path.join(folder, "notes.pov")
        with open(pov, "w", encoding="utf-8") as f:
            f.write(POV)
        scene, out = os.path.join(ROOT, "scenes", "notes-spheres.toml"), os.path.join(folder, "out.png")
        commands = {"plumb": [arguments[0], "render", scene, "-o", out, "-q"], "plumb, CPU twin": [arguments[0], "render", scene, "-o", out, "-q", "--device", "twin"]}
        if shutil.which("povray"):
            commands["POV-Ray"] = ["povray", f"+I{pov}", f"+O{out}", f"+W{SIZE}", f"+H{SIZE}", "-D", "-GA", "-A", f"+WT{os.cpu_count()}"]
        else:
            report["absent"].append("povray is not installed (Debian: povray)")
        results = {name: [] for name in commands}
        for name, command in commands.items():
            run(command)                       # what is cached on disk is warm for all
        for _ in range(repeat):
            for name, command in commands.items():
                results[name].append(run(command))
    for name, values in results.items():
        report["ways"].append({"name": name, "seconds": spread([v[0] for v in values]), "mib": max(v[1] for v in values)})
    print(json.dumps(report, indent=1))


if __name__ == "__main__":
    main()
