#!/usr/bin/env python3
"""Prints how many normals of a cloud point away from those of the mesh it was drawn from.

usage: flips.py YARDSTICK CLOUD MESH; YARDSTICK: the folder with cloudio.py"""
import json
import sys
import numpy as np
from scipy.spatial import cKDTree

sys.path.insert(0, sys.argv[1])
from cloudio import read_ply, sample_mesh, xyz  # noqa: E402

v, f = read_ply(sys.argv[3])
v = xyz(v)
n = np.cross(v[f[:, 1]] - v[f[:, 0]], v[f[:, 2]] - v[f[:, 0]])
if np.einsum("ij,ij->", v[f[:, 0]], n) < 0:
    n = -n
p, t = sample_mesh(v, f, 1_000_000, 77)
c = read_ply(sys.argv[2])[0]
x = xyz(c)
own = np.stack([c["nx"], c["ny"], c["nz"]], 1).astype(float)
inward = int((np.einsum("ij,ij->i", own, n[t[cKDTree(p).query(x)[1]]]) <= 0).sum())
print(json.dumps({"n": len(x), "inward": inward}))
