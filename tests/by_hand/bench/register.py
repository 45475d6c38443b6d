#!/usr/bin/python3
"""usage: register.py VORONOID OUT: `register` beside PCL (FPFH, SAC-IA, ICP) in the same run, POSES (20) poses each of igea: of all of
it, a tenth as dense with noise of 0.3 spacings; and of one of two halves that share half. Right: within 1 degree, 0.5 % of the diagonal
and, ours, trust of at least 0.5 is counted too. One thread. Writes OUT/register.md."""
import json
import os
import subprocess
import sys
import tempfile

import numpy as np
from scipy.spatial import cKDTree

BINARY, OUT = sys.argv[1:3]
POSES, IGEA = int(os.environ.get("POSES", "20")), "../shared/data/igea_mesh.ply"
PEER = os.path.join(os.path.dirname(BINARY), "tests/by_hand/bench/register")
HEAD = "ply\nformat binary_little_endian 1.0\nelement vertex %d\nproperty float x\nproperty float y\nproperty float z\nend_header\n"


def run(*command):
    """Its standard output and its CPU seconds."""
    before = os.times()
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=True)
    after = os.times()
    return done.stdout, after.children_user + after.children_system - before.children_user - before.children_system


def points(folder):
    """The vertices of igea, of which a pose takes some for each cloud."""
    run(BINARY, "convert", IGEA, "-q", "-f", "-o", f"{folder}/p.ply")
    with open(f"{folder}/p.ply", "rb") as file:
        head, body = file.read().split(b"end_header\n", 1)
    n = int(head.split(b"element vertex ")[1].split()[0])
    return np.frombuffer(body, "<f4", 3 * n).reshape(n, 3).astype(float)


def pair(folder, every, kind, seed):
    """Cloud, reference and the turn and shift that lead back."""
    rng = np.random.default_rng(seed)
    x = rng.permutation(every)[:60000]
    cloud, reference = x[:5000], x[5000:55000]
    if kind == "halves":
        along = x @ rng.normal(size=3)
        cloud, reference = x[along < np.quantile(along, 2 / 3)][:5000], x[along > np.quantile(along, 1 / 3)][-30000:]
    else:
        cloud = cloud + rng.normal(size=cloud.shape) * 0.3 * 2 * np.median(cKDTree(cloud).query(cloud, 2)[0][:, 1])
    q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    turn, shift = q * np.sign(np.linalg.det(q)), rng.normal(size=3) * np.ptp(x)
    for name, one in (("cloud", (cloud - shift) @ turn), ("reference", reference)):
        one.astype("<f4").tofile(f"{folder}/{name}.f32")
        with open(f"{folder}/{name}.ply", "wb") as file:
            file.write((HEAD % len(one)).encode() + one.astype("<f4").tobytes())
    return turn, shift, cloud.mean(0), np.linalg.norm(np.ptp(x, axis=0))


def ours(folder):
    text, cpu = run(BINARY, "register", f"{folder}/cloud.ply", "--reference", f"{folder}/reference.ply", "--threads", 1, "--json", "-f", "-o", f"{folder}/o.ply")
    told = json.loads(text.splitlines()[-1])["registration"]
    return np.array(told["transform"], float).reshape(4, 4), cpu, told["trust"]


def theirs(folder):
    words = run(PEER, f"{folder}/cloud.f32", f"{folder}/reference.f32")[0].split()
    return np.array(words[1:], float).reshape(4, 4), float(words[0]), None


def main():
    rows = "| igea, %d poses | right | trusted | CPU s, median |\n|---|---|---|---|\n" % POSES
    with tempfile.TemporaryDirectory(dir=OUT) as folder:
        every = points(folder)
        for kind, words in (("noise", "a tenth as dense, noise"), ("halves", "halves that share half")):
            found = {"register": [], "PCL, FPFH, SAC-IA, ICP": []}
            for seed in range(POSES):
                turn, shift, middle, diagonal = pair(folder, every, kind, seed)
                for name, who in zip(found, (ours, theirs)):
                    matrix, cpu, trust = who(folder)
                    angle = np.degrees(np.arccos(np.clip((np.trace(matrix[:3, :3] @ turn.T) - 1) / 2, -1, 1)))
                    off = np.linalg.norm(matrix[:3, :3] @ ((middle - shift) @ turn) + matrix[:3, 3] - middle) / diagonal
                    found[name].append((angle < 1 and off < 0.005, cpu, trust))
            for name, all_of in found.items():
                trusted = sum(one[2] >= 0.5 for one in all_of) if all_of[0][2] is not None else "-"
                rows += f"| {words}: {name} | {sum(one[0] for one in all_of)} | {trusted} | {np.median([one[1] for one in all_of]):.2f} |\n"
    print(rows)
    with open(os.path.join(OUT, "register.md"), "w", encoding="utf-8") as out:
        out.write(rows)


if os.path.exists(IGEA):
    main()
