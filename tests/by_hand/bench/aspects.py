#!/usr/bin/python3
"""usage: aspects.py RESULT SHAPE [MOST]: how far the cells of a result are from the aspects that the shape itself asks for.

SHAPE is ellipsoid (half axes 4, 1, 1), cylinder (radius 1, height 6, about the z axis, closed) or fandisk (its two widest
quarters of a cylinder, as far as 1.5 long spacings from their borders); MOST is maxAspect. Of each point, the cell is clipped in the true metric of the true tangent plane, among all points around. Prints a JSON
object: median and 90th percentile of |aspect / wanted - 1|, median aspect, and delta of the distances to the nearest in
the true metric. Nothing of voronoid is used. With --make SHAPE N FILE it writes a cloud of N points, even by area."""
import json
import sys

import numpy as np
from scipy.spatial import cKDTree


def ellipsoid(x):
    """Normals, long sides, aspects, and which points count."""
    r = np.hypot(x[:, 1], x[:, 2])
    t = np.arctan2(r, x[:, 0] / 4)
    w = np.hypot(4 * np.sin(t), np.cos(t))
    around = np.column_stack([x[:, 1], x[:, 2]]) / np.maximum(r, 1e-12)[:, None]
    normal = np.column_stack([np.cos(t) / w, (4 * np.sin(t) / w)[:, None] * around])
    long = np.column_stack([-4 * np.sin(t) / w, (np.cos(t) / w)[:, None] * around])
    return normal, long, w, np.ones(len(x), bool)


def cylinder(x):
    r = np.hypot(x[:, 0], x[:, 1])
    normal = np.column_stack([x[:, 0] / r, x[:, 1] / r, 0 * r])
    side = (np.abs(r - 1) < 0.02) & (np.abs(x[:, 2]) < 2.5)
    return normal, np.tile([0.0, 0, 1], (len(x), 1)), np.full(len(x), np.inf), side


# Of fandisk_mesh.ply, from its vertices, which lie on them within 7e-5: centre of the axis' part within, radius, half height.
QUARTERS = (((4.8279, 14.48898, -2.5548), 1.6415, 0.4126), ((4.82791, 13.66182, -2.40895), 2.1250, 0.4275))
AXIS = np.array([0.0, -0.98481, 0.17365])
MIDDLE = np.array([-0.70711, 0.12279, 0.69637])  # direction from the axis to the middle of a quarter
FANDISK_AREA = 60.669


def fandisk(x):
    spacing = np.sqrt(2 / np.sqrt(3) * FANDISK_AREA / len(x))
    away = 1.5 * np.sqrt(6) * spacing
    normal, counts = np.zeros_like(x), np.zeros(len(x), bool)
    for centre, radius, half in QUARTERS:
        d = x - centre
        h = d @ AXIS
        out = d - h[:, None] * AXIS
        r = np.linalg.norm(out, axis=1)
        out /= r[:, None]
        turn = np.arccos(np.clip(out @ MIDDLE, -1, 1))
        on = (np.abs(r - radius) < 0.1 * spacing) & (np.abs(h) < half - away) & (radius * turn < radius * np.pi / 4 - 3 * spacing)
        normal[on], counts = out[on], counts | on
    return normal, np.tile(AXIS, (len(x), 1)), np.full(len(x), np.inf), counts


def make(shape, n, path):
    rng = np.random.default_rng(5)
    if shape == 'ellipsoid':
        u = rng.normal(size=(20 * n, 3))
        u /= np.linalg.norm(u, axis=1)[:, None]
        area = np.sqrt(u[:, 0] ** 2 / 16 + u[:, 1] ** 2 + u[:, 2] ** 2)  # of the map from the sphere, up to a factor
        x = (u * [4, 1, 1])[rng.random(len(u)) < area][:n]
    else:
        caps = rng.random(n) < 1 / 7  # areas: each cap pi, side 12 pi
        turn, h = 2 * np.pi * rng.random(n), 6 * rng.random(n) - 3
        r = np.where(caps, np.sqrt(rng.random(n)), 1)
        x = np.column_stack([r * np.cos(turn), r * np.sin(turn), np.where(caps, np.sign(h) * 3, h)])
    with open(path, 'wb') as out:
        out.write(b'ply\nformat binary_little_endian 1.0\nelement vertex %d\nproperty float x\nproperty float y\n'
                  b'property float z\nend_header\n' % len(x))
        out.write(x.astype('<f4').tobytes())


