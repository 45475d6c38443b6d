#!/usr/bin/env python3
"""What the codec's table needs of a mesh.

usage: codec.py YARDSTICK sample MESH N OUT.ply   N points of the mesh, white noise by area
       codec.py YARDSTICK off MESH CLOUD.ply...   a line for each cloud: rms distance of its points from the mesh over the mesh's
                                                  diagonal, and how many points share their place with another one
YARDSTICK: the folder with cloudio.py and surface.py"""
import sys
import numpy as np

sys.path.insert(0, sys.argv[1])
from cloudio import read_ply, sample_mesh, write_ply, xyz  # noqa: E402
from surface import Surface  # noqa: E402

SEED = 60

v, f = read_ply(sys.argv[3])
v = xyz(v)
if sys.argv[2] == "sample":
    write_ply(sys.argv[5], sample_mesh(v, f, int(sys.argv[4]), SEED)[0])
    sys.exit()
truth = Surface(v, f)
for path in sys.argv[4:]:
    x = xyz(read_ply(path)[0])
    d = truth.distance(x) / truth.diagonal
    print(float(np.sqrt((d * d).mean())), len(x) - len(np.unique(x, axis=0)))
