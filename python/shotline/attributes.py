"""Attributes of meshes: values of vertices, or of the corners of triangles, such as colours and texture coordinates."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from .values import floats

# What the native half calls the value of a corner that has none.
_NO_ROW = np.iinfo(np.uint32).max


class Attribute(NamedTuple):
    """An attribute as the native half keeps it."""

    name: str
    # (k, width) float64.
    values: np.ndarray
    # For each triangle the values of its corners, (m, 3) uint32; None where value i is that of vertex i.
    corners: np.ndarray | None

    def array(self) -> np.ndarray:
        """The values of the vertices, (n, width), or of the corners of the triangles, (m, 3, width); NaN where a corner has
        none."""
        if self.corners is None:
            return self.values
        with_none = np.vstack([self.values, np.full((1, self.values.shape[1]), np.nan)])
        return with_none[np.where(self.corners == _NO_ROW, len(self.values), self.corners)]


def given_attributes(
    attributes: Mapping[str, ArrayLike] | None, vertices: int, triangles: int | None
) -> list[tuple[str, np.ndarray, np.ndarray | None]]:
    """The `attributes` argument of a mesh as the native half takes it; `triangles` is None for a mesh with faces of other
    numbers of corners. Raises ValueError for an array of another shape, and for an empty name."""
    return [_given(name, array, vertices, triangles) for name, array in (attributes or {}).items()]


def _given(
    name: Any, array: ArrayLike, vertices: int, triangles: int | None
) -> tuple[str, np.ndarray, np.ndarray | None]:
    if not isinstance(name, str):
        raise TypeError(f"attributes are named by strings, not by {type(name).__name__}")
    if not name:
        raise ValueError("an attribute has an empty name; files and hits.interpolate need one")
    values = floats(array, f"attribute {name!r}")
    if values.ndim > 1 and not values.shape[-1] and len(values):
        raise ValueError(f"attribute {name!r} has shape {values.shape}, so it has no numbers")
    if values.ndim in (1, 2) and len(values) == vertices:
        return name, np.ascontiguousarray(values.reshape(vertices, -1)), None
    if values.ndim == 3 and triangles is not None and values.shape[:2] == (triangles, 3):
        rows = np.arange(3 * triangles, dtype=np.uint32).reshape(triangles, 3)
        return name, np.ascontiguousarray(values.reshape(3 * triangles, -1)), rows
    corners = f" or ({triangles}, 3, k) for corners" if triangles is not None else ""
    raise ValueError(
        f"attribute {name!r} has shape {values.shape}, but must be ({vertices},) or ({vertices}, k) for vertices{corners}"
    )
