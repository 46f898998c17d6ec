#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""`plumb diff`'s FLIP against the second implementation in flip_witness.py, on the committed pairs and on closed forms.

usage: flip_test.py PLUMB DATA_FOLDER
"""
import json
import os
import subprocess
import sys
import tempfile
import unittest

import numpy as np

import flip_witness

PLUMB, DATA = sys.argv[1:3]
DEFAULT_PPD = 0.7 * 3840 / 0.7 * np.pi / 180
AGREEMENT = 1e-3  # the measure of the project: mean and largest error of two implementations


def said(a, b, *flags):
    done = subprocess.run([PLUMB, "diff", a, b, "--json", *flags], capture_output=True, check=False)
    assert done.returncode in (0, 1), done.stderr
    return json.loads(done.stdout)["planes"][0]["flip"]


class Flip(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def array(self, name, pixels):
        path = os.path.join(self.folder.name, name + ".npy")
        np.save(path, pixels)
        return path

    def both(self, a, b, ppd):
        want = flip_witness.flip(a / 255.0, b / 255.0, ppd)
        got = said(self.array("a", a), self.array("b", b), "--ppd", repr(ppd))
        self.assertAlmostEqual(got["mean"], want.mean(), delta=AGREEMENT)
        self.assertAlmostEqual(got["max"], want.max(), delta=AGREEMENT)
        return want

    def test_pictures(self):
        """Noise, shifted edges, thin lines and smooth ramps at several distances, odd sizes, smaller than the filters too."""
        random = np.random.default_rng(2020)
        for height, width, ppd in ((64, 96, DEFAULT_PPD), (33, 47, 20.0), (5, 7, DEFAULT_PPD), (150, 80, 120.0), (1, 1, 40.0)):
            y, x = np.mgrid[0:height, 0:width]
            ramp = np.stack([x * 255 // max(1, width - 1), y * 255 // max(1, height - 1), (x * y) % 256], axis=-1).astype(np.uint8)
            cases = {"noise": np.clip(ramp + random.integers(-30, 31, ramp.shape), 0, 255).astype(np.uint8), "shift": np.roll(ramp, 2, axis=1), "line": ramp.copy(),
                     "random": random.integers(0, 256, ramp.shape, dtype=np.uint8)}
            cases["line"][:, width // 2] = (255, 255, 255)
            for name, other in cases.items():
                with self.subTest(name, size=(width, height), ppd=ppd):
                    self.both(ramp, other, ppd)

    def test_every_default(self):
        a = np.zeros((40, 40, 3), np.uint8)
        b = np.full((40, 40, 3), 90, np.uint8)
        self.assertAlmostEqual(said(self.array("a", a), self.array("b", b))["mean"], flip_witness.flip(a / 255.0, b / 255.0, DEFAULT_PPD).mean(), delta=AGREEMENT)

    def test_committed_pairs(self):
        """What the authors' own program said of the pairs binds the witness, too."""
        with open(os.path.join(DATA, "witness.json"), encoding="utf-8") as f:
            pairs = json.load(f)["pairs"]
        seen = 0
        for name, want in pairs.items():
            if "flip" not in want:
                continue
            a, b = (read_png(os.path.join(DATA, f"{name}_{side}.png")) for side in "ab")
            witness = flip_witness.flip(a / 255.0, b / 255.0, DEFAULT_PPD)
            self.assertAlmostEqual(witness.mean(), want["flip"]["mean"], delta=AGREEMENT)
            self.assertAlmostEqual(witness.max(), want["flip"]["max"], delta=AGREEMENT)
            got = said(*(os.path.join(DATA, f"{name}_{side}.png") for side in "ab"))
            self.assertAlmostEqual(got["mean"], witness.mean(), delta=AGREEMENT)
            print(f"{name}: plumb {got['mean']:.7f}, NumPy {witness.mean():.7f}, authors {want['flip']['mean']:.7f}")
            seen += 1
        self.assertGreaterEqual(seen, 4)

    def test_closed_forms_of_the_witness(self):
        uniform = lambda *rgb: np.broadcast_to(np.array(rgb, float), (20, 20, 3))
        self.assertAlmostEqual(flip_witness.flip(uniform(0, 1, 0), uniform(0, 0, 1), 30.0).mean(), 1, delta=AGREEMENT)
        self.assertEqual(flip_witness.flip(uniform(0.3, 0.4, 0.5), uniform(0.3, 0.4, 0.5), 30.0).max(), 0)
        self.assertAlmostEqual(flip_witness.hunt(np.array([1.0, 1, 1]))[0], 100, delta=1e-9)


def read_png(path):
    """8-bit RGB, not interlaced: zlib and the five filters."""
    import struct
    import zlib
    with open(path, "rb") as f:
        data = f.read()
    at, header, packed = 8, None, b""
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + size]
        header = body if kind == b"IHDR" else header
        packed += body if kind == b"IDAT" else b""
        at += 12 + size
    width, height, bits, colour = struct.unpack(">IIBB", header[:10])
    assert (bits, colour) == (8, 2), "RGB of 8 bits"
    raw = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, 1 + 3 * width)
    rows, above = [], np.zeros(3 * width, int)
    for line in raw.astype(int):
        row = line[1:].copy()
        for i in range(3 * width):
            left, corner = (row[i - 3], above[i - 3]) if i >= 3 else (0, 0)
            guess = left + above[i] - corner
            paeth = min((abs(guess - left), 0, left), (abs(guess - above[i]), 1, above[i]), (abs(guess - corner), 2, corner))[2]
            row[i] = (row[i] + (0, left, above[i], (left + above[i]) // 2, paeth)[line[0]]) & 255
        rows.append(row)
        above = row
    return np.array(rows, np.uint8).reshape(height, width, 3)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
