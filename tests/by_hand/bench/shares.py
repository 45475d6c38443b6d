#!/usr/bin/env python3
"""Prints whether a result covers every sheet of the mesh that its input was drawn from, as much as the others.

usage: shares.py YARDSTICK CLOUD MESH; YARDSTICK: the folder with cloudio.py and sheets.py

  share_off   largest difference of a part's share of the points from its share of the area, over the latter
  truth_max   largest distance from the mesh, at two million places, to the nearest point, over the spacing of a hexagonal lattice of as
              many points on the mesh's area
  truth_over  share of these places that are farther than 1.5 of it"""
import json
import sys
import numpy as np
from scipy.spatial import cKDTree

sys.path.insert(0, sys.argv[1])
from cloudio import read_ply, sample_mesh, xyz  # noqa: E402
from sheets import Sheets  # noqa: E402

STEP, PLACES, FAR = 100_000, 2_000_000, 1.5

v, f = read_ply(sys.argv[3])
v = xyz(v)
truth = Sheets(v, f)
x = xyz(read_ply(sys.argv[2])[0])
face = np.concatenate([truth.foot(x[i:i + STEP])[1] for i in range(0, len(x), STEP)])
area = np.linalg.norm(np.cross(v[f[:, 1]] - v[f[:, 0]], v[f[:, 2]] - v[f[:, 0]]), axis=1)
parts = truth.component.max() + 1
wanted = np.bincount(truth.component, area, parts) / area.sum()
has = np.bincount(truth.component[face], minlength=parts) / len(x)
there = wanted > 0
spacing = np.sqrt(2 / np.sqrt(3) * truth.area / len(x))
del truth, face
tree = cKDTree(x)
far = np.concatenate([tree.query(sample_mesh(v, f, STEP, 1000 + i)[0])[0] for i in range(PLACES // STEP)]) / spacing
print(json.dumps({"share_off": float(np.abs(has[there] / wanted[there] - 1).max()), "truth_max": float(far.max()),
                  "truth_over": float((far > FAR).mean())}))
