#!/usr/bin/env python3
"""What the codec's table needs; shares no code with the product.

usage: codec.py YARDSTICK sample MESH N OUT.ply   N points of the mesh, white noise by area
       codec.py YARDSTICK plain CLOUD OUT.ply [coloured]   its positions about their mean, as float32, and its colours
       codec.py YARDSTICK quarter CLOUD OUT.ply   every fourth of its points, drawn at random
       codec.py YARDSTICK psnr CLOUD.ply FILE.ply...   a line for each file: its D1, D2 and, where both have colours, YUV
                                  in dB against the cloud
       codec.py YARDSTICK mls PROGRAM CLOUD OUT.ply   its places, each once, upsampled by the program mls; prints CPU seconds
       codec.py YARDSTICK saved   of lines "bytes dB bytes dB" on standard input, of two ways to code: the share of bytes, in
                                  percent, that the second one saves at equal dB (Bjontegaard's BD-rate, cubics of log bytes);
                                  "none" where no dB is reached by both
YARDSTICK: the folder with cloudio.py. D1, D2 and YUV: those of mpeg-pcc-dmetric, with normals of the quadric through 20 points; YUV is (6 Y + U + V) / 8 by
BT.709, and points in one place have the mean of their colours."""
import os
import subprocess
import sys
import numpy as np
from scipy.spatial import cKDTree

sys.path.insert(0, sys.argv[1])
from cloudio import read_ply, sample_mesh, write_ply, xyz  # noqa: E402

SEED = 60
BLOCK = 20000


def normals(points, tree):
    out = np.empty_like(points)
    for at in range(0, len(points), BLOCK):
        middle = points[at:at + BLOCK]
        near = points[tree.query(middle, 20)[1]] - middle[:, None]
        flat = near - near.mean(1, keepdims=True)
        axes = np.linalg.eigh(np.einsum("nki,nkj->nij", flat, flat))[1]
        w, u, v = np.moveaxis(np.einsum("nki,nij->nkj", near, axes), 2, 0)
        size = np.abs(near).max((1, 2))[:, None] + 1e-300
        w, u, v = w / size, u / size, v / size
        terms = np.stack([np.ones_like(u), u, v, u * u, u * v, v * v], 2)
        square = np.einsum("nki,nkj->nij", terms, terms) + 1e-9 * np.eye(6)
        fit = np.linalg.solve(square, np.einsum("nki,nk->ni", terms, w)[:, :, None])[:, :, 0]
        normal = axes[:, :, 0] - fit[:, 1:2] * axes[:, :, 1] - fit[:, 2:3] * axes[:, :, 2]
        out[at:at + BLOCK] = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    return out


COLOURS = ("red", "green", "blue")
YUV = np.array([[.2126, .7152, .0722], [-.1146, -.3854, .5], [.5, -.4542, -.0458]])


def colours_of(vertices):
    return {k: vertices[k] for k in COLOURS} if "red" in vertices.dtype.names else {}


def read(path):
    """Its places, each once, and their YUV or None."""
    vertices = read_ply(path)[0]
    places, which = np.unique(xyz(vertices).astype(float), axis=0, return_inverse=True)
    if not colours_of(vertices):
        return places, None
    yuv = np.zeros_like(places)
    np.add.at(yuv, which.ravel(), np.stack([vertices[k].astype(float) for k in COLOURS], 1) @ YUV.T)
    return places, yuv / np.bincount(which.ravel())[:, None]


def psnr(points, tree, normal, peak, decoded, yuv, its_yuv):
    """The worse direction of each; a decoded point's normal is the mean of those whose nearest it is."""
    to = tree.query(decoded)[1]
    near = cKDTree(decoded).query(points)[1]
    first = np.zeros(len(decoded), int)
    first[near[::-1]] = np.arange(len(points))[::-1]
    mean = np.zeros_like(decoded)
    np.add.at(mean, near, normal * np.where((normal * normal[first[near]]).sum(1) < 0, -1, 1)[:, None])
    mean /= np.maximum(np.bincount(near, minlength=len(decoded)), 1)[:, None]
    there, back = decoded - points[to], points - decoded[near]
    d1 = max((there ** 2).sum(1).mean(), (back ** 2).sum(1).mean())
    d2 = max(((there * normal[to]).sum(1) ** 2).mean(), ((back * mean[near]).sum(1) ** 2).mean())
    figures = [10 * np.log10(3 * peak ** 2 / d) for d in (d1, d2)]
    if yuv is not None and its_yuv is not None:
        worst = np.maximum(((its_yuv - yuv[to]) ** 2).mean(0), ((yuv - its_yuv[near]) ** 2).mean(0))
        figures.append((10 * np.log10(255 ** 2 / np.maximum(worst, 1e-10))) @ [6 / 8, 1 / 8, 1 / 8])
    return figures


if sys.argv[2] == "sample":
    v, f = read_ply(sys.argv[3])
    write_ply(sys.argv[5], sample_mesh(xyz(v), f, int(sys.argv[4]), SEED)[0])
elif sys.argv[2] == "plain":
    vertices = read_ply(sys.argv[3])[0]
    points = xyz(vertices)
    write_ply(sys.argv[4], points - points.mean(0), colours_of(vertices) if len(sys.argv) > 5 else None)
elif sys.argv[2] == "quarter":
    vertices = read_ply(sys.argv[3])[0]
    vertices = vertices[np.random.default_rng(SEED).permutation(len(vertices))[:len(vertices) // 4]]
    write_ply(sys.argv[4], xyz(vertices), colours_of(vertices))
elif sys.argv[2] == "mls":
    places = np.unique(xyz(read_ply(sys.argv[4])[0]), axis=0)
    middle, raw = places.mean(0), [f"{sys.argv[5]}.{end}" for end in ("in", "out")]
    (places - middle).astype("<f4").tofile(raw[0])
    print(subprocess.run([sys.argv[3], *raw], check=True, stdout=subprocess.PIPE, text=True).stdout.strip())
    write_ply(sys.argv[5], np.fromfile(raw[1], "<f4").reshape(-1, 3) + middle)
    for path in raw:
        os.remove(path)
elif sys.argv[2] == "saved":
    a = np.array([line.split() for line in sys.stdin], float)
    low, high = max(a[:, 1].min(), a[:, 3].min()), min(a[:, 1].max(), a[:, 3].max())
    if not high > low:
        print("none")
        sys.exit()
    one, two = (np.polyint(np.polyfit(a[:, i + 1] - low, np.log(a[:, i]), 3)) for i in (0, 2))
    areas = [np.polyval(p, high - low) - np.polyval(p, 0) for p in (one, two)]
    print(100 * (1 - np.exp((areas[1] - areas[0]) / (high - low))))
else:
    points, yuv = read(sys.argv[3])
    tree = cKDTree(points)
    normal, peak = normals(points, tree), tree.query(points, 2)[0][:, 1].max()
    for path in sys.argv[4:]:
        places, its_yuv = read(path)
        print(*psnr(points, tree, normal, peak, places, yuv, its_yuv))
