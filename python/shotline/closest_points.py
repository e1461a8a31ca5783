"""The points of a mesh that are nearest to given points."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from . import _native
from .progress import callback
from .rays import points as positions
from .values import threads_of


class ClosestPoints(NamedTuple):
    """The points of a mesh that are nearest to points of shape (..., 3).

    points: (..., 3) float64, in the coordinates of the mesh.
    distance: (...) float64, in its units.
    primitive: (...) int32, the triangle; never one with two equal corners. Where several triangles have the point, always the same one of them.
    barycentric: (..., 3) float64, the weights of the corners of the triangle; their sum is 1.

    For a point that is not finite, or more than 1e150 sizes of the mesh away: NaN, infinity and -1.
    """

    points: np.ndarray
    distance: np.ndarray
    primitive: np.ndarray
    barycentric: np.ndarray


def closest_points(mesh: _native.Mesh, points: ArrayLike, threads: int, progress: Any) -> ClosestPoints:
    """The answer for a mesh of the native half. Raises ValueError for points of another shape than (..., 3)."""
    array = positions(points, "points")
    flat = np.ascontiguousarray(array.reshape(-1, 3))
    columns = mesh.closest_points(flat, threads_of(threads), callback(progress))
    return ClosestPoints(*(column.reshape((*array.shape[:-1], *column.shape[1:])) for column in columns))
