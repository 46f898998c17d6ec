#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Prints the reports of `plumb bench` beside the goals of docs/goals.csv, and with --write makes docs/performance.md of them.

A goal is a ratio. `reached`: the median is at least the goal; `near`: at least nine tenths of it; `short`: less.
The page is made of tables and a few facts, and its first ten lines are drawn from the tables. So its text can be made anew
from a page that was measured before.

usage: bench_table.py [--write] [--small] FOLDER     raster.json, matrix.json, trace.json, growth.json, start.json and process.json of toolchain/bench.sh
                                                     --small: sizes of a test, which reach no row of the goals
       bench_table.py --again PAGE                   writes the text of PAGE anew around the tables that stand in it
       bench_table.py --check PAGE                   exit 1 when the text of PAGE is not the one for its tables
       bench_table.py --self-test                    exit 1 when a line of the page says something else than its table
"""
import csv
import json
import os
import re
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


# The tables of the page in its order.
TABLES = ("raster", "matrix", "trace", "process", "growth", "start", "parts")
# What the page says outside its tables, each with the place where it stands.
FACTS = {"context": r"^(.*; plumb \S+ \(\w+\))$", "size": r"^(\d+x\d+), per-pixel Phong", "raster_pairs": r"(\d+) interleaved pairs; the picture",
         "trace_pairs": r"same rays\. (\d+) interleaved pairs", "slope_goal": r"goal: at most ([\d.]+)\."}


def records(rows):
    return [dict(zip(rows[0], row)) for row in rows[1:]]


def number(cell):
    return float(cell.split()[0])


def power(cell):
    """1e6 as the documents write it: 10^6."""
    mantissa, exponent = cell.split("e")
    return f"10^{exponent}" if mantissa == "1" else f"{float(cell):.0f}"


def range_of(values, digits=2):
    return f"{min(values):.{digits}f}" if min(values) == max(values) else f"{min(values):.{digits}f} to {max(values):.{digits}f}"


def against_goal(row, column):
    goal = f" (goal {row['goal']}: {row['verdict']})" if row["goal"] else ""
    return row[column].split()[0] + goal


def goal_lines(tables):
    words = [row["verdict"] for name in ("raster", "matrix", "trace", "start") for row in records(tables[name]) if row["verdict"]]
    if words:
        count = {word: words.count(word) for word in ("reached", "near", "short")}
        yield f"**Goals.** Of {len(words)} goals: {count['reached']} reached, {count['near']} near, {count['short']} short."


def raster_lines(tables):
    rows = records(tables["raster"])
    if not rows:
        return
    ratios = [number(row["ratio"]) for row in rows]
    faster = sum(ratio > 1 for ratio in ratios)
    yield (f"**Raster.** The passes are faster than the device's own graphics pipeline in {faster} of {len(rows)} scenes. "
           f"They are {range_of(ratios)} times as fast.")
    coverage = max(int(number(row["coverage differs"])) for row in rows)
    levels = max(int(row["levels"]) for row in rows)
    yield f"**The same picture.** Between the two, at most {coverage} pixels of a scene differ in coverage, and colours differ by at most {levels} of 255."


def matrix_lines(tables):
    rows = [dict(row, count=row["work"].split()[1], kind=row["work"].split()[0]) for row in records(tables["matrix"])]
    for kind, said in (("vertices", "**Vertices.** Transforming {} vertices by one matrix runs"), ("chain", "**Chains.** Multiplying {} matrices runs")):
        goals = [row for row in rows if row["kind"] == kind and row["goal"]]
        for row in goals:
            yield f"{said.format(power(row['count']))} on the device at {against_goal(row, 'against GLM')} of GLM's speed."
    device = [row for row in rows if row["way"].startswith("device") and row["against GLM"]]
    if not device:
        return
    wins = {kind: [row["count"] for row in device if row["kind"] == kind and number(row["against GLM"]) > 1] for kind in ("vertices", "chain")}
    where = [f"{name} from {power(min(wins[kind], key=float))}" if wins[kind] else f"{name} at no size"
             for kind, name in (("vertices", "vertices"), ("chain", "chains"))]
    yield f"**Small arrays.** A call of the device takes {min(number(row['ms']) for row in device):.2f} ms at least. It beats GLM with {' and '.join(where)}."


def trace_lines(tables):
    rows = records(tables["trace"])
    for stem, said in (("spheres", "**Rays at spheres.** Scenes of {} spheres run at {} times the speed of plain C++."),
                       ("mesh", "**Rays at meshes.** Meshes of {} triangles run at {} times the speed of Embree's rtcIntersect1.")):
        ours = [row for row in rows if row["row"].startswith(stem) and "ROBUST" not in row["theirs"]]
        if ours:
            yield said.format(" and ".join(row["objects"] for row in ours), " and ".join(against_goal(row, "ratio") for row in ours))


def growth_lines(tables):
    rows = records(tables["growth"])
    steps = [row["slope from the one before"].split()[1] for row in rows if row["slope from the one before"]]
    most = max((row for row in rows if row["axis"] == "triangles"), key=lambda row: (float(row["work"]), int(row["threads"])))
    size = power(f"{float(most['work']):.0e}".replace("e+0", "e"))
    slopes = f" Time grows in proportion to the work, or slower, in {steps.count('reached')} of {len(steps)} steps." if steps else ""
    yield f"**Growth.** A picture of {size} triangles takes {number(most['ms']):.0f} ms on {most['threads']} threads and {most['peak MiB']} MiB.{slopes}"


def start_lines(tables):
    rows = {row["program"]: row for row in records(tables["start"])}
    other = next((name for name in rows if name.endswith(" / plumb warm")), None)
    beside = f" The fastest other program, {other.split(' / ')[0]}, takes {number(rows[other]['seconds']):.1f} times as long." if other else ""
    yield (f"**Start.** From exec to PNG takes {number(rows['plumb warm']['seconds']):.2f} s, and {number(rows['plumb cold']['seconds']):.2f} s "
           f"with an empty shader cache.{beside}")


def takeaways(tables):
    """The lines that a reader takes away, from the cells of the tables and nothing else."""
    return [line for part in (goal_lines, raster_lines, matrix_lines, trace_lines, growth_lines, start_lines) for line in part(tables)]


def page(facts, tables):
    lines = "\n".join("- " + line for line in takeaways(tables))
    text = {name: markdown(rows) for name, rows in tables.items()}
    return f"""# Performance

