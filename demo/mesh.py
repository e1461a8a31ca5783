"""A generated closed mesh for the demo: a trefoil knot of bumpy tube."""

import struct
from math import cos, hypot, pi, sin

ALONG, AROUND = 500, 70
TUBE = 0.27


def add(a, b, factor=1.0):
    return tuple(x + factor * y for x, y in zip(a, b, strict=False))


def dot(a, b):
    return sum(x * y for x, y in zip(a, b, strict=False))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    length = hypot(*a)
    return tuple(x / length for x in a)


def axis(u):
    """The trefoil, wound on a torus about z."""
    reach = 1 + 0.45 * cos(3 * u)
    return (reach * cos(2 * u), reach * sin(2 * u), 0.45 * sin(3 * u))


def frame(u):
    """Two directions across the tube. They are derived from the torus, so they agree where the knot closes."""
    tangent = unit(add(axis(u + 1e-4), axis(u - 1e-4), -1))
    outwards = add(axis(u), (cos(2 * u), sin(2 * u), 0), -1)
    first = unit(add(outwards, tangent, -dot(outwards, tangent)))
    return first, cross(tangent, first)


def knot():
    """Vertices, and triangles that run counter-clockwise seen from outside."""
    vertices = []
    for i in range(ALONG):
        u = 2 * pi * i / ALONG
        centre, (first, second) = axis(u), frame(u)
        for k in range(AROUND):
            v = 2 * pi * k / AROUND
            radius = TUBE * (1 + 0.07 * sin(54 * u + 2 * v) * cos(5 * v))
            vertices.append(add(add(centre, first, radius * cos(v)), second, radius * sin(v)))
    triangles = []
    for i in range(ALONG):
        for k in range(AROUND):
            here, ahead = i * AROUND, (i + 1) % ALONG * AROUND
            a, b, c, d = here + k, ahead + k, ahead + (k + 1) % AROUND, here + (k + 1) % AROUND
            triangles += [(a, c, b), (a, d, c)]
    return vertices, triangles


def write_ply(path, vertices, triangles):
    """Binary PLY, little-endian."""
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(vertices)}\nproperty float x\nproperty float y\nproperty float z\n"
        f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    with open(path, "wb") as file:
        file.write(header.encode())
        file.write(b"".join(struct.pack("<3f", *v) for v in vertices))
        file.write(b"".join(struct.pack("<B3i", 3, *t) for t in triangles))
