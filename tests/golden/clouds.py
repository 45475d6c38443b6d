"""The made clouds of the golden cases, and the surfaces that they lie on.

A cloud comes from additions, products and roots alone: the same bytes on every machine. A surface is a list of sheets, each a
triangle mesh, which are measured one by one."""
import numpy as np


def unit(seed, count):
    """Numbers in [0, 1), by splitmix64."""
    with np.errstate(over="ignore"):
        z = (np.arange(1, count + 1, dtype=np.uint64) + np.uint64(seed << 32)) * np.uint64(0x9E3779B97F4A7C15)
        z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        return ((z ^ (z >> np.uint64(31))) >> np.uint64(11)).astype(np.float64) / 2.0 ** 53


def spread(seed, n, columns):
    return unit(seed, n * columns).reshape(n, columns) * 2 - 1


def grid(points):
    """Triangles over a grid of points (rows, columns, 3)."""
    rows, columns = points.shape[:2]
    i = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = (x.ravel() for x in (i[:-1, :-1], i[1:, :-1], i[1:, 1:], i[:-1, 1:]))
    return points.reshape(-1, 3), np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def plane(u, v, function):
    return grid(np.stack(function(*np.meshgrid(u, v, indexing="ij")), 2))


def joined(*meshes):
    starts = np.cumsum([0] + [len(v) for v, _ in meshes])
    return np.concatenate([v for v, _ in meshes]), np.concatenate([f + s for (_, f), s in zip(meshes, starts)])


def cube_mesh(parts):
    """The faces of the cube from -1 to 1."""
    side = np.linspace(-1, 1, parts + 1)
    u, v = np.meshgrid(side, side, indexing="ij")
    return joined(*(grid(np.roll(np.stack([u, v, np.full_like(u, w)], 2), axis, 2)) for axis in range(3) for w in (-1, 1)))


def length(x):
    return np.sqrt(x[:, 0] ** 2 + x[:, 1] ** 2 + x[:, 2] ** 2)[:, None]


def sphere():
    v, f = cube_mesh(96)
    return v / length(v), f


def box():
    """A cube with normals and colours; of 50 points two share their place."""
    n = 3000
    x = spread(1, n, 3)
    face = np.arange(n) % 6
    normal = np.zeros((n, 3))
    normal[np.arange(n), face // 2] = face % 2 * 2 - 1
    x[np.arange(n), face // 2] = normal[np.arange(n), face // 2]
    x[49::50] = x[48::50]
    normal[49::50] = normal[48::50]
    colour = {c: (unit(2 + k, n) * 256).astype("u1") for k, c in enumerate(("red", "green", "blue"))}
    return x, {**{c: normal[:, k].astype("f4") for k, c in enumerate(("nx", "ny", "nz"))}, **colour}


def ball(seed=5, n=4000):
    """The unit sphere, denser towards the corners of the cube around it."""
    x = spread(seed, n, 3)
    return x / length(x), {}


def few():
    return ball(16, 400)


def noisy():
    """Half of the sphere off by up to 4 %."""
    x = ball(6)[0]
    return np.where(x[:, :1] > 0, x * (1 + 0.08 * (unit(7, len(x))[:, None] - 0.5)), x), {}


def voxels():
    return np.rint(ball(8, 8000)[0] * 25) / 25, {}


def directions(seed, n):
    """Points on the unit circle."""
    x = spread(seed, 2 * n, 2)
    r2 = x[:, 0] ** 2 + x[:, 1] ** 2
    x = x[(r2 < 1) & (r2 > 0.01)][:n]
    return x / np.sqrt(x[:, :1] ** 2 + x[:, 1:] ** 2)


def torus():
    """Radii 1 and 0.4, denser on the inner side."""
    a, b = directions(9, 6000), directions(10, 6000)
    r = 1 + 0.4 * b[:, :1]
    return np.concatenate([r * a, 0.4 * b[:, 1:]], 1), {}


def round_torus():
    return plane(np.linspace(0, 2 * np.pi, 401), np.linspace(0, 2 * np.pi, 161), lambda u, v: (
        (1 + 0.4 * np.cos(v)) * np.cos(u), (1 + 0.4 * np.cos(v)) * np.sin(u), 0.4 * np.sin(v)))


def bent(x, y):
    """Up along x, down along y, folded by 45 degrees at x = 0.5."""
    return x, y, 0.5 * x * x - 0.15 * y * y + np.maximum(0, x - 0.5)


def sheet():
    """The bent sheet, with one round hole."""
    x = spread(11, 5200, 2)
    x = x[(x[:, 0] + 0.4) ** 2 + x[:, 1] ** 2 >= 0.03][:5000]
    return np.stack(bent(x[:, 0], x[:, 1]), 1), {}


def whole_sheet():
    side = np.linspace(-1, 1, 201)
    return plane(side, side, bent)


FAR = np.array([637000.25, 5100000.5, 12])


def saddle(x, y):
    return 50 * x, 50 * y, 15 * (x * x - y * y)


def far():
    """A rough saddle with a hole, far from the origin; one point of 100 is off it by a tenth of its width."""
    x = spread(12, 5000, 2)
    x = x[x[:, 0] ** 2 + x[:, 1] ** 2 >= 0.1][:4000]
    x = np.stack(saddle(x[:, 0], x[:, 1]), 1)
    x[:, 2] += unit(17, len(x)) - 0.5
    x[::100, 2] += 10
    return x + FAR, {}


def whole_saddle():
    """Beyond the border too, where points may go whose border is free."""
    side = np.linspace(-1.2, 1.2, 241)
    v, f = plane(side, side, saddle)
    return v + FAR, f


GAP = 0.06  # between two sheets: nearly two spacings of their points, and one of the result's


def sheets():
    """Two unit squares, one above the other, rough by a twentieth of their distance."""
    x = (spread(13, 2000, 3) + 1) / 2
    x[:, 2] = (np.arange(len(x)) % 2 + 0.1 * (x[:, 2] - 0.5)) * GAP
    return x, {}


def lower():
    side = np.linspace(0, 1, 21)
    return plane(side, side, lambda u, v: (u, v, np.zeros_like(u)))


def upper():
    v, f = lower()
    return v + [0, 0, GAP], f


APART = np.array([1.2, 0.1, 0.05])


def crossing():
    """Two spheres that pass through each other."""
    return np.concatenate([ball(14, 3000)[0], ball(15, 3000)[0] + APART]), {}


def moved_sphere():
    v, f = sphere()
    return v + APART, f


MADE = {f.__name__: f for f in (box, ball, few, noisy, voxels, torus, sheet, far, sheets, crossing)}

def cube():
    return cube_mesh(12)


# The sheets of a made cloud.
SHEETS = {"box": [cube], "ball": [sphere], "few": [sphere], "noisy": [sphere], "voxels": [sphere], "torus": [round_torus],
          "sheet": [whole_sheet], "far": [whole_saddle], "sheets": [lower, upper], "crossing": [sphere, moved_sphere]}

MESHES = {"bunny.ply": "bun_zipper.ply", "cow_mesh.ply": "cow_mesh.ply", "fandisk_mesh.ply": "fandisk_mesh.ply",
          "armadillo_mesh.ply": "armadillo_mesh.ply"}  # real clouds with the meshes that they lie on
