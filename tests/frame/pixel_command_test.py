#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""`plumb pixel`: random pixels of the committed scenes recomputed with exact fractions, the columns of both sides, wrong faces explained, the worked examples of
sections 12 and 14 read from its JSON, refusals.

usage: pixel_command_test.py PLUMB SOURCE [PIXELS]      PIXELS: how many are recomputed, 240 unless told
"""
import json
import os
import random
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from exact_chain import faults_of  # noqa: E402

PLUMB, SOURCE = sys.argv[1], sys.argv[2]
PIXELS = int(sys.argv[3]) if len(sys.argv) > 3 else 240
# Scenes and choices; every shading, several samples, affine and unnormalised attributes, 4 sub-pixel bits, a point light, a distant viewer.
DRAWN = [
    "suzanne.toml --size 160x120", "suzanne.toml --size 97x61 --samples 4", "cornell.toml --size 80x80 --shading phong", "mug.toml --size 96x72 --shading phong",
    "teapot.toml --size 96x72 --shading phong", "still-life.toml --size 96x72 --fill exact --shading phong", "pyramid.toml --fill exact --size 200x200",
    "cylinder.toml --fill exact --shading gouraud --size 120x120", "cylinder.toml --fill exact --shading phong --size 120x120", "pyramid.toml --fill exact --shading unlit --size 100x100",
    "lamp-and-occluder.toml --size 96x72 --shading phong", "suzanne.toml --size 80x60 --shading gouraud", "suzanne.toml --size 80x60 --trade interpolation=affine",
    "suzanne.toml --size 80x60 --trade subpixel=4", "suzanne.toml --size 80x60 --trade normals=as-interpolated", "mug.toml --size 64x48 --shading flat",
    "suzanne.toml --size 80x60 --viewer distant",
    "four-spheres.toml --size 96x64", "mirrors.toml --size 96x60", "lamp-and-occluder.toml --size 64x48 --shading ray", "four-spheres.toml --size 48x32 --samples 4",
]
WRONG = [("suzanne.toml", size) for size in ("320x240", "400x300", "640x480")] + [("mug.toml", "320x240"), ("teapot.toml", "400x300")]

faults = []


def check(holds, what):
    if not holds:
        faults.append(what)


def run(*words):
    return subprocess.run([PLUMB, *words], capture_output=True, text=True)


def scene_of(name):
    return os.path.join(SOURCE, "scenes", name)


def pixels_of(words, pixels):
    name, *flags = words.split()
    made = run("pixel", scene_of(name), *pixels, *flags, "--json", "-q")
    if made.returncode != 0:
        faults.append(f"plumb pixel {words}: exit {made.returncode}: {made.stderr.strip()}")
        return None
    return json.loads(made.stdout)


def size_of(words):
    name, *flags = words.split()
    if "--size" in flags:
        return [int(n) for n in flags[flags.index("--size") + 1].split("x")]
    return [400, 400]


def recompute():
    chance, recomputed, values, covered = random.Random(17), 0, 0, 0
    each = -(-PIXELS // len(DRAWN))
    for words in DRAWN:
        width, height = size_of(words)
        wanted = [f"{chance.randrange(width // 6, width - width // 6)},{chance.randrange(height // 6, height - height // 6)}" for _ in range(each)]
        report = pixels_of(words, wanted)
        if report is None:
            continue
        for pixel in report["pixels"]:
            found, checked = faults_of(pixel)
            faults.extend(f"{words}: {fault}" for fault in found[:3])
            recomputed += 1
            values += checked
            covered += pixel["shown"]["twin"]["object"] is not None
            check(pixel["explains"][0].startswith("device and twin: the same bits"), f"{words} at {pixel['pixel']}: {pixel['explains']}")
    check(recomputed >= PIXELS, f"{recomputed} pixels were recomputed, not {PIXELS}")
    check(covered > recomputed // 3, f"only {covered} of {recomputed} pixels show something")
    print(f"{recomputed} pixels, {values} values recomputed with exact fractions")


def a_wrong_value_is_noticed():
    report = pixels_of("pyramid.toml --fill exact --shading phong --size 200x200", ["100,195"])
    if report is None:
        return
    for lines in report["pixels"][0]["chains"]:
        for line in lines["lines"]:
            if line["name"] == "bytes":
                line["twin"][1] += 1
    check(faults_of(report["pixels"][0])[0] != [], "a wrong byte goes unnoticed")


def lines_of(chain):
    return {line["name"]: line for line in chain["lines"]}


def sides():
    report = pixels_of("pyramid.toml --fill exact --shading phong --size 200x200", ["100,195"])
    if report is None:
        return
    lines = lines_of(report["pixels"][0]["chains"][0])
    for name in ("r0", "z0", "visible", "n0", "z", "nearest", "pixel_N", "linear", "bytes"):
        check(lines[name]["device"] is not None and lines[name]["device"] == lines[name]["twin"], f"{name}: device {lines[name]['device']}, twin {lines[name]['twin']}")
    for line in lines.values():
        for side in ("textbook", "device", "twin", "truth"):
            check((line[side] is None) == (side in line.get("not_computed", {})), f"{line['name']}: {side} has neither values nor a reason, or both")
            check(line[side] is not None or line["not_computed"][side] != "", f"{line['name']}: {side} has an empty reason")
        if line["truth"] is not None and line["textbook"] is not None and not line.get("decision"):
            for truth, bound, textbook in zip(line["truth"], line["bound"], line["textbook"]):
                rounding = 0.5 if line["name"] == "bytes" else 0  # the textbook's bytes are whole
                check(abs(truth - textbook) <= rounding + 1e-3 * max(1, abs(truth)), f"{line['name']}: textbook {textbook}, truth {truth}")
                check(bound <= 1e-9 * max(1, abs(truth)), f"{line['name']}: bound {bound} of {truth}")
    made = run("pixel", scene_of("pyramid.toml"), "200,310", "--fill", "exact", "--device", "twin", "--json", "-q")
    for line in json.loads(made.stdout)["pixels"][0]["chains"][0]["lines"]:
        check(line["device"] is None and line["not_computed"]["device"] != "", f"{line['name']}: a device that does not draw has values")


def trees():
    """Rays: truth and twin of every line are near each other, the parts of a tree add up to the truth's colour, and a ray may be given."""
    report = pixels_of("lamp-and-occluder.toml --size 64x48 --shading ray", ["32,40", "20,36", "40,30"])
    for pixel in report["pixels"] if report else []:
        lines = lines_of(pixel["chains"][0])
        check(lines["ray1_distance"]["device"] == lines["ray1_distance"]["twin"], f"{pixel['pixel']}: {lines['ray1_distance']}")
        own = lines["ray1_sum"]["truth"]
        for got, want, bound, slack in zip(own, pixel["shown"]["truth"]["linear"], pixel["shown"]["truth"]["linear_bound"], lines["ray1_sum"]["bound"]):
            check(abs(got - want) <= bound + slack, f"{pixel['pixel']}: the tree adds up to {got}, the truth sees {want}")
        for line in lines.values():
            if line["truth"] is None or line["twin"] is None or line.get("decision"):
                continue
            for truth, twin in zip(line["truth"], line["twin"]):
                check(abs(truth - twin) <= (0.5 + 1e-3 if line["name"] == "bytes" else 1e-4 * max(1, abs(truth))), f"{pixel['pixel']} {line['name']}: twin {twin}, truth {truth}")
    report = pixels_of("four-spheres.toml", ["--ray", "0,3,12,0,1,0"])
    if report:
        pixel, lines = report["pixels"][0], lines_of(report["pixels"][0]["chains"][0])
        check(report["size"] == [1, 1] and report["view"] == "ray" and lines["ray1_vector"]["truth"] == [0, -2, -12], f"--ray: {report['size']}, {lines['ray1_vector']}")
        children = [name for name in lines if name.endswith("_T")]
        check(len(children) > 1, f"--ray: a mirror sends no ray on: {children}")


