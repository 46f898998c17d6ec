#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""plumb plan, render --error and render --time: what they choose, what they check, what they refuse, and the calibration that they keep.

usage: budget_command_test.py PLUMB SCENES
"""
import json
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

PLUMB, SCENES = None, None


class Budgets(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp(prefix="plumb-budget-")
        cls.cache = os.path.join(cls.folder, "cache", "plumbline")

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    def run_plumb(self, code, command, scene, *arguments, size="96x72", says=None):
        line = [PLUMB, command, os.path.join(SCENES, scene), "--device", "twin", "--size", size, *arguments]
        done = subprocess.run(line, cwd=self.folder, env={**os.environ, "XDG_CACHE_HOME": os.path.join(self.folder, "cache")},
                              stdin=subprocess.DEVNULL, capture_output=True, timeout=120, check=False)
        self.assertEqual(done.returncode, code, (arguments, done.stderr))
        if says is not None:
            self.assertIn(says, done.stderr.decode() + done.stdout.decode())
        return done

    def report(self, *arguments, **keywords):
        return json.loads(self.run_plumb(*arguments, "--json", **keywords).stdout)

    def read(self, name):
        with open(os.path.join(self.folder, name), "rb") as f:
            return f.read()

    def flags_of(self, choices):
        """Flags that draw the choices of a report: "phong, specular=schlick"."""
        shading, *trades = choices.split(", ")
        return ["--shading", shading] + (["--trade", ",".join(trades)] if trades else [])

    def test_the_cheapest_is_drawn_and_certified(self):
        for error in ("60:max,1%:wrong", "4:rms", "2:max,1:p99,1%:wrong"):
            budget = self.report(0, "render", "suzanne.toml", "-o", "a.png", "--error", error, "--check-time", "10min")["budget"]
            self.assertTrue(budget["kept"] and budget["certified"], budget)
            self.assertEqual(budget["checked"]["pixels"], 96 * 72)
            self.assertEqual(budget["tried"][-1]["choices"], budget["choices"])
            for limit in ("max", "p99", "rms", "wrong"):
                if budget["asked"][limit] is not None:
                    self.assertLessEqual(budget["got"][limit], budget["asked"][limit])
            # The probe is the whole picture here: everything cheaper was weighed, and does not keep it.
            for one in budget["weighed"]:
                if one["choices"] == budget["choices"]:
                    break
                self.assertTrue(any(limit is not None and name != "time_ms" and one["probe"][name] > limit
                                    for name, limit in budget["asked"].items()), one)
            self.run_plumb(0, "render", "suzanne.toml", "-o", "b.png", *self.flags_of(budget["choices"]))
            self.assertEqual(self.read("a.png"), self.read("b.png"))

    def test_a_tight_budget_asks_for_more_than_a_loose_one(self):
        loose, tight = (self.report(0, "plan", "suzanne.toml", "--error", error)["budget"] for error in ("100:rms", "0.6:rms"))
        self.assertLess(loose["predicted_ms"], tight["predicted_ms"])
        self.assertIn("phong", tight["choices"])

    def test_what_is_stated_stays(self):
        budget = self.report(0, "plan", "suzanne.toml", "--error", "100:rms", "--shading", "phong", "--trade", "rate=1")["budget"]
        self.assertTrue(all(one["choices"].startswith("phong") and "rate" not in one["choices"] for one in budget["weighed"]), budget)

    def test_no_choice_is_6_and_writes_nothing(self):
        self.run_plumb(6, "render", "suzanne.toml", "-o", "none.png", "--error", "0.5:rms", "--shading", "flat",
                       says="no choice keeps rms 0.5")
        self.run_plumb(6, "render", "suzanne.toml", "-o", "none.png", "--time", "1ms", size="1600x1200", says="no choice is done in 1 ms")
        self.assertFalse(os.path.exists(os.path.join(self.folder, "none.png")))

    def test_a_sample_is_not_certified(self):
        budget = self.report(0, "render", "suzanne.toml", "-o", "c.png", "--error", "2:max,1%:wrong", "--check-time", "1ms",
                             size="320x240")["budget"]
        self.assertFalse(budget["certified"])
        self.assertGreaterEqual(budget["checked"]["pixels"], 3000)
        self.assertLess(budget["checked"]["pixels"], 320 * 240)
        self.assertTrue(0 < budget["checked"]["beyond_below"] < 0.01, budget["checked"])

    def test_a_time_takes_the_most_accurate(self):
        short = self.report(0, "plan", "suzanne.toml", "--time", "60s")["budget"]
        self.assertIn("samples=16", short["choices"])
        drawn = self.report(0, "render", "suzanne.toml", "-o", "d.png", "--time", "60s")
        self.assertEqual(drawn["options"]["samples"], 16)
        self.assertTrue(drawn["budget"]["kept"])
        self.assertEqual(drawn["budget"]["took_ms"], drawn["time_ms"]["render"])
        pinned = self.report(0, "plan", "suzanne.toml", "--time", "60s", "--samples", "1")["budget"]
        self.assertNotIn("samples=16", pinned["choices"])

    def test_rays_are_counted_before_they_start(self):
        plan = self.report(0, "plan", "mirrors.toml", size="320x240")
        drawn = self.report(0, "render", "mirrors.toml", "-o", "e.png", size="320x240")
        rays = sum(sum(depth.values()) for depth in drawn["counters"]["rays"])
        self.assertLess(abs(plan["forecast"]["rays"] / rays - 1), 0.1)
        budget = self.report(0, "render", "mirrors.toml", "-o", "f.png", "--error", "40:rms", "--check-time", "10min")["budget"]
        self.assertTrue(budget["kept"] and budget["certified"])

    def test_a_calibration_is_kept_and_a_damaged_one_is_made_anew(self):
        for _ in range(20):  # what is measured beside other work is not kept
            if b"not kept" not in self.run_plumb(0, "plan", "suzanne.toml").stderr:
                break
        self.assertNotIn("measured", self.run_plumb(0, "plan", "suzanne.toml").stderr.decode())
        files = [name for name in os.listdir(self.cache) if name.startswith("costs-")]
        self.assertEqual(len(files), 1)
        path = os.path.join(self.cache, files[0])
        with open(path, "r+b") as f:
            f.seek(40)
            f.write(b"\xff")
        self.run_plumb(0, "plan", "suzanne.toml", says="measured in")
        self.assertEqual([name for name in os.listdir(self.cache) if name.startswith("costs-")], files)

    def test_a_plan_states_what_is_proved(self):
        """Errors of the probe's pixels are never beyond what is proved of them; a choice without a proof says why."""
        usual = {"specular": "exact", "light-vector": "pixel", "interpolation": "perspective", "normals": "normalised", "rate": "1"}
        # Of a raster picture one choice each, because the order of several follows costs that are measured. Rays are counted.
        cases = [("suzanne.toml", "255:rms", ("--shading", "phong", "--trade", ",".join(f"{axis}={word}" for axis, word in {**usual, **one}.items())),
                  len(one)) for one in ({}, {"specular": "schlick"}, {"normals": "as-interpolated"})]
        cases.append(("mirrors.toml", "1:rms", ("--min-weight", "0"), 2))
        for scene, error, arguments, least in cases:
            self.run_plumb(0, "plan", scene, "--error", error, "--explain", "--json=plan.json", *arguments, size="48x36", says="proved max, rms")
            weighed = [one for one in json.loads(self.read("plan.json"))["budget"]["weighed"] if one["probe"] is not None]
            self.assertGreaterEqual(sum(one["bound"]["rms"] is not None for one in weighed), least, weighed)
            for one in weighed:
                self.assertNotEqual(one["bound"]["why"] is None, one["bound"]["rms"] is None, one)
                for figure in ("max", "p99", "rms"):
                    if one["bound"][figure] is not None:
                        self.assertLessEqual(one["probe"][figure], one["bound"][figure] + 1e-4, one)

    def test_a_plan_says_what_render_says_of_the_scene(self):
        corners = "".join(f"v {100000000 + x} {y} 0\n" for x, y in ((0, 0), (100, 0), (0, 100)))
        with open(os.path.join(self.folder, "far.obj"), "w", encoding="utf-8") as file:
            file.write(f"{corners}v -1e8 0 0\nv -1e8 1 0\nv -99999999 0 0\nf 1 2 3\nf 4 5 6\nl 1 2\n")
        with open(os.path.join(self.folder, "mirror.toml"), "w", encoding="utf-8") as file:
            file.write("shading = 'phong'\n[camera]\neye = [100000030, 30, 200]\nat = [100000030, 30, 0]\n"
                       "[[material]]\nname = 'mirror'\nreflect = 0.5\n"
                       "[[mesh]]\nname = 'far'\nfile = 'far.obj'\nmaterial = 'mirror'\n[[object]]\nmesh = 'far'\n")
        scene = os.path.join(self.folder, "mirror.toml")

        def told(done):
            return sorted(line for line in done.stderr.decode().splitlines() if line.startswith(("plumb: not drawn: ", "plumb: warning: ")))

        planned = self.run_plumb(0, "plan", scene, "--json")
        lines = told(planned)
        self.assertEqual(lines, told(self.run_plumb(0, "render", scene, "-o", "mirror.png")))
        for words in ("not drawn: reflection and refraction", "float32 may move a vertex", "no area", "lines"):
            self.assertTrue(any(words in line for line in lines), (words, lines))
        report = json.loads(planned.stdout)
        self.assertTrue(any("float32 may move" in sentence for sentence in report["accuracy"]["warnings"]), report["accuracy"])
        self.assertEqual(told(self.run_plumb(0, "plan", scene, "-q")), [])
        self.run_plumb(3, "plan", scene, "--strict")

    def test_refusals_are_one_line(self):
        for arguments, says in ((["--error", "0.4"], "is below the 0.5 steps that rounding to bytes costs"),
                                (["--error", "0.2:rms"], "is below the 0.2887 steps"),
                                (["--error", "3", "--encode", "linear"], "is below the 6.46 steps"),
                                (["--error", "2:mean"], "'mean' is no metric"),
                                (["--error", "2:rms,3:rms"], "rms has a limit already"),
                                (["--error", "2", "--fill", "notes"], "--fill notes"),
                                (["--error", "2", "--shading", "wire"], "a wire frame has no truth")):
            done = self.run_plumb(2, "render", "suzanne.toml", "-o", "none.png", *arguments, says=says)
            self.assertEqual(done.stderr.count(b"\n"), 1, done.stderr)
        self.run_plumb(2, "render", "suzanne.toml", "--error", "2", "--explain", says="give -o FILE")
        self.assertFalse(os.path.exists(os.path.join(self.folder, "none.png")))


if __name__ == "__main__":
    PLUMB, SCENES = sys.argv[1:3]
    unittest.main(argv=sys.argv[:1])
