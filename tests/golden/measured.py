"""Runs golden cases and measures their results: a hash of the positions, and figures by the yardstick, which shares no code with
the product."""
import functools
import hashlib
import json
import os
import re
import subprocess
import sys

MISSING = UNMEASURED = None  # why cases cannot be run, or run but not measured
try:
    import numpy as np
    import clouds
except ImportError as error:
    MISSING = str(error)
try:
    sys.path.append("../shared/yardstick")
    import cells
    import cloudio
    import metrics
    import surface
except ImportError as error:
    UNMEASURED = f"{error} (../shared/yardstick, python3-scipy)"

FOLDER = os.path.dirname(os.path.abspath(__file__))
DATA = "../shared/data"
DENSE = 30_000  # points that find the triangles of a surface near a point: with the triangles' middles, enough for these meshes

# What is measured: in the tables a column each. The sign says where better is: +1 more, -1 less.
FIGURES = {"delta": ("%.4f", -1), "hex": ("%.4f", 1), "six": ("%.3f", 1), "rms": ("%.2e", -1), "minmean": ("%.3f", 1)}

def table(name):
    """The rows of a file here: a dict of lists of words by the first word."""
    with open(os.path.join(FOLDER, name)) as file:
        rows = [line.split() for line in file if not line.startswith("#")]
    return {row[0]: row[1:] for row in rows if row}

def cases(only="."):
    return {name: row for name, row in table("cases.txt").items() if re.search(only, name)}

def write_cloud(path, x, columns, kind):
    names = {"<f4": "float", "<f8": "double", "|u1": "uchar"}
    columns = {**{c: x[:, k].astype(kind) for k, c in enumerate("xyz")}, **columns}
    rows = np.empty(len(x), [(c, v.dtype) for c, v in columns.items()])
    for c, v in columns.items():
        rows[c] = v
    head = "".join(f"property {names[v.dtype.str]} {c}\n" for c, v in columns.items())
    with open(path, "wb") as file:
        file.write(f"ply\nformat binary_little_endian 1.0\nelement vertex {len(x)}\n{head}end_header\n".encode() + rows.tobytes())

def absent(cloud):
    """What a case lacks, if anything."""
    files = {cloud, clouds.MESHES.get(cloud, cloud)} - {*clouds.MADE}
    return "; ".join(f"{DATA}/{file} is not there" for file in sorted(files) if not os.path.exists(os.path.join(DATA, file)))


def input_of(cloud, folder):
    """Path of a case's cloud."""
    if cloud not in clouds.MADE:
        return os.path.join(DATA, cloud)
    path = os.path.join(folder, cloud + ".ply")
    x, columns = clouds.MADE[cloud]()
    write_cloud(path, x, columns, "<f8" if cloud == "far" else "<f4")
    return path

def run(command, row, folder, name, threads, *more):
    """Runs a case; (path of the result, report, None) or (None, None, what the product says)."""
    out = os.path.join(folder, name + ".out.ply")
    asked = [*command, row[1], input_of(row[0], folder), *row[2:], *more, "--threads", str(threads), "--json", "-f", "-o", out]
    done = subprocess.run(asked, capture_output=True, text=True)
    if done.returncode != 0:
        return None, None, f"{' '.join(asked)}: exit {done.returncode}: {done.stderr}"
    return out, json.loads(done.stdout.splitlines()[-1]), None

def positions(path):
    """Positions of a result, and a hash of them and of its faces."""
    types = {"float": "<f4", "double": "<f8", "uchar": "u1", "char": "i1", "short": "<i2", "ushort": "<u2", "int": "<i4", "uint": "<u4"}
    with open(path, "rb") as file:
        head, body = file.read().split(b"end_header\n", 1)
    vertex, *rest = head.decode().split("element ")[1:]
    lines = [line.split() for line in vertex.splitlines()]
    rows = np.frombuffer(body, [(name, types[kind]) for _, kind, name in lines[1:]], int(lines[0][1]))
    x = np.stack([rows[c] for c in "xyz"], 1)
    faces = body[rows.nbytes:] if rest else b""
    return x.astype(np.float64), hashlib.sha256(b"%d " % len(x) + x.tobytes() + faces).hexdigest()[:16]

@functools.lru_cache(None)
def sheets_of(cloud):
    """The surface that a cloud lies on, sheet by sheet; none where it is not known."""
    if cloud in clouds.MESHES:
        v, f = cloudio.read_ply(os.path.join(DATA, clouds.MESHES[cloud]))
        return [surface.Surface(cloudio.xyz(v), f, DENSE)]
    return [sheet_of(make) for make in clouds.SHEETS.get(cloud, [])]

@functools.lru_cache(None)
def sheet_of(make):
    return surface.Surface(*make(), DENSE)

def figures(x, cloud):
    """Those of FIGURES by name; rms None where no surface is known. Sheets are measured one by one: a point belongs to the one
    that it is nearest to."""
    apart, rms, sheets = x, None, sheets_of(cloud)
    if sheets:
        off = np.stack([sheet.distance(x) for sheet in sheets])
        apart = x + 100 * sheets[0].diagonal * off.argmin(0)[:, None]
        rms = float(np.sqrt((off.min(0) ** 2).mean())) / sheets[0].diagonal
    cell = cells.report(apart)
    return {"delta": cell["delta"], "hex": cell["hex"], "six": cell["six"], "rms": rms,
            "minmean": metrics.uniformity(apart)["min_over_mean"]}

def line(x, figures):
    """Number of points and figures as the tables show them."""
    return [str(len(x)), *("-" if figures[name] is None else form % figures[name] for name, (form, _) in FIGURES.items())]


def beyond(words, worst):
    """A line for each figure that is worse than its bound. words: number of points and figures as shown."""
    wrong = []
    for (name, (_, better)), word, bound in zip(FIGURES.items(), words[1:], worst):
        if "-" in (word, bound):
            continue
        low, high = bound.split("..") if ".." in bound else (bound, "inf") if better > 0 else ("-inf", bound)
        if not float(low) <= float(word) <= float(high):
            wrong.append(f"{name} is {word}, want {bound if '..' in bound else ('at least ' if better > 0 else 'at most ') + bound}")
    return wrong


def write(name, rows):
    """The file anew, in columns, under its comment."""
    path = os.path.join(FOLDER, name)
    with open(path) as file:
        head = [text for text in file if text.startswith("#")]
    lines = [[case, *row] for case, row in rows.items()]
    widths = [max(map(len, column)) for column in zip(*lines)]
    with open(path, "w") as file:
        file.writelines(head + ["  ".join(w.ljust(n) for w, n in zip(row, widths)).rstrip() + "\n" for row in lines])
