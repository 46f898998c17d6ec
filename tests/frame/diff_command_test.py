#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""`plumb diff` as a user meets it: exit codes, what goes to which stream, which files exist afterwards.

usage: diff_command_test.py PLUMB DATA_FOLDER [unittest arguments]
"""
import json
import os
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import unittest

PLUMB, DATA = (os.path.abspath(path) for path in sys.argv[1:3])


def npy(values, shape, kind="<f4", code="f"):
    header = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}"
    header += " " * ((64 - (10 + len(header) + 1) % 64) % 64) + "\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header.encode() + struct.pack("<%d%s" % (len(values), code), *values)


class Diff(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="plumb-diff-")
        self.addCleanup(shutil.rmtree, self.folder)
        for name in ("monkey_a.png", "monkey_b.png", "shift_a.png"):
            shutil.copy(os.path.join(DATA, name), self.folder)
        self.inputs = self.files()

    def write(self, name, data):
        with open(os.path.join(self.folder, name), "wb") as f:
            f.write(data)
        self.inputs = self.files()

    def files(self):
        return sorted(os.listdir(self.folder))

    def diff(self, code, *arguments, says=None):
        done = subprocess.run([PLUMB, "diff", *arguments], cwd=self.folder, stdin=subprocess.DEVNULL, capture_output=True, timeout=120, check=False)
        self.assertEqual(done.returncode, code, (arguments, done.stdout, done.stderr))
        if code != 0:
            self.assertTrue(done.stderr.startswith(b"plumb: "), done.stderr)
        if code > 1:
            self.assertEqual(done.stderr.count(b"\n"), 1, done.stderr)
            self.assertEqual(done.stdout, b"")
            self.assertEqual(self.files(), self.inputs, "nothing is written after a refusal")
        if says is not None:
            self.assertIn(says, done.stderr.decode())
        return done

    def test_equal_is_0_and_different_is_1_with_the_place(self):
        done = self.diff(0, "monkey_a.png", "monkey_a.png")
        self.assertIn(b": equal\n", done.stdout)
        self.assertEqual(done.stderr, b"")
        done = self.diff(1, "monkey_a.png", "monkey_b.png", says="(92, 34)")
        for word in (b"max", b"mean", b"rmse", b"psnr", b"ssim", b"flip", b"deltae", b"over 8/255", b"largest connected region"):
            self.assertIn(word, done.stdout)

    def test_gates_decide_instead(self):
        self.diff(0, "monkey_a.png", "monkey_b.png", "--gate", "max<=64/255", "--gate", "flip<=0.02", "--gate", "over(8/255)<=2%")
        self.diff(1, "monkey_a.png", "monkey_b.png", "--gate", "max<=64/255", "--gate", "max<=63/255", says="worst at (92, 34)")
        self.diff(1, "monkey_a.png", "monkey_b.png", "--gate=color.ssim>=0.999")
        self.diff(2, "monkey_a.png", "monkey_b.png", "--gate", "max<=a little", says="accepted")
        self.diff(2, "monkey_a.png", "monkey_b.png", "--gate", "depth.max<=1", says="no plane 'depth'")
        self.diff(2, "monkey_a.png", "monkey_b.png", "--gate", "ulp<=1", says="no ulp", )

    def test_usage_is_2(self):
        for arguments in (["monkey_a.png"], ["monkey_a.png"] * 3, ["monkey_a.png", "monkey_b.png", "--radius", "17"], ["monkey_a.png", "monkey_b.png", "--ppd", "0"],
                          ["monkey_a.png", "monkey_b.png", "-o", "d.exr"], ["monkey_a.png", "monkey_b.png", "--heat", "d.jpg"], ["monkey_a.png", "monkey_b.png", "--size", "3x3"],
                          ["monkey_a.png", "monkey_b.png", "-o", "d.png", "--heat", "d.png"], ["monkey_a.png", "monkey_b.png", "-o", "-", "--json"],
                          ["monkey_a.png", "monkey_b.png", "--plane", "nothing"], ["monkey_a.png", "monkey_b.png", "-o", "shift_a.png", "--no-clobber"]):
            self.diff(2, *arguments)

    def test_refused_input_is_3(self):
        with open(os.path.join(self.folder, "monkey_a.png"), "rb") as f:
            whole = f.read()
        self.write("cut.png", whole[:-30])
        self.write("text.png", b"not a picture")
        self.write("flat.npy", npy([1, 2], (2,)))
        for bad in ("cut.png", "text.png", "flat.npy", "missing.png", "."):
            self.diff(3, "monkey_a.png", bad, "-o", "d.png", "--heat", "h.png", "--json=r.json", says=bad)
            self.diff(3, bad, "monkey_a.png")

    def test_another_size_is_a_difference(self):
        done = self.diff(1, "monkey_a.png", "shift_a.png", "-o", "d.png", "--json", says="160x120 against 96x64")
        report = json.loads(done.stdout)
        self.assertFalse(report["same_size"])
        self.assertEqual(report["planes"], [])
        self.assertEqual(self.files(), self.inputs, "nothing to draw")

    def test_nan_comes_first(self):
        nan = float("nan")
        self.write("a.npy", npy([1, nan, 3, 4], (2, 2)))
        done = self.diff(1, "a.npy", "a.npy", says="NaN at (1, 0)")
        self.assertLess(done.stdout.index(b"NaN"), done.stdout.index(b"max"))
        self.diff(1, "a.npy", "a.npy", "--gate", "max<=9", says="NaN at (1, 0)")
        self.diff(0, "a.npy", "a.npy", "--gate", "max<=9", "--gate", "nan<=1")
        self.diff(1, "a.npy", "a.npy", "--gate", "nan<=0")

    def test_floats_have_ulp_and_infinities_are_strings(self):
        one = struct.unpack("<f", struct.pack("<I", 0x3F800001))[0]
        self.write("a.npy", npy([1, 2, 3, 4], (2, 2)))
        self.write("b.npy", npy([one, 2, 3, 4], (2, 2)))
        self.diff(0, "a.npy", "b.npy", "--gate", "ulp<=1")
        self.diff(1, "a.npy", "b.npy", "--gate", "ulp<1", says="(0, 0)")
        self.write("c.npy", npy([1, float("inf"), 3, 4], (2, 2)))
        self.assertEqual(json.loads(self.diff(1, "a.npy", "c.npy", "--json").stdout)["planes"][0]["max"], "inf")
        self.diff(3, "a.npy", "d.npy")

    def test_pictures_show_where(self):
        done = self.diff(1, "monkey_a.png", "monkey_b.png", "-o", "d.png", "--heat", "h.png", "--json")
        written = json.loads(done.stdout)["written"]
        self.assertEqual([w["shows"] for w in written], ["difference", "flip"])
        for name in ("d.png", "h.png"):
            with open(os.path.join(self.folder, name), "rb") as f:
                self.assertEqual(struct.unpack(">II", f.read()[16:24]), (160, 120))
        # The difference of the picture with itself is black, which is one colour.
        self.diff(0, "monkey_a.png", "monkey_a.png", "-o", "black.png")
        self.diff(1, "black.png", "d.png")
        done = self.diff(1, "monkey_a.png", "monkey_b.png", "-o", "-")
        self.assertEqual(done.stdout[:8], b"\x89PNG\r\n\x1a\n")
        self.assertNotIn(b"DIFFERS", done.stdout)

    def test_report_has_its_keys(self):
        report = json.loads(self.diff(1, "monkey_a.png", "monkey_b.png", "--json", "--gate", "max<=0").stdout)
        self.assertTrue({"tool", "a", "b", "options", "equal", "same_size", "only_a", "only_b", "planes", "gates", "faults", "written"} <= set(report))
        plane = report["planes"][0]
        self.assertTrue({"name", "kind", "pixels", "nan_a", "nan_b", "differing", "first_differing", "region", "max", "max_at", "mean", "rmse", "psnr", "over", "ssim", "flip", "deltae"} <= set(plane))
        self.assertEqual(list(plane["over"]), ["1/255", "2/255", "4/255", "8/255"])
        self.assertFalse(report["gates"][0]["held"])
        self.assertEqual(report["gates"][0]["at"], [92, 34])
        self.assertEqual(len(report["a"]["sha256"]), 64)
        self.diff(0, "monkey_a.png", "monkey_a.png", "--json=r.json")
        with open(os.path.join(self.folder, "r.json"), encoding="utf-8") as f:
            self.assertEqual(json.load(f)["planes"][0]["psnr"], "inf")

    def test_quiet_and_order(self):
        self.assertEqual(subprocess.run([PLUMB, "-q", "--gate", "max<=1", "diff", "monkey_a.png", "monkey_b.png"], cwd=self.folder, capture_output=True, check=False).stderr, b"")
        self.diff(0, "--radius", "0", "monkey_a.png", "--plane=color", "monkey_a.png")

    def test_what_render_writes_is_compared(self):
        cube = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
        self.write("t.obj", cube.encode())
        for name, shading in (("p.exr", "phong"), ("f.exr", "flat")):
            subprocess.run([PLUMB, "render", "t.obj", "--device", "twin", "--size", "48x40", "--shading", shading, "--aov", "color,depth,normal,object_id", "-o", name], cwd=self.folder, check=True,
                           capture_output=True)
        self.inputs = self.files()
        report = json.loads(self.diff(1, "p.exr", "f.exr", "--json").stdout)
        equal = {plane["name"]: plane["differing"] == 0 for plane in report["planes"]}
        self.assertEqual(set(equal), {"color", "depth", "normal", "object_id"})
        self.assertTrue(equal["depth"] and equal["object_id"], "shading changes no depth, although it is infinite where nothing is drawn")
        self.diff(0, "p.exr", "f.exr", "--plane", "depth,object_id")
        self.diff(3, "p.exr", "t.obj")

    def test_signals_end_the_run(self):
        side = 3000
        self.write("big.npy", npy([], (side, side, 3), "|u1", "B") + os.urandom(side * side * 3))
        self.write("big2.npy", npy([], (side, side, 3), "|u1", "B") + os.urandom(side * side * 3))
        with subprocess.Popen([PLUMB, "diff", "big.npy", "big2.npy", "-o", "d.png"], cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
            try:
                process.wait(1)
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGINT)
            _, rest = process.communicate(timeout=60)
            self.assertEqual(process.returncode, 130, rest)
        self.assertEqual(self.files(), self.inputs)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
