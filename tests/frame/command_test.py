#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The command as a user meets it: exit codes, what goes to which stream, which files exist afterwards.

usage: command_test.py PLUMB PLUMB_FAULTY [unittest arguments]   (PLUMB_FAULTY: tests/frame/faulty_renderer.cpp)
"""
import csv
import json
import os
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import unittest

PLUMB, FAULTY = sys.argv[1:3]
CUBE = """v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1
f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 1 5 8 4\n"""
NONE = {"VK_ICD_FILENAMES": "/nonexistent", "VK_DRIVER_FILES": "/nonexistent", "PLUMB_VALIDATION": "0"}


def png_size(data):
    assert data[:8] == b"\x89PNG\r\n\x1a\n", data[:8]
    return struct.unpack(">II", data[16:24])


class Command(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="plumb-command-")
        self.addCleanup(shutil.rmtree, self.folder)
        self.write("cube.obj", CUBE)

    def write(self, name, text):
        with open(os.path.join(self.folder, name), "w", encoding="utf-8") as f:
            f.write(text)

    def read(self, name):
        with open(os.path.join(self.folder, name), "rb") as f:
            return f.read()

    def files(self):
        return sorted(os.listdir(self.folder))

    def run_plumb(self, *arguments, program=PLUMB, env=None, **keywords):
        return subprocess.run([program, *arguments], cwd=self.folder, env={**os.environ, **(env or {})}, stdin=subprocess.DEVNULL,
                              capture_output=not keywords, timeout=120, check=False, **keywords)

    def expect(self, code, *arguments, says=None, **keywords):
        done = self.run_plumb(*arguments, **keywords)
        self.assertEqual(done.returncode, code, (arguments, done.stderr))
        if says is not None:
            self.assertIn(says, done.stderr.decode())
        if code != 0:
            self.assertTrue(done.stderr.startswith(b"plumb: ") or b"\nplumb: " in done.stderr, done.stderr)
        return done

    def twin(self, code, *arguments, **keywords):  # small and without a device
        return self.expect(code, *arguments, "--device", "twin", "--size", "64x48", **keywords)


class Rendering(Command):
    def test_device_and_twin_write_the_same_file(self):
        done = self.expect(0, "render", "cube.obj", "-o", "device.png", "--size", "64x48")
        self.assertEqual(done.stdout, b"")
        self.expect(0, "render", "cube.obj", "-o", "twin.png", "--size", "64x48", "--device", "twin")
        self.assertEqual(png_size(self.read("device.png")), (64, 48))
        self.assertEqual(self.read("device.png"), self.read("twin.png"))

    def test_order_of_flags_changes_nothing(self):
        self.twin(0, "render", "cube.obj", "-o", "a.png", "--shading", "flat", "--view", "iso")
        self.twin(0, "--view", "iso", "-o", "b.png", "--shading=flat", "render", "cube.obj")
        self.assertEqual(self.read("a.png"), self.read("b.png"))

    def test_dash_is_a_png_on_stdout(self):
        done = self.twin(0, "render", "cube.obj", "-o", "-")
        self.assertEqual(png_size(done.stdout), (64, 48))
        self.assertEqual(self.files(), ["cube.obj"])
        self.twin(2, "render", "cube.obj", "-o", "-", "--json", says="standard output")
        done = self.twin(0, "render", "cube.obj", "-o", "-", "--json=r.json")
        png_size(done.stdout)
        json.loads(self.read("r.json"))

    def test_quiet_says_nothing(self):
        done = self.twin(0, "render", "cube.obj", "-o", "a.png", "-q")
        self.assertEqual((done.stdout, done.stderr), (b"", b""))

    def test_no_clobber_refuses(self):
        self.twin(0, "render", "cube.obj", "-o", "a.png", "--no-clobber")
        before = self.read("a.png")
        self.twin(2, "render", "cube.obj", "-o", "a.png", "--no-clobber", "--shading", "flat", says="--no-clobber")
        self.assertEqual(self.read("a.png"), before)

    def test_report_has_its_keys(self):
        done = self.expect(0, "render", "cube.obj", "-o", "a.png", "--size", "64x48", "--json")
        report = json.loads(done.stdout)
        for key in ("tool", "host", "device", "fallback", "scene", "camera", "options", "plan", "time_ms", "image", "counters", "determinism", "memory", "output"):
            self.assertIn(key, report)
        self.assertEqual(set(report["tool"]), {"version", "git", "spirv"})
        self.assertTrue(report["tool"]["spirv"])
        self.assertTrue(all(len(h) == 64 for h in report["tool"]["spirv"].values()))
        self.assertTrue({"cpu_vendor", "cpu_model", "threads"} <= set(report["host"]))
        self.assertTrue({"name", "type", "driver", "driverInfo", "api", "limits", "reason"} <= set(report["device"]))
        self.assertTrue({"path", "sha256", "triangles", "objects", "ignored", "warnings"} <= set(report["scene"]))
        self.assertEqual(report["scene"]["triangles"], 12)
        self.assertEqual(set(report["plan"]), {"passes", "steps", "skipped", "choices"})
        self.assertEqual([step["pass"] for step in report["plan"]["steps"]], report["plan"]["passes"])
        self.assertEqual({s["pass"] for s in report["plan"]["steps"] if s["ran"] and not s["fused_in"]}, set(report["time_ms"]["passes"]))
        self.assertTrue({"load", "device", "passes", "render", "write", "total"} <= set(report["time_ms"]))
        self.assertTrue({"sha256_pixels", "size", "covered", "distinct_colours", "blank", "nan", "inf"} <= set(report["image"]))
        self.assertEqual(report["image"]["size"], [64, 48])
        self.assertTrue(0.05 < report["image"]["covered"] < 0.9)
        self.assertFalse(report["image"]["blank"])
        self.assertEqual(report["determinism"], "bits")
        self.assertEqual(report["output"], ["a.png"])
        twin = json.loads(self.twin(0, "render", "cube.obj", "-o", "b.png", "--json").stdout)
        self.assertEqual(twin["device"]["type"], "twin")
        self.assertEqual(twin["image"]["sha256_pixels"], report["image"]["sha256_pixels"])

    def test_error_is_measured_and_changes_no_byte(self):
        plain = self.expect(0, "render", "cube.obj", "-o", "a.png", "--size", "64x48")
        self.assertNotIn(b"error in steps", plain.stderr)
        done = self.expect(0, "render", "cube.obj", "-o", "b.png", "--size", "64x48", "--with-error", "--json", says="error in steps of 1/255")
        self.assertEqual(self.read("a.png"), self.read("b.png"))
        report = json.loads(done.stdout)
        error = report["error"]
        self.assertEqual(report["truth"]["samples"], 1)
        self.assertIn("truth", report["time_ms"])
        self.assertTrue(0 < error["rms"] <= error["max"] and 0 < error["linear"]["max"], error)
        self.assertLess(error["mean"], 1 / 255)
        x, y = error["maxAt"]
        self.assertTrue(0 <= x < 64 and 0 <= y < 48)
        flat = json.loads(self.twin(0, "render", "cube.obj", "-o", "c.png", "--shading", "unlit", "--with-error", "--json").stdout)["error"]
        self.assertGreater(flat["rms"], 10 * error["rms"])
        self.twin(2, "render", "cube.obj", "-o", "w.png", "--shading", "wire", "--with-error", says="wire frame has no truth")
        self.assertEqual(self.files(), ["a.png", "b.png", "c.png", "cube.obj"])

    def test_pixels_are_certified(self):
        done = self.twin(0, "render", "cube.obj", "-o", "{aov}.npy", "--aov", "error,certified,color,id", "--json", says="certified to half a step: ")
        report = json.loads(done.stdout)["certificate"]
        header = 128  # of an NPY of this size
        steps, grades = (list(struct.iter_unpack(code, self.read(name)[header:])) for code, name in (("<f", "error.npy"), ("<I", "certified.npy")))
        ids = list(struct.iter_unpack("<I", self.read("object_id.npy")[header:]))
        self.assertEqual((len(steps), len(grades)), (64 * 48, 64 * 48))
        for (step,), (grade,) in zip(steps, grades):
            self.assertEqual(grade, 0 if step == float("inf") else 3 if step <= 0.5 else 2 if step <= 1 else 1)
            self.assertGreater(step, 0)  # no certificate is without the truth's own error
        shown = [grade for (grade,), (thing,) in zip(grades, ids) if thing != 0xffffffff]
        self.assertTrue(0 < report["halfStep"] <= report["oneStep"] <= report["pixels"], report)
        self.assertLessEqual(abs(report["pixels"] - len(shown)), report["pixels"] // 50)  # pixels on the outline may show what the truth does not
        self.assertGreaterEqual(report["oneStep"], sum(grade >= 2 for grade in shown))
        self.assertEqual((report["open"], report["halfStepShare"]), (0, report["halfStep"] / report["pixels"]))
        x, y = report["maxAt"]
        self.assertEqual(struct.pack("<f", report["max"] * 255), struct.pack("<f", steps[64 * y + x][0]))
        plain = self.twin(0, "render", "cube.obj", "-o", "plain.npy")
        self.assertNotIn(b"certified", plain.stderr)
        self.assertEqual(self.read("plain.npy"), self.read("color.npy"))
        flat = json.loads(self.twin(0, "render", "cube.obj", "-o", "flat.exr", "--shading", "unlit", "--aov", "error,certified", "--json").stdout)["certificate"]
        self.assertLess(flat["oneStep"], report["oneStep"])
        self.assertIn(b"plumb:error", self.read("flat.exr"))
        self.twin(2, "render", "cube.obj", "-o", "w.npy", "--shading", "wire", "--aov", "certified", says="--aov error, certified: a wire frame has no truth")
        self.twin(2, "render", "cube.obj", "-o", "e{eye}.npy", "--stereo", "pair", "--aov", "error", says="one eye")
        self.twin(2, "render", "cube.obj", "-o", "a.png", "--aov", "error", says="holds color only")

    def test_trades_change_the_picture_and_are_refused_by_name(self):
        self.twin(0, "render", "cube.obj", "-o", "a.png")
        for trade in ("interpolation=affine,light-vector=scene", "light-vector=face,transform=fp64", "light-vector=vertex,transform=block-integer", "subpixel=4", "rate=1/2"):
            self.twin(0, "render", "cube.obj", "-o", "b.png", "--trade", trade)
            self.assertNotEqual(self.read("a.png"), self.read("b.png"), trade)
        self.twin(0, "render", "cube.obj", "-o", "b.png", "--trade", "depth=reversed-32,specular=exact")
        self.assertEqual(self.read("a.png"), self.read("b.png"))
        for trade, says in (("shading=flat", "--trade"), ("depth=15", "accepted for depth: reversed-32, standard-32, 24, 16"), ("specular=quick", "accepted for specular: exact, schlick, native"), ("rate=1/4", "accepted for rate: 1, 1/2"),
                            ("depth=16,depth=24", "--trade"), ("depth", "--trade")):
            self.twin(2, "render", "cube.obj", "-o", "c.png", "--trade", trade, says=says)
        self.assertEqual(self.files(), ["a.png", "b.png", "cube.obj"])
        self.expect(0, "verify", "cube.obj", "--size", "64x48", "--trade", "specular=schlick,depth=16,subpixel=4,interpolation=affine,light-vector=scene,normals=as-interpolated,rate=1/2")
        self.twin(2, "render", "cube.obj", "-o", "c.png", "--trade", "rate=1/2,light-vector=face", says="leave rate=1/2 out")
        self.twin(2, "render", "cube.obj", "-o", "c.png", "--trade", "encode=native,light-vector=vertex", says="leave specular=native and encode=native out")
        self.twin(2, "render", "cube.obj", "-o", "c.png", "--fill", "notes", "--trade", "rate=1/2", says="--fill notes has the axis specular")
        # What the device computes its own way is compared with its bound.
        native = json.loads(self.expect(0, "verify", "cube.obj", "--size", "64x48", "--trade", "specular=native,encode=native", "--json").stdout)
        self.assertEqual(native["determinism"], "bounded")
        self.assertEqual(native["verify"]["bound"]["steps"], 1)
        self.assertGreater(max(native["verify"]["bound"]["linear"]), 0)
        self.assertTrue(all(plane["beyond"] == 0 for plane in native["verify"]["planes"]))

    def test_fp64_is_refused_where_the_device_has_none(self):
        self.expect(0, "verify", "cube.obj", "--size", "64x48", "--trade", "transform=fp64")
        self.expect(0, "verify", "cube.obj", "--size", "64x48", "--trade", "transform=block-integer")
        none = {"PLUMB_LIMITS": "float64=0"}
        self.expect(2, "render", "cube.obj", "-o", "c.png", "--trade", "transform=fp64", says="has no binary64 (shaderFloat64)", env=none)
        self.assertEqual(self.files(), ["cube.obj"])
        self.expect(0, "verify", "cube.obj", "--size", "64x48", "--trade", "transform=block-integer", env=none)
        rows = json.loads(self.expect(0, "measure", "cube.obj", "--size", "64x48", "--axis", "transform", "--repetitions", "2", "--json", env=none).stdout)["rows"]
        self.assertEqual([(r["choice"], r["absent"]) for r in rows], [("default again", False), ("fp32", False), ("fp64", True), ("block-integer", False)])
        self.assertIn("shaderFloat64", rows[2]["why"])

    def test_measure_warns_of_a_picture_that_shows_nothing(self):
        done = self.expect(0, "measure", "cube.obj", "--size", "16x16", "--eye", "0,0,9", "--at", "0,0,99", "--axis", "encode", "--repetitions", "1")
        self.assertEqual(done.stderr.count(b"nothing is seen"), 1, done.stderr)

    def test_turntable_needs_a_placeholder_and_makes_an_array(self):
        self.twin(2, "render", "cube.obj", "--turntable", "3", "-o", "spin.png", says="{n}")
        self.assertEqual(self.files(), ["cube.obj"])
        done = self.twin(0, "render", "cube.obj", "--turntable", "11", "-o", "spin_{n}.png", "--json")
        self.assertEqual(self.files(), ["cube.obj"] + [f"spin_{i:02}.png" for i in range(11)])
        reports = json.loads(done.stdout)
        self.assertEqual([r["output"] for r in reports], [[f"spin_{i:02}.png"] for i in range(11)])
        self.twin(2, "render", "cube.obj", "-o", "x_{m}.png", says="placeholders")
        self.twin(0, "render", "cube.obj", "-o", "still.png")
        self.assertEqual(self.read("still.png")[-200:], self.read("spin_00.png")[-200:], "a turn begins where the still picture stands")

    def test_views_make_a_sheet_or_several_files(self):
        self.twin(0, "render", "cube.obj", "--view", "front", "--view", "iso", "--view", "-30,20", "-o", "sheet.png")
        self.assertEqual(png_size(self.read("sheet.png")), (128, 96))
        self.twin(0, "render", "cube.obj", "--view", "front", "--view", "iso", "-o", "{view}.png")
        self.twin(0, "render", "cube.obj", "--view", "iso", "-o", "alone.png")
        self.assertEqual(self.read("iso.png"), self.read("alone.png"))
        self.twin(2, "render", "cube.obj", "--view", "front", "--view", "front", "-o", "{view}.png", says="two pictures")
        self.twin(2, "render", "cube.obj", "--view", "front", "--view", "iso", "-o", "x.exr", says="contact sheet")

    def test_planes_go_where_they_fit(self):
        self.twin(2, "render", "cube.obj", "--aov", "depth", "-o", "a.png", says="color only")
        self.twin(2, "render", "cube.obj", "--aov", "depth,normal", "-o", "a.npy", says="{aov}")
        self.twin(2, "render", "cube.obj", "--bits", "16", "-o", "a.npy", says="--bits")
        self.twin(2, "render", "cube.obj", "-o", "a.jpg", says=".png, .exr or .npy")
        self.assertEqual(self.files(), ["cube.obj"])
        self.twin(0, "render", "cube.obj", "--aov", "depth,normal,object_id,primitive_id,color,distance", "-o", "a.exr")
        self.assertEqual(self.read("a.exr")[:4], b"\x76\x2f\x31\x01")
        self.twin(0, "render", "cube.obj", "--aov", "depth,id", "-o", "p_{aov}.npy")
        depth, ids = self.read("p_depth.npy"), self.read("p_object_id.npy")
        self.assertIn(b"'<f4'", depth[:128])
        self.assertIn(b"(48, 64)", depth[:128])
        z = struct.unpack("<3072f", depth[-4 * 3072:])
        o = struct.unpack("<3072I", ids[-4 * 3072:])
        self.assertTrue(all((d == float("inf")) == (i == 0xffffffff) for d, i in zip(z, o)))
        self.assertIn(0, o)
        self.twin(0, "render", "cube.obj", "--bits", "16", "-o", "deep.png")
        self.assertEqual(self.read("deep.png")[24:26], bytes((16, 2)))
        self.twin(0, "render", "cube.obj", "--background", "transparent", "-o", "clear.png")
        self.assertEqual(self.read("clear.png")[24:26], bytes((8, 6)))

    def test_background_has_the_bytes_that_were_asked_for(self):
        for curve in ("srgb", "linear"):
            self.twin(0, "render", "cube.obj", "--background", "#1280fe", "--encode", curve, "--aov", "color", "-o", "a.npy")
            self.assertEqual(self.read("a.npy")[128:132], bytes((0x12, 0x80, 0xfe, 0xff)), curve)

    def test_explain_says_what_runs(self):
        done = self.twin(0, "render", "cube.obj", "--explain")
        self.assertIn(b"passes: ", done.stdout)
        self.assertTrue(json.loads(self.twin(0, "render", "cube.obj", "--explain", "--json").stdout)["plan"]["passes"])
        self.assertEqual(self.files(), ["cube.obj"])
        done = self.twin(0, "render", "cube.obj", "--explain", "-o", "a.png")
        self.assertEqual(done.stdout, b"")
        self.assertIn(b"passes: ", done.stderr)

    def test_camera_flags_move_the_camera(self):
        camera = json.loads(self.twin(0, "render", "cube.obj", "-o", "a.png", "--json", "--eye", "0,0,5", "--at", "0,0,0", "--fov", "40", "--near", "0.25").stdout)["camera"]
        self.assertEqual((camera["eye"], camera["forward"], camera["up"]), ([0, 0, 5], [0, 0, -1], [0, 1, 0]))
        self.assertEqual((camera["fovYDegrees"], camera["near"], camera["focusDistance"]), (40, 0.25, 5))
        self.twin(2, "render", "cube.obj", "-o", "b.png", "--eye", "1,1,1", "--at", "1,1,1", says="same point")
        self.twin(0, "render", "cube.obj", "-o", "top.png", "--eye", "0,9,0", "--at", "0,0,0")
        turn = json.loads(self.twin(0, "render", "cube.obj", "-o", "t_{n}.png", "--json", "--eye", "0,3,4", "--at", "0,0,0", "--turntable", "4").stdout)
        for report, eye in zip(turn, ((0, 3, 4), (4, 3, 0), (0, 3, -4), (-4, 3, 0))):
            for got, want in zip(report["camera"]["eye"], eye):
                self.assertAlmostEqual(got, want, 12)


class Failures(Command):
    def nothing_written(self):
        self.assertEqual(self.files(), ["cube.obj"])

    def test_usage_is_2(self):
        for arguments in (["render", "cube.obj"], ["render", "cube.obj", "-o", "a.png", "--size", "x"], ["render", "-o", "a.png"], ["nonsense"], [], ["diff", "a"],
                          ["render", "cube.obj", "-o", "a.png", "--view", "front", "--eye", "1,2,3"], ["render", "cube.obj", "-o", "."]):
            done = self.expect(2, *arguments)
            self.assertEqual(done.stderr.count(b"\n"), 1, done.stderr)
            self.assertEqual(done.stdout, b"")
        self.nothing_written()

    def test_input_is_3(self):
        self.write("bad.obj", "v 0 0 0\nf 1 2 3\n")
        self.twin(3, "render", "bad.obj", "-o", "a.png", says="bad.obj:2")
        self.twin(3, "render", "missing.obj", "-o", "a.png", says="missing.obj")
        self.twin(3, "render", "cube.xyz", "-o", "a.png")
        self.expect(3, "info", "missing.obj")
        os.remove(os.path.join(self.folder, "bad.obj"))
        self.nothing_written()

    def test_strict_refuses_a_missing_material_library(self):
        self.write("lib.obj", "mtllib none.mtl\nusemtl x\n" + CUBE)
        done = self.twin(0, "render", "lib.obj", "-o", "a.png", "--json")
        self.assertEqual(len(json.loads(done.stdout)["scene"]["warnings"]), 1)
        self.twin(3, "render", "lib.obj", "-o", "b.png", "--strict")
        self.assertNotIn("b.png", self.files())

    def test_device_is_4(self):
        self.expect(4, "render", "cube.obj", "-o", "a.png", "--require-device", "gpu")
        self.expect(4, "render", "cube.obj", "-o", "a.png", "--device", "no such device")
        self.expect(4, "devices", "--require-device", "gpu")
        self.expect(4, "verify", "cube.obj", env=NONE)
        self.expect(4, "render", "cube.obj", "-o", "a.png", "--require-device", "lavapipe", env=NONE)
        self.nothing_written()

    def test_without_an_icd_the_twin_draws_the_same(self):
        done = self.expect(0, "render", "cube.obj", "-o", "none.png", "--size", "64x48", env=NONE)
        self.assertIn(b"mesa-vulkan-drivers", done.stderr)
        self.twin(0, "render", "cube.obj", "-o", "twin.png")
        self.assertEqual(self.read("none.png"), self.read("twin.png"))
        self.expect(0, "devices", env=NONE)

    def test_write_failure_is_5(self):
        self.twin(5, "render", "cube.obj", "-o", "no/such/folder.png", says="No such file")
        with open("/dev/full", "wb") as full:
            done = self.run_plumb("render", "cube.obj", "-o", "-", "--device", "twin", "--size", "64x48", stdout=full, stderr=subprocess.PIPE)
            self.assertEqual(done.returncode, 5, done.stderr)
            self.assertEqual(self.run_plumb("info", "cube.obj", stdout=full, stderr=subprocess.PIPE).returncode, 5)
        self.nothing_written()

    def test_closed_stdout_is_5_and_no_file_gets_its_number(self):
        done = subprocess.run(["sh", "-c", f"'{PLUMB}' render cube.obj -o a.png --json --device twin --size 64x48 >&-"], cwd=self.folder, capture_output=True, check=False)
        self.assertEqual(done.returncode, 5, done.stderr)
        if "a.png" in self.files():
            self.assertNotIn(b"{", self.read("a.png")[:1])

    def test_full_disk_leaves_the_old_file(self):
        self.write("a.png", "old")
        done = subprocess.run(["bash", "-c", f"ulimit -f 1; '{PLUMB}' render cube.obj -o a.png --device twin --size 400x400"], cwd=self.folder, capture_output=True, check=False)
        self.assertEqual(done.returncode, 5, done.stderr)
        self.assertEqual(self.read("a.png"), b"old")
        self.assertEqual(self.files(), ["a.png", "cube.obj"])

    def test_blank_is_7(self):
        away = ("--eye", "0,0,9", "--at", "0,0,99", "-o", "a.png")
        done = self.twin(7, "render", "cube.obj", *away, "--fail-blank", "--json", says="blank")
        self.assertTrue(json.loads(done.stdout)["image"]["blank"])
        self.nothing_written()
        self.twin(7, "render", "cube.obj", "-o", "a.png", "--fail-blank=95%")
        self.nothing_written()
        self.twin(0, "render", "cube.obj", *away)

    def test_signals_end_the_run_and_leave_nothing(self):
        for number, code in ((signal.SIGINT, 130), (signal.SIGTERM, 143)):
            with subprocess.Popen([PLUMB, "render", "cube.obj", "-o", "a.png", "--device", "twin", "--size", "6000x6000", "--samples", "16", "--limit-band", "8", "--progress", "json"],
                                  cwd=self.folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
                for line in process.stderr:
                    if b"progress" in line and json.loads(line)["progress"] > 0:
                        break
                process.send_signal(number)
                _, rest = process.communicate(timeout=60)
                self.assertEqual(process.returncode, code, rest)
            self.nothing_written()


class Faults(Command):
    def faulty(self, code, fault, *arguments, **keywords):
        return self.expect(code, *arguments, "--size", "64x48", program=FAULTY, env={"PLUMB_FAULT": fault}, **keywords)

    def test_a_lost_device_is_opened_afresh(self):
        done = self.faulty(0, "lost-once", "render", "cube.obj", "-o", "a.png", "--json", says="opened afresh")
        report = json.loads(done.stdout)
        self.assertEqual(len(report["fallback"]), 1)
        self.assertNotEqual(report["device"]["type"], "twin")

    def test_a_device_that_fails_twice_gives_way_to_the_twin(self):
        done = self.faulty(0, "lost", "render", "cube.obj", "-o", "a.png", "--json", says="the CPU twin draws")
        report = json.loads(done.stdout)
        self.assertEqual(len(report["fallback"]), 2)
        self.assertEqual(report["device"]["type"], "twin")
        self.twin(0, "render", "cube.obj", "-o", "twin.png")
        self.assertEqual(self.read("a.png"), self.read("twin.png"))

    def test_a_required_device_is_not_replaced(self):
        self.faulty(5, "lost", "render", "cube.obj", "-o", "a.png", "--require-device", "lavapipe")
        self.assertEqual(self.files(), ["cube.obj"])

    def test_nan_is_5(self):
        self.faulty(5, "nan", "render", "cube.obj", "-o", "a.exr", says="NaN")
        self.assertEqual(self.files(), ["cube.obj"])

    def test_a_difference_is_1_with_evidence(self):
        done = self.run_plumb(
            "verify", "cube.obj", "cube.obj", "-o", "e.png", "--json", "--size", "64x48", program=FAULTY, env={"PLUMB_FAULT": "differs"})
        self.assertEqual(done.returncode, 1, done.stderr)
        reports = json.loads(done.stdout)
        self.assertEqual([r["verify"]["equal"] for r in reports], [False, False])
        self.assertIn("pixel (0, 0)", reports[0]["verify"]["mismatches"][0]["what"])
        self.assertEqual(self.files(), ["cube.obj"] + [f"e.{i}.{side}.png" for i in (0, 1) for side in ("device", "diff", "twin")])


class Verify(Command):
    def test_device_and_twin_are_equal(self):
        done = self.expect(0, "verify", "cube.obj", "--size", "64x48")
        self.assertIn(b"equal", done.stdout)
        self.assertNotIn(b"differs", done.stdout)
        report = json.loads(self.expect(0, "verify", "cube.obj", "--size", "33x21", "--samples", "4", "--json", "-o", "e.png").stdout)
        self.assertTrue(report["verify"]["equal"])
        for plane in report["verify"]["planes"]:
            self.assertEqual(plane["sha256_twin"], plane["sha256_device"])
        self.assertEqual(self.files(), ["cube.obj"])

    def test_an_empty_view_is_the_background_in_every_file(self):
        away = ["cube.obj", "--eye", "0,0,9", "--at", "0,0,99", "--size", "32x24"]
        for flags in ([], ["--samples", "4"], ["--background", "#4080c0"], ["--background", "transparent"], ["--stereo", "anaglyph", "--background", "#4080c0"]):
            self.expect(0, "verify", *away, *[f for f in flags if f not in ("--stereo", "anaglyph")], says="nothing is seen: every object is outside the view")
            for name, more in (("p.png", []), ("q.png", ["--bits", "16"]), ("e.exr", ["--aov", "color,depth,normal,id"]), ("l.npy", ["--aov", "linear"])):
                if "--stereo" in flags and name in ("e.exr", "l.npy"):
                    continue
                for side in ("auto", "twin"):
                    self.expect(0, "render", *away, *flags, *more, "--device", side, "-o", f"{side}-{name}", says="nothing is seen")
                self.assertEqual(self.read(f"auto-{name}"), self.read(f"twin-{name}"), (flags, name))
        self.expect(0, "render", *away, "--background", "#ffffff", "--aov", "linear", "-o", "w.npy")
        self.assertEqual(self.read("w.npy")[-32 * 24 * 3 * 4:], struct.pack("<f", 1.0) * (32 * 24 * 3))
        report = json.loads(self.expect(0, "verify", *away, "--json").stdout)
        self.assertEqual(report["verify"]["covered_pixels"], 0)


MIRROR = """[[material]]
name = "m"
reflect = 0.5
[[mesh]]
name = "c"
file = "cube.obj"
material = "m"
[[object]]
mesh = "c"

