"""Rays aimed exactly at the edges and vertices of closed meshes, and their crossings by exact arithmetic.

Vertices, origins and directions are integers below 2^24, so that float32 and float64 represent the same mesh and the same
rays, and every engine gets exactly the same problem. Integers of 64 bits decide exactly which triangles, borders
included, a line meets. A crossing is where the winding number changes between two of these points.
"""

from fractions import Fraction

import numpy as np

KINDS = ("vertices", "edges", "two features")
# Vertices are multiples of this, so that the points that divide an edge into eight are integers too.
CUT = 8
SIZE = 512


def on_grid(points):
    return np.rint(np.asarray(points) * SIZE).astype(np.int64) * CUT


def sphere(levels=3):
    """An icosahedron on the unit sphere, whose faces are subdivided into four several times."""
    g = (1 + 5**0.5) / 2
    v = [
        (-1, g, 0),
        (1, g, 0),
        (-1, -g, 0),
        (1, -g, 0),
        (0, -1, g),
        (0, 1, g),
        (0, -1, -g),
        (0, 1, -g),
        (g, 0, -1),
        (g, 0, 1),
        (-g, 0, -1),
        (-g, 0, 1),
    ]
    f = [
        (0, 11, 5),
        (0, 5, 1),
        (0, 1, 7),
        (0, 7, 10),
        (0, 10, 11),
        (1, 5, 9),
        (5, 11, 4),
        (11, 10, 2),
        (10, 7, 6),
        (7, 1, 8),
        (3, 9, 4),
        (3, 4, 2),
        (3, 2, 6),
        (3, 6, 8),
        (3, 8, 9),
        (4, 9, 5),
        (2, 4, 11),
        (6, 2, 10),
        (8, 6, 7),
        (9, 8, 1),
    ]
    v = [tuple(np.array(p) / np.linalg.norm(p)) for p in v]
    for _ in range(levels):
        middle = {}

        def cut(a, b):
            key = min(a, b), max(a, b)
            if key not in middle:
                p = np.array(v[a]) + v[b]
                middle[key] = len(v)
                v.append(tuple(p / np.linalg.norm(p)))
            return middle[key]

        finer = []
        for a, b, c in f:
            ab, bc, ca = cut(a, b), cut(b, c), cut(c, a)
            finer += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        f = finer
    return on_grid(v), np.array(f)


def quads(rows, columns, number):
    """Two triangles for each cell of a grid; `number(i, j)` is the vertex at its corner (i, j)."""
    for i in range(rows):
        for j in range(columns):
            a, b, c, d = number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)
            yield from ((a, b, c), (a, c, d))


def torus(around=48, across=24):
    u, w = np.meshgrid(
        np.arange(around) * 2 * np.pi / around, np.arange(across) * 2 * np.pi / across, indexing="ij"
    )
    r = 0.7 + 0.3 * np.cos(w)
    v = np.stack([r * np.cos(u), r * np.sin(u), 0.3 * np.sin(w)], -1).reshape(-1, 3)
    return on_grid(v), np.array(list(quads(around, across, lambda i, j: i % around * across + j % across)))


def cube(cuts=8):
    """A cube whose sides are cut into triangles, so that most edges lie within a plane."""
    numbers, faces = {}, []
    for axis in range(3):
        for end in (0, cuts):

            def number(i, j):
                p = [0, 0, 0]
                p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3] = end, i, j
                return numbers.setdefault(tuple(p), len(numbers))

            faces += [f if end else f[::-1] for f in quads(cuts, cuts, number)]
    return on_grid(np.array(list(numbers)) * 2 / cuts - 1), np.array(faces)


MESHES = {"sphere": sphere, "torus": torus, "cube": cube}


