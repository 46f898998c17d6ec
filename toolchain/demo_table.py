#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The table that demo.sh closes on, from the reports of `plumb render --json` and the verdicts of `plumb verify`.

usage: demo_table.py PICTURES.txt OUT
"""
import json
import os
import sys

def row_of(name, out):
    with open(os.path.join(out, name + ".verdict"), encoding="utf-8") as f:
        verdict = f.read().strip()
    try:
        with open(os.path.join(out, name + ".json"), encoding="utf-8") as f:
            report = json.load(f)
    except (OSError, ValueError):
        return [name, "-", "-", "no report", "-", verdict], None
    if isinstance(report, list):
        report = report[0]
    size = report["image"]["size"]
    times = report["time_ms"]
    passes = times["passes"]
    return [name, "x".join(str(n) for n in size), str(report["scene"]["triangles"]),
            "  ".join(f"{key} {value:.1f}" for key, value in passes.items()), f"{times['total']:.0f}", verdict], report["device"]


def main():
    pictures, out = sys.argv[1:]
    with open(pictures, encoding="utf-8") as f:
        names = [line.split()[0] for line in f if line.strip() and not line.startswith("#")]
    rows = [["scene", "size", "triangles", "passes run, ms of each", "total ms", "twin"]]
    device = None
    for name in names:
        row, on = row_of(name, out)
        rows.append(row)
        device = on or device
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    print()
    for row in rows:
        right = (2, 4)  # numbers
        print("  ".join(cell.rjust(w) if i in right else cell.ljust(w) for i, (cell, w) in enumerate(zip(row, widths))).rstrip())
    if device:
        print(f"\nDrawn by {device['name']}, pictures in {out}/. On a first run the time of a pass holds the compilation of its shader.\n"
              "twin: the planes of the CPU twin and of the device, compared byte for byte.")


if __name__ == "__main__":
    main()
