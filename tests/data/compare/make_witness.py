#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Makes the picture pairs of this folder and witness.json: what programs that share no code with Plumbline say about them.

PSNR, mean, root-mean-square and largest error: ImageMagick's `compare`. SSIM and CIEDE2000: scikit-image (SSIM of the luma 0.299 R' + 0.587 G' + 0.114 B').
FLIP: the authors' own command-line tool, built from https://github.com/NVlabs/flip (commit in witness.json). Tests read the file and need none of these.

usage: make_witness.py PLUMB FLIP_TOOL FLIP_COMMIT    with Debian's /usr/bin/python3, packages imagemagick and python3-skimage
"""
import json
import os
import re
import subprocess
import sys
import tempfile

import numpy as np
import skimage
from skimage import color, io, metrics

FOLDER = os.path.dirname(os.path.abspath(__file__))
PLUMB, FLIP, COMMIT = sys.argv[1:4]


def path(name, side):
    return os.path.join(FOLDER, f"{name}_{side}.png")


PICTURES = {}


def save(name, side, pixels):
    """scikit-image writes 8 bits only, so ImageMagick writes the pictures of 16."""
    PICTURES[name, side] = pixels
    if pixels.dtype == np.uint8:
        io.imsave(path(name, side), pixels, check_contrast=False)
        return
    height, width, _ = pixels.shape
    subprocess.run(["convert", "-size", f"{width}x{height}", "-depth", "16", "-endian", "MSB", "rgb:-", "-strip", "png48:" + path(name, side)], input=pixels.astype(">u2").tobytes(), check=True)


def make_pictures():
    scene = os.path.join(FOLDER, "../../../scenes/suzanne.toml")
    for side, shading in (("a", "phong"), ("b", "gouraud")):
        subprocess.run([PLUMB, "render", scene, "--device", "twin", "--size", "160x120", "--shading", shading, "-o", path("monkey", side), "-q"], check=True)
        PICTURES["monkey", side] = io.imread(path("monkey", side))
    random = np.random.default_rng(6)
    y, x = np.mgrid[0:64, 0:96]
    ramps = np.stack([x * 255 // 95, y * 255 // 63, (x + y) * 255 // 158], axis=-1)
    save("noise", "a", ramps.astype(np.uint8))
    save("noise", "b", np.clip(ramps + random.integers(-12, 13, ramps.shape), 0, 255).astype(np.uint8))
    disc = lambda cx, cy: ((x - cx) ** 2 + (y - cy) ** 2 < 400)[..., None] * np.array([230, 60, 20]) + 25
    save("shift", "a", disc(48, 32).astype(np.uint8))
    save("shift", "b", disc(50, 33).astype(np.uint8))
    hues = np.stack([x * 4 % 256, (x * 7 + y * 3) % 256, (y * 11) % 256], axis=-1)
    save("hues", "a", hues.astype(np.uint8))
    save("hues", "b", hues[..., [1, 2, 0]].astype(np.uint8))
    fine = (ramps * 257).astype(np.uint16)
    save("wide", "a", fine)
    save("wide", "b", np.clip(fine.astype(int) + random.integers(-300, 301, fine.shape), 0, 65535).astype(np.uint16))


def image_magick(name, metric):
    done = subprocess.run(["compare", "-precision", "17", "-metric", metric, path(name, "a"), path(name, "b"), "null:"], capture_output=True, text=True, check=False)
    text = done.stderr.strip()
    inside = re.search(r"\(([^)]*)\)", text)  # "quantum units (share of full scale)"
    return float(inside.group(1) if inside else text)


def flip(name):
    with tempfile.TemporaryDirectory() as out:
        text = subprocess.run([FLIP, "-r", path(name, "a"), "-t", path(name, "b"), "-d", out], capture_output=True, text=True, check=True).stdout
    return {"mean": float(re.search(r"Mean: ([\d.]+)", text).group(1)), "max": float(re.search(r"Max: ([\d.]+)", text).group(1))}


def witness(name):
    full = np.iinfo(PICTURES[name, "a"].dtype).max
    a, b = (PICTURES[name, side].astype(float) / full for side in "ab")
    luma = [p @ np.array([0.299, 0.587, 0.114]) for p in (a, b)]
    similarity = metrics.structural_similarity(*luma, gaussian_weights=True, sigma=1.5, use_sample_covariance=False, data_range=1.0)
    delta = color.deltaE_ciede2000(color.rgb2lab(a), color.rgb2lab(b))
    found = {"psnr": image_magick(name, "PSNR"), "mean": image_magick(name, "MAE"), "rmse": image_magick(name, "RMSE"), "max": image_magick(name, "PAE"),
             "differing": int((a != b).any(axis=-1).sum()), "ssim": float(similarity), "deltae_mean": float(delta.mean()), "deltae_max": float(delta.max())}
    if full == 255:
        found["flip"] = flip(name)  # the tool reads 8 bits
    return found


def main():
    make_pictures()
    versions = {"imagemagick": subprocess.run(["compare", "--version"], capture_output=True, text=True, check=True).stdout.split("\n")[0].removeprefix("Version: ImageMagick ").split(" https")[0],
                "scikit-image": skimage.__version__, "numpy": np.__version__, "flip": f"NVlabs/flip commit {COMMIT}"}
    result = {"made_by": "make_witness.py", "versions": versions, "pairs": {name: witness(name) for name in ("monkey", "noise", "shift", "hues", "wide")}}
    with open(os.path.join(FOLDER, "witness.json"), "w", encoding="utf-8") as f:
        f.write(json.dumps(result, indent=2) + "\n")


if __name__ == "__main__":
    main()
