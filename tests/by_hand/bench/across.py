#!/usr/bin/env python3
"""How many triangles of a mesh join two sheets of the true surface.

usage: across.py YARDSTICK_FOLDER RESULT.ply TRUTH.ply POINTS_OF_THE_INPUT

A corner lies on the face of TRUTH that is nearest to it (exact distances). A triangle is across when the faces of its corners are not joined
within three of its longest edges around its middle: by faces that share an edge, all in that ball. Faces whose normals agree
within 73 degrees on one component of TRUTH count as joined without a look.

  across   triangles that join two sheets
  far      those of them farther than their longest edge, from the middle, from all places where TRUTH crosses itself: where two of its
           components are nearer than NEAR spacings; there a point's place hardly tells which of them it is on
  off      mean distance of a corner to TRUTH, in spacings of the input
  border   edges of one triangle
"""
import json
import sys
import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

NEAR = 0.1  # spacings of a hexagonal lattice of the input's points over TRUTH


def welded(v, f):
    """The faces by numbers that points at one place share, and the component of each."""
    unique, inverse = np.unique(np.round(v, 6), axis=0, return_inverse=True)
    g = inverse.reshape(-1)[f]
    e = np.concatenate([g[:, [0, 1]], g[:, [1, 2]]])
    label = connected_components(coo_matrix((np.ones(len(e)), (e[:, 0], e[:, 1])), shape=(len(unique),) * 2), False)[1]
    return g, label[g[:, 0]]


class Truth:
    def __init__(self, v, f):
        from cloudio import sample_mesh
        self.v, self.f = v, f
        self.g, self.component = welded(v, f)
        n = np.cross(v[f[:, 1]] - v[f[:, 0]], v[f[:, 2]] - v[f[:, 0]])
        self.area = np.linalg.norm(n, axis=1) / 2
        self.normal = n / np.maximum(1e-300, 2 * self.area[:, None])
        self.trees = []
        for c in np.unique(self.component):
            own = np.where(self.component == c)[0]
            dense, at = sample_mesh(v, f[own], max(10_000, int(1_000_000 * self.area[own].sum() / self.area.sum())), 7)
            self.trees.append((own, own[at], cKDTree(dense), cKDTree(v[f[own]].mean(1))))

    def foot(self, p, which, k=8):
        """Distance of each point to one component, and its nearest face."""
        from surface import _point_triangle
        own, at, dense, middle = self.trees[which]
        k = min(k, len(own))
        near = np.concatenate([at[dense.query(p, k=k)[1].reshape(len(p), k)], own[middle.query(p, k=k)[1].reshape(len(p), k)]], axis=1)
        best, face = np.full(len(p), np.inf), np.zeros(len(p), int)
        for j in range(near.shape[1]):
            t = self.f[near[:, j]]
            d = _point_triangle(p, self.v[t[:, 0]], self.v[t[:, 1]], self.v[t[:, 2]])
            better = d < best
            best[better], face[better] = d[better], near[better, j]
        return best, face

    def nearest(self, p, leave=None):
        """Distance of each point to all components but `leave`, and its nearest face."""
        best, face = np.full(len(p), np.inf), np.zeros(len(p), int)
        for which in range(len(self.trees)):
            if which != leave:
                d, at = self.foot(p, which)
                face, best = np.where(d < best, at, face), np.minimum(d, best)
        return best, face

    def crossings(self, near):
        """Places of components, half a million in all, nearer than that to another one."""
        places = [np.asarray(tree[2].data)[::2] for tree in self.trees]
        return np.concatenate([x[self.nearest(x, which)[0] < near] for which, x in enumerate(places)])

    def beside(self):
        """For each face those that share an edge with it."""
        edge = {}
        for t, corner in enumerate(self.g.tolist()):
            for c in range(3):
                edge.setdefault(frozenset((corner[c], corner[c - 1])), []).append(t)
        out = [[] for _ in self.f]
        for faces in edge.values():
            for t in faces:
                out[t] += [u for u in faces if u != t]
        return out


def joined(truth, beside, faces, middle, reach):
    """Whether faces that share edges, all in a ball, lead from the first one to the others."""
    seen, front, wanted = {faces[0]}, [faces[0]], set(faces[1:]) - {faces[0]}
    while front and wanted:
        t = front.pop()
        for u in beside[t]:
            if u not in seen and np.linalg.norm(truth.v[truth.f[u]] - middle, axis=1).min() < reach:
                seen.add(u)
                wanted.discard(u)
                front.append(u)
    return not wanted


def across(truth, v, f, face):
    """Whether each triangle joins two sheets."""
    at = face[f]
    component, normal = truth.component[at], truth.normal[at]
    out = (component != component[:, :1]).any(1)
    agree = np.ones(len(f), bool)
    for c in range(3):
        agree &= np.einsum("ij,ij->i", normal[:, c], normal[:, c - 1]) > 0.3
    doubtful = np.where(~out & ~agree)[0]
    beside = truth.beside() if len(doubtful) else None
    for t in doubtful:
        x = v[f[t]]
        reach = 3 * max(np.linalg.norm(x[c] - x[c - 1]) for c in range(3))
        out[t] = not joined(truth, beside, at[t].tolist(), x.mean(0), reach)
    return out


def main(folder, result, mesh, points):
    sys.path.insert(0, folder)
    from cloudio import read_ply, xyz
    v, f = read_ply(result)
    v, f = xyz(v), np.asarray(f)
    tv, tf = read_ply(mesh)
    truth = Truth(xyz(tv), np.asarray(tf))
    spacing = np.sqrt(2 / np.sqrt(3) * truth.area.sum() / int(points))
    off, face = truth.nearest(v)
    wrong = across(truth, v, f, face)
    places = truth.crossings(NEAR * spacing)
    longest = np.max([np.linalg.norm(v[f[:, c]] - v[f[:, c - 1]], axis=1) for c in range(3)], axis=0)
    far = wrong if len(places) == 0 else wrong & (cKDTree(places).query(v[f].mean(1))[0] > longest)
    edge = np.sort(np.concatenate([f[:, [0, 1]], f[:, [1, 2]], f[:, [2, 0]]]), 1)
    print(json.dumps({"triangles": len(f), "across": int(wrong.sum()), "across_share": float(wrong.mean()), "far": int(far.sum()),
                      "far_share": float(far.mean()), "off": float(off.mean() / spacing),
                      "border": int((np.unique(edge, axis=0, return_counts=True)[1] == 1).sum())}))


if __name__ == "__main__":
    if len(sys.argv) != 5:
        sys.exit(__doc__)
    main(*sys.argv[1:])
