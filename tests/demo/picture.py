#!/usr/bin/env python3
"""Draws a part of a cloud before and after, side by side, seen from the front, points as small discs.

usage: picture.py BEFORE.ply NORMALS.ply AFTER.ply X Y SIZE OUT.png
  NORMALS  has those of the points of BEFORE, in their order; AFTER has its own (nx, ny, nz); all are binary, little endian
  X Y SIZE the lower left corner and the side of what is shown

Only NumPy. The same files give the same picture. picture.sh makes the one that README shows."""
import struct
import sys
import zlib
import numpy as np

SIDE, GAP, FINER = 360, 12, 2            # pixels of a panel, between two, and the finer grid that a pixel is the mean of
RADIUS = 2.0                             # of a disc, pixels
LIGHT = np.array([-0.35, 0.55, 0.76])    # where it comes from
DARK, BRIGHT = np.array([24, 44, 84]), np.array([150, 186, 224])
SHADES, GREYS = 12, 16                   # of points, and of a colour in the file: few, for a small file
TYPES = {"char": "i1", "uchar": "u1", "short": "<i2", "ushort": "<u2", "int": "<i4", "uint": "<u4", "float": "<f4", "double": "<f8"}


def read(path):
    """Positions and normals."""
    data = open(path, "rb").read()
    head, body = data.split(b"end_header\n", 1)
    lines = [line.split() for line in head.decode().splitlines()]
    if ["format", "binary_little_endian", "1.0"] not in lines:
        sys.exit(path + ": not a binary little endian PLY")
    n = next(int(w[2]) for w in lines if w[:2] == ["element", "vertex"])
    rows = np.frombuffer(body, np.dtype([(w[2], TYPES[w[1]]) for w in lines if w[:1] == ["property"]]), n)
    of = lambda *names: np.stack([rows[name] for name in names], 1).astype(float) if names[0] in rows.dtype.names else None
    return of("x", "y", "z"), of("nx", "ny", "nz")


def draw(x, normals, low, scale):
    """A panel: far points first, none that face away."""
    fine = SIDE * FINER
    panel = np.full((fine, fine), -1.0)
    front = normals[:, 2] > 0
    x, shade = x[front], np.rint(np.clip(normals[front] @ (LIGHT / np.linalg.norm(LIGHT)), 0, 1) * SHADES) / SHADES
    order = np.argsort(x[:, 2], kind="stable")
    column, row = ((x[:, :2] - low) * scale * FINER).T
    reach = int(RADIUS * FINER) + 1
    for i in order:
        c, r = int(column[i]), int(fine - 1 - row[i])
        if not (-reach < c < fine + reach and -reach < r < fine + reach):
            continue
        top, left = max(r - reach, 0), max(c - reach, 0)
        rows, columns = np.ogrid[top:min(r + reach + 1, fine), left:min(c + reach + 1, fine)]
        disc = (rows + 0.5 - fine + row[i]) ** 2 + (columns + 0.5 - column[i]) ** 2 < (RADIUS * FINER) ** 2
        panel[top:max(r + reach + 1, 0), left:max(c + reach + 1, 0)][disc] = shade[i]
    inside = panel >= 0
    colour = np.where(inside[..., None], DARK + panel[..., None] * (BRIGHT - DARK), 255)
    return colour.reshape(SIDE, FINER, SIDE, FINER, 3).mean((1, 3))


def write(path, picture):
    """A PNG with a palette."""
    step = 256 // GREYS
    coarse = np.minimum((picture.astype(int) + step // 2) // step * step, 255).astype(np.uint8)
    colours, index = np.unique(coarse.reshape(-1, 3), axis=0, return_inverse=True)
    if len(colours) > 256:  # by brightness alone: colours lie on a line and on its ways to white
        level = coarse.reshape(-1, 3).astype(int).sum(1) * 255 // 765
        colours = np.array([coarse.reshape(-1, 3)[level == k].mean(0) if (level == k).any() else [0] * 3 for k in range(256)])
        index = level
    chunk = lambda kind, data: (struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)))
    height, width = picture.shape[:2]
    rows = np.concatenate([np.zeros((height, 1), np.uint8), index.reshape(height, width).astype(np.uint8)], 1)
    with open(path, "wb") as out:
        out.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 3, 0, 0, 0))
                  + chunk(b"PLTE", colours.astype(np.uint8).tobytes()) + chunk(b"IDAT", zlib.compress(rows.tobytes(), 9))
                  + chunk(b"IEND", b""))


(before, _), (_, normals), after = read(sys.argv[1]), read(sys.argv[2]), read(sys.argv[3])
if len(before) != len(normals):
    sys.exit("%s: %d normals for %d points" % (sys.argv[2], len(normals), len(before)))
low, scale = np.array([float(sys.argv[4]), float(sys.argv[5])]), SIDE / float(sys.argv[6])
panels = [draw(before, normals, low, scale), np.full((SIDE, GAP, 3), 255.0), draw(*after, low, scale)]
write(sys.argv[7], np.concatenate(panels, 1))
