#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""How the cost of a picture grows: runs `plumb bench passes` for rising numbers of triangles, pixels and lights, on one thread and on two.

Each point is a process of its own, so that its peak memory is its own. The slope of log time over log work is taken above the fixed cost (what the
line through the two smallest points has at no work) and only where a picture takes at least twice that; the goal is at most 1.05.

usage: bench_growth.py PLUMB OUT.json [--repeat N] [--small]     --small: tiny points only, to see that it runs
       bench_growth.py --svg OUT.json PICTURE.svg
"""
import json
import math
import os
import subprocess
import sys

SLOPE_GOAL = 1.05
FULL = "1920x1080"
AXES = [
    ("triangles", [(n, f"sphere{n:.0e}".replace("e+0", "e"), FULL) for n in (1e3, 1e4, 1e5, 1e6, 1e7)]),
    ("pixels", [(w * h, "sphere1e5", f"{w}x{h}") for w, h in ((432, 240), (1360, 760), (4272, 2400), (10672, 6000))]),
    ("lights", [(n, f"lights{n}", FULL) for n in (1, 2, 4, 8, 16, 32, 64)]),
]
SMALL = [
    ("triangles", [(1e3, "sphere1e3", "64x48"), (1e4, "sphere1e4", "64x48")]),
    ("pixels", [(64 * 48, "sphere1e3", "64x48"), (640 * 480, "sphere1e3", "640x480")]),
    ("lights", [(1, "lights1", "64x48"), (64, "lights64", "64x48")]),
]


def measure(plumb, row, size, threads, repeat):
    environment = dict(os.environ, LP_NUM_THREADS=str(threads))
    command = [plumb, "bench", "passes", row, "--size", size, "--repeat", str(repeat), "--json", "--quiet"]
    report = json.loads(subprocess.run(command, env=environment, check=True, stdout=subprocess.PIPE).stdout)
    row = report["rows"][0]
    return {"ms": row["ms"], "passes_ms": row["passes_ms"], "resident": row["resident"], "peak_bytes": report["memory"]["peak_bytes"],
            "device_peak_bytes": report["memory"]["device_peak_bytes"]}, {k: report[k] for k in ("tool", "host", "device")}


def slopes_of(points):
    """(fixed cost in ms, [(from work, to work, slope or None where the fixed cost hides it)])."""
    (w0, t0), (w1, t1) = points[0], points[1]
    fixed = max(0.0, t0 - w0 * (t1 - t0) / (w1 - w0))
    slopes = []
    for (wa, ta), (wb, tb) in zip(points, points[1:]):
        clear = tb >= 2 * fixed and ta > fixed
        slopes.append((wa, wb, math.log((tb - fixed) / (ta - fixed)) / math.log(wb / wa) if clear and tb > fixed else None))
    return fixed, slopes


def run(plumb, out, repeat, axes):
    report = {"bench": "growth", "slope_goal": SLOPE_GOAL, "curves": []}
    for name, points in axes:
        for threads in (1, 2):
            curve = {"axis": name, "threads": threads, "points": []}
            for work, row, size in points:
                point, context = measure(plumb, row, size, threads, max(3, repeat if work < 5e6 else repeat // 3))
                report.update(context)
                curve["points"].append({"work": work, "row": row, "size": size, **point})
                print(f"{name:10} {threads} thread{'s' if threads > 1 else ' '} {work:>10.0f}  {point['ms']['median']:>10.2f} ms  {point['peak_bytes'] / 2**20:>7.0f} MiB", file=sys.stderr)
            curve["fixed_ms"], steps = slopes_of([(p["work"], p["ms"]["median"]) for p in curve["points"]])
            curve["slopes"] = [{"from": a, "to": b, "slope": s} for a, b, s in steps]
            report["curves"].append(curve)
    with open(out + ".part", "w", encoding="utf-8") as f:
        json.dump(report, f, indent=1)
    os.replace(out + ".part", out)


def short(x):
    for unit, size in (("M", 1e6), ("k", 1e3)):
        if x >= size:
            return f"{x / size:g}{unit}" if x / size >= 1 and x % size == 0 else f"{x / size:.1f}{unit}"
    return f"{x:g}"


def svg_of(report):
    """One panel an axis, both scales logarithmic, a grey line of slope 1 through the last point of the faster curve."""
    width, height, left, top = 250, 220, 48, 30
    axes = []
    for curve in report["curves"]:
        if curve["axis"] not in axes:
            axes.append(curve["axis"])
    every = [p["ms"]["median"] for c in report["curves"] for p in c["points"]]
    low, high = math.floor(math.log10(min(every))), math.ceil(math.log10(max(every)))
    y_of = lambda ms: top + height * (high - math.log10(ms)) / (high - low)
    parts = []
    for panel, axis in enumerate(axes):
        curves = [c for c in report["curves"] if c["axis"] == axis]
        works = [math.log10(p["work"]) for c in curves for p in c["points"]]
        first, last = min(works), max(works)
        base = left + panel * (width + left + 12)
        x_of = lambda work: base + width * (math.log10(work) - first) / (last - first)
        parts.append(f'<rect x="{base}" y="{top}" width="{width}" height="{height}" fill="none" stroke="#999"/>')
        for power in range(low, high + 1):
            y = y_of(10.0**power)
            parts.append(f'<line x1="{base}" y1="{y:.1f}" x2="{base + width}" y2="{y:.1f}" stroke="#ddd"/><text x="{base - 6}" y="{y + 4:.1f}" text-anchor="end">{10.0**power:g}</text>')
        for p in curves[0]["points"]:
            parts.append(f'<text x="{x_of(p["work"]):.1f}" y="{top + height + 16}" text-anchor="middle">{short(p["work"])}</text>')
        parts.append(f'<text x="{base + width / 2}" y="{top + height + 34}" text-anchor="middle">{axis}</text>')
        for curve, colour in zip(curves, ("#0072b2", "#d55e00")):
            points = [(x_of(p["work"]), y_of(p["ms"]["median"])) for p in curve["points"]]
            parts.append(f'<polyline fill="none" stroke="{colour}" stroke-width="2" points="{" ".join(f"{x:.1f},{y:.1f}" for x, y in points)}"/>')
            for (x, y), p in zip(points, curve["points"]):
                low10, high10 = y_of(p["ms"]["p90"]), y_of(p["ms"]["p10"])
                parts.append(f'<line x1="{x:.1f}" y1="{low10:.1f}" x2="{x:.1f}" y2="{high10:.1f}" stroke="{colour}"/><circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="{colour}"/>')
            parts.append(f'<text x="{base + 8}" y="{top + 16 + 15 * curves.index(curve)}" fill="{colour}">{curve["threads"]} thread{"s" if curve["threads"] > 1 else ""}</text>')
        end = curves[-1]["points"][-1]
        at, ms = math.log10(end["work"]), math.log10(end["ms"]["median"])
        reach = min(last - first, ms - low)
        parts.append(f'<line x1="{x_of(10 ** (at - reach)):.1f}" y1="{y_of(10 ** (ms - reach)):.1f}" x2="{x_of(end["work"]):.1f}" y2="{y_of(10**ms):.1f}" stroke="#777" stroke-dasharray="4 3"/>')
    total = left + len(axes) * (width + left + 12)
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {total} {top + height + 44}" font-family="sans-serif" font-size="11">'
            f'<rect width="100%" height="100%" fill="white"/><text x="{left}" y="18">time of a picture in ms over triangles, pixels and lights; dashed: slope 1</text>' + "".join(parts) + "</svg>\n")


def main():
    words = sys.argv[1:]
    if len(words) == 3 and words[0] == "--svg":
        with open(words[1], encoding="utf-8") as f:
            text = svg_of(json.load(f))
        with open(words[2] + ".part", "w", encoding="utf-8") as f:
            f.write(text)
        os.replace(words[2] + ".part", words[2])
        return
    small = "--small" in words
    repeat = 15
    if "--repeat" in words:
        at = words.index("--repeat")
        repeat = int(words[at + 1])
        del words[at:at + 2]
    words = [w for w in words if w != "--small"]
    if len(words) != 2:
        sys.exit(__doc__.strip())
    run(words[0], words[1], 3 if small else min(repeat, 15), SMALL if small else AXES)


if __name__ == "__main__":
    main()
