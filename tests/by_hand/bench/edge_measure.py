#!/usr/bin/python3
"""How well a cloud keeps the sharp edges of the mesh that it stands for: a JSON object.

usage: edge_measure.py YARDSTICK_FOLDER RESULT.ply TRUTH.ply [NOISE [INPUT.ply]]

NOISE: standard deviation of the input's noise over the diagonal of TRUTH (0). Lengths are over that diagonal, angles in degrees.
A true edge: two faces whose normals differ by more than 30 degrees. Near: within 0.01 diagonal of one.

  n, near             points, and those near an edge
  mean, rms, p99      distance of the near ones to the faces
  clean, clean_rms    the same of all others: mean and rms
  normal, normal_p90  median and 90th percentile of the angle between a near point's normal and its face's, whichever way it points;
                      where two faces are within NOISE of the nearer one, the smaller angle. null without normals
  smeared             share of near points whose normal is more than 30 degrees from both faces of their edge, or that lie farther
                      than 2 NOISE off the faces; each of both where the other cannot be told
  turned              share of all points whose normal points inwards
  reach, reach_p99    mean and 99th percentile of the distance from places on the true edges to the nearest point
  delta               rms of d / mean(d) - 1, d being the distance to the nearest other point
  rms_over_input      rms of all points over that of INPUT; near_over_input of those near an edge
"""
import json
import sys
import numpy as np
from scipy.spatial import cKDTree

SHARP, SMEARED = 30.0, 30.0  # degrees
NEAR = 0.01                  # of the diagonal


def face_normals(v, f):
    n = np.cross(v[f[:, 1]] - v[f[:, 0]], v[f[:, 2]] - v[f[:, 0]])
    return n / np.maximum(np.linalg.norm(n, axis=1), 1e-300)[:, None]


def sharp_edges(v, f):
    """Edges as ends (m, 2, 3), and their two faces (m, 2)."""
    normal = face_normals(v, f)
    side = np.sort(np.concatenate([f[:, [0, 1]], f[:, [1, 2]], f[:, [2, 0]]]), 1)
    face = np.tile(np.arange(len(f)), 3)
    order = np.lexsort((side[:, 1], side[:, 0]))
    side, face = side[order], face[order]
    same = (side[1:] == side[:-1]).all(1)
    a, b = face[:-1][same], face[1:][same]
    sharp = (normal[a] * normal[b]).sum(1) < np.cos(np.radians(SHARP))
    return v[side[1:][same][sharp]], np.stack([a, b], 1)[sharp]


def along_edges(ends, step):
    """Places along the edges, and whose they are."""
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    count = np.maximum(1, np.ceil(length / step).astype(int))
    which = np.repeat(np.arange(len(ends)), count)
    t = (np.arange(len(which)) - np.repeat(np.cumsum(count) - count, count) + 0.5) / count[which]
    return ends[which, 0] + t[:, None] * (ends[which, 1] - ends[which, 0]), which


def point_triangles(p, a, b, c):
    from surface import _point_triangle
    return _point_triangle(p, a, b, c)


def nearest_faces(surface, p, k=8):
    """The candidates of the yardstick's Surface.distance: faces (n, 2k) and distances to them."""
    near = np.concatenate([surface.tri[surface.tree.query(p, k=k)[1]], surface.centroids.query(p, k=k)[1]], axis=1)
    far = np.empty(near.shape)
    for j in range(near.shape[1]):
        t = surface.f[near[:, j]]
        far[:, j] = point_triangles(p, *(surface.v[t[:, i]] for i in range(3)))
    return near, far


def degrees(cosine):
    return np.degrees(np.arccos(np.clip(cosine, -1, 1)))


def normals_of(rows):
    if "nx" not in rows.dtype.names:
        return None
    n = np.stack([rows["nx"], rows["ny"], rows["nz"]], 1).astype(float)
    return n / np.maximum(np.linalg.norm(n, axis=1), 1e-300)[:, None]


def near_edges(places, p, reach):
    far, at = cKDTree(places).query(p, distance_upper_bound=reach)
    return np.isfinite(far), np.minimum(at, len(places) - 1)


def measured(rows, surface, ends, pair, noise):
    from cloudio import xyz
    diagonal, p, normal = surface.diagonal, xyz(rows), normals_of(rows)
    places, whose = along_edges(ends, diagonal / 2000)
    near, at = near_edges(places, p, NEAR * diagonal)
    face, far = nearest_faces(surface, p)
    least = far.min(1)
    off, clean = least[near] / diagonal, least[~near] / diagonal
    d = cKDTree(p).query(p, k=2)[0][:, 1]
    reach = cKDTree(p).query(places)[0] / diagonal
    told = {
        "n": len(p), "near": int(near.sum()), "mean": off.mean(), "rms": (off ** 2).mean() ** 0.5, "p99": np.quantile(off, 0.99),
        "clean": clean.mean(), "clean_rms": (clean ** 2).mean() ** 0.5, "all_rms": (least ** 2).mean() ** 0.5 / diagonal,
        "normal": None, "normal_p90": None, "turned": None, "reach": reach.mean(), "reach_p99": np.quantile(reach, 0.99),
        "delta": ((d / d.mean() - 1) ** 2).mean() ** 0.5, "coincident": int((d == 0).sum())}
    smeared = off > 2 * noise if noise > 0 else np.zeros(len(off), bool)
    if normal is not None:
        true = face_normals(surface.v, surface.f)
        cosine = (true[face] * normal[:, None, :]).sum(2)
        told["turned"] = (cosine[np.arange(len(p)), far.argmin(1)] < 0).mean()
        angle = np.where(far <= least[:, None] + max(noise, 1e-6) * diagonal, degrees(np.abs(cosine)), 180).min(1)[near]
        told["normal"], told["normal_p90"] = np.median(angle), np.quantile(angle, 0.9)
        told["normal_clean"] = np.median(degrees(np.abs(cosine[np.arange(len(p)), far.argmin(1)]))[~near])
        sides = true[pair[whose[at[near]]]]
        both = degrees(np.abs((sides * normal[near][:, None, :]).sum(2))).min(1)
        smeared = smeared | (both > SMEARED)
    told["smeared"] = smeared.mean()
    return told


def main(folder, result, truth, noise="0", base=None):
    sys.path.insert(0, folder)
    from cloudio import read_ply, xyz
    from surface import Surface
    v, f = read_ply(truth)
    v, f = xyz(v), np.asarray(f)
    surface, (ends, pair) = Surface(v, f, 400_000), sharp_edges(v, f)
    told = measured(read_ply(result)[0], surface, ends, pair, float(noise))
    if base:
        given = measured(read_ply(base)[0], surface, ends, pair, 0)
        told["rms_over_input"] = told["all_rms"] / given["all_rms"]
        told["near_over_input"] = told["rms"] / given["rms"]
        told["clean_over_input"] = told["clean_rms"] / given["clean_rms"]
    print(json.dumps({k: w if w is None or isinstance(w, int) else float(w) for k, w in told.items()}))


if __name__ == "__main__":
    if len(sys.argv) not in (4, 5, 6):
        sys.exit(__doc__)
    main(*sys.argv[1:])
