#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Stereo, fields, separations, wire frames, viewers and area lights as a user meets them, and what of them is refused.

usage: modes_command_test.py PLUMB SCENES [unittest arguments]
"""
import json
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

import numpy

PLUMB, SCENES = sys.argv[1:3]
CARDS = """handedness = "left"
size = [96, 64]
shading = "unlit"
[camera]
distance = 100
near = 1
"""


def card(name, x, z):
    return (f"[[mesh]]\nname = '{name}'\nvertices = [[{x - 4}, -4, {z}], [{x - 4}, 4, {z}], [{x + 4}, 4, {z}], [{x + 4}, -4, {z}]]\n"
            "faces = [[0, 1, 2, 3]]\n")


def grey_png(data):
    """Rows of a grey PNG of 8 bits, filter None or Sub."""
    width, height, bits, colour = struct.unpack(">IIBB", data[16:26])
    assert (bits, colour) == (8, 0), (bits, colour)
    at, packed = 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        if kind == b"IDAT":
            packed += data[at + 8:at + 8 + length]
        at += 12 + length
    rows = numpy.frombuffer(zlib.decompress(packed), numpy.uint8).reshape(height, width + 1)
    assert set(rows[:, 0]) <= {0, 1}, rows[:, 0]
    return numpy.where(rows[:, :1] == 1, numpy.cumsum(rows[:, 1:], axis=1, dtype=numpy.uint8), rows[:, 1:])


class Modes(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="plumb-modes-")
        self.addCleanup(shutil.rmtree, self.folder)

    def path(self, name):
        return os.path.join(self.folder, name)

    def write(self, name, text):
        with open(self.path(name), "w", encoding="utf-8") as f:
            f.write(text)

    def read(self, name):
        with open(self.path(name), "rb") as f:
            return f.read()

    def scene(self, name):
        return os.path.join(SCENES, name)

    def expect(self, code, *arguments, says=None, leaves=None):
        before = set(os.listdir(self.folder))
        done = subprocess.run([PLUMB, *arguments], cwd=self.folder, stdin=subprocess.DEVNULL, capture_output=True, timeout=120, check=False)
        error = done.stderr.decode()
        self.assertEqual(done.returncode, code, (arguments, error))
        if says is not None:
            self.assertIn(says, error)
        made = sorted(set(os.listdir(self.folder)) - before)
        if code != 0:
            self.assertEqual(made, [], "a refused picture leaves nothing")
            self.assertTrue(error.startswith("plumb: ") and error.count("\n") == 1, error)
        if leaves is not None:
            self.assertEqual(made, sorted(leaves))
        return done

    def render(self, *arguments, **keywords):
        return self.expect(0, "render", *arguments, "--device", "twin", **keywords)

    def plane(self, name):
        return numpy.load(self.path(name))


class Stereo(Modes):
    def setUp(self):
        super().setUp()
        # Before the screen, in it, and behind it.
        self.write("cards.toml", CARDS + card("near", -12, -20) + card("middle", 0, 0) + card("far", 18, 60))

    def edges(self, name):  # first column of each object in the middle row
        row = self.plane(name)[32]
        return [int(numpy.argmax(row == i)) for i in range(3)]

    def test_parallax_falls_with_distance_and_is_0_at_the_screen(self):
        self.render("cards.toml", "-o", "{eye}_{aov}.npy", "--aov", "color,object_id", "--stereo", "pair", "--eye-separation", "10",
                    leaves=["left_color.npy", "left_object_id.npy", "right_color.npy", "right_object_id.npy"])
        left, right = self.edges("left_object_id.npy"), self.edges("right_object_id.npy")
        parallax = [a - b for a, b in zip(left, right)]
        # focal separation (1/w - 1/d) with d = 100, and each window moved by whole pixels: off by less than a pixel an eye.
        for got, w in zip(parallax, (80, 100, 160)):
            self.assertLess(abs(got - 100 * 10 * (1 / w - 1 / 100)), 2)
        self.assertGreater(parallax[0], parallax[1])
        self.assertEqual(parallax[1], 0)
        self.assertGreater(parallax[1], parallax[2])
        self.assertEqual(self.plane("left_color.npy").shape, (64, 96, 4))

    def test_side_by_side_and_anaglyph_are_the_pair(self):
        for extra in ([], ["--samples", "4", "--shading", "wire"]):
            self.render("cards.toml", "-o", "{eye}.npy", "--stereo", "pair", *extra)
            self.render("cards.toml", "-o", "both.npy", "--stereo", "side-by-side", *extra)
            self.render("cards.toml", "-o", "glasses.npy", "--stereo", "anaglyph", *extra)
            left, right = self.plane("left.npy"), self.plane("right.npy")
            self.assertFalse((left == right).all())
            self.assertTrue((self.plane("both.npy") == numpy.concatenate([left, right], axis=1)).all())
            glasses = self.plane("glasses.npy")
            self.assertTrue((glasses[..., 0] == left[..., 0]).all() and (glasses[..., 1:] == right[..., 1:]).all())

    def test_the_line_names_every_file_and_the_size_that_was_written(self):
        line = lambda *arguments: self.render("cards.toml", *arguments).stderr.decode()
        self.assertTrue(line("-o", "a_{eye}.png", "--stereo", "pair").startswith("a_left.png, a_right.png: 96x64 unlit pair, 6 triangles, "))
        self.assertTrue(line("-o", "b.png", "--stereo", "side-by-side").startswith("b.png: 192x64 unlit side-by-side, "))
        self.assertTrue(line("-o", "c_{field}.png", "--interlace").startswith("c_odd.png, c_even.png: 96x64 unlit in two fields, "))

    def test_the_device_draws_the_same_pair(self):
        self.expect(0, "render", "cards.toml", "-o", "device_{eye}.png", "--stereo", "pair", "--require-device", "lavapipe")
        self.render("cards.toml", "-o", "twin_{eye}.png", "--stereo", "pair")
        for eye in ("left", "right"):
            self.assertEqual(self.read(f"device_{eye}.png"), self.read(f"twin_{eye}.png"))

    def test_the_report_says_how(self):
        report = json.loads(self.render("cards.toml", "-o", "a.png", "--stereo", "anaglyph", "--json").stdout)
        self.assertEqual(report["stereo"], {"form": "anaglyph", "eyeSeparation": 100 / 30, "shiftPixels": 2})
        self.assertNotIn("stereo", json.loads(self.render("cards.toml", "-o", "b.png", "--json").stdout))

    def test_what_is_refused(self):
        self.expect(2, "render", "cards.toml", "-o", "a.png", "--stereo", "pair", says="{eye}")
        self.expect(2, "render", "cards.toml", "-o", "a_{eye}.png", says="{eye}")
        self.expect(2, "render", "cards.toml", "-o", "a.png", "--stereo", "cross-eyed", says="accepted: pair, side-by-side, anaglyph")
        self.expect(2, "render", "cards.toml", "-o", "a.png", "--eye-separation", "1", says="--stereo")
        self.expect(2, "render", "cards.toml", "-o", "a.png", "--stereo", "anaglyph", "--eye-separation", "0", says="--eye-separation")
        self.expect(2, "render", "cards.toml", "-o", "a.png", "--stereo", "anaglyph", "--eye-separation", "1000", says="so far apart")
        self.expect(2, "render", "cards.toml", "-o", "a.exr", "--stereo", "side-by-side", "--aov", "depth", says="depth")
        self.expect(2, "render", "cards.toml", "-o", "a.png", "--stereo", "anaglyph", "--background", "transparent", says="alpha")
        self.expect(2, "render", "cards.toml", "-o", "a.png", "--stereo", "anaglyph", "--with-error", says="one eye")
        self.expect(2, "render", self.scene("notes-20-spheres.toml"), "-o", "a.png", "--stereo", "anaglyph", says="parallel projection")


class Fields(Modes):
    def test_fields_recombine_to_the_progressive_picture(self):
        cylinder = self.scene("cylinder.toml")
        for size in ("61x47", "60x48"):
            self.render(cylinder, "-o", "whole_{aov}.npy", "--aov", "color,depth", "--size", size)
            self.render(cylinder, "-o", "{field}_{aov}.npy", "--aov", "color,depth", "--size", size, "--interlace")
            for aov in ("color", "depth"):
                whole, odd, even = (self.plane(f"{part}_{aov}.npy") for part in ("whole", "odd", "even"))
                woven = numpy.empty_like(whole)
                woven[0::2], woven[1::2] = odd, even  # line 1 is row 0
                self.assertEqual(woven.tobytes(), whole.tobytes())

    def test_fields_of_both_eyes(self):
        self.render(self.scene("pyramid.toml"), "-o", "{eye}_{field}.png", "--stereo", "pair", "--interlace", "--size", "40x30",
                    leaves=["left_even.png", "left_odd.png", "right_even.png", "right_odd.png"])

    def test_what_is_refused(self):
        pyramid = self.scene("pyramid.toml")
        self.expect(2, "render", pyramid, "-o", "a.png", "--interlace", says="{field}")
        self.expect(2, "render", pyramid, "-o", "a_{field}.png", says="--interlace")
        self.expect(2, "render", pyramid, "-o", "a_{field}.png", "--interlace", "--size", "40x1", says="no even lines")


class Separations(Modes):
    def test_inks_add_up_to_the_picture(self):
        box = self.scene("cornell.toml")
        self.render(box, "-o", "rgb.npy", "--size", "64x48")
        rgb = self.plane("rgb.npy")[..., :3].astype(int)
        self.render(box, "-o", "{ink}.png", "--separations", "cmyk", "--size", "64x48", leaves=["black.png", "cyan.png", "magenta.png", "yellow.png"])
        ink = [grey_png(self.read(f"{name}.png")).astype(int) for name in ("cyan", "magenta", "yellow", "black")]
        for channel in range(3):
            light = (255 - ink[channel]) * (255 - ink[3])
            self.assertTrue(((2 * light + 255) // 510 == rgb[..., channel]).all())
        self.assertTrue((numpy.minimum(numpy.minimum(ink[0], ink[1]), ink[2]) == 0).all(), "full black generation")
        self.render(box, "-o", "cmy_{ink}.png", "--separations", "cmy", "--size", "64x48", leaves=["cmy_cyan.png", "cmy_magenta.png", "cmy_yellow.png"])
        for channel, name in enumerate(("cyan", "magenta", "yellow")):
            self.assertTrue((255 - grey_png(self.read(f"cmy_{name}.png")).astype(int) == rgb[..., channel]).all())

    def test_what_is_refused(self):
        pyramid = self.scene("pyramid.toml")
        self.expect(2, "render", pyramid, "-o", "a.png", "--separations", "cmyk", says="{ink}")
        self.expect(2, "render", pyramid, "-o", "-", "--separations", "cmyk", says="{ink}")
        self.expect(2, "render", pyramid, "-o", "a_{ink}.png", says="--separations")
        self.expect(2, "render", pyramid, "-o", "a_{ink}.png", "--separations", "rgb", says="cmy, cmyk")
        self.expect(2, "render", pyramid, "-o", "a_{ink}.exr", "--separations", "cmy", says="grey PNG")
        self.expect(2, "render", pyramid, "-o", "a_{ink}.png", "--separations", "cmy", "--bits", "16", says="8 bits")
        self.expect(2, "render", pyramid, "-o", "a_{ink}.png", "--separations", "cmy", "--background", "transparent", says="transparent")


class Drawing(Modes):
    def counters(self, *arguments):
        return json.loads(self.render(*arguments, "-o", "counted.png", "--json").stdout)["counters"]

    def test_edges_of_a_wire_frame_are_counted(self):
        wire = [self.scene("pyramid.toml"), "--shading", "wire"]
        self.assertEqual(self.counters(*wire)["edges"], 8)
        self.assertEqual(self.counters(*wire, "--edges", "polygons")["edges"], 16)
        self.assertEqual(self.counters(*wire, "--wire", "culled")["edges"], 7)
        self.expect(2, "render", self.scene("pyramid.toml"), "-o", "a.png", "--wire", "solid", says="--shading wire")
        self.expect(2, "render", *wire, "-o", "a.png", "--wire", "hidden", says="see-through, culled, solid")

    def test_device_and_twin_remove_the_same_lines(self):
        for scene in ("cylinder.toml", "still-life.toml"):
            self.expect(0, "verify", self.scene(scene), "--shading", "wire", "--wire", "solid", "--size", "201x133")

    def test_wire_choices_of_a_scene_file_are_those_of_the_flags(self):
        with open(self.scene("pyramid.toml"), encoding="utf-8") as f:
            text = f.read()
        self.write("solid.toml", text.replace('shading = "flat"', 'shading = "wire"\nwire = "solid"\nedges = "polygons"'))
        self.render("solid.toml", "-o", "a.npy")
        self.render(self.scene("pyramid.toml"), "-o", "b.npy", "--shading", "wire", "--wire", "solid")
        self.assertEqual(self.read("a.npy"), self.read("b.npy"))

    def test_culling_on_and_off(self):
        for fill in ("exact", "notes"):
            self.assertGreater(self.counters(self.scene("pyramid.toml"), "--fill", fill)["culledBackFace"], 0)
            self.assertEqual(self.counters(self.scene("pyramid.toml"), "--fill", fill, "--cull", "off")["culledBackFace"], 0)

    def test_a_distant_viewer_is_a_choice(self):
        cylinder = self.scene("cylinder.toml")
        self.expect(0, "verify", cylinder, "--viewer", "distant", "--size", "133x97")
        self.render(cylinder, "-o", "local.npy", "--size", "64x64")
        self.render(cylinder, "-o", "distant.npy", "--size", "64x64", "--viewer", "distant")
        self.assertNotEqual(self.read("local.npy"), self.read("distant.npy"))
        with open(cylinder, encoding="utf-8") as f:
            self.write("far.toml", 'viewer = "distant"\n' + f.read())
        self.render("far.toml", "-o", "key.npy", "--size", "64x64")
        self.assertEqual(self.read("key.npy"), self.read("distant.npy"))
        self.expect(2, "render", cylinder, "-o", "a.png", "--viewer", "distant", "--shading", "ray", says="raster shadings")

    def test_the_notes_fill_takes_samples_and_has_a_truth(self):
        cylinder = self.scene("cylinder.toml")
        self.expect(0, "verify", cylinder, "--fill", "notes", "--samples", "4", "--size", "133x97")
        report = json.loads(self.render(cylinder, "-o", "a.png", "--fill", "notes", "--with-error", "--size", "200x200", "--json").stdout)
        self.assertGreater(report["error"]["wrongPrimitive"], 0)  # corners on whole pixels, both ends painted
        # Along the outline only, which the notes paint up to a pixel wider on each side.
        self.assertLess(report["error"]["wrongPrimitiveShare"], 0.1)

    def test_the_20_spheres_have_a_truth_of_their_own(self):
        done = self.render(self.scene("notes-20-spheres.toml"), "-o", "a.png", "--with-error", "--json", "--strict")
        error = json.loads(done.stdout)["error"]
        self.assertEqual((error["pixels"], error["wrongPrimitive"]), (20 * 7845, 0))
        self.assertGreater(error["unrounded"]["rms"], 0, "the notes' program rounds heights")
        self.assertNotIn("not drawn", done.stderr.decode())
        self.assertIn("20 spheres", done.stderr.decode())

    def test_spheres_take_the_choices_of_the_specular_power(self):
        spheres, rms = self.scene("notes-20-spheres.toml"), {}
        for power in ("exact", "native", "schlick"):
            self.expect(0, "verify", spheres, "--trade", f"specular={power}", "--require-device", "lavapipe")
            done = self.expect(0, "render", spheres, "-o", f"{power}.png", "--trade", f"specular={power}", "--with-error", "--json", "--require-device", "lavapipe")
            rms[power] = json.loads(done.stdout)["error"]["unrounded"]["rms"]
        self.assertLess(rms["native"], rms["schlick"], "the device's own power is a power, Schlick's quotient is none")

    def test_what_a_raster_picture_leaves_to_rays_is_said_or_refused(self):
        mirror = Refusals.OBJECT + "material = 'm'\n[[material]]\nname = 'm'\nreflect = 0.5\n"
        self.write("mirror.toml", mirror)
        said = "material 'm' reflects 0.5; only --shading ray"
        self.assertIn(said, self.render("mirror.toml", "-o", "a.png", "--shading", "phong").stderr.decode())
        self.expect(3, "render", "mirror.toml", "-o", "b.png", "--shading", "phong", "--strict", says=said)
        self.render("mirror.toml", "-o", "c.png", "--strict")
        self.write("ball.toml", "handedness = 'left'\nfill = 'notes'\nsize = [64, 48]\n[camera]\ndistance = 500\n[[material]]\nname = 'm'\nreflect = 0.5\n"
                   "[[sphere]]\ncentre = [0, 0, 100]\nradius = 20\nmaterial = 'm'\n")
        self.assertIn(said, self.render("ball.toml", "-o", "d.png").stderr.decode())
        self.expect(3, "render", "ball.toml", "-o", "e.png", "--strict", says=said)

    def test_an_empty_picture_says_why(self):
        said = lambda *arguments: self.render("turned.toml", "-o", "a.png", *arguments).stderr.decode()
        self.write("turned.toml", "[camera]\neye = [0.3, 0.3, -3]\nat = [0.3, 0.3, 0]\n" + Refusals.MESH)
        for fill in ("exact", "notes"):
            self.assertIn("nothing is seen: every polygon faces away from the viewer; --cull off draws them", said("--fill", fill))
            self.assertNotIn("nothing is seen", said("--fill", fill, "--cull", "off"))
        self.assertIn("nothing is seen: every object is outside the view", said("--at", "0,0,-9"))

    def test_the_report_compares_its_time_with_frame_rates(self):
        rate = json.loads(self.render(self.scene("pyramid.toml"), "-o", "a.png", "--json").stdout)["frame_rate"]
        self.assertGreater(rate["per_second"], 0)
        self.assertEqual(rate["holds_30"], rate["per_second"] >= 30)
        self.assertEqual(rate["holds_60"], rate["per_second"] >= 60)


class Flattened(Modes):
    """A scale of 0 does what 5.2 of the notes says: the object becomes flat, a line, a point. Nothing is refused, and what leaves nothing to see is said."""

    HEAD = "size = [64, 48]\nbackground = '#203040'\ncull = false\n[camera]\neye = [2, 3, 6]\nat = [0, 0, 0]\n[[light]]\ntype = 'directional'\ndirection = [1, 2, 3]\n"
    BOX = ("[[mesh]]\nname = 'box'\nvertices = [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]]\n"
           "faces = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [2, 3, 7, 6], [1, 2, 6, 5], [0, 4, 7, 3]]\n")
    SHEET = "[[mesh]]\nname = 'box'\nvertices = [[-1, 0, -1], [-1, 0, 1], [1, 0, 1], [1, 0, -1]]\nfaces = [[0, 1, 2, 3]]\n"
    # Transforms, and whether they leave an area.
    ROWS = [("[{ scale = [1, 0, 1] }]", True), ("[{ rotate_x = 20 }, { scale = [1, 0, 1] }, { rotate_z = 33 }, { rotate_y = 7 }]", True),
            ("[{ matrix = [1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1] }]", True), ("[{ scale = [0, 0, 1] }]", False), ("[{ scale = 0 }]", False),
            ("[{ rotate_x = 20 }, { scale = [0, 0, 1] }, { rotate_y = 33 }]", False)]
    WAYS = [[], ["--shading", "flat"], ["--shading", "gouraud"], ["--shading", "ray"], ["--fill", "notes"], ["--fill", "notes", "--shading", "flat"], ["--shading", "wire"]]

    def covered(self, way, name):
        picture = self.path("ids.npy")
        self.expect(0, "render", name, *way, "--aov", "object_id", "-o", picture)
        return numpy.load(picture).reshape(48, 64) != 0xffffffff

    def test_device_and_twin_agree_and_warnings_say_what_is_left(self):
        for transform, area in self.ROWS:
            self.write("flat.toml", self.HEAD + self.BOX + f"[[object]]\nname = 'flat'\nmesh = 'box'\ntransform = {transform}\n")
            for way in self.WAYS:
                with self.subTest(transform=transform, way=way):
                    self.expect(0, "verify", "flat.toml", *way)
                    done = self.expect(0, "render", "flat.toml", *way, "-o", "flat.png")
                    warned = b"object 'flat' is flattened to a line or a point" in done.stderr
                    self.assertNotEqual(warned, area, done.stderr)
                    # A wire frame draws the line, and so does the notes' fill, whose polygons are a pixel wide at least (errata B12).
                    if "wire" not in way and (area or "notes" not in way):
                        self.assertEqual(self.covered(way, "flat.toml").any(), area)

    def test_a_flattened_box_is_the_sheet(self):
        for name, mesh, transform in (("flat.toml", self.BOX, "transform = [{ scale = [1, 0, 1] }]"), ("sheet.toml", self.SHEET, "")):
            self.write(name, self.HEAD + mesh + f"[[object]]\nmesh = 'box'\n{transform}\n")
        for way in self.WAYS:
            with self.subTest(way=way):
                flat, sheet = self.covered(way, "flat.toml"), self.covered(way, "sheet.toml")
                self.assertTrue(sheet.any())
                # The sides of the box are lines; the notes' fill paints those as well, both ends.
                numpy.testing.assert_array_equal(flat & sheet if "notes" in way else flat, sheet)


class Refusals(Modes):
    """Each is one line that names file, line, column and field; exit 3."""

    MESH = "[[mesh]]\nname = 'm'\nvertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]\nfaces = [[0, 1, 2]]\n"
    OBJECT = MESH + "[[object]]\nmesh = 'm'\n"
    ROWS = [
        (OBJECT + "transform = [{ rotate = { axis = [0, 0, 0], degrees = 30 } }]", "bad.toml:7:34: object.transform[0].rotate.axis is the zero vector"),
        (OBJECT + "transform = [{ rotate = { from = [1, 2, 3], to = [1, 2, 3], degrees = 30 } }]", "bad.toml:7:50: object.transform[0].rotate.to is the same point as from"),
        ("up = [0, 0, 0]\n" + MESH, "bad.toml:1:6: up is the zero vector"),
        (MESH.replace("[[0, 1, 2]]", "[[0, 1]]"), "bad.toml:4:10: mesh.faces[0] has 2 vertices; a polygon has at least 3"),
        (MESH + "[[light]]\ntype = 'area'\nposition = [0, 0, 0]\nedge_u = [0, 0, 0]\npoints = 4", "bad.toml:8:10: light.edge_u is the zero vector"),
        (MESH + "[[light]]\ntype = 'area'\nposition = [0, 0, 0]\nedge_u = [1, 0, 0]\nedge_v = [0, 1, 0]\npoints = [100, 100]",
         "bad.toml:10:10: light.points makes 10000 points; an area light has at most 4096"),
        (MESH + "[[light]]\ntype = 'area'\nposition = [0, 0, 0]\nedge_u = [1, 0, 0]\npoints = 0", "bad.toml:9:10: light.points is 0, outside 1 to 4096"),
        (MESH + "[[light]]\ntype = 'point'\nposition = [0, 0, 0]\npoints = 4", "bad.toml:8:10: light.points needs type = \"area\""),
        ("background = { cmyk = [0, 0, 0] }\n" + MESH, "bad.toml:1:23: background.cmyk has 3 numbers, not 4"),
        ("background = { cmy = [0, 0, 2] }\n" + MESH, "bad.toml:1:29: background.cmy[2] is 2, outside 0 to 1"),
        ("background = { hsv = [0, 0, 0] }\n" + MESH, "bad.toml:1:16: unknown key 'hsv' in background"),
        (MESH + "[[material]]\nname = 'x'\nshininess = 1000001", "bad.toml:7:13: material.shininess is 1000001, outside 0 to 1e+06"),
        (MESH + "[[material]]\nname = 'x'\nshininess = 1e9", "bad.toml:7:13: material.shininess is 1e+09, outside 0 to 1e+06"),
        ("wire = 'hidden'\n" + MESH, "bad.toml:1:8: wire is 'hidden'"),
        ("viewer = 'far'\n" + MESH, "bad.toml:1:10: viewer is 'far'"),
        ("edges = 'twice'\n" + MESH, "bad.toml:1:9: edges is 'twice'"),
    ]

    def test_each_names_file_line_and_field(self):
        for text, message in self.ROWS:
            self.write("bad.toml", text)
            done = self.expect(3, "render", "bad.toml", "-o", "a.png", "--device", "twin")
            self.assertTrue(done.stderr.decode().startswith("plumb: " + message), (message, done.stderr))

    def test_a_polygon_that_crosses_itself_is_refused_where_it_stands(self):
        """By the fill of the notes; the exact fill cuts it as a fan and warns."""
        plane = "handedness = 'left'\n[camera]\ndistance = 500\n[[mesh]]\nname = 'm'\n"
        star = plane + "vertices = [[0, 20], [12, -16], [-19, 6], [19, 6], [-12, -16]]\nfaces = [[0, 3, 1],\n [0, 1, 2, 3, 4]]\n"
        tie = plane + "vertices = [[-20, -10], [20, 10], [20, -10], [-20, 10]]\nfaces = [[0, 1, 2, 3]]\n"
        for text, face in ((star, 1), (tie, 0)):
            self.write("bad.toml", text)
            done = subprocess.run([PLUMB, "render", "bad.toml", "-o", "a.png", "--fill", "notes", "--device", "twin"], cwd=self.folder, capture_output=True, timeout=120, check=False)
            self.assertEqual(done.returncode, 3)
            self.assertEqual(done.stderr.decode().splitlines()[-1], f"plumb: bad.toml:7:9: mesh.faces[{face}] crosses itself (object 'm'), and --fill notes fills simple polygons")
            self.assertFalse(os.path.exists(self.path("a.png")))
            self.render("bad.toml", "-o", "b.png", "--fill", "exact")
        # A long one is cut as any other: a comb.
        comb = [[x, 9 if x % 2 else 1] for x in range(8200)] + [[8200, 0], [0, 0]]
        self.write("bad.toml", plane + f"vertices = {comb}\nfaces = [{list(range(len(comb)))}]\n")
        self.assertIn("8200 triangles", self.expect(0, "render", "bad.toml", "-o", "comb.png").stderr.decode())
        with open(self.path("star.off"), "w", encoding="utf-8") as f:
            f.write("OFF\n5 1 0\n0 20 0\n12 -16 0\n-19 6 0\n19 6 0\n-12 -16 0\n5 0 1 2 3 4\n")
        done = subprocess.run([PLUMB, "render", "star.off", "-o", "a.png", "--fill", "notes", "--device", "twin"], cwd=self.folder, capture_output=True, timeout=120, check=False)
        self.assertEqual(done.returncode, 3)
        self.assertTrue(done.stderr.decode().splitlines()[-1].startswith("plumb: star.off: mesh.faces[0] crosses itself"), done.stderr)

    def test_so_does_a_mesh_file_whose_only_polygon_has_two_vertices(self):
        self.write("bad.obj", "v 0 0 0\nv 1 0 0\nf 1 2\n")
        self.assertTrue(self.expect(3, "render", "bad.obj", "-o", "a.png", "--device", "twin").stderr.decode().startswith("plumb: bad.obj:3:6: no face has 3 corners or more: the file has no face"))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
