# SPDX-License-Identifier: MIT
"""A contact sheet of PNG files, with nothing but the standard library: every picture scaled into a cell by averaging boxes of bytes."""
import os
import struct
import zlib

CELL, GAP, COLUMNS = (160, 120), 6, 7
BACKGROUND = (20, 22, 26)


def read_png(path):
    """(width, height, rows of RGB bytes) of an 8-bit RGB PNG that is not interlaced."""
    with open(path, "rb") as file:
        data = file.read()
    if data[:8] != b"\x89PNG\r\n\x1a\n":
        raise ValueError(f"{path}: no PNG")
    at, packed, width, height = 8, b"", 0, 0
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + size]
        if kind == b"IHDR":
            width, height, depth, colour, _, _, interlace = struct.unpack(">IIBBBBB", body)
            if (depth, colour, interlace) != (8, 2, 0):
                raise ValueError(f"{path}: not 8-bit RGB")
        elif kind == b"IDAT":
            packed += body
        at += 12 + size
    raw, stride, rows, above = zlib.decompress(packed), 3 * width, [], bytearray(3 * width)
    for y in range(height):
        kind, line = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for i in range(stride):
            a, b, c = line[i - 3] if i >= 3 else 0, above[i], above[i - 3] if i >= 3 else 0
            if kind == 1:
                line[i] = line[i] + a & 255
            elif kind == 2:
                line[i] = line[i] + b & 255
            elif kind == 3:
                line[i] = line[i] + (a + b) // 2 & 255
            elif kind == 4:
                p = a + b - c
                pa, pb, pc = abs(p - a), abs(p - b), abs(p - c)
                line[i] = line[i] + (a if pa <= pb and pa <= pc else b if pb <= pc else c) & 255
        rows.append(bytes(line))
        above = line
    return width, height, rows


def cell_of(path):
    width, height, rows = read_png(path)
    scale = min(CELL[0] / width, CELL[1] / height)
    w, h = max(1, int(width * scale)), max(1, int(height * scale))
    out = [[BACKGROUND] * CELL[0] for _ in range(CELL[1])]
    left, top = (CELL[0] - w) // 2, (CELL[1] - h) // 2
    for y in range(h):
        y0, y1 = y * height // h, max(y * height // h + 1, (y + 1) * height // h)
        for x in range(w):
            x0, x1 = x * width // w, max(x * width // w + 1, (x + 1) * width // w)
            count = (y1 - y0) * (x1 - x0)
            out[top + y][left + x] = tuple(sum(rows[r][3 * c + k] for r in range(y0, y1) for c in range(x0, x1)) // count for k in range(3))
    return out


def write_sheet(paths, target):
    columns = min(COLUMNS, len(paths))
    lines = (len(paths) + columns - 1) // columns
    width, height = columns * (CELL[0] + GAP) + GAP, lines * (CELL[1] + GAP) + GAP
    picture = [[BACKGROUND] * width for _ in range(height)]
    for n, path in enumerate(paths):
        left, top = GAP + n % columns * (CELL[0] + GAP), GAP + n // columns * (CELL[1] + GAP)
        for y, row in enumerate(cell_of(path)):
            picture[top + y][left:left + CELL[0]] = row
    raw = b"".join(b"\0" + bytes(k for pixel in row for k in pixel) for row in picture)
    chunks = ((b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)), (b"IDAT", zlib.compress(raw, 9)), (b"IEND", b""))
    data = b"\x89PNG\r\n\x1a\n" + b"".join(struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body)) for kind, body in chunks)
    with open(target + ".part", "wb") as file:
        file.write(data)
    os.replace(target + ".part", target)
