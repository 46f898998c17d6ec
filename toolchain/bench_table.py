#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Prints the reports of `plumb bench` beside the goals of docs/goals.csv, and with --write makes docs/performance.md of them.

A goal is a ratio. `reached`: the median is at least the goal; `near`: at least nine tenths of it; `short`: less.

usage: bench_table.py [--write] [--small] FOLDER     raster.json, matrix.json, trace.json, growth.json, start.json and process.json of toolchain/bench.sh
                                                     --small: sizes of a test, which reach no row of the goals
"""
import csv
import json
import os
import subprocess
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
    yield ["work", "way", "ms", "G/s", "of the bound", "of the device's ceiling", "against GLM", "error, u", "goal", "verdict"]
    for table in report["tables"]:
        for way in table["ways"]:
            key = f"{table['work']} {table['count']} {way['name']}".replace(",", "")
            goal, word = ("", "") if way["partial"] else verdict(way["against_glm"]["median"], goals.get(("matrix", key)))
            ceiling = "" if way["of_device"] is None else f"{100 * way['of_device']['median']:.0f} %"
            yield [f"{table['work']} {table['count']:.0e}".replace("e+0", "e"), way["name"], spread(way["ms"], 3), f"{way['per_second'] * 1e-9:.3f}",
                   f"{100 * way['share_of_bound']:.0f} %", ceiling, "" if way["partial"] else spread(way["against_glm"]),
                   "" if way["partial"] else f"{way['error_u']:.1f}", goal, word]
        for line in table["absent"]:
            yield [f"{table['work']} {table['count']:.0e}".replace("e+0", "e"), "absent: " + line, "", "", "", "", "", "", "", ""]


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
    raster, matrix, trace = reports[:3]
    there = {("raster", row["name"]) for row in raster["rows"]}
    there |= {("matrix", f"{t['work']} {t['count']} {w['name']}".replace(",", "")) for t in matrix["tables"] for w in t["ways"]}
    there |= {("trace", row["name"]) for row in trace["rows"]}
    if trace["absent"]:
        goals = {key: goal for key, goal in goals.items() if not key[1].startswith("mesh")}
    missing = sorted(set(goals) - there)
    if missing:
        sys.exit("bench_table.py: docs/goals.csv names rows that were not measured: " + "; ".join(" ".join(m) for m in missing))


def growth_rows(report):
    yield ["axis", "threads", "work", "ms", "peak MiB", "of it device", "slope from the one before"]
    for curve in report["curves"]:
        slopes = {s["to"]: s["slope"] for s in curve["slopes"]}
        for p in curve["points"]:
            slope = slopes.get(p["work"])
            steep = "" if slope is None else f"{slope:.2f} " + ("reached" if slope <= report["slope_goal"] else "short")
            yield [curve["axis"], str(curve["threads"]), f"{p['work']:.0f}", spread(p["ms"]) + ("" if p["resident"] else " (bands or chunks)"),
                   f"{p['peak_bytes'] / 2**20:.0f}", f"{p['device_peak_bytes'] / 2**20:.0f}", steep]


def start_rows(report):
    yield ["program", "settings", "seconds", "peak MiB", "goal", "verdict"]
    rows = {r["name"]: r for r in report["rows"]}
    warm = rows["plumb warm"]
    others = [r for r in report["rows"] if r["name"] not in ("empty", "plumb cold", "plumb warm")]
    for r in report["rows"]:
        goal = word = ""
        if r is warm:
            limit = 3 * rows["empty"]["seconds"]["median"]
            goal = f"{limit:.3f} s, 110 MiB"
            word = "reached" if r["seconds"]["median"] <= limit and r["peak_bytes"] <= 110 * 2**20 else "short"
        yield [r["name"], r["settings"], spread(r["seconds"], 3), f"{r['peak_bytes'] / 2**20:.0f}", goal, word]
    if others:
        fastest = min(others, key=lambda r: r["seconds"]["median"])
        ratio = fastest["seconds"]["median"] / warm["seconds"]["median"]
        yield [f"{fastest['name']} / plumb warm", "the fastest of the others", f"{ratio:.2f}", "", "3", "reached" if ratio >= 3 else "short"]
    for line in report["absent"]:
        yield ["absent", line, "", "", "", ""]


def parts_rows(report):
    yield ["part, ms"] + list(report["parts_ms"]["warm"])
    for name, parts in report["parts_ms"].items():
        yield [name] + [f"{parts[k]:.1f}" for k in report["parts_ms"]["warm"]]


def main():
    arguments = [a for a in sys.argv[1:] if not a.startswith("--")]
    if len(arguments) != 1:
        sys.exit(__doc__.strip())
    reports = []
    for name in ("raster", "matrix", "trace", "growth", "start") + (() if "--small" in sys.argv[1:] else ("process",)):
        with open(os.path.join(arguments[0], name + ".json"), encoding="utf-8") as f:
            reports.append(json.load(f))
    goals = goals_of(os.path.join(ROOT, "docs", "goals.csv"))
    small = "--small" in sys.argv[1:]
    if not small:
        check_goals(reports, goals)
    raster, matrix, trace, growth, start = reports[:5]
    process = None if small else reports[5]
    print(context(raster))
    tables = [raster_rows(raster, goals), matrix_rows(matrix, goals), trace_rows(trace, goals), growth_rows(growth), start_rows(start), parts_rows(start)]
    for rows in tables + ([] if small else [process_rows(process)]):
        print(aligned(rows))
    for line in trace["absent"]:
        print("absent:", line)
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

Error against long double, in units of 2^-24 of the result's largest entry. "Of the bound": of what the memory's bandwidth, measured in the same rounds, allows. "Of the device's ceiling": of the speed of a kernel of
the same shape that only loads and stores (vertices) or only loads (chains). All ways of a row read and write the same arrays of vertices.

{markdown(matrix_rows(matrix, goals))}
## Rays

Spheres: mirrors over a board that mirrors a little, one lamp with feelers, depth 5, against the same algorithm in plain C++. Meshes: primary rays alone, against Embree's rtcIntersect1 on the
same rays. {trace["rows"][0]["pairs"]} interleaved pairs. Ratio above 1: ours is faster. Mray/s of ours, feelers counted.

{markdown(trace_rows(trace, goals))}
Whole processes, interleaved: the scene of the notes' C program at 1200x1200 from file to PNG.

{markdown(process_rows(process))}
## How cost grows

![Time of a picture over triangles, pixels and lights, on one and two threads](images/growth.svg)

The passes alone, the scene resident, medians. Triangles: spheres at 1920x1080; pixels: a sphere of 10^5 triangles; lights: the same sphere under directional and
point lights in turn. The slope is that of log time over log work above the fixed cost, where a picture takes at least twice that; goal: at most {growth['slope_goal']}. Each point is a process of its own;
its peak memory includes the scene's making.

{markdown(growth_rows(growth))}
## From exec to a written PNG

Suzanne, 3936 triangles, three lights, 640x480; a new process each time. The others draw the same mesh from the same place, with their own shading.

{markdown(start_rows(start))}
{markdown(parts_rows(start))}"""
    subprocess.run([sys.executable, os.path.join(ROOT, "toolchain", "bench_growth.py"), "--svg", os.path.join(arguments[0], "growth.json"),
                    os.path.join(ROOT, "docs", "images", "growth.svg")], check=True)
    out = os.path.join(ROOT, "docs", "performance.md")
    with open(out + ".part", "w", encoding="utf-8") as f:
        f.write(text)
    os.replace(out + ".part", out)


if __name__ == "__main__":
    main()