{lines}

Made by `toolchain/bench.sh --write` from the reports of `plumb bench`; do not edit. Goals: [goals.csv](goals.csv). A goal is a ratio: it is
*reached* when the median is at least the goal, *near* from nine tenths of it on, else *short*. Numbers of one row belong together. Absolute
times of different runs do not, since a shared machine drifts.

{facts["context"]}

## Raster: the passes against the same device's graphics pipeline

{facts["size"]}, per-pixel Phong, back faces culled, {facts["raster_pairs"]} interleaved pairs; the picture in memory of the host on both sides.
Ratio above 1: the passes are faster. Each figure is a median [10 %..90 %]; "of the least" is the ratio of the two shortest times.
Coverage may differ only within 1/256 pixel of an edge (checked in the same run). "Levels" is the largest difference of a colour, in steps of 1/255.

{text["raster"]}
## Matrix throughput

"Error, u": against long double, in units of 2^-24 of the result's largest entry. "Of the bound": share of the speed that the memory's bandwidth
allows, measured in the same rounds. "Of the device's ceiling": share of the speed of a kernel of the same shape that only loads and stores (vertices)
or only loads (chains). All ways of a row read and write the same arrays of vertices.

{text["matrix"]}
## Rays

Spheres: mirrors over a board that mirrors a little, one lamp with shadow rays, depth 5, against the same algorithm in plain C++.
Meshes: primary rays alone, against Embree's rtcIntersect1 on the same rays. {facts["trace_pairs"]} interleaved pairs. Ratio above 1: ours is faster.
Mray/s of ours, shadow rays counted.

{text["trace"]}
Whole processes, interleaved: the scene of the notes' C program at 1200x1200 from file to PNG.

{text["process"]}
## How cost grows

![Time of a picture over triangles, pixels and lights, on one and two threads](images/growth.svg)

The passes alone, the scene resident, medians. Triangles: spheres at 1920x1080. Pixels: a sphere of 10^5 triangles. Lights: the same sphere under
directional and point lights in turn. The slope is that of log time over log work above the fixed cost, where a picture takes at least twice that;
goal: at most {facts["slope_goal"]}. Each point is a process of its own; its peak memory includes the scene's making.