def wrong_faces():
    explained = 0
    for name, size in WRONG:
        made = run("render", scene_of(name), "--size", size, "--shading", "phong", "--with-error", "--json", "-q", "-o", os.path.join(FOLDER, "x.png"))
        error = json.loads(made.stdout)["error"]
        if error["wrongPrimitive"] == 0:
            continue
        x, y = error["wrongPrimitiveAt"]
        report = pixels_of(f"{name} --size {size} --shading phong", [f"{x},{y}"])
        if report is None:
            continue
        pixel = report["pixels"][0]
        check(pixel["shown"]["twin"]["polygon"] != pixel["shown"]["truth"]["polygon"] or pixel["shown"]["twin"]["object"] != pixel["shown"]["truth"]["object"],
              f"{name} {size} at {x},{y}: the wrong face is not seen as one")
        parts = [chain["truth_parts"] for chain in pixel["chains"] if chain["truth_parts"]]
        check(parts != [] and any(parts[0] in sentence for sentence in pixel["explains"]), f"{name} {size} at {x},{y}: {pixel['explains']}")
        explained += 1
    check(explained > 0, "no scene has a wrong face to explain")
    print(f"{explained} wrong faces explained")


def mismatches():
    report = pixels_of("pyramid.toml --fill exact --shading phong --size 200x200 --trade specular=native", ["100,195"])
    if report is None:
        return
    pixel = report["pixels"][0]
    named = pixel["chains"][0]["device_parts"]
    same = pixel["shown"]["device"]["linear"] == pixel["shown"]["twin"]["linear"]
    check(same == (named is None), f"specular=native: linear {pixel['shown']}, first line {named}")
    check(same or named.startswith("linear"), f"specular=native: {named}")


def near(got, want, what):
    for g, w in zip(got, want):
        check(abs(g - w) <= 1e-12 * max(1, abs(w)), f"{what}: {got}, the notes {want}")


