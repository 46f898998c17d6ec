#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""--detail, the axes tessellation and detail of measure, and --flicker through the command. usage: detail_command_test.py PLUMB SCENES"""
import json
import os
import subprocess
import sys
import tempfile
import unittest

SHAPES = """size = [160, 120]
ambient = 0.2
background = "#203040"
[camera]
eye = [0, 1, 6]
at = [0, 0, 0]
fov = 40
[[light]]
type = "directional"
direction = [1, 1, 1]
intensity = 0.8
[[material]]
name = "shine"
diffuse = [0.6, 0.2, 0.1]
specular = 0.8
shininess = 40
[[mesh]]
name = "ball"
shape = "sphere"
segments = 64
material = "shine"
[[mesh]]
name = "drum"
shape = "cylinder"
radius = 0.6
length = 1.2
segments = 64
material = "shine"
[[object]]
name = "ball"
mesh = "ball"
transform = [{ translate = [-1.2, 0, 0] }]
[[object]]
name = "drum"
mesh = "drum"
transform = [{ rotate_x = 35 }, { translate = [1.2, 0, 0] }]
"""


def run(*words):
    return subprocess.run([PLUMB, *words], capture_output=True, text=True, timeout=120, check=False)


class Detail(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(self.folder.name)
        with open("shapes.toml", "w", encoding="utf-8") as file:
            file.write(SHAPES)
        # Eight sides and smooth normals, as the notes' cylinder has them; it turns about its own axis.
        with open("turn.toml", "w", encoding="utf-8") as file:
            file.write(SHAPES[:SHAPES.index("[[mesh]]")] + '[[mesh]]\nname = "drum"\nshape = "cylinder"\nlength = 3\nsegments = 8\nmaterial = "shine"\n')

    def report(self, *words):
        done = run(*words, "--json")
        self.assertEqual(done.returncode, 0, f"{' '.join(words)}: {done.stderr.strip()}")
        return json.loads(done.stdout)

    def test_the_picture_says_what_was_simplified_and_its_error_is_that_of_the_scene(self):
        suzanne = os.path.join(SCENES, "suzanne.toml")
        words = ("render", suzanne, "--size", "160x120", "--with-error")
        whole = self.report(*words, "-o", "whole.png")
        detail = self.report(*words, "-o", "detail.png", "--detail", "1")
        self.assertTrue("detail" not in whole, "a picture without --detail reports one")
        d = detail["detail"]
        self.assertTrue(d["pixels"] == 1 and d["simplifier"].startswith("meshoptimizer "), str(d))
        self.assertTrue(d["drawnTriangles"] < d["triangles"] / 2, f"{d['drawnTriangles']} of {d['triangles']} triangles")
        self.assertTrue(d["drawnTriangles"] == detail["counters"]["triangles"] and d["triangles"] == whole["counters"]["triangles"], "counters are those of another scene")
        self.assertTrue(d["objects"][0]["name"] == "suzanne" and 0 < d["objects"][0]["pixels"] <= 1, str(d["objects"]))
        self.assertTrue(any(f"'suzanne' is drawn with {d['drawnTriangles']} of {d['triangles']} triangles" in line for line in detail["plan"]["choices"]), "the plan is silent")
        self.assertTrue("detail" in detail["time_ms"], "no time of it")
        # The truth is that of the scene: simplified, the picture is further from it.
        self.assertTrue(detail["error"]["rms"] > 2 * whole["error"]["rms"], f"rms {detail['error']['rms']} simplified, {whole['error']['rms']} whole")
        self.assertTrue(0 < detail["error"]["wrongPrimitiveShare"] < 0.1, str(detail["error"]["wrongPrimitiveShare"]))
        loud = run("render", suzanne, "--size", "160x120", "-o", "a.png", "--detail", "1")
        self.assertTrue("'suzanne' is drawn with" in loud.stderr, f"not said: {loud.stderr}")
        explained = run("render", suzanne, "--size", "160x120", "--detail", "1", "--explain")
        self.assertTrue(explained.returncode == 0 and "'suzanne' is drawn with" in explained.stdout, "--explain is silent")
        coarse = self.report("render", suzanne, "--size", "160x120", "-o", "b.png", "--detail", "4")
        self.assertTrue(coarse["detail"]["drawnTriangles"] < d["drawnTriangles"], "4 px take no more away than 1 px")

    def test_both_sides_draw_the_same_bytes(self):
        """The same bytes on both sides, of meshes and of shapes."""
        for scene, more in ((os.path.join(SCENES, "suzanne.toml"), ()), ("shapes.toml", ()), ("shapes.toml", ("--shading", "ray"))):
            done = run("verify", scene, "--size", "160x120", "--detail", "0.5", *more)
            self.assertTrue(done.returncode == 0 and ": equal" in done.stdout and "is drawn with" in done.stderr, f"verify {scene} {more}: {done.stdout[:200]}{done.stderr[:200]}")

    def test_shapes_have_the_segments_that_a_budget_takes(self):
        few = self.report("render", "shapes.toml", "-o", "few.png", "--detail", "2")["detail"]["objects"]
        many = self.report("render", "shapes.toml", "-o", "many.png", "--detail", "0.05")["detail"]["objects"]
        for a, b in zip(few, many):
            self.assertTrue(a["segments"] < 64 < b["segments"], f"{a['name']}: {a['segments']} and {b['segments']} segments")
            self.assertTrue(a["pixels"] <= 2 and b["pixels"] <= 0.05, f"{a} {b}")

    def test_measure_has_an_axis_of_segments_and_one_of_pixels(self):
        m = self.report("measure", "shapes.toml", "--axis", "tessellation,detail", "--repetitions", "3", "--size", "160x120")
        rows = {(r["axis"], r["choice"]): r for r in m["rows"]}
        means = [rows["tessellation", str(n)]["errorAtItsSamples"]["mean"] for n in (8, 16, 32)] if ("tessellation", "8") in rows else []
        self.assertTrue(len(means) == 3 and means[0] > 2 * means[1] > 4 * means[2], f"errors of 8, 16 and 32 segments: {means}")
        self.assertTrue(rows["detail", "4"]["errorAtItsSamples"]["mean"] > rows["detail", "1/4"]["errorAtItsSamples"]["mean"], "4 px are no worse than 1/4 px")

    def test_flat_flashes_gouraud_flickers_and_phong_moves(self):
        """Of a turning cylinder's highlight: flat flashes, Gouraud flickers, Phong moves."""
        change = {}
        for shading in ("flat", "gouraud", "phong"):
            done = run("render", "turn.toml", "--turntable", "36", "--flicker", "--shading", shading, "-o", "turn{n}.png", "--json=turn.json")
            self.assertTrue(done.returncode == 0 and "flicker: a pixel changes by at most" in done.stderr, f"{shading}: {done.stderr}")
            with open("turn.json", encoding="utf-8") as file:
                flicker = json.load(file)[-1]["flicker"]
            self.assertTrue(len(flicker["steps"]) == 36, "a turn of 36 pictures has 36 steps")
            self.assertTrue(flicker["max"] == max(s["max"] for s in flicker["steps"]), "the largest is not the largest")
            change[shading] = flicker
            print(f"  {shading}: max {flicker['max']:.4f}, rms {flicker['rms']:.5f}")
        for figure in ("max", "rms"):
            self.assertTrue(change["flat"][figure] > change["gouraud"][figure] > change["phong"][figure], f"{figure}: " + str({k: v[figure] for k, v in change.items()}))

    def test_what_makes_no_sense_is_refused_in_one_line(self):
        suzanne = os.path.join(SCENES, "suzanne.toml")
        rows = (("render", suzanne, "-o", "no.png", "--detail", "0"), ("render", suzanne, "-o", "no.png", "--detail", "nan"), ("render", suzanne, "-o", "no.png", "--detail", "-1"),
                ("render", suzanne, "-o", "no.png", "--detail", "much"), ("render", suzanne, "-o", "no.png", "--flicker"),
                ("render", suzanne, "-o", "no{n}.png", "--turntable", "1", "--flicker"), ("render", suzanne, "-o", "no{eye}.png", "--stereo", "pair", "--detail", "1"))
        for words in rows:
            done = run(*words)
            self.assertTrue(done.returncode == 2 and done.stderr.count("\n") == 1, f"{words}: exit {done.returncode}: {done.stderr}")
        self.assertTrue(not [name for name in os.listdir(".") if name.startswith("no")], "a refused command left a file")


if __name__ == "__main__":
    PLUMB, SCENES = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])
    unittest.main(argv=sys.argv[:1])
