#!/usr/bin/python3
"""usage: mesh_distance.py RESULT TRUTH: how far the surface of TRUTH is from the triangles of RESULT (both PLY), over the
diagonal of the truth: a JSON object with the mean, rms and largest distance of 200,000 points of it. By the yardstick."""
import json
import sys

sys.path.insert(0, '../shared/yardstick')
from cloudio import read_ply, sample_mesh, xyz  # noqa: E402
from surface import Surface  # noqa: E402



def read(path):
    vertices, faces = read_ply(path)
    return xyz(vertices), faces


result, truth = (read(path) for path in sys.argv[1:3])
points, _ = sample_mesh(*truth, 200_000, 11)
diagonal = Surface(*truth, dense=1000).diagonal
far = Surface(*result, dense=400_000).distance(points) / diagonal
print(json.dumps({'mean': float(far.mean()), 'rms': float((far ** 2).mean() ** 0.5), 'max': float(far.max())}))
