#!/usr/bin/python3
"""Clouds of the edge-aware benchmark, float32 PLY.

usage: ear_clouds.py YARDSTICK_FOLDER OUTDIR

  fandisk163k_rough   163K points on fandisk, each moved anywhere within 2 % of the box's diagonal, and one in a hundred of them by up
                      to 10 % more, along its normal: noise and outliers of Huang et al. 2013, Fig. 3, which says neither the law of
                      the noise nor how many outliers; both lengths are read as the most that a point is moved
  fandisk163k_rough.moved   the number of outliers: a line of text
  armadillo222k_noisy 222,543 points on the armadillo with Gaussian noise of 0.1 % of the diagonal: the size of Table I
"""
import os
import sys
import numpy as np

ROUGH, ROUGH_NOISE, MOVED, MOVED_BY = 163_000, 0.02, 0.01, 0.10
SCANNED, SCANNED_NOISE = 222_543, 0.001


def rough(v, f, sample):
    p, triangle = sample(v, f, ROUGH, 21)
    r, diagonal = np.random.default_rng(22), np.linalg.norm(np.ptp(v, 0))
    d = r.normal(size=p.shape)
    d *= (r.random(len(p)) ** (1 / 3) / np.linalg.norm(d, axis=1))[:, None]
    n = np.cross(v[f[triangle, 1]] - v[f[triangle, 0]], v[f[triangle, 2]] - v[f[triangle, 0]])
    n /= np.linalg.norm(n, axis=1)[:, None]
    by = np.where(r.random(len(p)) < MOVED, r.uniform(-1, 1, len(p)), 0)
    return p + ROUGH_NOISE * diagonal * d + (MOVED_BY * diagonal * by)[:, None] * n, np.count_nonzero(by)


def main(folder, out):
    sys.path.insert(0, folder)
    from cloudio import read_ply, sample_mesh, write_ply, xyz

    def mesh(name):
        v, f = read_ply(os.path.join(folder, "..", "data", name))
        return xyz(v), np.asarray(f)

    path = os.path.join(out, "fandisk163k_rough")
    p, moved = rough(*mesh("fandisk_mesh.ply"), sample_mesh)
    write_ply(path + ".ply", p)
    with open(path + ".moved", "w") as count:
        count.write("%d\n" % moved)
    v, f = mesh("armadillo_mesh.ply")
    p = sample_mesh(v, f, SCANNED, 23)[0]
    noise = np.random.default_rng(24).normal(size=p.shape) * SCANNED_NOISE * np.linalg.norm(np.ptp(v, 0))
    write_ply(os.path.join(out, "armadillo222k_noisy.ply"), p + noise)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
