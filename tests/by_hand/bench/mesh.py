#!/usr/bin/env python3
"""What a mesh of triangles is like, and how far it and the true one lie from each other.

usage: mesh.py YARDSTICK_FOLDER RESULT.ply TRUTH.ply"""
import json
import sys
import numpy as np

SAMPLES = 1_000_000


def triangles(v, f):
    """Quality 6 S / (sqrt(3) p h) with half the perimeter p, and the smallest angle, of each triangle."""
    a, b, c = v[f[:, 0]], v[f[:, 1]], v[f[:, 2]]
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    side = np.sort(np.stack([np.linalg.norm(p - q, axis=1) for p, q in ((a, b), (b, c), (c, a))], 1), 1)
    quality = 6 / np.sqrt(3) * area / (side.sum(1) / 2 * side[:, 2])
    cosine = (side[:, 1] ** 2 + side[:, 2] ** 2 - side[:, 0] ** 2) / (2 * side[:, 1] * side[:, 2])
    return quality, np.degrees(np.arccos(np.clip(cosine, -1, 1)))


def main(folder, result, truth):
    sys.path.insert(0, folder)
    from cloudio import read_ply, xyz
    from surface import Surface
    v, f = read_ply(result)
    v, f = xyz(v).astype(float), np.asarray(f)
    quality, angle = triangles(v, f)
    edge = np.sort(np.concatenate([f[:, [0, 1]], f[:, [1, 2]], f[:, [2, 0]]]), 1)
    edges, faces = np.unique(edge, axis=0, return_counts=True)
    tv, tf = read_ply(truth)
    there, here = Surface(xyz(tv).astype(float), np.asarray(tf), SAMPLES), Surface(v, f, SAMPLES)
    spacing = np.sqrt(2 / np.sqrt(3) * there.area / len(v))
    print(json.dumps({
        "n": len(v), "triangles": len(f), "border": int((faces == 1).sum()), "over": int((faces > 2).sum()),
        "euler": int(len(np.unique(f)) - len(edges) + len(f)), "q_avg": float(quality.mean()),
        "q_p001": float(np.quantile(quality, 0.001)), "q_min": float(quality.min()), "angle": float(angle.min()),
        "hausdorff": float(max(there.distance(here.dense).max(), here.distance(there.dense).max()) / spacing)}))


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    main(*sys.argv[1:])
