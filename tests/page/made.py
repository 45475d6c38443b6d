"""Clouds for the tests of the page."""
import math
import random
import struct

FAR = (637_000.25, 4_851_000.5, 400.125)  # metres, as a map grid has them: float32 rounds them to 1/16 and 1/2


def lines(rows=60, columns=180, apart=3.0):
    """A square sheet as a scanner has it: points 1 apart on lines that are farther apart, as ASCII PLY."""
    head = ["ply", "format ascii 1.0", f"element vertex {rows * columns}", *(f"property float {axis}" for axis in "xyz"), "end_header"]
    return "\n".join(head + [f"{x} {apart * y} 0" for y in range(rows) for x in range(columns)] + [""]).encode()


def mesh(n=12):
    """A bent sheet of 2 (n - 1)^2 triangles over n^2 points, as ASCII PLY."""
    head = ["ply", "format ascii 1.0", f"element vertex {n * n}", *(f"property float {axis}" for axis in "xyz"),
            f"element face {2 * (n - 1) ** 2}", "property list uchar int vertex_indices", "end_header"]
    corners = [f"{x} {y} {math.sin(x / 3)}" for y in range(n) for x in range(n)]
    faces = [f"3 {at} {at + 1} {at + n}\n3 {at + 1} {at + n + 1} {at + n}" for y in range(n - 1) for x in range(n - 1) for at in [n * y + x]]
    return "\n".join(head + corners + faces + [""]).encode()


def torus(points, at=(0.0, 0.0, 0.0), seed=1, turned=False):
    """A torus of radii 1 and 0.4 with uneven random points, doubles and colours, as binary PLY; turned: its axis is the first one."""
    draw = random.Random(seed)
    rows = []
    for _ in range(points):
        u, v = 2 * math.pi * draw.random() ** 1.5, 2 * math.pi * draw.random()
        ring = 1 + 0.4 * math.cos(v)
        own = ring * math.cos(u), ring * math.sin(u), 0.4 * math.sin(v)
        rows.append(struct.pack("<3d3B", *(a + b for a, b in zip(at, (own[2], *own[:2]) if turned else own)),
                                int(127 + 127 * math.cos(u)), int(127 + 127 * math.sin(v)), 90))
    names = [f"property double {axis}" for axis in "xyz"] + [f"property uchar {name}" for name in ("red", "green", "blue")]
    head = ["ply", "format binary_little_endian 1.0", f"element vertex {points}", *names, "end_header", ""]
    return "\n".join(head).encode() + b"".join(rows)
