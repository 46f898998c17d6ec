#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The fronts of `plumb bench plan` as a picture: for each scene, time as a share of the full plan's over error, of the full plan, the lossless one and each
budget. Bars are the intervals of the ratios.

usage: plan_fronts.py REPORT.json PICTURE.svg
       plan_fronts.py --table REPORT.json     the rows as a Markdown table
"""
import json
import math
import os
import sys

COLUMNS, WIDTH, HEIGHT, LEFT, TOP, GAP = 3, 190, 120, 46, 34, 62
COLOURS = {"full": "#777777", "lossless": "#0072b2", "1/255": "#009e73", "4/255": "#d55e00"}
LEAST_ERROR = 0.1  # steps: below what rounding to bytes costs; where a logarithm begins


def name_of(row):
    return os.path.splitext(os.path.basename(row["name"]))[0]


def points_of(row):
    return [way for way in row["ways"] if not way["absent"] and way["ms"] and way["error"]]


def panel(row, base_x, base_y, high, right):
    parts = [f'<rect x="{base_x}" y="{base_y}" width="{WIDTH}" height="{HEIGHT}" fill="none" stroke="#999"/>',
             f'<text x="{base_x}" y="{base_y - 6}">{name_of(row)}, {row["shading"]}, {row["ways"][0]["ms"]["median"]:.3g} ms</text>']
    x_of = lambda share: base_x + WIDTH * min(share, right) / right
    y_of = lambda steps: base_y + HEIGHT * (high - math.log10(max(steps, LEAST_ERROR))) / (high - math.log10(LEAST_ERROR))
    for share in (0, 0.5, 1):
        parts.append(f'<line x1="{x_of(share):.1f}" y1="{base_y}" x2="{x_of(share):.1f}" y2="{base_y + HEIGHT}" stroke="#e5e5e5"/>'
                     f'<text x="{x_of(share):.1f}" y="{base_y + HEIGHT + 14}" text-anchor="middle">{share:g}</text>')
    for power in range(math.ceil(math.log10(LEAST_ERROR)), high + 1):
        parts.append(f'<line x1="{base_x}" y1="{y_of(10.0 ** power):.1f}" x2="{base_x + WIDTH}" y2="{y_of(10.0 ** power):.1f}" stroke="#e5e5e5"/>'
                     f'<text x="{base_x - 5}" y="{y_of(10.0 ** power) + 4:.1f}" text-anchor="end">{10.0 ** power:g}</text>')
    ways = points_of(row)
    at = [(x_of(way["of_full"]["median"]), y_of(255 * way["error"]["rms"])) for way in ways]
    parts.append('<polyline fill="none" stroke="#bbb" points="' + " ".join(f"{x:.1f},{y:.1f}" for x, y in at) + '"/>')
    for (x, y), way in zip(at, ways):
        interval, colour = way["of_full"], COLOURS[way["name"]]
        low, top = x_of(interval["low"]), x_of(interval["high"] if interval["high"] is not None else right)
        parts.append(f'<line x1="{low:.1f}" y1="{y:.1f}" x2="{top:.1f}" y2="{y:.1f}" stroke="{colour}"/><circle cx="{x:.1f}" cy="{y:.1f}" r="3.5" fill="{colour}"/>')
    return "".join(parts)


def svg_of(report):
    rows = [row for row in report["rows"] if points_of(row)]
    errors = [255 * way["error"]["rms"] for row in rows for way in points_of(row)]
    shares = [way["of_full"]["median"] for row in rows for way in points_of(row)]
    high, right = math.ceil(math.log10(max(max(errors), 1.0))), max(1.1, 1.05 * max(shares))
    lines = (len(rows) + COLUMNS - 1) // COLUMNS
    total_x, total_y = LEFT + COLUMNS * (WIDTH + LEFT), TOP + 16 + lines * (HEIGHT + GAP)
    legend = "".join(f'<circle cx="{LEFT + 268 + 84 * i}" cy="14" r="3.5" fill="{colour}"/><text x="{LEFT + 276 + 84 * i}" y="18">{name}</text>'
                     for i, (name, colour) in enumerate(COLOURS.items()))
    panels = "".join(panel(row, LEFT + (i % COLUMNS) * (WIDTH + LEFT), TOP + 22 + (i // COLUMNS) * (HEIGHT + GAP), high, right) for i, row in enumerate(rows))
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {total_x} {total_y}" font-family="sans-serif" font-size="11">'
            f'<rect width="100%" height="100%" fill="white"/><text x="{LEFT}" y="18">time as a share of the full plan, error (rms)</text>{legend}{panels}</svg>\n')


def cell(way):
    if way["absent"]:
        return "absent"
    ratio = way["of_full"]
    text = f'{way["ms"]["median"]:.3g} ms'
    if way["name"] != "full":
        high = "inf" if ratio["high"] is None else f'{ratio["high"]:.2f}'
        text = f'{ratio["median"]:.2f} [{ratio["low"]:.2f}..{high}]'
    return text + (f', {255 * way["error"]["rms"]:.3g}' if way["error"] else "")


def table_of(report):
    names = [way["name"] for way in report["rows"][0]["ways"]]
    lines = ["| scene | " + " | ".join(names) + " | choices within " + names[-1] + " |", "|---" * (len(names) + 2) + "|"]
    for row in report["rows"]:
        last = row["ways"][-1]
        lines.append(f'| `{name_of(row)}` | ' + " | ".join(cell(way) for way in row["ways"]) + f' | {last.get("choices", last["absent"])} |')
    return "\n".join(lines)


def main():
    words = sys.argv[1:]
    if len(words) != 2:
        sys.exit(__doc__.strip().split("\n\n")[-1])
    if words[0] == "--table":
        with open(words[1], encoding="utf-8") as file:
            print(table_of(json.load(file)))
        return
    with open(words[0], encoding="utf-8") as file:
        text = svg_of(json.load(file))
    with open(words[1] + ".part", "w", encoding="utf-8") as file:
        file.write(text)
    os.replace(words[1] + ".part", words[1])


if __name__ == "__main__":
    main()