{text["growth"]}
## From exec to a written PNG

Suzanne, 3936 triangles, three lights, 640x480; a new process each time. The others draw the same mesh from the same viewpoint, with their own shading.

{text["start"]}
{text["parts"]}"""


def read_page(text):
    """(facts, tables) of a page; what page() wrote comes back as it was."""
    facts = {}
    for name, place in FACTS.items():
        found = re.search(place, text.replace("same\nrays", "same rays"), re.M)
        if not found:
            sys.exit(f"bench_table.py: the page does not say its {name}")
        facts[name] = found.group(1)
    blocks = re.findall(r"^\|.*\n(?:\|.*\n?)*", text, re.M)
    if len(blocks) != len(TABLES):
        sys.exit(f"bench_table.py: the page has {len(blocks)} tables, not {len(TABLES)}")
    tables = {}
    for name, block in zip(TABLES, blocks):
        rows = [line[2:-2].split(" | ") for line in block.splitlines()]
        tables[name] = [rows[0]] + rows[2:]
    return facts, tables


def write(path, text):
    with open(path + ".part", "w", encoding="utf-8") as f:
        f.write(text)
    os.replace(path + ".part", path)


SAMPLE = {
    "raster": [["row", "triangles", "ratio", "goal", "verdict", "coverage differs", "levels"],
               ["a", "10", "0.90 [0.80..0.95]", "1", "near", "4 of 100", "2"], ["b", "20", "3.50 [3.00..4.00]", "2", "reached", "0 of 50", "1"]],
    "matrix": [["work", "way", "ms", "against GLM", "goal", "verdict"], ["vertices 1e3", "device, load and store alone", "0.050 [0.040..0.060]", "", "", ""],
               ["vertices 1e6", "device, one composite", "3.000 [2.000..4.000]", "0.36 [0.30..0.40]", "0.42", "short"],
               ["chain 7e0", "device, tree of 1024", "0.170 [0.160..0.180]", "0.00 [0.00..0.00]", "", ""],
               ["chain 1e5", "device, tree of 1024", "1.000 [0.900..1.100]", "1.56 [1.20..1.90]", "", ""],
               ["chain 1e6", "device, tree of 1024", "4.000 [3.900..4.100]", "3.68 [2.60..4.28]", "4", "near"],
               ["chain 1e6", "GLM, sequential", "14.000 [13.900..14.100]", "1.00 [1.00..1.00]", "", ""],
               ["chain 1e6", "absent: device, sequential: too long", "", "", "", ""]],
    "trace": [["row", "objects", "theirs", "ratio", "goal", "verdict"], ["spheres4", "4", "C++, 2 threads", "1.17 [1.09..1.29]", "1.3", "near"],
              ["mesh1e5 embree", "99856", "Embree rtcIntersect1", "1.50 [1.43..1.55]", "1.1", "reached"],
              ["mesh1e5 embree-robust", "99856", "Embree rtcIntersect1, ROBUST", "1.71 [1.56..1.83]", "", ""]],
    "process": [["program", "seconds", "MiB"], ["plumb", "0.15 [0.13..0.15]", "95"]],
    "growth": [["axis", "threads", "work", "ms", "peak MiB", "slope from the one before"], ["triangles", "1", "10000000", "300.00 [1.00..400.00]", "2536", "0.72 reached"],
               ["triangles", "2", "10000000", "155.82 [153.73..196.04]", "2537", "1.85 short"], ["lights", "2", "64", "79.18 [73.64..82.88]", "117", ""]],
    "start": [["program", "settings", "seconds", "goal", "verdict"], ["plumb cold", "", "0.573 [0.501..0.602]", "", ""],
              ["plumb warm", "", "0.129 [0.106..0.138]", "0.148 s", "reached"], ["f3d / plumb warm", "", "3.30", "3", "reached"]],
    "parts": [["part, ms", "load", "total"], ["warm", "4.9", "113.1"]],
}
SAMPLE_LINES = """\
**Goals.** Of 8 goals: 4 reached, 3 near, 1 short.
**Raster.** The passes are faster than the device's own graphics pipeline in 1 of 2 scenes. They are 0.90 to 3.50 times as fast.
**The same picture.** Between the two, at most 4 pixels of a scene differ in coverage, and colours differ by at most 2 of 255.
**Vertices.** Transforming 10^6 vertices by one matrix runs on the device at 0.36 (goal 0.42: short) of GLM's speed.
**Chains.** Multiplying 10^6 matrices runs on the device at 3.68 (goal 4: near) of GLM's speed.
**Small arrays.** A call of the device takes 0.17 ms at least. It beats GLM with vertices at no size and chains from 10^5.
**Rays at spheres.** Scenes of 4 spheres run at 1.17 (goal 1.3: near) times the speed of plain C++.
**Rays at meshes.** Meshes of 99856 triangles run at 1.50 (goal 1.1: reached) times the speed of Embree's rtcIntersect1.
**Growth.** A picture of 10^7 triangles takes 156 ms on 2 threads and 2537 MiB. Time grows in proportion to the work, or slower, in 1 of 2 steps.
**Start.** From exec to PNG takes 0.13 s, and 0.57 s with an empty shader cache. The fastest other program, f3d, takes 3.3 times as long.
"""


def self_test():
    facts = {"context": "device; processor, 2 threads; load at the start 0.1; plumb 0.1.0 (93a33eb)", "size": "1920x1080", "raster_pairs": "17",
             "trace_pairs": "18", "slope_goal": "1.05"}
    wrong = [f"not said: {line}" for line in SAMPLE_LINES.splitlines() if line not in takeaways(SAMPLE)]
    wrong += [f"said: {line}" for line in takeaways(SAMPLE) if line not in SAMPLE_LINES.splitlines()]
    text = page(facts, SAMPLE)
    if read_page(text) != (facts, SAMPLE):
        wrong.append("a page that is read back has other facts or tables")
    for old, new in (("1.17 (goal", "1.18 (goal"), ("Of 8 goals", "Of 9 goals"), ("1.17 [1.09", "1.27 [1.09"), ("| 4 of 100", "| 5 of 100"), ("short", "near")):
        changed = text.replace(old, new, 1)
        if changed == text or page(*read_page(changed)) == changed:
            wrong.append(f"a page with \"{new}\" for \"{old}\" goes unnoticed")
    for line in wrong:
        print(line)
    print(f"bench_table --self-test: {len(takeaways(SAMPLE))} lines, {len(wrong)} wrong answers")
    return 1 if wrong else 0


def again(path, check):
    with open(path, encoding="utf-8") as f:
        text = f.read()
    wanted = page(*read_page(text))
    if check and wanted != text:
        sys.exit(f"{path}: its text is not the one for its tables; write it with: toolchain/bench_table.py --again {path}")
    if wanted != text:
        write(path, wanted)


def main():
    if sys.argv[1:] == ["--self-test"]:
        sys.exit(self_test())
    arguments = [a for a in sys.argv[1:] if not a.startswith("--")]
    if len(arguments) != 1:
        sys.exit(__doc__.strip())
    if "--again" in sys.argv[1:] or "--check" in sys.argv[1:]:
        again(arguments[0], "--check" in sys.argv[1:])
        return
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
    tables = {"raster": raster_rows(raster, goals), "matrix": matrix_rows(matrix, goals), "trace": trace_rows(trace, goals),
              "process": process_rows(process) if process else [["program", "seconds", "MiB"]], "growth": growth_rows(growth),
              "start": start_rows(start), "parts": parts_rows(start)}
    tables = {name: [list(row) for row in rows] for name, rows in tables.items()}
    for line in takeaways(tables):
        print(line)
    print()
    for rows in tables.values():
        print(aligned(rows))
    for line in trace["absent"]:
        print("absent:", line)
    if "--write" not in sys.argv[1:]:
        return
    size = raster["rows"][0]["size"]
    facts = {"context": context(raster), "size": f"{size[0]}x{size[1]}", "raster_pairs": str(raster["rows"][0]["pairs"]),
             "trace_pairs": str(trace["rows"][0]["pairs"]), "slope_goal": f"{growth['slope_goal']}"}
    subprocess.run([sys.executable, os.path.join(ROOT, "toolchain", "bench_growth.py"), "--svg", os.path.join(arguments[0], "growth.json"),
                    os.path.join(ROOT, "docs", "images", "growth.svg")], check=True)
    write(os.path.join(ROOT, "docs", "performance.md"), page(facts, tables))


if __name__ == "__main__":
    main()
