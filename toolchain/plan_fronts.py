#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The fronts of `plumb bench plan --json` as a picture and as a table: for each scene, time as a share of the lossless plan's over error, of the full plan,
the lossless one and the choices of each budget. Bars are the intervals of the ratios; a hollow point is not told apart from the lossless plan.

usage: plan_fronts.py REPORT.json PICTURE.svg
       plan_fronts.py --table REPORT.json             the rows as a Markdown table
       plan_fronts.py --table REPORT.json PAGE.md     writes it into the page, between the lines "plans" and "end of plans"
"""
import json
import math
import os
import sys
from xml.sax.saxutils import escape

COLUMNS, WIDTH, HEIGHT, LEFT, TOP, GAP = 3, 190, 120, 50, 34, 62
COLOURS = ("#777777", "#0072b2", "#009e73", "#d55e00")  # full, lossless, then the budgets
LEAST_ERROR = 0.1  # steps, where the logarithm begins: less than rounding to bytes costs
MARKS = ("<!-- plans -->", "<!-- end of plans -->")


def name_of(row):
    return os.path.splitext(os.path.basename(row["name"]))[0]


def points_of(row):
    return [(i, way) for i, way in enumerate(row["ways"]) if way["ms"] and way["error"] and way["of_lossless"]]


def apart(way):
    return way["told"] in ("faster", "slower")


def panel(row, base_x, base_y, high, right):
    def x_of(share):
        return base_x + WIDTH * min(share, right) / right

    def y_of(steps):
        return base_y + HEIGHT * (high - math.log10(max(steps, LEAST_ERROR))) / (high - math.log10(LEAST_ERROR))

    parts = [f'<rect x="{base_x}" y="{base_y}" width="{WIDTH}" height="{HEIGHT}" fill="none" stroke="#999"/>',
             f'<text x="{base_x}" y="{base_y - 6}">{escape(name_of(row))}, {row["shading"]}, {row["ways"][1]["ms"]["median"]:.3g} ms</text>']
    for share in (0, 0.5, 1):
        x = x_of(share)
        parts.append(f'<line x1="{x:.1f}" y1="{base_y}" x2="{x:.1f}" y2="{base_y + HEIGHT}" stroke="#e5e5e5"/>'
                     f'<text x="{x:.1f}" y="{base_y + HEIGHT + 14}" text-anchor="middle">{share:g}</text>')
    for power in range(math.ceil(math.log10(LEAST_ERROR)), high + 1):
        y = y_of(10.0 ** power)
        parts.append(f'<line x1="{base_x}" y1="{y:.1f}" x2="{base_x + WIDTH}" y2="{y:.1f}" stroke="#e5e5e5"/>'
                     f'<text x="{base_x - 5}" y="{y + 4:.1f}" text-anchor="end">{10.0 ** power:g}</text>')
    for i, way in points_of(row):
        ratio, colour, y = way["of_lossless"], COLOURS[i], y_of(way["error"]["rms"])
        x, low = x_of(ratio["median"]), x_of(ratio["low"] or 0)
        top = x_of(right if ratio["high"] is None else ratio["high"])
        if i != 1:
            parts.append(f'<line x1="{low:.1f}" y1="{y:.1f}" x2="{top:.1f}" y2="{y:.1f}" stroke="{colour}" stroke-width="1.5"/>')
        parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3.5" fill="{colour if i == 1 or apart(way) else "white"}" stroke="{colour}" stroke-width="1.5"/>')
    return "".join(parts)


def svg_of(report):
    rows = [row for row in report["rows"] if points_of(row)]
    ways = [way for row in rows for _, way in points_of(row)]
    high = math.ceil(math.log10(max([way["error"]["rms"] for way in ways] + [1.0])))
    right = min(2.0, max([1.15] + [1.05 * way["of_lossless"]["median"] for way in ways]))  # what takes longer stands at the edge
    lines = (len(rows) + COLUMNS - 1) // COLUMNS
    total_x, total_y = LEFT + COLUMNS * (WIDTH + LEFT), TOP + 30 + lines * (HEIGHT + GAP)
    names = [way["name"] for way in report["rows"][0]["ways"]]
    names = names[:2] + ["error " + name for name in names[2:]]
    legend = "".join(f'<circle cx="{LEFT + 8 + 110 * i}" cy="32" r="3.5" fill="{colour}"/><text x="{LEFT + 16 + 110 * i}" y="36">{escape(name)}</text>'
                     for i, (name, colour) in enumerate(zip(names, COLOURS)))
    legend += f'<circle cx="{LEFT + 448}" cy="32" r="3.5" fill="white" stroke="#555" stroke-width="1.5"/><text x="{LEFT + 456}" y="36">not told apart</text>'
    panels = "".join(panel(row, LEFT + (i % COLUMNS) * (WIDTH + LEFT), TOP + 36 + (i // COLUMNS) * (HEIGHT + GAP), high, right) for i, row in enumerate(rows))
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {total_x} {total_y}" font-family="sans-serif" font-size="12">'
            f'<rect width="100%" height="100%" fill="white"/>'
            f'<text x="{LEFT}" y="16">across: time, the lossless plan is 1; up: error (rms, steps of 1/255)</text>{legend}{panels}</svg>\n')


def cell(way):
    if way["absent"]:
        return "–"
    error = f', {way["error"]["rms"]:.3g}' if way["error"] else ""
    if way["name"] == "lossless":
        return f'{way["ms"]["median"]:.3g} ms{error}'
    if way["same_as"]:
        return "as lossless"
    ratio = way["of_lossless"]
    if ratio is None:
        return f'{way["ms"]["median"]:.3g} ms{error}'
    return f'{ratio["median"]:.2f}{"" if apart(way) else " (not told apart)"}{error}'


def table_of(report):
    names = [way["name"] for way in report["rows"][0]["ways"]]
    lines = ["| scene | " + " | ".join(names[:2] + ["error " + name for name in names[2:]]) + f" | choices within {names[-1]} |", "|---" * (len(names) + 2) + "|"]
    for row in report["rows"]:
        last = row["ways"][-1]
        lines.append(f'| `{name_of(row)}` | ' + " | ".join(cell(way) for way in row["ways"]) + f' | {last["choices"] or "none"} |')
    return "\n".join(lines)


def write(path, text):
    with open(path + ".part", "w", encoding="utf-8") as file:
        file.write(text)
    os.replace(path + ".part", path)


def put(table, page):
    with open(page, encoding="utf-8") as file:
        text = file.read()
    begin, end = (text.find(mark) for mark in MARKS)
    if begin < 0 or end < begin:
        sys.exit(f"{page}: no lines '{MARKS[0]}' and '{MARKS[1]}'")
    write(page, f"{text[:begin]}{MARKS[0]}\n{table}\n{text[end:]}")


def main():
    words = sys.argv[1:]
    table = words[:1] == ["--table"]
    names = words[1:] if table else words
    if not 1 <= len(names) <= 2 or (len(names) == 1 and not table):
        sys.exit(__doc__.strip().split("\n\n")[-1])
    with open(names[0], encoding="utf-8") as file:
        report = json.load(file)
    if not table:
        write(names[1], svg_of(report))
    elif len(names) == 2:
        put(table_of(report), names[1])
    else:
        print(table_of(report))


if __name__ == "__main__":
    main()
