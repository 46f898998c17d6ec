#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""plumb matrix as it is used: what it prints, and what it refuses. usage: matrix_command_test.py PLUMB SOURCE"""
import json
import os
import subprocess
import sys
import tempfile
import unittest

PLUMB, SOURCE = sys.argv[1], sys.argv[2]


def run(*arguments):
    return subprocess.run([PLUMB, "matrix", *arguments], capture_output=True, text=True, timeout=60)


def golden(entry, check):
    with open(os.path.join(SOURCE, "tests/data/worked-examples.json"), encoding="utf-8") as f:
        content = json.load(f)
    bound = float(content["conventions"]["implementation_tolerance"].split()[1])
    for e in content["examples"]:
        if e["id"] == entry:
            for c in e["checks"]:
                if c["name"] == check:
                    return e["inputs"], c["expected"], bound
    raise KeyError(entry)


class Matrix(unittest.TestCase):
    def assert_close(self, got, want, bound):
        if isinstance(want, list):
            self.assertEqual(len(got), len(want))
            for g, w in zip(got, want):
                self.assert_close(g, w, bound)
        else:
            self.assertLessEqual(abs(got - want), bound * max(1, abs(want)))

    def line(self):
        inputs, _, _ = golden("s1022_composite_phi90", "composite")
        words = [",".join(repr(float(x)) for x in inputs[k]) for k in ("P1", "P2", "test_point")]
        return f"rotate={inputs['phi_deg']}:from={words[0]}:to={words[1]}", words[2]

    def test_a_line_rotation_has_the_composite_of_the_notes(self):
        step, point = self.line()
        r = run(step, "--point", point, "--notation", "row", "--json")
        self.assertEqual(r.returncode, 0, r.stderr)
        report = json.loads(r.stdout)
        _, want, bound = golden("s1022_composite_phi90", "composite")
        self.assert_close(report["composite"], want, bound)
        _, want, bound = golden("s1022_composite_phi90", "test_point_after_each_step")
        self.assert_close([s["points"][0] for s in report["steps"]], want, bound)
        self.assertEqual((report["sequential"]["products"], report["tree"]["products"], report["tree"]["depth"]), (6, 6, 3))
        self.assertEqual([sum(n["product"] for n in level) for level in report["tree"]["levels"]], [3, 2, 1])

    def test_both_notations_are_transposes(self):
        step, _ = self.line()
        rows, columns = (json.loads(run(step, "--notation", n, "--json").stdout)["composite"] for n in ("row", "column"))
        self.assertEqual(rows, [list(c) for c in zip(*columns)])

    def test_vertices_are_counted(self):
        step, _ = self.line()
        report = json.loads(run(step, "--vertices", "1000", "--threads", "3", "--json").stdout)["run"]
        self.assertEqual((report["separate"]["applications"], report["composite"]["applications"], report["parallel"]["applications"]), (7000, 1000, 1000))
        self.assertEqual(report["composite"]["equations"], 3000)
        self.assertTrue(report["parallel"]["same_bytes"])
        self.assertEqual(report["dependent_steps"], 4)

    def test_the_plane(self):
        report = json.loads(run("--dimensions", "2", "rotate=90:about=3,2", "--notation", "row", "--json").stdout)
        _, want, bound = golden("s1021_composite_2d", "composite")
        self.assert_close(report["composite"], want, bound)

    def test_text_goes_to_standard_output_and_nothing_elsewhere(self):
        r = run("scale=2", "translate=1,2,3", "--inverse")
        self.assertEqual((r.returncode, r.stderr), (0, ""))
        for piece in ("step 1: S(2, 2, 2)", "step 2: T(1, 2, 3)", "inverse:", "as a tree: 1 product, 1 deep"):
            self.assertIn(piece, r.stdout)

    def test_scenes(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "s.toml")
            head = '[[mesh]]\nname = "m"\nvertices = [[0,0,0],[2,0,0],[0,4,0]]\nfaces = [[0,1,2]]\n[[object]]\nname = "o"\nmesh = "m"\n'
            with open(path, "w", encoding="utf-8") as f:
                f.write(head + 'transform = [{ rotate_z = 90, about = "centre" }, { rotate = { from = [0,0,0], to = [0,0,5], degrees = 90 } }]\n')
            report = json.loads(run(path, "--json").stdout)
            self.assertEqual([s["name"] for s in report["steps"]][:3], ["T(-1, -2, 0)", "R_Z(90)", "T(1, 2, 0)"])
            self.assertEqual(len(report["steps"]), 10)
            # (0,0) -> about (1,2): (3,1) -> a quarter turn about Z: (-1,3)
            self.assertEqual([row[3] for row in report["composite"][:2]], [-1, 3])
            for bad, field in (('{ rotate = { from = [1,2,3], to = [1,2,3], degrees = 9 } }', "object.transform[0].rotate.to"),
                               ('{ rotate = { axis = [0,0,0], degrees = 9 } }', "object.transform[0].rotate.axis"),
                               ('{ rotate = { to = [1,2,3], axis = [1,0,0], degrees = 9 } }', "object.transform[0].rotate.to"),
                               ('{ rotate = { from = [1,2,3], to = [2,2,3], axis = [1,0,0], degrees = 9 } }', "object.transform[0].rotate.axis"),
                               ('{ rotate_x = 9, about = "middle" }', "object.transform[0].about")):
                with open(path, "w", encoding="utf-8") as f:
                    f.write(head + f"transform = [{bad}]\n")
                r = run(path)
                self.assertEqual(r.returncode, 3, bad)
                self.assertEqual(r.stdout, "")
                self.assertEqual(r.stderr.count("\n"), 1, r.stderr)
                self.assertIn("s.toml:8:", r.stderr)
                self.assertIn(field, r.stderr)

            with open(path, "w", encoding="utf-8") as f:
                f.write(head + "transform = [{ scale = [1, 0, 1] }]\n")
            self.assertEqual(json.loads(run(path, "--json").stdout)["composite"][1], [0, 0, 0, 0], "a scale of 0 flattens")

    def test_refused_words_name_step_and_field(self):
        for words, field in ((["rotate=90:axis=0,0,0"], "axis is the zero vector"),
                             (["rotate=90:from=1,2,3:to=1,2,3"], "to is the same point"),
                             (["translate=1,2,3", "scale=0", "--inverse"], "no inverse"),
                             (["rotate_z=x"], "rotate_z"), (["rotate_z=nan"], "rotate_z"), (["rotate_z=1e40"], "rotate_z"),
                             (["scale=1,2"], "scale has 2 numbers, not 3"),
                             (["rotate_y=1", "turn=1"], "step 2"),
                             (["translate=1,2,3:about=1,2,3"], "about does not go with translate"),
                             (["rotate_x=1:about=1,2,3:about=1,2,3"], "about is given twice"),
                             (["rotate=1"], "axis= is missing"), (["matrix=1,2,3"], "not 16"),
                             (["scale=1", "--point", "1,2"], "--point"), (["scale=1", "--object", "x"], "--object"),
                             (["--dimensions", "2", "rotate_x=1"], "not a step of the plane"),
                             (["--dimensions", "2", "scale=2", "--reverse-z"], "--reverse-z"), ([], "needs")):
            r = run(*words)
            self.assertEqual(r.returncode, 2, words)
            self.assertEqual(r.stdout, "")
            self.assertEqual(r.stderr.count("\n"), 1, r.stderr)
            self.assertIn(field, r.stderr)

    def test_a_scale_of_zero_collapses_where_no_inverse_is_asked_for(self):
        r = run("scale=0", "--json")
        self.assertEqual(r.returncode, 0)
        self.assertEqual(json.loads(r.stdout)["composite"][0][0], 0)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