def worked_examples():
    """Sections 12 and 14: the polygon of an entry as a scene, its numbers from the JSON."""
    with open(os.path.join(SOURCE, "tests", "data", "worked-examples.json"), encoding="utf-8") as file:
        entries = json.load(file)["examples"]
    read = 0
    for entry in entries:
        given = entry["inputs"]
        want = {check["name"]: check["expected"] for check in entry["checks"]}
        if {"P0", "P1", "P2", "viewpoint"} <= set(given):
            vertices, distance, window = [given["P0"], given["P1"], given["P2"]], -given["viewpoint"][2], (400, 400)
        elif {"vertex", "d", "W", "H"} <= set(given):
            vertices, distance, window = [given["vertex"], [200, 0, 100], [0, 200, 100]], given["d"], (given["W"], given["H"])
        else:
            continue
        path = os.path.join(FOLDER, "entry.toml")
        with open(path, "w", encoding="utf-8") as file:
            file.write(f'handedness = "left"\nsize = [{window[0]}, {window[1]}]\n[camera]\ndistance = {distance}\n[[mesh]]\nname = "m"\nvertices = {vertices}\nfaces = [[0, 1, 2]]\n'
                       '[[object]]\nmesh = "m"\n')
        made = run("pixel", path, "--polygon", "0", "--json", "-q")
        if made.returncode != 0:
            faults.append(f"{entry['id']}: {made.stderr.strip()}")
            continue
        lines = lines_of(json.loads(made.stdout)["pixels"][0]["chains"][0])
        read += 1
        if "vertex" in given:
            near(lines["projected0"]["truth"], want["projected"], entry["id"])
            near(lines["display0"]["truth"], want["display_unrounded"], entry["id"])
            continue
        for name, line in (("P", "P"), ("Q", "Q"), ("N", "N"), ("N_magnitude", "N_length"), ("N_unit", "N_unit"), ("D", "D"), ("result", "NV_minus_D")):
            value = want[name] if isinstance(want[name], list) else [want[name]]
            near(lines[line]["truth"], value, f"{entry['id']} {name}")
        visible = 1.0 if entry["data"]["visible"] else 0.0
        check(lines["visible"]["truth"] == [visible] and lines["visible"]["twin"] in ([visible], None), f"{entry['id']}: {lines['visible']}")
    check(read >= 10, f"only {read} entries were read")


def refusals():
    pyramid = scene_of("pyramid.toml")
    for words, exit_code, said in (
            (("pixel", pyramid, "400,10", "--fill", "exact"), 2, "pixel 400,10 is outside the picture of 400x400: columns are 0 to 399, rows 0 to 399"),
            (("pixel", pyramid, "1,2,3"), 2, "accepted: a pixel as COLUMN,ROW"), (("pixel", pyramid, "-1,2"), 2, ""), (("pixel", pyramid, "1.5,2"), 2, "accepted: a pixel as COLUMN,ROW"),
            (("pixel", pyramid), 2, "nothing is asked for"), (("pixel", pyramid, "--polygon", "5", "--fill", "exact"), 2, "object 0 has 5 polygons, numbered from 0"),
            (("pixel", pyramid, "--vertex", "99", "--fill", "exact"), 2, "--vertex 99"), (("pixel", pyramid, "--polygon", "0", "--object", "cone"), 2, "the scene has no object 'cone'"),
            (("pixel", pyramid, "--polygon", "0", "--vertex", "1"), 2, "exclude each other"), (("pixel", pyramid, "1,1", "--shading", "wire"), 2, "not those of wire frames"),
            (("pixel", pyramid, "1,1", "--fill", "notes"), 2, "not those of wire frames or of --fill notes"), (("pixel", scene_of("mirrors.toml"), "--polygon", "0"), 2, "rays are opened by a pixel"),
            (("pixel", pyramid, "--ray", "0,0,0,0,0,0"), 2, "two different points"), (("pixel", pyramid, "--ray", "1,2,3"), 2, "six finite numbers"),
            (("pixel", pyramid, "1,1", "--ray", "0,0,0,0,0,1"), 2, "leave the pixels out"), (("pixel", pyramid, "--vertex", "0", "--ray", "0,0,0,0,0,1"), 2, "--ray opens what it meets"),
            (("pixel", scene_of("notes-spheres.toml"), "1,1", "--levels", "cut"), 2, "--levels cut"),
            (("pixel", os.path.join(FOLDER, "none.toml"), "1,1"), 3, "none.toml"), (("pixel", pyramid, "1,1", "--view", "front", "--view", "iso"), 2, "give --view once")):
        made = run(*words)
        check(made.returncode == exit_code, f"{' '.join(words[1:])}: exit {made.returncode}, not {exit_code}: {made.stderr}")
        check(made.stdout == "" and len(made.stderr.strip().splitlines()) == 1 and said in made.stderr, f"{' '.join(words[1:])}: {made.stderr!r}")


with tempfile.TemporaryDirectory() as FOLDER:
    recompute()
    a_wrong_value_is_noticed()
    sides()
    trees()
    wrong_faces()
    mismatches()
    worked_examples()
    refusals()
for fault in faults[:40]:
    print(fault)
sys.exit(1 if faults else 0)