def read(path):
    data = open(path, 'rb').read()
    head, body = data.split(b'end_header\n', 1)
    lines = head.decode().split('\n')
    n = next(int(l.split()[2]) for l in lines if l.startswith('element vertex'))
    types = {'float': '<f4', 'double': '<f8', 'uchar': 'u1', 'int': '<i4', 'uint': '<u4'}
    fields, vertex = [], False
    for l in lines:
        words = l.split()
        if words[:1] == ['element']:
            vertex = words[1] == 'vertex'
        elif words[:1] == ['property'] and vertex:
            fields.append((words[2], types[words[1]]))
    rows = np.frombuffer(body, np.dtype(fields), n)
    return np.column_stack([rows[c].astype(float) for c in 'xyz'])


def cell(offsets):
    """Corners of the cell at the origin, clipped by the bisectors with points of the plane."""
    polygon = 50 * np.max(np.abs(offsets)) * np.array([[-1.0, -1], [1, -1], [1, 1], [-1, 1]])
    for o in offsets:
        side = polygon @ o - o @ o / 2
        if np.all(side <= 0):
            continue
        kept = []
        for i in range(len(polygon)):
            j = (i + 1) % len(polygon)
            if side[i] <= 0:
                kept.append(polygon[i])
            if (side[i] <= 0) != (side[j] <= 0):
                kept.append(polygon[i] + side[i] / (side[i] - side[j]) * (polygon[j] - polygon[i]))
        polygon = np.array(kept)
    return polygon


def aspect(p):
    """Root of the ratio of the principal second moments about the centroid."""
    a, b = p, np.roll(p, -1, 0)
    cross = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    area = cross.sum() / 2
    centroid = ((a + b) * cross[:, None]).sum(0) / (6 * area)
    second = np.zeros((2, 2))
    for u, v, c in zip(a, b, cross):
        s = u + v
        second += c / 24 * (np.outer(u, u) + np.outer(v, v) + np.outer(s, s))
    low, high = np.linalg.eigvalsh(second - area * np.outer(centroid, centroid))
    return np.sqrt(high / low)


def main():
    if sys.argv[1] == '--make':
        return make(sys.argv[2], int(sys.argv[3]), sys.argv[4])
    x = read(sys.argv[1])
    normal, long, wanted, counts = {'ellipsoid': ellipsoid, 'cylinder': cylinder, 'fandisk': fandisk}[sys.argv[2]](x)
    wanted = np.minimum(wanted, float(sys.argv[3]) if len(sys.argv) > 3 else 6)
    short = np.cross(normal, long)
    root = np.sqrt(wanted)
    near = cKDTree(x).query(x, min(len(x), 121))[1]
    got, nearest = np.full(len(x), np.nan), np.full(len(x), np.nan)
    for i in np.nonzero(counts)[0]:
        d = x[near[i][near[i] != i]] - x[i]
        flat = np.column_stack([d @ long[i] / root[i], d @ short[i] * root[i]])
        order = np.argsort((flat ** 2).sum(1))[:40]
        nearest[i] = np.sqrt(((flat ** 2).sum(1) + (d @ normal[i]) ** 2).min())
        got[i] = aspect(cell(flat[order]) * [root[i], 1 / root[i]])
    off = np.abs(got[counts] / wanted[counts] - 1)
    print(json.dumps({'cells': int(counts.sum()), 'aspect_median': float(np.median(got[counts])),
                      'wanted_median': float(np.median(wanted[counts])), 'off_median': float(np.median(off)),
                      'off_p90': float(np.quantile(off, 0.9)),
                      'delta_metric': float(nearest[counts].std() / nearest[counts].mean())}))


main()