def rays(v, f, kind, count, rng):
    """`count` rays from outside of the mesh, (count, 6) int64, through a vertex, a point of an edge, or two of these."""
    radius = int(np.linalg.norm(v, axis=1).max()) + 1

    def point(vertex):
        corner = rng.integers(0, 3, count)
        face = f[rng.integers(0, len(f), count)]
        a, b = (v[np.take_along_axis(face, (corner[:, None] + k) % 3, 1)[:, 0]] for k in (0, 1))
        part = np.where(vertex, 0, rng.integers(1, CUT, count))[:, None]
        return (a * (CUT - part) + b * part) // CUT

    if kind == "two features":
        p, q = (point(rng.random(count) < 0.5) for _ in range(2))
        o, d = p + 8 * (p - q), q - p
        return np.hstack([o, d])[np.linalg.norm(o, axis=1) > radius]
    o = rng.normal(size=(count, 3))
    o = np.rint(o * (3 * radius / np.linalg.norm(o, axis=1))[:, None]).astype(np.int64)
    return np.hstack([o, point(kind == "vertices") - o])


def truth(v, f, rays):
    """For each ray, its exact crossings (a list of Fractions) and whether it also touches the mesh without crossing it,
    where engines may differ by convention; None for a ray within the plane of a triangle."""
    met = meetings(v, f, rays)
    middles = [(i, (a + b) / 2) for i, ts in enumerate(met) if ts for a, b in zip(ts, ts[1:], strict=False)]
    rows = np.array([i for i, _ in middles], dtype=np.int64)
    at = rays[rows, :3] + np.array([float(t) for _, t in middles])[:, None] * rays[rows, 3:]
    inside = iter(winding(v, f, at))
    lists: list[tuple[list[Fraction], bool] | None] = []
    for ts in met:
        if ts is None:
            lists.append(None)
            continue
        states = [0, *(next(inside) for _ in ts[1:]), 0]
        crossed = [t for t, a, b in zip(ts, states, states[1:], strict=False) if a != b]
        lists.append((crossed, len(crossed) < len(ts)))
    return lists


def meetings(v, f, rays):
    """The distinct exact t at which each ray meets triangles; None for a ray within the plane of a triangle."""
    corners, out = v[f], []
    # Edge functions are sums of six products.
    assert 6 * int(np.abs(rays[:, 3:]).max()) * (int(np.abs(rays[:, :3]).max()) + int(np.abs(v).max())) ** 2 < 2**63
    for begin in range(0, len(rays), 64):
        o, d = rays[begin : begin + 64, None, :3], rays[begin : begin + 64, None, 3:]
        a, b, c = (corners[None, :, k] - o for k in range(3))
        w = np.stack([(d * np.cross(p, q)).sum(-1) for p, q in ((a, b), (b, c), (c, a))])
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        n, slope = (normal * a).sum(-1), w.sum(0)
        hit = ((w >= 0).all(0) | (w <= 0).all(0)) & (slope != 0)
        flat = ((slope == 0) & (n == 0)).any(1)
        for i in range(len(o)):
            faces = np.nonzero(hit[i])[0]
            ts = {Fraction(int(n[i, k]), int(slope[i, k])) for k in faces}
            out.append(None if flat[i] else sorted(t for t in ts if t >= 0))
    return out


def winding(v, f, points):
    """Winding numbers by solid angles (van Oosterom and Strackee 1983), which involve no rays."""
    out = []
    for begin in range(0, len(points), 64):
        a, b, c = (v[f][None, :, k] - points[begin : begin + 64, None] for k in range(3))
        la, lb, lc = (np.linalg.norm(x, axis=-1) for x in (a, b, c))
        det = (a * np.cross(b, c)).sum(-1)
        below = la * lb * lc + (a * b).sum(-1) * lc + (b * c).sum(-1) * la + (c * a).sum(-1) * lb
        turns = np.arctan2(det, below).sum(-1) / (2 * np.pi)
        whole = np.rint(turns)
        assert np.abs(turns - whole).max() < 1e-6, "a point on the surface"
        out += whole.astype(int).tolist()
    return out
