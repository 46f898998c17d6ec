#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""`plumb verify --suite` runs every module that the program holds. On a faulty driver `plumb verify --capsule` keeps what differs, and `plumb replay`
runs it again.

usage: suite_command_test.py PLUMB PLUMB_PLANTED [unittest arguments]
"""
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree

PLUMB, PLANTED = (os.path.abspath(path) for path in sys.argv[1:3])
SUZANNE = os.path.abspath(os.path.join(os.path.dirname(__file__), "../../scenes/suzanne.toml"))
MOST_BYTES, MOST_TRIANGLES = 1 << 20, 8


class InFolder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def expect(self, code, *arguments, says=""):
        done = subprocess.run([PLUMB, *arguments], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(done.returncode, code, f"{arguments}: {done.stdout}{done.stderr}")
        self.assertIn(says, done.stdout + done.stderr)
        return done


class Suite(InFolder):
    def test_every_module_runs_and_all_is_equal(self):
        done = self.expect(0, "verify", "--suite", "--junit", "suite.xml", "--json=suite.json")
        with open(os.path.join(self.folder, "suite.json"), encoding="utf-8") as f:
            report = json.load(f)
        embedded = [line.split()[0] for line in self.expect(0, "--version").stdout.splitlines() if len(line.split()) == 2 and len(line.split()[1]) == 64]
        self.assertGreaterEqual(len(embedded), 35)
        self.assertEqual(report["modules"], {"embedded": len(embedded), "run": len(embedded), "not_run": []})
        self.assertEqual([t for t in report["tests"] if t["verdict"] != "equal"], [])
        lines = done.stdout.splitlines()
        self.assertEqual([line.split()[1] for line in lines[:-1]], [t["name"] for t in report["tests"]], "a line a test")
        self.assertIn(f"{len(embedded)} of {len(embedded)} modules ran", lines[-1])
        suite = xml.etree.ElementTree.parse(os.path.join(self.folder, "suite.xml")).getroot()
        self.assertEqual([case.get("name") for case in suite], [t["name"] for t in report["tests"]])
        self.assertEqual((suite.get("tests"), suite.get("failures"), suite.get("errors"), suite.get("skipped")), (str(len(suite)), "0", "0", "0"))

    def test_words_that_do_not_fit(self):
        self.expect(2, "verify", "--suite", "cube.obj", says="leave the operands out")
        self.expect(2, "verify", "--suite", "--size", "64x48", says="leave the flags that change one out")
        self.expect(2, "verify", "--suite", "-o", "a.png", says="leave --output out")
        self.expect(2, "verify", "cube.obj", "--junit", "a.xml", says="--junit goes with --suite")
        self.expect(4, "verify", "--suite", "--device", "twin", says="there is no device")
        os.makedirs(os.path.join(self.folder, "full", "of"))
        self.expect(2, "verify", "--suite", "--capsule", "full", says="a folder that is new or empty")
        self.expect(2, "verify", "--suite", "--reduce", "soon", says="e.g. 10s")


class Capsules(InFolder):
    @classmethod
    def setUpClass(cls):
        cls.made = tempfile.TemporaryDirectory()
        cls.said = {name: cls.verified(name, *words) for name, *words in
                    (("differs", "products", 1, "--shading", "flat"), ("fails", "uncounted", 5, "--shading", "wire"))}

    @classmethod
    def verified(cls, name, fault, code, *words):
        """What verify says of a capsule, made on a driver with a fault."""
        done = subprocess.run([PLANTED, "verify", SUZANNE, "--size", "96x72", "--capsule", name, "--reduce", "20s", f"--json={name}.json", *words],
                              cwd=cls.made.name, capture_output=True, text=True, env=dict(os.environ, PLUMB_DRIVER=fault))
        assert done.returncode == code, f"{name}: {done.returncode}: {done.stdout}{done.stderr}"
        said = re.search(rf"capsule {name}: (\S.*) in (\w+), (\d+) of (\d+) triangles, (\d+) files, (\d+) bytes", done.stderr)
        assert said, done.stderr
        return {"pass": said[1], "module": said[2], "triangles": int(said[3]), "before": int(said[4]), "files": int(said[5]), "bytes": int(said[6])}

    @classmethod
    def tearDownClass(cls):
        cls.made.cleanup()

    def setUp(self):
        super().setUp()
        for name in ("differs", "fails"):
            shutil.copytree(os.path.join(self.made.name, name), os.path.join(self.folder, name))

    def change(self, name, changed):
        path = os.path.join(self.folder, name)
        with open(path, "rb") as f:
            text = f.read()
        with open(path, "wb") as f:
            f.write(changed(text))

    def test_they_are_small(self):
        for name, said in self.said.items():
            self.assertGreater(said["before"], MOST_TRIANGLES)
            self.assertLessEqual(said["triangles"], MOST_TRIANGLES)
            self.assertLessEqual(said["bytes"], MOST_BYTES)
            files = os.listdir(os.path.join(self.folder, name))
            self.assertEqual(len(files), said["files"])
            self.assertEqual(sum(os.path.getsize(os.path.join(self.folder, name, file)) for file in files), said["bytes"])
        self.assertEqual(self.said["fails"]["module"], "lines")

    def test_the_report_of_what_differs_names_the_capsule(self):
        with open(os.path.join(self.made.name, "differs.json"), encoding="utf-8") as f:
            verify = json.load(f)["verify"]
        self.assertFalse(verify["equal"])
        self.assertEqual((verify["capsule"], verify["mismatches"][0]["pass"]), ("differs", self.said["differs"]["pass"]))
        # Without the fault nothing differs, and no capsule is made.
        self.expect(0, "verify", SUZANNE, "--size", "96x72", "--shading", "flat", "--capsule", "none", "--json=equal.json")
        self.assertFalse(os.path.exists(os.path.join(self.folder, "none")))
        with open(os.path.join(self.folder, "equal.json"), encoding="utf-8") as f:
            self.assertIsNone(json.load(f)["verify"]["capsule"])

    def test_they_give_the_same_each_time(self):
        for name, says in (("differs", "as captured"), ("fails", "did not finish")):
            done = self.expect(1, "replay", name, "--json=r.json", says=says)
            self.assertIn("20 runs", done.stdout)
            with open(os.path.join(self.folder, "r.json"), encoding="utf-8") as f:
                report = json.load(f)
            self.assertEqual([(r["times"], r["outcome"]) for r in report["results"]], [(20, "as captured")])
            self.assertFalse(report["equal"])

    def test_a_device_that_does_as_expected_passes(self):
        # A twin that has the device's values: what a mended driver leaves.
        with open(os.path.join(self.folder, "differs", "capsule.json"), encoding="utf-8") as f:
            capsule = json.load(f)
        capsule["compared"]["expected"] = capsule["compared"]["got"]
        with open(os.path.join(self.folder, "differs", "capsule.json"), "w", encoding="utf-8") as f:
            json.dump(capsule, f)
        self.expect(0, "replay", "differs", "--times", "3", says="values are those of the twin")

    def test_torn_and_foreign_folders_are_refused(self):
        self.expect(3, "replay", "nowhere", says="is no folder")
        os.mkdir(os.path.join(self.folder, "empty"))
        self.expect(3, "replay", "empty", says="has no capsule.json")
        self.change("differs/module.spv", lambda b: b[:-4] + b"\0\0\0\1")
        self.expect(3, "replay", "differs", says="module.spv: has other bytes than capsule.json says")
        os.remove(os.path.join(self.folder, "fails", "module.spv"))
        self.expect(3, "replay", "fails", says="module.spv: is missing")
        self.change("fails/capsule.json", lambda b: b[:300])
        self.expect(3, "replay", "fails", says="truncated or no capsule")
        self.change("differs/capsule.json", lambda b: b.replace(b"plumb-capsule-1", b"plumb-capsule-9"))
        self.expect(3, "replay", "differs", says="'plumb-capsule-1' is wanted")
        self.expect(2, "replay", says="needs CAPSULE")
        self.expect(2, "replay", "differs", "fails", says="needs one capsule")
        self.expect(4, "replay", "--device", "twin", os.path.join(self.made.name, "differs"), says="there is none")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:], verbosity=2)