[[light]]
type = "directional"
direction = [0, 1, 1]
"""
SPHERE = """encoding = "linear"
[camera]
eye = [0, 1, 6]
at = [0, 0, 0]
[[material]]
name = "m"
reflect = 0.5
[[sphere]]
centre = [0, 0, 0]
radius = 1
material = "m"
[[plane]]
point = [0, -1, 0]
normal = [0, 1, 0]
[[light]]
type = "directional"
direction = [0, 1, 1]
"""


class Rays(Command):
    """What asks for rays, how they pass through pixels, and what is said about it."""

    def setUp(self):
        super().setUp()
        self.write("mirror.toml", MIRROR)
        self.write("sphere.toml", SPHERE)

    def test_a_material_asks_for_rays_and_a_flag_overrides(self):
        done = self.twin(0, "render", "mirror.toml", "--explain")
        self.assertIn(b"choice: shading ray: material 'm' reflects 0.5; --shading overrides", done.stdout)
        done = self.twin(0, "render", "mirror.toml", "--explain", "--shading", "phong")
        self.assertIn(b"dropped: reflection and refraction: material 'm' reflects 0.5; only --shading ray traces them", done.stdout)
        self.assertIn(b"not drawn: reflection and refraction", done.stderr)
        done = self.twin(0, "render", "cube.obj", "--explain")
        self.assertNotIn(b"ray", done.stdout)

    def test_illum_of_a_material_library_asks_for_rays(self):
        self.write("glass.mtl", "newmtl g\nKd 1 0 0\nKs 0.2 0.2 0.2\nd 0.25\nNi 1.5\nillum 6\n")
        self.write("glass.obj", "mtllib glass.mtl\nusemtl g\n" + CUBE)
        done = self.twin(0, "render", "glass.obj", "--explain", "--strict")
        self.assertIn(b"shading ray: material 'g' transmits 0.75", done.stdout)
        self.assertNotIn(b"not drawn", done.stderr)

    def test_each_sampling_is_the_same_on_both_sides(self):
        for i, flags in enumerate((["--sampling", "random", "--samples", "4", "--seed", "3"], ["--sampling", "corners"], ["--sampling", "adaptive"],
                                   ["--jitter", "reflect=0.1,shadow=0.05", "--samples", "4", "--sampling", "centre"], ["--sampling", "notes", "--levels", "cut"])):
            self.expect(0, "render", "sphere.toml", "-o", f"d{i}.png", "--size", "64x48", *flags)
            self.twin(0, "render", "sphere.toml", "-o", f"t{i}.png", *flags)
            self.assertEqual(self.read(f"d{i}.png"), self.read(f"t{i}.png"), flags)
            self.expect(0, "verify", "sphere.toml", "--size", "64x48", *flags)
        self.assertEqual(len({self.read(f"d{i}.png") for i in range(5)}), 5)

    def test_the_scene_states_choices_of_rays_and_flags_override(self):
        keys = 'sampling = "random"\njitter = { reflect = 0.1, shadow = 0.05 }\nseed = 3\n'
        self.write("stated.toml", keys + SPHERE)
        self.twin(0, "render", "stated.toml", "-o", "a.png", "--samples", "4")
        flags = ["--sampling", "random", "--jitter", "reflect=0.1,shadow=0.05", "--seed", "3"]
        self.twin(0, "render", "sphere.toml", "-o", "b.png", "--samples", "4", *flags)
        self.expect(0, "diff", "a.png", "b.png")  # pixels: provenance differs
        self.twin(0, "render", "stated.toml", "-o", "c.png", "--sampling", "grid", "--jitter", "reflect=0,shadow=0", "--samples", "4")
        self.twin(0, "render", "sphere.toml", "-o", "d.png", "--samples", "4")
        self.expect(0, "diff", "c.png", "d.png")
        self.expect(1, "diff", "a.png", "d.png")
        done = self.twin(0, "render", "stated.toml", "--explain", "--seed", "7")
        for line in ("sampling random: a ray anywhere in each sample's square (stated by the scene; --sampling overrides)",
                     "noise of 0.1 on reflected rays, seed 7 (stated by the scene; --jitter overrides)", "seed 7 (stated by --seed)"):
            self.assertIn(("choice: " + line).encode(), done.stdout)
        done = self.twin(0, "render", "sphere.toml", "--explain")
        self.assertNotIn(b"stated by", done.stdout)
        self.write("corners.toml", 'sampling = "corners"\n' + SPHERE)
        self.twin(2, "render", "corners.toml", "-o", "e.png", "--samples", "4", says="the scene's sampling = \"corners\"")
        self.twin(0, "render", "corners.toml", "-o", "f.png", "--samples", "4", "--sampling", "grid")
        self.write("levels.toml", 'encoding = "linear"\nlevels = "cut"\n' + SPHERE.replace('encoding = "linear"\n', ""))
        self.assertIn(b"levels cut: colours are whole levels, cut after each ray (stated by the scene; --levels overrides)", self.twin(0, "render", "levels.toml", "--explain").stdout)
        self.assertIn(b"levels exact (stated by --levels)", self.twin(0, "render", "levels.toml", "--explain", "--levels", "exact").stdout)
        self.twin(2, "render", "levels.toml", "-o", "g.png", "--encode", "srgb", says="--encode linear")

    def test_a_traced_picture_has_its_error(self):
        report = json.loads(self.twin(0, "render", "sphere.toml", "-o", "a.png", "--with-error", "--json", says="samples followed again").stdout)
        self.assertIn("rays from the definitions", report["truth"]["description"])
        self.assertGreater(report["error"]["pixels"], 500)
        self.assertLess(report["error"]["wrongPrimitiveShare"], 0.01)
        self.assertIsNone(report["error"]["rounding"])
        shallow = json.loads(self.twin(0, "render", "sphere.toml", "-o", "b.png", "--with-error", "--max-depth", "1", "--json").stdout)
        deep = json.loads(self.twin(0, "render", "sphere.toml", "-o", "c.png", "--with-error", "--max-depth", "9", "--json").stdout)
        self.assertGreater(shallow["error"]["rms"], 2 * deep["error"]["rms"])

    def test_refusals(self):
        self.twin(2, "render", "cube.obj", "-o", "a.png", "--sampling", "corners", says="--sampling goes with --shading ray")
        self.twin(2, "render", "cube.obj", "-o", "a.png", "--jitter", "shadow=0.1", says="--jitter goes with --shading ray")
        self.twin(2, "render", "sphere.toml", "-o", "a.png", "--sampling", "corners", "--samples", "4", says="leave --samples out")
        self.twin(2, "render", "sphere.toml", "-o", "a.png", "--levels", "cut", "--encode", "srgb", says="--encode linear")
        self.write("bad.toml", SPHERE.replace("radius = 1", "radius = -1"))
        self.twin(3, "render", "bad.toml", "-o", "a.png", says="bad.toml:10:10: sphere.radius is -1, not above 0")
        self.write("bad.toml", SPHERE.replace("normal = [0, 1, 0]", "normal = [0, 0, 0]"))
        self.twin(3, "render", "bad.toml", "-o", "a.png", says="bad.toml:14:10: plane.normal is the zero vector")
        self.write("bad.toml", SPHERE.replace("reflect = 0.5", "reflect = 0.5\ndensity = 0"))
        self.twin(3, "render", "bad.toml", "-o", "a.png", says="bad.toml:8:11: material.density is 0, outside 0.01 to 100")
        self.write("bad.toml", SPHERE.replace("reflect = 0.5", "reflect = 0.5\nlocal = 0.75"))
        self.twin(3, "render", "bad.toml", "-o", "a.png", says="add up to more than 1")
        self.assertEqual([f for f in self.files() if f.endswith(".png")], [])


class Bench(Command):
    """The benchmarks run and their pictures and results agree; a time is nothing that a test may judge."""

    def test_raster_draws_the_picture_of_the_graphics_pipeline(self):
        rows = ["sphere1e3", "knot1e3", "full-screen", "layers-f2b", "cube.obj"]
        done = self.expect(0, "bench", "raster", *rows, "--size", "333x211", "--repeat", "3", "--json")
        report = json.loads(done.stdout)
        self.assertEqual([row["name"] for row in report["rows"]], rows)
        for row in report["rows"]:
            self.assertEqual(row["agreement"]["failure"], "", row)
            self.assertEqual(row["agreement"]["unexplained"], 0)
            self.assertGreater(row["agreement"]["covered"], 1000)
            self.assertTrue(row["resident"])
            self.assertEqual(row["ratio"]["count"], 3)
            self.assertGreater(row["compute_ms"]["least"], 0)
        self.assertIn("load", report["host"])

    def test_raster_without_residence_says_so(self):
        done = self.expect(0, "bench", "raster", "sphere1e3", "--size", "64x48", "--repeat", "3", env={"PLUMB_LIMITS": "storageRange=20000"})
        self.assertIn(b"several bands or chunks", done.stdout)

    def test_raster_needs_a_graphics_queue(self):
        self.expect(4, "bench", "raster", "sphere1e3", "--size", "64x48", says="has no graphics pipeline", env={"PLUMB_LIMITS": "graphicsQueue=0"})

    def test_passes_are_measured_alone_under_any_number_of_lights(self):
        done = self.expect(0, "bench", "passes", "sphere1e3", "lights3", "lights64", "--size", "64x48", "--repeat", "3", "--json")
        rows = json.loads(done.stdout)["rows"]
        self.assertEqual([(row["name"], row["lights"]) for row in rows], [("sphere1e3", 1), ("lights3", 3), ("lights64", 64)])
        for row in rows:
            self.assertEqual(row["ms"]["count"], 3)
            self.assertGreater(row["ms"]["least"], 0)
            self.assertGreater(row["counters"]["drawnTriangles"], 100)
            self.assertIn("fill", row["passes_ms"])

    def test_matrix_measures_every_way_and_device_equals_twin(self):
        done = self.expect(0, "bench", "matrix", "1001", "250000", "--repeat", "3", "--json")
        tables = json.loads(done.stdout)["tables"]
        self.assertEqual([(t["work"], t["count"]) for t in tables], [("vertices", 1001), ("vertices", 250000), ("chain", 1001), ("chain", 250000)])
        for table in tables:
            self.assertEqual(table["failure"], "")
            names = [way["name"] for way in table["ways"]]
            self.assertIn("device", " ".join(names))
            self.assertIn("GLM", " ".join(names))
            self.assertIn(table["ceiling"], names)
            for way in table["ways"]:
                self.assertEqual(way["of_device"] is not None, way["name"].startswith("device"), way)
                self.assertEqual(way["partial"], way["name"].endswith("alone"), way)
                if way["partial"]:
                    self.assertEqual((way["error_u"], way["against_glm"], way["products"]), (None, None, 0), way)
                    continue
                self.assertGreater(way["error_u"], 0, way)   # float32 against long double: a result without error was not computed
                if "binary64" in way["name"]:
                    self.assertLessEqual(way["error_u"], 1 + 2**-20, way)   # half a unit in the last place, and what binary64 itself rounds
            # What the notes count: a matrix a vertex and seven of them, and how many products wait for one another.
            one, seven = ([w for w in table["ways"] if w["name"] == f"device, {name}"] for name in ("one composite", "7 one after another"))
            if table["work"] == "vertices":
                self.assertEqual((one[0]["products"], one[0]["steps"]), (table["count"], 1))
                self.assertEqual((seven[0]["products"], seven[0]["steps"]), (7 * table["count"], 7))
            else:
                pairs = next(w for w in table["ways"] if "pairwise" in w["name"])
                self.assertEqual((pairs["products"], pairs["steps"]), (table["count"] - 1, (table["count"] - 1).bit_length()))
        self.assertTrue(any("sequential" in line for line in tables[3]["absent"]))

    def test_claims_are_counted_and_timed(self):
        done = self.expect(0, "bench", "claims", "sphere1e3", "--size", "96x72", "--repeat", "3", "--json")
        tables = {t["claim"]: t for t in json.loads(done.stdout)["tables"]}
        self.assertEqual(sorted(tables), ["P1", "P2", "P3", "P4", "P6", "P7", "P8", "P9"])
        for table in tables.values():
            self.assertEqual(table["failure"], "")
            for way in table["ways"]:
                self.assertEqual((way["ms"]["count"], way["ratio"]["count"]), (3, 3))
                self.assertGreater(way["ms"]["least"], 0)
            self.assertEqual(table["ways"][0]["ratio"]["median"], 1)
        counts = {(claim, way["name"]): way["counts"] for claim, table in tables.items() for way in table["ways"]}
        self.assertEqual(counts["P1", "device"]["equations of 1000 vertices"], 3000)
        self.assertEqual(counts["P2", "step by step"], {"applications": 30000, "products": 0})
        self.assertEqual(counts["P2", "one composite"], {"applications": 10000, "products": 2})
        self.assertEqual(counts["P3", "step by step"]["applications"], 7000)
        self.assertEqual(counts["P3", "one composite"], {"applications": 1000, "products": 6})
        self.assertEqual(counts["P4", "one after another"], {"products": 6, "waiting": 6})
        self.assertEqual(counts["P4", "tree"], {"products": 6, "waiting": 3})
        ends = counts["P7", "end points, then 2-D lines"]
        self.assertEqual(ends["projections"], 2 * ends["edges"])
        self.assertGreater(ends["edges"], 1000)
        self.assertGreater(counts["P7", "every point"]["projections"], ends["projections"])
        culled, all_ = counts["P8", "culled"], counts["P8", "not culled"]
        self.assertGreater(2 * culled["back-facing"], culled["triangles"])
        self.assertEqual((all_["back-facing"], all_["triangles"]), (0, culled["triangles"]))
        self.assertLess(culled["drawn"], all_["drawn"])
        self.assertEqual(counts["P9", "Phong"]["illuminations"], counts["P6", "bin, fill, shade"]["pixels"])
        self.assertGreater(counts["P9", "Phong"]["illuminations"], counts["P9", "Gouraud"]["illuminations"])
        text = self.expect(0, "bench", "claims", "sphere1e3", "--size", "64x48", "--repeat", "3").stdout.decode()
        self.assertIn("of the first", text)

    def test_trace_draws_the_picture_of_plain_code_and_of_embree(self):
        done = self.expect(0, "bench", "trace", "spheres4", "spheres20", "mesh1e5", "--size", "321x200", "--repeat", "3", "--json")
        report = json.loads(done.stdout)
        names = [row["name"] for row in report["rows"]]
        self.assertEqual(names[:2], ["spheres4", "spheres20"])
        if report["absent"]:
            self.assertIn("Embree", report["absent"][0])
        else:
            self.assertEqual(names[2:], ["mesh1e5 embree", "mesh1e5 embree-robust"])
        for row in report["rows"]:
            self.assertEqual(row["agreement"]["failure"], "", row)
            self.assertGreaterEqual(row["rays"], 321 * 200)
            self.assertEqual(row["ratio"]["count"], 3)
        self.assertGreater(report["rows"][0]["feelers"], 10000)

    def test_refusals(self):
        self.expect(2, "bench", "rater", says="accepted: raster, passes, matrix, claims, trace, plan")
        self.expect(2, "bench", "trace", "spheres7", says="is no row; accepted: spheres4")
        self.expect(2, "bench", "claims", "knot1e3", says="sphereN")
        self.expect(2, "bench", "raster", "sphere7", says="is no row")
        self.expect(2, "bench", "passes", "lights65", says="is no row")
        self.expect(2, "bench", "matrix", "1.5", says="is no count")
        self.expect(3, "bench", "raster", "nothing.obj", says="nothing.obj")
        self.expect(4, "bench", "matrix", "1000", says="there is none", env=NONE)


class Measure(Command):
    def test_rows_have_times_and_errors(self):
        done = self.twin(0, "measure", "cube.obj", "--axis", "shading,samples", "--axis", "specular", "--repetitions", "3", "--json", "--csv=m.csv")
        report = json.loads(done.stdout)
        self.assertEqual(report["schema"], "plumb-measure-1")
        self.assertEqual(report["cut"], [])
        self.assertEqual(report["truth"]["samples"], 16)
        for key in ("device", "cpu", "threads", "load", "build", "scene", "size", "repetitions", "interleaved", "date"):
            self.assertIn(key, report["context"])
        rows = {(r["axis"], r["choice"]): r for r in report["rows"]}
        self.assertEqual({a for a, _ in rows}, {"control", "shading", "samples", "specular"})
        self.assertEqual(report["context"]["order"]["seed"], 0)
        self.assertEqual(rows["control", "default again"]["error"], rows["shading", "phong"]["error"])
        self.assertEqual(report["telling"]["rows"], len({json.dumps([r["timeMs"], r["passesMs"]]) for r in rows.values() if not r["absent"]}) - 1)
        self.assertIn("rounds tell no times apart", " ".join(report["notes"]))
        for row in rows.values():
            if row["absent"]:
                self.assertTrue(row["why"])
                self.assertIsNone(row["timeMs"])
                continue
            self.assertEqual(row["timeMs"]["n"], 3)
            self.assertTrue(row["timeMs"]["min"] <= row["timeMs"]["median"] <= row["timeMs"]["max"])
            self.assertEqual(row["told"], "default" if row["baseline"] else "not told apart", "three rounds tell nothing")
            self.assertEqual(row["ratioInterval"], {"low": 1, "high": 1} if row["baseline"] else {"low": None, "high": None})
            if row["choice"] == "wire":
                self.assertIsNone(row["error"])
                continue
            self.assertTrue(0 < row["error"]["rms"] <= row["error"]["max"] <= 1)
            self.assertTrue(0 < row["errorAtItsSamples"]["unrounded"]["max"])
        self.assertEqual(rows["shading", "phong"]["ratio"], 1)
        self.assertTrue(rows["shading", "phong"]["baseline"] and rows["samples", "1"]["baseline"])
        self.assertGreater(rows["samples", "1"]["error"]["rms"], rows["samples", "16"]["error"]["rms"])
        on_front = {(r["axis"], r["choice"]) for r in report["rows"] if r["onFront"]}
        self.assertTrue({(f["axis"], f["choice"]) for f in report["front"]} <= on_front)
        with open(os.path.join(self.folder, "m.csv"), newline="", encoding="utf-8") as f:
            table = list(csv.DictReader(f))
        self.assertEqual([(r["axis"], r["choice"]) for r in table], [(r["axis"], r["choice"]) for r in report["rows"]])
        for line, row in zip(table, report["rows"]):
            self.assertNotIn(None, line)
            if not row["absent"] and row["error"]:
                self.assertEqual(float(line["error_rms"]), row["error"]["rms"])
                self.assertEqual(float(line["time_ms_median"]), row["timeMs"]["median"])
                self.assertEqual(line["told"], row["told"])
        done = self.twin(0, "measure", "cube.obj", "--axis", "threads", "--repetitions", "12", "--json", "--seed", "9")
        report = json.loads(done.stdout)
        self.assertEqual(report["context"]["order"]["seed"], 9)
        for row in report["rows"]:
            low, high = row["ratioInterval"]["low"], row["ratioInterval"]["high"]
            self.assertTrue(low <= row["ratio"] <= high)
            self.assertEqual(row["told"], "default" if row["baseline"] else "faster" if high < 1 else "slower" if low > 1 else "not told apart")

    def test_nothing_is_said_of_two_rounds(self):
        for rounds in ("1", "2"):
            done = self.twin(0, "measure", "cube.obj", "--axis", "shading", "--repetitions", rounds, "--json")
            report = json.loads(done.stdout)
            self.assertTrue(all(r["ratio"] is None and r["told"] is None and not r["onFront"] and not r["onAxisFront"] for r in report["rows"]))
            self.assertTrue(all(r["timeMs"]["median"] is None for r in report["rows"] if r["timeMs"]))
            self.assertEqual(report["front"], [])
            self.assertIn("no median", " ".join(report["notes"]))
            self.assertIn(b"no front", done.stderr)

    def test_refusals_are_one_line_and_write_nothing(self):
        for arguments, says in ((["--axis", "shadings"], "shadings"), (["--axis", "shading,,samples"], "--axis"), (["--limit", "5"], "--limit"), (["--limit", "0s"], "--limit"),
                                (["--repetitions", "0"], "--repetitions"), (["--shading", "wire"], "wire"), (["--view", "iso", "--view", "top"], "--view"),
                                (["--json", "--csv"], "--csv")):
            done = self.twin(2, "measure", "cube.obj", *arguments, "--json=r.json" if "--json" not in arguments else "-q", says=says)
            self.assertEqual(done.stderr.count(b"\n"), 1, done.stderr)
            self.assertEqual(done.stdout, b"")
        self.assertEqual(self.files(), ["cube.obj"])

    def test_measure_writes_a_report_for_people(self):
        self.twin(0, "measure", "cube.obj", "--axis", "shading,encoding", "--repetitions", "2", "-o", "r.html", "-q")
        page = self.read("r.html").decode()
        self.assertLess(len(page), 2_000_000)
        shown = json.loads(page.split('id="pictures">')[1].split("</script>")[0])
        self.assertEqual(shown["size"], [64, 48])
        self.assertTrue({"shading/flat", "shading/phong", "encoding/linear"} <= set(shown["of"]))
        self.assertEqual(shown["leftOut"], [])
        self.assertEqual(json.loads(page.split('id="measurement">')[1].split("</script>")[0])["schema"], "plumb-measure-1")
        self.twin(2, "measure", "cube.obj", "-o", "r.png", says=".html")
        self.twin(5, "measure", "cube.obj", "-o", "no/such/r.html")
        self.assertEqual(self.files(), ["cube.obj", "r.html"])

    def test_limit_cuts_and_lists(self):
        report = json.loads(self.twin(0, "measure", "cube.obj", "--limit", "1ms", "--json").stdout)
        self.assertTrue(report["cut"])
        self.assertTrue(all(c["why"] for c in report["cut"]))
        self.assertIsNone(report["truth"])
        self.assertFalse(report["context"]["limitKept"])
        self.assertIn("was not kept", " ".join(report["notes"]))
        self.twin(6, "measure", "cube.obj", "--limit", "1ms", "-o", "r.html", says="no time for the truth")
        self.assertEqual(self.files(), ["cube.obj"])


class Telling(Command):
    def test_devices_names_what_would_be_picked(self):
        report = json.loads(self.expect(0, "devices", "--json").stdout)
        picked = [d for d in report["devices"] if d["picked"]]
        self.assertEqual(len(picked), 1)
        self.assertTrue(picked[0]["lavapipe"])
        self.assertTrue(picked[0]["selfTest"]["passed"])
        self.assertIn(b"self-test passed", self.expect(0, "devices").stdout)

    def test_fingerprint_is_compared(self):
        text = self.expect(0, "devices", "--fingerprint", "--json=a.json", "-o", "a.html").stdout.decode()
        a = json.loads(self.read("a.json"))
        self.assertGreaterEqual(len(a["traits"]), 30)
        self.assertIn(f"hash {a['hash']}\n", text)
        for trait in a["traits"]:
            self.assertIn(trait["name"], text)
            self.assertIn(trait["verdict"], ("within", "open", "beyond"), trait["finding"])
            for key in ("what", "allowance", "planes", "finding", "questions", "differing", "answers"):
                self.assertIn(key, trait)
            if "ulp" in trait and trait["differing"]:
                self.assertRegex(trait["at"]["got"], r"^[0-9a-f]{8}$")
        page = self.read("a.html").decode()
        self.assertIn(a["hash"], page)
        self.assertNotIn("{{", page)
        done = self.expect(0, "devices", "--fingerprint", "--json")
        b = json.loads(done.stdout)
        self.assertEqual(b["hash"], a["hash"], "one hash a device")
        self.write("b.json", done.stdout.decode())
        equal = self.expect(0, "devices", "--compare", "a.json", "b.json")
        self.assertIn(b"all the same", equal.stdout)
        done = self.expect(3, "devices", "--compare", "a.json", "cube.obj", says="truncated or no fingerprint")
        self.write("torn.json", self.read("a.json").decode()[:100000])
        self.expect(3, "devices", "--compare", "torn.json", "b.json", says="torn.json: byte")
        a["version"] += 1
        self.write("later.json", json.dumps(a))
        self.expect(3, "devices", "--compare", "later.json", "b.json", says="make both fingerprints with one program")
        a["version"] -= 1
        named = {trait["name"]: trait for trait in a["traits"]}
        named["cos"]["answers"] = named["sin"]["answers"]
        self.write("other.json", json.dumps(a))
        self.expect(3, "devices", "--compare", "b.json", "other.json", says="'cos' are not those of its 'sha256'")
        self.expect(3, "devices", "--compare", "b.json", "absent.json")
        self.expect(4, "devices", "--fingerprint", "--device", "twin", says="there is none")

    def test_info_judges_a_mesh(self):
        self.write("open.obj", "\n".join(CUBE.split("\n")[:-2]) + "\n")
        closed, opened = json.loads(self.expect(0, "info", "cube.obj", "open.obj", "--json").stdout)
        mesh = closed["meshes"][0]
        self.assertEqual((mesh["faces"], mesh["triangles"], mesh["positions"], mesh["edges"]), (6, 12, 8, 18))
        self.assertTrue(mesh["closed"])
        self.assertEqual((mesh["boundary_edges"], mesh["non_manifold_edges"], mesh["flipped_edges"]), (0, 0, 0))
        self.assertEqual(mesh["bounds"], {"min": [-1, -1, -1], "max": [1, 1, 1]})
        self.assertEqual(opened["meshes"][0]["boundary_edges"], 4)
        self.write("flipped.obj", CUBE.replace("f 4 3 2 1", "f 1 2 3 4") + "v 0 -5 0\nf 1 2 9\n")
        mesh = json.loads(self.expect(0, "info", "flipped.obj", "--json").stdout)["meshes"][0]
        self.assertGreater(mesh["flipped_edges"], 0)
        self.assertEqual(mesh["non_manifold_edges"], 1)
        text = self.expect(0, "info", "cube.obj").stdout
        self.assertIn(b"closed", text)

    def test_info_bounds_the_vertices_and_not_the_corners_of_their_box(self):
        corners = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
        self.write("octahedron.obj", "".join(f"v {x} {y} {z}\n" for x, y, z in corners) + "f 1 3 5\nf 3 2 5\nf 2 4 5\nf 4 1 5\nf 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n")
        self.write("turned.toml", '[[mesh]]\nname = "o"\nfile = "octahedron.obj"\n\n[[object]]\nmesh = "o"\ntransform = [{ rotate_z = 45 }]\n')
        report = json.loads(self.expect(0, "info", "turned.toml", "--json").stdout)
        self.assertEqual(report["meshes"][0]["bounds"], {"min": [-1, -1, -1], "max": [1, 1, 1]})
        half = 0.5 ** 0.5
        for side, sign in (("min", -1), ("max", 1)):
            for got, want in zip(report["bounds"][side], (half, half, 1)):
                self.assertLessEqual(abs(got - sign * want), 4 * 2 ** -53, "a rounding of each product, sum and constant")
        self.assertEqual(report["bounds"]["min"][2], -1)

    def test_help_version_and_man(self):
        for command in ("render", "verify", "diff", "devices", "info", "bench", "help"):
            done = self.expect(0, "help", command)
            if command != "help":
                self.assertEqual(done.stdout, self.expect(0, command, "--help").stdout)
            self.assertGreaterEqual(done.stdout.count(f"\n  plumb {command}".encode()), 3)
        self.assertRegex(self.expect(0, "--version").stdout.decode(), r"^plumb \d+\.\d+\.\d+ \(")
        self.assertTrue(self.expect(0, "help", "--man").stdout.startswith(b".TH PLUMB 1"))

    def test_bash_completes_commands_flags_and_values(self):
        script = self.expect(0, "help", "--completion", "bash").stdout.decode()

        def completed(*words):
            line = script + 'COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _plumb; printf "%s\\n" "${COMPREPLY[@]}"'
            return subprocess.run(["bash", "-c", line, "plumb", *words], capture_output=True, text=True, check=True, cwd=self.folder).stdout.split()

        self.assertEqual(completed("plumb", "re"), ["render", "replay"])
        self.assertEqual(completed("plumb", "render", "--shad"), ["--shading"])
        self.assertEqual(completed("plumb", "render", "--shading", "g"), ["gouraud"])
        self.assertEqual(completed("plumb", "render", "cu"), ["cube.obj"])
        self.assertNotIn("--limit-band", completed("plumb", "render", "--"))
        self.assertNotIn("--size", completed("plumb", "info", "--"))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
