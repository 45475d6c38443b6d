"""Clouds for the tests of the page."""
import math
import random
import struct

FAR = (637_000.25, 4_851_000.5, 400.125)  # metres, as a map grid has them: float32 rounds them to 1/16 and 1/2


def torus(points, at=(0.0, 0.0, 0.0), seed=1):
    """A torus of radii 1 and 0.4 with uneven random points, doubles and colours, as binary PLY."""
    draw = random.Random(seed)
    rows = []
    for _ in range(points):
        u, v = 2 * math.pi * draw.random() ** 1.5, 2 * math.pi * draw.random()
        ring = 1 + 0.4 * math.cos(v)
        rows.append(struct.pack("<3d3B", at[0] + ring * math.cos(u), at[1] + ring * math.sin(u), at[2] + 0.4 * math.sin(v),
                                int(127 + 127 * math.cos(u)), int(127 + 127 * math.sin(v)), 90))
    names = [f"property double {axis}" for axis in "xyz"] + [f"property uchar {name}" for name in ("red", "green", "blue")]
    head = ["ply", "format binary_little_endian 1.0", f"element vertex {points}", *names, "end_header", ""]
    return "\n".join(head).encode() + b"".join(rows)
