# SPDX-License-Identifier: MIT
"""LDR-FLIP a second time, from the paper alone (Andersson et al., "FLIP: A Difference Evaluator for Alternating Images", 2020): whole pictures, two-dimensional
kernels by FFT. pipeline/compare/flip.cpp works in bands with separated kernels; the two share no code and no order of operations."""
import numpy as np

# Linear sRGB (D65) to XYZ by the primaries' chromaticities, so that not even the matrix is shared as digits.
_XY = np.array([[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]])
_WHITE_XY = np.array([0.3127, 0.3290])


def _matrix():
    columns = np.stack([_XY[:, 0] / _XY[:, 1], np.ones(3), (1 - _XY.sum(axis=1)) / _XY[:, 1]])
    white = np.array([_WHITE_XY[0] / _WHITE_XY[1], 1, (1 - _WHITE_XY.sum()) / _WHITE_XY[1]])
    return columns * np.linalg.solve(columns, white)


XYZ = _matrix()
WHITE = XYZ.sum(axis=1)


def linear(srgb):
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def opponent(rgb):
    x, y, z = np.moveaxis(rgb @ XYZ.T / WHITE, -1, 0)
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=-1)


def from_opponent(ycc):
    y = (ycc[..., 0] + 16) / 116
    xyz = np.stack([y + ycc[..., 1] / 500, y, y - ycc[..., 2] / 200], axis=-1) * WHITE
    return xyz @ np.linalg.inv(XYZ).T


def hunt(rgb):
    t = rgb @ XYZ.T / WHITE
    f = np.where(t > (6 / 29) ** 3, np.cbrt(t), t * (29 / 6) ** 2 / 3 + 4 / 29)
    lightness = 116 * f[..., 1] - 16
    return np.stack([lightness, 5 * lightness * (f[..., 0] - f[..., 1]), 2 * lightness * (f[..., 1] - f[..., 2])], axis=-1)


def hyab(p, q):
    d = p - q
    return np.abs(d[..., 0]) + np.linalg.norm(d[..., 1:], axis=-1)


def convolve(plane, kernel):
    """Full two-dimensional correlation with the border repeated, by FFT."""
    r = kernel.shape[0] // 2
    padded = np.pad(plane, r, mode="edge")
    shape = [padded.shape[i] + kernel.shape[i] - 1 for i in (0, 1)]
    full = np.fft.irfft2(np.fft.rfft2(padded, shape) * np.fft.rfft2(kernel[::-1, ::-1], shape), shape)
    return full[2 * r:2 * r + plane.shape[0], 2 * r:2 * r + plane.shape[1]]


def contrast_kernel(terms, radius, ppd):
    y, x = np.mgrid[-radius:radius + 1, -radius:radius + 1] / ppd
    kernel = sum(a * np.sqrt(np.pi / b) * np.exp(-np.pi ** 2 * (x * x + y * y) / b) for a, b in terms)
    return kernel / kernel.sum()


def perceived(rgb, ppd):
    terms = [[(1, 0.0047)], [(1, 0.0053)], [(34.1, 0.04), (13.5, 0.025)]]
    radius = int(np.ceil(3 * np.sqrt(0.04 / (2 * np.pi ** 2)) * ppd))
    ycc = opponent(rgb)
    filtered = np.stack([convolve(ycc[..., c], contrast_kernel(terms[c], radius, ppd)) for c in range(3)], axis=-1)
    return hunt(np.clip(from_opponent(filtered), 0, 1))


def features(rgb, ppd):
    lightness = (opponent(rgb)[..., 0] + 16) / 116
    sigma = 0.5 * 0.082 * ppd
    radius = int(np.ceil(3 * sigma))
    y, x = np.mgrid[-radius:radius + 1, -radius:radius + 1]
    bell = np.exp(-(x * x + y * y) / (2 * sigma * sigma))
    found = []
    for kernel in (-x * bell, (x * x / sigma ** 2 - 1) * bell):
        kernel = np.where(kernel > 0, kernel / kernel[kernel > 0].sum(), kernel / -kernel[kernel < 0].sum())
        found.append(np.hypot(convolve(lightness, kernel), convolve(lightness, kernel.T)))
    return found


def flip(a, b, ppd):
    """Error of each pixel of two sRGB pictures (H, W, 3) with values from 0 to 1."""
    a, b = linear(a), linear(b)
    most = hyab(hunt(np.array([0.0, 1, 0])), hunt(np.array([0.0, 0, 1]))) ** 0.7
    knee = 0.4 * most
    d = hyab(perceived(a, ppd), perceived(b, ppd)) ** 0.7
    colour = np.where(d < knee, 0.95 / knee * d, 0.95 + (d - knee) / (most - knee) * 0.05)
    feature = np.max([np.abs(p - q) for p, q in zip(features(a, ppd), features(b, ppd))], axis=0)
    return colour ** (1 - np.clip((feature / np.sqrt(2)) ** 0.5, 0, 1))
