#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The gallery of the lecture notes, made at a small size: every row marked drawn has a picture, every picture is drawn, device and twin agree on each scene, a fault differs
from its cure, and the page asks for nothing but what lies beside it. usage: gallery_test.py PLUMB ROOT"""
import html.parser
import json
import os
import subprocess
import sys
import tempfile
import unittest

PLUMB, ROOT = None, None
SIZE = "96x72"
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "toolchain"))
import gallery  # noqa: E402
import gallery_sheet  # noqa: E402


class Links(html.parser.HTMLParser):
    def __init__(self):
        super().__init__()
        self.targets, self.images = [], 0

    def handle_starttag(self, tag, attributes):
        named = dict(attributes)
        self.images += tag == "img"
        self.targets += [named[key] for key in ("src", "href") if key in named]


class Gallery(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.out = os.path.join(cls.folder.name, "gallery")
        cls.done = subprocess.run([sys.executable, os.path.join(ROOT, "toolchain", "gallery.py"), PLUMB, cls.out, "--size", SIZE], capture_output=True, text=True)
        if cls.done.returncode != 0:
            raise AssertionError(cls.done.stderr)
        with open(os.path.join(cls.out, "gallery.json"), encoding="utf-8") as file:
            cls.summary = json.load(file)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_every_drawn_row_has_a_picture(self):
        self.assertEqual(gallery.check(), 0)
        self.assertEqual({row for p in self.summary for row in p["rows"]}, gallery.marked_drawn())

    def test_every_picture_is_drawn(self):
        self.assertEqual(self.done.returncode, 0, self.done.stderr)
        self.assertNotIn("validation", self.done.stderr)
        files = [picture["file"] for p in self.summary for picture in p["pictures"]]
        self.assertEqual(files, [name + ".png" for p in gallery.pictures() for name in p.files()])
        for p in self.summary:
            for picture in p["pictures"]:
                image = picture["image"]
                self.assertTrue("x".join(map(str, image["size"])) == SIZE or gallery.has_notes_viewer(picture["arguments"][0]), picture["file"])
                self.assertGreater(image["distinct_colours"], 1, picture["file"])
                self.assertTrue(os.path.getsize(os.path.join(self.out, picture["file"])) > 0)

    def test_a_picture_has_its_error_or_says_why_not(self):
        for p in self.summary:
            for picture in p["pictures"]:
                self.assertNotEqual(picture["error"] is None, picture["why"] is None, picture)
                self.assertTrue(picture["passes"])
                self.assertGreater(picture["time_ms"]["render"], 0)

    def test_a_truth_is_that_of_its_picture(self):
        """Most pixels show the face that the truth shows: else it is the truth of something else."""
        for p in self.summary:
            for picture in p["pictures"]:
                if picture["error"] and picture["error"]["wrongPrimitiveShare"] is not None:
                    self.assertLess(picture["error"]["wrongPrimitiveShare"], 0.5, picture["file"])

    def test_unlit_polygons_are_wrong_at_their_outlines_only(self):
        """Their materials' ambient colour is their own, under an ambient light of 1: so the Phong truth shows their colour too."""
        byte = 12.92 * 0.5 / 255  # half a step of linear light, where the sRGB curve is steepest
        unlit = [q for p in self.summary for q in p["pictures"] if q["passes"] == ["project", "scanline", "scanpaint", "encode"]]
        self.assertGreaterEqual(len(unlit), 5)
        for picture in unlit:
            error = picture["error"]
            # A pixel with another face is off by the whole scale at most, every other one by its byte.
            self.assertLessEqual(error["rms"] ** 2, error["wrongPrimitiveShare"] + byte ** 2, picture["file"])

    def test_a_fault_differs_from_its_cure_and_is_further_from_the_truth(self):
        pairs = [p for p in self.summary if len(p["pictures"]) == 2]
        self.assertGreaterEqual(len(pairs), 5)
        for p in pairs:
            self.assertGreater(p["between"]["differing"], 0, p["name"])
            fault, cure = (picture["error"] for picture in p["pictures"])
            rays = [picture["passes"][0] == "trace" for picture in p["pictures"]]
            if fault and cure and rays[0] == rays[1]:  # else each has a truth of its own
                self.assertGreater(fault["rms"], cure["rms"], p["name"])

    def test_the_page_lies_beside_what_it_shows(self):
        links = Links()
        with open(os.path.join(self.out, "index.html"), encoding="utf-8") as file:
            links.feed(file.read())
        self.assertEqual(links.images, sum(len(p["pictures"]) for p in self.summary))
        for target in links.targets:
            self.assertTrue(os.path.isfile(os.path.join(self.out, target)), target)

    def test_the_sheet_shows_every_picture(self):
        width, height, rows = gallery_sheet.read_png(os.path.join(self.out, "sheet.png"))
        count = sum(len(p["pictures"]) for p in self.summary)
        cell, gap, columns = gallery_sheet.CELL, gallery_sheet.GAP, gallery_sheet.COLUMNS
        self.assertEqual((width, height), (columns * (cell[0] + gap) + gap, (count + columns - 1) // columns * (cell[1] + gap) + gap))
        for n in range(count):
            left, top = gap + n % columns * (cell[0] + gap), gap + n // columns * (cell[1] + gap)
            colours = {rows[y][3 * x:3 * x + 3] for y in range(top, top + cell[1], 7) for x in range(left, left + cell[0], 7)}
            self.assertGreater(len(colours), 1, f"cell {n} is empty")

    def test_device_and_twin_agree_on_every_scene_of_the_gallery(self):
        folder = os.path.join(ROOT, "scenes", "gallery")
        for name in sorted(os.listdir(folder)):
            if name.endswith(".toml"):
                scene = os.path.join("scenes", "gallery", name)
                size = [] if gallery.has_notes_viewer(scene) else ["--size", SIZE]
                done = subprocess.run([PLUMB, "verify", os.path.join(ROOT, scene), *size, "--require-device", "lavapipe"], capture_output=True, text=True)
                self.assertEqual(done.returncode, 0, f"{name}: {done.stdout[-300:]}{done.stderr[-300:]}")

    def test_a_scene_that_is_not_there_fails(self):
        with self.assertRaisesRegex(RuntimeError, "no-such-scene"):
            gallery.render(PLUMB, ["scenes/no-such-scene.toml"], os.path.join(self.out, "none.png"), None)

    def test_the_teapot_is_what_its_patches_make(self):
        done = subprocess.run([sys.executable, os.path.join(ROOT, "toolchain", "make_teapot.py"), "--check"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout)
        info = json.loads(subprocess.run([PLUMB, "info", os.path.join(ROOT, "scenes", "teapot.toml"), "--json"], capture_output=True, text=True).stdout)
        mesh = info["meshes"][0]
        # No crack: open are the body's rim, the lid's, two ends of the handle and two of the spout, 10 steps a patch.
        self.assertEqual(mesh["boundary_edges"], 10 * (4 + 4 + 2 * 2 + 2 * 2))
        self.assertEqual(mesh["non_manifold_edges"], 0)


if __name__ == "__main__":
    PLUMB, ROOT = map(os.path.abspath, sys.argv[1:3])
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
