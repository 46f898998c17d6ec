#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Prints the reports of `plumb bench` beside the goals of docs/goals.csv, and with --write makes docs/performance.md of them.

A goal is a ratio. `reached`: the median is at least the goal; `near`: at least nine tenths of it; `short`: less.

usage: bench_table.py [--write] RASTER.json MATRIX.json TRACE.json PROCESS.json
"""
import csv
import json
import os
import sys

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")


def goals_of(path):
    with open(path, encoding="utf-8", newline="") as f:
        return {(row["bench"], row["row"]): float(row["goal"]) for row in csv.DictReader(f)}


def verdict(median, goal):
    if goal is None:
        return "", ""
    return f"{goal:g}", "reached" if median >= goal else "near" if median >= 0.9 * goal else "short"


def spread(s, digits=2):
    return f"{s['median']:.{digits}f} [{s['p10']:.{digits}f}..{s['p90']:.{digits}f}]"


def raster_rows(report, goals):
    yield ["row", "triangles", "graphics ms", "passes ms", "ratio", "of the least", "goal", "verdict", "coverage differs", "levels"]
    for row in report["rows"]:
        ratio, agreement = row["ratio"], row["agreement"]
        goal, word = verdict(ratio["median"], goals.get(("raster", row["name"])))
        yield [row["name"], str(row["triangles"]), spread(row["graphics_ms"]), spread(row["compute_ms"]), spread(ratio), f"{row['ratio_of_least']:.2f}", goal, word,
               f"{agreement['coverage_differs']} of {agreement['covered']}", str(agreement["colour_most"])]


def matrix_rows(report, goals):
    yield ["work", "way", "ms", "G/s", "of the bound", "against GLM", "error, u", "goal", "verdict"]
    for table in report["tables"]:
        for way in table["ways"]:
            key = f"{table['work']} {table['count']} {way['name']}".replace(",", "")
            goal, word = verdict(way["against_glm"]["median"], goals.get(("matrix", key)))
            yield [f"{table['work']} {table['count']:.0e}".replace("e+0", "e"), way["name"], spread(way["ms"], 3), f"{way['per_second'] * 1e-9:.3f}",
                   f"{100 * way['share_of_bound']:.0f} %", spread(way["against_glm"]), f"{way['error_u']:.1f}", goal, word]
        for line in table["absent"]:
            yield [f"{table['work']} {table['count']:.0e}".replace("e+0", "e"), "absent: " + line, "", "", "", "", "", "", ""]


def trace_rows(report, goals):
    yield ["row", "objects", "theirs", "theirs ms", "ours ms", "ratio", "of the least", "goal", "verdict", "Mray/s", "dispatch ms", "pixels differ"]
    for row in report["rows"]:
        goal, word = verdict(row["ratio"]["median"], goals.get(("trace", row["name"])))
        yield [row["name"], str(row["objects"]), row["theirs"], spread(row["theirs_ms"]), spread(row["ours_ms"]), spread(row["ratio"]), f"{row['ratio_of_least']:.2f}", goal, word,
               f"{row['rays_per_second'] * 1e-6:.1f}", f"{row['dispatch_ms']:.0f}", str(row["agreement"]["differ"])]


def process_rows(report):
    yield ["program", "seconds", "MiB"]
    for way in report["ways"]:
        yield [way["name"], spread(way["seconds"]), f"{way['mib']:.0f}"]


def aligned(rows):
    rows = list(rows)
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    return "\n".join("  ".join(cell.ljust(w) for cell, w in zip(row, widths)).rstrip() for row in rows) + "\n"


def markdown(rows):
    rows = list(rows)
    lines = ["| " + " | ".join(row) + " |" for row in rows]
    return "\n".join([lines[0], "|" + "---|" * len(rows[0])] + lines[1:]) + "\n"


def context(report):
    host, device = report["host"], report["device"]
    load = ", ".join(f"{x:.2f}" for x in host.get("load", []))
    return (f"{device['name']}, {device.get('driver', '')} {device.get('driverInfo', '')}; {host['cpu_model']}, {host['threads']} threads; load at the start {load}; "
            f"plumb {report['tool']['version']} ({report['tool']['git']})")


def check_goals(reports, goals):
    """A goal whose row is in neither report is a slip of the pen."""
    raster, matrix, trace, _ = reports
    there = {("raster", row["name"]) for row in raster["rows"]}
    there |= {("matrix", f"{t['work']} {t['count']} {w['name']}".replace(",", "")) for t in matrix["tables"] for w in t["ways"]}
    there |= {("trace", row["name"]) for row in trace["rows"]}
    if trace["absent"]:
        goals = {key: goal for key, goal in goals.items() if not key[1].startswith("mesh")}
    missing = sorted(set(goals) - there)
    if missing:
        sys.exit("bench_table.py: docs/goals.csv names rows that were not measured: " + "; ".join(" ".join(m) for m in missing))


def main():
    arguments = [a for a in sys.argv[1:] if a != "--write"]
    if len(arguments) != 4:
        sys.exit(__doc__.strip())
    reports = []
    for path in arguments:
        with open(path, encoding="utf-8") as f:
            reports.append(json.load(f))
    goals = goals_of(os.path.join(ROOT, "docs", "goals.csv"))
    check_goals(reports, goals)
    raster, matrix, trace, process = reports
    print(context(raster))
    print(aligned(raster_rows(raster, goals)))
    print(aligned(matrix_rows(matrix, goals)))
    print(aligned(trace_rows(trace, goals)))
    for line in trace["absent"]:
        print("absent:", line)
    print(aligned(process_rows(process)))
    if "--write" not in sys.argv[1:]:
        return
    size = raster["rows"][0]["size"]
    pairs = raster["rows"][0]["pairs"]
    text = f"""# Performance

Made by `toolchain/bench.sh --write` from the reports of `plumb bench`; do not edit. Goals: [goals.csv](goals.csv). Numbers of one row belong together; absolute
times of different runs do not, since a shared machine drifts.

{context(raster)}

## Raster: the passes against the same device's graphics pipeline

{size[0]}x{size[1]}, per-pixel Phong, back faces culled, {pairs} interleaved pairs; the picture in memory of the host on both sides. Ratio above 1: the passes are faster. Median [10 %..90 %].
Coverage may differ only within 1/256 pixel of an edge (checked in the same run).

{markdown(raster_rows(raster, goals))}
## Matrix throughput

Error against binary64 rounded once, in units of 2^-24 of the result's largest entry. "Of the bound": of what the memory's bandwidth, measured in the same rounds, allows.

{markdown(matrix_rows(matrix, goals))}
## Rays

Spheres: mirrors over a board that mirrors a little, one lamp with feelers, depth 5, against the same algorithm in plain C++. Meshes: primary rays alone, against Embree's rtcIntersect1 on the
same rays. {trace["rows"][0]["pairs"]} interleaved pairs. Ratio above 1: ours is faster. Mray/s of ours, feelers counted.

{markdown(trace_rows(trace, goals))}
Whole processes, interleaved: the scene of the notes' C program at 1200x1200 from file to PNG.

{markdown(process_rows(process))}"""
    out = os.path.join(ROOT, "docs", "performance.md")
    with open(out + ".part", "w", encoding="utf-8") as f:
        f.write(text)
    os.replace(out + ".part", out)


if __name__ == "__main__":
    main()
