#!/usr/bin/python3
"""usage: peers.py VORONOID OUT: README's table beside other programs, of the PLY in CLOUD (else of Stanford's bunny where it is present,
else of a scan from a Debian package) to POINTS (5000) points. A program that is not installed is named below the table. Writes OUT/peers.md.

Delta is measured here by SciPy. CPU seconds are those of the algorithm alone for the libraries, else of the whole program."""
import glob
import itertools
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile

import numpy as np
from scipy.spatial import cKDTree

BINARY, OUT = sys.argv[1:3]
BUNNY = "../shared/data/bunny.ply"
POINTS, RUNS = int(os.environ.get("POINTS", "5000")), int(os.environ.get("RUNS", "5"))
TYPES = {"char": "i1", "uchar": "u1", "short": "<i2", "ushort": "<u2", "int": "<i4", "uint": "<u4", "float": "<f4", "double": "<f8"}
TRIALS = 14  # halvings of the interval in which the size that leaves about POINTS points is looked for
FARTHEST = """
import sys, time, open3d
cloud, began = open3d.io.read_point_cloud(sys.argv[1]), time.process_time()
cloud = cloud.farthest_point_down_sample(int(sys.argv[2]))
print(time.process_time() - began)
open3d.io.write_point_cloud(sys.argv[3], cloud)
"""


def run(*command):
    """Its standard output and its CPU seconds."""
    before = os.times()
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False,
                          env={**os.environ, "QT_QPA_PLATFORM": "offscreen", "OMP_NUM_THREADS": "1"})
    after = os.times()
    if done.returncode:
        sys.exit(f"{' '.join(map(str, command))}: {done.stdout[-500:]}{done.stderr[-500:]}")
    return done.stdout, after.children_user + after.children_system - before.children_user - before.children_system


def positions(path):
    """Those of a PLY of any encoding, of which voronoid makes a binary one."""
    run(BINARY, "convert", path, "-f", "-o", f"{path}.read.ply")
    with open(f"{path}.read.ply", "rb") as file:
        head, body = file.read().split(b"end_header\n", 1)
    lines = [line.split() for line in head.decode().splitlines()]
    vertex = next(k for k, words in enumerate(lines) if words[:2] == ["element", "vertex"])
    names = itertools.takewhile(lambda words: words[0] == "property", lines[vertex + 1:])
    rows = np.frombuffer(body, [(words[2], TYPES[words[1]]) for words in names], int(lines[vertex][2]))
    return np.stack([rows[axis] for axis in "xyz"], 1).astype(float)


class Peers:
    """The programs, each of which makes `out` from a cloud and returns CPU seconds."""

    def __init__(self, cloud, folder):
        self.cloud, self.folder, self.out = cloud, folder, f"{folder}/out.ply"
        self.spacing = None

    def ours(self):
        text, cpu = run(BINARY, "resample", self.cloud, "-n", POINTS, "--threads", 1, "--json", "-f", "-o", self.out)
        self.spacing = (2 * json.loads(text.splitlines()[-1])["area"] / (3 ** 0.5 * POINTS)) ** 0.5
        return cpu

    def wlop(self, iterations, radius, uniform):
        text, _ = run(os.path.join(os.path.dirname(BINARY), "tests/by_hand/bench/wlop"), self.cloud, POINTS, iterations, radius * self.spacing,
                      uniform, self.out)
        return json.loads(text)["cpu"]

    def farthest(self):
        return float(run("/usr/bin/python3", "-c", FARTHEST, self.cloud, POINTS, self.out)[0])

    def voxels(self, size):
        if not os.path.exists(f"{self.folder}/in.pcd"):
            run("pcl_ply2pcd", self.cloud, f"{self.folder}/in.pcd")
        _, cpu = run("pcl_voxel_grid", f"{self.folder}/in.pcd", f"{self.folder}/out.pcd", "-leaf", f"{size},{size},{size}")
        run("pcl_pcd2ply", f"{self.folder}/out.pcd", self.out)
        return cpu

    def apart(self, size):
        for path in glob.glob(f"{self.folder}/in_*"):
            os.remove(path)
        shutil.copyfile(self.cloud, f"{self.folder}/in.ply")
        _, cpu = run("CloudCompare", "-SILENT", "-AUTO_SAVE", "OFF", "-NO_TIMESTAMP", "-C_EXPORT_FMT", "PLY", "-O", f"{self.folder}/in.ply",
                     "-SS", "SPATIAL", size, "-SAVE_CLOUDS")
        shutil.copyfile(glob.glob(f"{self.folder}/in_*.ply")[0], self.out)
        return cpu

    def sized(self, work):
        """work(size) with the size that leaves about POINTS points."""
        low, high = 0.1 * self.spacing, 3 * self.spacing
        for _ in range(TRIALS):
            size = (low + high) / 2
            work(size)
            low, high = (size, high) if len(positions(self.out)) > POINTS else (low, size)
        return lambda: work(high)


def row(peers, work):
    cpus = [work() for _ in range(RUNS + 1)][1:]  # the first warms up
    found = positions(peers.out)
    near = cKDTree(found).query(found, 2)[0][:, 1]
    return f"{near.std() / near.mean():.3f} | {len(found):,} | {statistics.median(cpus):.2g} s"


def has_open3d():
    return subprocess.run(["/usr/bin/python3", "-c", "import open3d"], capture_output=True, check=False).returncode == 0


def main():
    cloud = os.environ.get("CLOUD") or (BUNNY if os.path.exists(BUNNY) else run("tests/demo/scan.sh", "hippo1.ply")[0].strip())
    with tempfile.TemporaryDirectory() as folder:
        peers = Peers(cloud, folder)
        rows = [("voronoid, defaults, one thread", True, peers.ours),
                ("CGAL WLOP, 35 iterations, radius 1.5 spacings", True, lambda: peers.wlop(35, 1.5, 1)),
                ("CGAL WLOP, 35 iterations, its own radius", True, lambda: peers.wlop(35, 0, 0)),
                ("Open3D, farthest points", has_open3d(), peers.farthest),
                ("PCL, voxel grid", shutil.which("pcl_voxel_grid"), peers.voxels),
                ("CloudCompare, minimum distance", shutil.which("CloudCompare"), peers.apart)]
        shutil.copyfile(cloud, peers.out)
        text = f"{cloud}, {len(positions(peers.out)):,} points, to {POINTS:,}\n\n| | delta | points | CPU time |\n|---|---|---|---|\n"
        for name, is_here, work in rows:
            if is_here:
                text += f"| {name} | {row(peers, peers.sized(work) if work in (peers.voxels, peers.apart) else work)} |\n"
        absent = [name for name, is_here, _ in rows if not is_here]
        text += f"\nNot installed: {'; '.join(absent)}.\n" if absent else ""
    with open(os.path.join(OUT, "peers.md"), "w", encoding="utf-8") as out:
        out.write(text)
    print(text)


main()
