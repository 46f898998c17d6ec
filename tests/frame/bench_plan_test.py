#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""plumb bench plan: its rows, what they claim of errors and times, its report, and the picture and table that toolchain/plan_fronts.py makes of it. No time is
judged. usage: bench_plan_test.py PLUMB SOURCE"""
import json
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree

PLUMB, SOURCE = None, None
# A board that fills the view, a wire frame, bytes of linear light, and rays.
ROWS = ("board", "wire", "pyramid", "mirror")
OWN = {"wire": "shading = 'wire'\n[camera]\neye = [1, 1, 4]\nat = [0, 0, 0]\n[[mesh]]\nname = 'box'\nfile = 'box.obj'\n[[object]]\nmesh = 'box'\n",
       "board": "[camera]\neye = [0, 0, 2]\nat = [0, 0, 0]\n[[light]]\ntype = 'point'\nposition = [1, 1, 3]\n"
                "[[material]]\nname = 'm'\nspecular = 0.3\nshininess = 9\n[[mesh]]\nname = 'board'\nmaterial = 'm'\n"
                "vertices = [[-9, -9, 0], [9, -9, 0], [9, 9, 0], [-9, 9, 0]]\nfaces = [[0, 1, 2, 3]]\n[[object]]\nmesh = 'board'\n",
       "mirror": "ambient = 0.2\n[camera]\neye = [0, 0, 5]\nat = [0, 0, 0]\nfov = 30\n[[light]]\ntype = 'directional'\ndirection = [1, 1, 1]\n"
                 "[[material]]\nname = 'm'\nreflect = 0.5\n" + "".join(f"[[sphere]]\ncentre = [{x}, 0, 0]\nradius = 0.8\nmaterial = 'm'\n" for x in (-1, 1))}


class BenchPlan(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp(prefix="plumb-bench-plan-")
        for name, text in OWN.items():
            with open(os.path.join(cls.folder, name + ".toml"), "w", encoding="utf-8") as file:
                file.write(text)
        with open(os.path.join(cls.folder, "box.obj"), "w", encoding="utf-8") as file:
            file.write("v -1 -1 0\nv 1 -1 0\nv 0 1 0\nv 0 0 -1\nf 1 2 3\nf 2 1 4\nf 3 2 4\nf 1 3 4\n")
        cls.run_plumb(cls, 0, *ROWS, "--repeat", "3", "--json=plans.json")
        with open(os.path.join(cls.folder, "plans.json"), encoding="utf-8") as file:
            cls.report = json.load(file)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    def run_plumb(self, code, *words, size="64x48"):
        words = [(word if word in OWN else os.path.join(SOURCE, "scenes", word)) + ".toml" if word in ROWS else word for word in words]
        done = subprocess.run([PLUMB, "bench", "plan", *words, *(["--size", size] if size else [])], cwd=self.folder, stdin=subprocess.DEVNULL,
                              env={**os.environ, "XDG_CACHE_HOME": os.path.join(self.folder, "cache")}, capture_output=True, timeout=120, check=False)
        assert done.returncode == code, (words, done.returncode, done.stderr.decode())
        return done

    def ways(self, name):
        row = next(row for row in self.report["rows"] if os.path.basename(row["name"]) == name + ".toml")
        return {way["name"]: way for way in row["ways"]}

    def test_every_row_has_every_way(self):
        self.assertEqual([os.path.basename(row["name"])[:-5] for row in self.report["rows"]], list(ROWS))
        for row in self.report["rows"]:
            self.assertEqual([way["name"] for way in row["ways"]], ["full", "lossless", "1/255", "4/255"])
            self.assertEqual((row["rounds"], row["size"], row["failure"]), (3, [64, 48], ""))
            for way in row["ways"][:2]:
                self.assertIsNone(way["absent"])
                self.assertEqual(way["ms"]["count"], 3)
                self.assertEqual(way["error"], row["ways"][0]["error"], "the same bytes")
            for way in row["ways"]:
                self.assertEqual(way["absent"] is None, way["ms"] is not None, way)

    def test_three_rounds_tell_nothing_apart(self):
        for row in self.report["rows"]:
            for way in row["ways"]:
                if way["ms"] and way["name"] != "lossless" and not way["same_as"]:
                    self.assertEqual(way["told"], "not told apart")
                    self.assertIsNone(way["of_lossless"]["low"], "an interval of three rounds has no end")
                    self.assertGreater(way["of_lossless"]["median"], 0)
            self.assertEqual(row["ways"][1]["told"], "default")
            self.assertEqual(row["ways"][1]["of_lossless"]["median"], 1)

    def test_budgets_are_kept_or_say_why_not(self):
        drawn = 0
        for row in self.report["rows"]:
            for way, limit in zip(row["ways"][2:], (1, 4)):
                if way["absent"]:
                    self.assertRegex(way["absent"], "no choice keeps|has no truth|is below the 6.46 steps", row["name"])
                    continue
                drawn += 1
                self.assertLessEqual(way["error"]["max"], limit)
                self.assertLessEqual(way["error"]["wrong"], 0.001)
                self.assertGreaterEqual(way["tried"], 1)
        self.assertGreater(drawn, 1)
        for name, says in (("wire", "a wire frame has no truth"), ("pyramid", "is below the 6.46 steps")):
            self.assertIn(says, self.ways(name)["1/255"]["absent"])
            self.assertEqual(self.ways(name)["lossless"]["error"] is None, name == "wire")

    def test_the_error_is_that_of_render(self):
        done = subprocess.run([PLUMB, "render", os.path.join(self.folder, "board.toml"), "--size", "64x48", "--with-error", "--json", "-o", "s.png"],
                              cwd=self.folder, capture_output=True, check=True)
        error = json.loads(done.stdout)["error"]
        self.assertAlmostEqual(self.ways("board")["lossless"]["error"]["rms"], 255 * error["rms"], 4)

    def test_text_report_and_progress(self):
        done = self.run_plumb(0, "board", "--repeat", "3", "-o", "report.html", "--progress", "json")
        for words in ("board.toml: phong, 64x48, 1 sample; left out: ", "\n* full ", "\n* lossless ", " 1/255 ", " 4/255 "):
            self.assertIn(words, done.stdout.decode())
        shares = [json.loads(line) for line in done.stderr.decode().splitlines() if line.startswith("{")]
        self.assertTrue(any("bench 1/1" in json.dumps(share) for share in shares), done.stderr)
        with open(os.path.join(self.folder, "report.html"), encoding="utf-8") as file:
            page = file.read()
        for words in ('"axis":"plan","choice":"full"', '"axis":"budget","choice":"4/255"', "plumb-measure-1"):
            self.assertIn(words, page)

    def test_refusals(self):
        for words, code, says in ((("--repeat", "3"), 2, "there is no scenes/*.toml here"), (("nothing.toml",), 3, "nothing.toml"),
                                  (("board", "wire", "-o", "a.html"), 2, "name one ROW"), (("board", "-o", "a.png"), 2, ".html"),
                                  (("wire", "--repeat", "3", "-o", "a.html"), 2, "a wire frame has no truth")):
            self.assertIn(says, self.run_plumb(code, *words).stderr.decode())
        self.assertFalse(os.path.exists(os.path.join(self.folder, "a.html")))

    def test_without_rows_it_takes_the_folder(self):
        folder = os.path.join(self.folder, "scenes")
        os.mkdir(folder)
        shutil.copy(os.path.join(self.folder, "board.toml"), folder)
        done = self.run_plumb(0, "--repeat", "3", "--json")
        shutil.rmtree(folder)
        self.assertEqual([row["name"] for row in json.loads(done.stdout)["rows"]], ["scenes/board.toml"])

    def test_picture_and_table(self):
        script = os.path.join(SOURCE, "toolchain", "plan_fronts.py")
        report, picture, page = (os.path.join(self.folder, name) for name in ("plans.json", "plans.svg", "page.md"))
        subprocess.run([sys.executable, script, report, picture], check=True)
        svg = xml.etree.ElementTree.parse(picture).getroot()
        text = "".join(svg.itertext())
        for name in ROWS:
            self.assertEqual(name + "," in text, name != "wire", "a wire frame has no error that it could stand at")
        circles = svg.findall(".//{http://www.w3.org/2000/svg}circle")
        points = sum(1 for row in self.report["rows"] for way in row["ways"] if way["ms"] and way["error"])
        self.assertEqual(len(circles), points + 5, "the legend has five")
        with open(page, "w", encoding="utf-8") as file:
            file.write("before\n<!-- plans -->\nold\n<!-- end of plans -->\nafter\n")
        subprocess.run([sys.executable, script, "--table", report, page], check=True)
        with open(page, encoding="utf-8") as file:
            lines = file.read().splitlines()
        self.assertEqual((lines[0], lines[-1], len(lines)), ("before", "after", 4 + 2 + len(ROWS)))
        self.assertTrue(all(line.count("|") == 7 for line in lines[2:-2]), lines)
        self.assertEqual(subprocess.run([sys.executable, script, "--table", report, report], capture_output=True, check=False).returncode, 1)


if __name__ == "__main__":
    PLUMB, SOURCE = sys.argv[1:3]
    unittest.main(argv=sys.argv[:1])
