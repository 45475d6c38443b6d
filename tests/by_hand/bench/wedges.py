#!/usr/bin/python3
"""Wedges of two unit squares that meet at an angle, resampled, and how well their edge is kept: a JSON object a line, for each angle
and noise (Huang et al. 2013, Fig. 12).

usage: wedges.py YARDSTICK_FOLDER OUTDIR SEEDS COMMAND...

COMMAND: a program and its arguments, in which IN and OUT are replaced. Figures are over the points of all seeds that lie within two
spacings of the edge: off (mean, p99) the distance to the faces over the noise; normal, normal_p90 the angle to the face they lie on,
the better of both within a noise of the edge, in degrees; smeared the share whose normal is more than 30 degrees from both faces, or
which lie farther than two noises off; reach the mean distance from the edge to the nearest point, in spacings; cpu seconds, the mean.
"""
import json
import os
import resource
import subprocess
import sys
import numpy as np
from scipy.spatial import cKDTree

ANGLES, NOISES, POINTS = (90, 120, 150), (0.005, 0.01), 1000
SPACING = np.sqrt(2 / np.sqrt(3) * 2 / POINTS)
NEAR, SMEARED = 2, 30  # spacings, degrees


def frame(angle):
    """Directions within the two faces, across the edge (the y axis), and their normals."""
    t = np.radians(angle)
    across = np.array([[1, 0, 0], [np.cos(t), 0, np.sin(t)]])
    return across, np.array([[0, 0, 1], [np.sin(t), 0, -np.cos(t)]])


def wedge(angle, noise, seed):
    r = np.random.default_rng(seed)
    u = r.random((POINTS, 2))
    p = u[:, :1] * frame(angle)[0][r.integers(0, 2, POINTS)]
    p[:, 1] += u[:, 1]
    return p + r.normal(size=p.shape) * noise


def to_faces(p, angle):
    """Distances (n, 2) to the unit squares."""
    across, normal = frame(angle)
    out = np.empty((len(p), 2))
    for i in range(2):
        s, h = p @ across[i], p @ normal[i]
        out[:, i] = np.sqrt(h ** 2 + (s - np.clip(s, 0, 1)) ** 2 + (p[:, 1] - np.clip(p[:, 1], 0, 1)) ** 2)
    return out


def angles(normal, angle):
    return np.degrees(np.arccos(np.clip(np.abs(normal @ frame(angle)[1].T), 0, 1)))


def near_figures(p, normal, angle, noise):
    """Distance, angle to the normal and smeared, of the points near the edge but for those at its ends, where the squares end."""
    far = np.hypot(p[:, 0], p[:, 2])
    near = (far < NEAR * SPACING) & (p[:, 1] > NEAR * SPACING) & (p[:, 1] < 1 - NEAR * SPACING)
    faces, turned = to_faces(p[near], angle), angles(normal[near], angle)
    off = faces.min(1)
    mine = np.where(faces <= off[:, None] + noise, turned, 180).min(1)
    return off, mine, (turned.min(1) > SMEARED) | (off > 2 * noise)


def reach(p):
    y = np.linspace(NEAR * SPACING, 1 - NEAR * SPACING, 200)
    return cKDTree(p).query(np.stack([0 * y, y, 0 * y], 1))[0] / SPACING


def run(command, source, result):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([{"IN": source, "OUT": result}.get(word, word) for word in command], check=True, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime


def main(folder, out, seeds, *command):
    sys.path.insert(0, folder)
    from cloudio import read_ply, write_ply, xyz
    source, result = os.path.join(out, "wedge.ply"), os.path.join(out, "wedge_out.ply")
    for angle in ANGLES:
        for noise in NOISES:
            told, reached, cpu, n = [], [], [], []
            for seed in range(int(seeds)):
                write_ply(source, wedge(angle, noise, seed))
                cpu.append(run(command, source, result))
                rows = read_ply(result)[0]
                p, normal = xyz(rows), np.stack([rows["nx"], rows["ny"], rows["nz"]], 1)
                told.append(near_figures(p, normal, angle, noise))
                reached.append(reach(p))
                n.append(len(p))
            off, mine, smeared = (np.concatenate(column) for column in zip(*told))
            print(json.dumps({
                "angle": angle, "noise": noise, "n": int(np.median(n)), "near": len(off), "off": float(off.mean() / noise),
                "p99": float(np.quantile(off, 0.99) / noise), "normal": float(np.median(mine)), "normal_p90": float(np.quantile(mine, 0.9)),
                "smeared": float(smeared.mean()), "reach": float(np.mean(reached)), "cpu": float(np.mean(cpu))}))
    os.unlink(source)
    os.unlink(result)


if __name__ == "__main__":
    if len(sys.argv) < 5:
        sys.exit(__doc__)
    main(*sys.argv[1:])
