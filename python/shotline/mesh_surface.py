"""The surface of a triangle mesh: areas, normals, and points that are spread over it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .values import bounded_integer


class SurfacePoints(NamedTuple):
    """Points of a mesh, as `Mesh.sample` returns them.

    points: (n, 3) float64, in the coordinates of the mesh.
    primitive: (n,) int32, the triangle of each.
    barycentric: (n, 3) float64, the weights of the corners of the triangle; their sum is 1.
    """

    points: np.ndarray
    primitive: np.ndarray
    barycentric: np.ndarray


def areas_and_normals(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The areas of triangles, (m,), and their unit normals, (m, 3); NaN where a triangle has no area."""
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    edges = np.stack([b - a, c - a])
    # In units of the longest coordinate of its edges, no product of a triangle overflows, or underflows needlessly.
    size = np.abs(edges).max(axis=(0, 2))
    first, second = edges / np.where(size > 0, size, 1.0)[:, None]
    cross = np.cross(first, second)
    double = np.linalg.norm(cross, axis=1)
    normals = cross / np.where(double > 0, double, np.nan)[:, None]
    with np.errstate(over="ignore"):
        return double / 2 * size * size, normals


def sample(vertices: np.ndarray, faces: np.ndarray, n: int, seed: int) -> SurfacePoints:
    """`n` points, independent and uniform over the area of the triangles. Raises ValueError for triangles without area, or
    with an area that is not finite."""
    count, seed = bounded_integer(n, "n", 0, 2**31 - 1), bounded_integer(seed, "seed", 0, 2**63 - 1)
    ends = np.cumsum(areas_and_normals(vertices, faces)[0])
    if not 0 < ends[-1] < np.inf:
        raise ValueError(f"the area of the mesh is {ends[-1]}, so no points can be spread over it")
    random = np.random.default_rng(seed).random((count, 3))
    face = np.searchsorted(ends, random[:, 0] * ends[-1], side="right")
    # The root spreads points evenly, because a strip of the triangle is as wide as its distance from the corner.
    root = np.sqrt(random[:, 1])
    weights = np.stack([1 - root, root * (1 - random[:, 2]), root * random[:, 2]], axis=1)
    points = (weights[:, :, None] * vertices[faces[face]]).sum(axis=1)
    return SurfacePoints(points, face.astype(np.int32), weights)
