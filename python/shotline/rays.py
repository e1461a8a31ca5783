"""Converts rays to the arrays that the core reads: float64, native byte order, C order; copies only if necessary."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from .values import floats


class Rays(NamedTuple):
    """Rays of checked shape; the core checks the numbers."""

    shape: tuple[int, ...]
    ray_count: int
    origins: np.ndarray
    directions: np.ndarray | None


def points(values: ArrayLike, what: str) -> np.ndarray:
    """An array of shape (..., 3)."""
    array = floats(values, what)
    if array.ndim == 0 or array.shape[-1] != 3:
        turned = f": give its transpose, {what}.T" if array.ndim == 2 and array.shape[0] == 3 else ""
        raise ValueError(f"{what} must have shape (..., 3), not {array.shape}{turned}")
    return array


def rays(o: ArrayLike, d: ArrayLike | None) -> Rays:
    """Rays from origins and directions that broadcast against each other, or from one array with both."""
    if d is None:
        both = floats(o, "rays")
        if both.ndim == 0 or both.shape[-1] != 6:
            alone = ": directions are given as d" if both.ndim and both.shape[-1] == 3 else ""
            raise ValueError(
                f"without d, o must have shape (..., 6), an origin and a direction each, not {both.shape}{alone}"
            )
        flat = both.reshape(-1, 6)
        return Rays(both.shape[:-1], len(flat), flat, None)
    origins, directions = points(o, "o"), points(d, "d")
    shape = origins.shape[:-1]
    if shape != directions.shape[:-1]:
        try:
            shape = np.broadcast_shapes(shape, directions.shape[:-1])
        except ValueError:
            message = f"o of shape {origins.shape} and d of shape {directions.shape} do not broadcast"
            raise ValueError(message) from None
    count = math.prod(shape)
    return Rays(shape, count, _spread(origins, shape, count), _spread(directions, shape, count))


def _spread(vectors: np.ndarray, shape: tuple[int, ...], count: int) -> Any:
    """One vector for all rays, or one per ray."""
    if vectors.size == 3:
        return vectors if vectors.ndim == 1 else vectors.reshape(3)
    if vectors.shape[:-1] == shape:
        return vectors.reshape(count, 3)
    return np.ascontiguousarray(np.broadcast_to(vectors, (*shape, 3))).reshape(count, 3)


def lengths(vectors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The lengths of vectors (..., 3) as products of two factors, of which neither overflows nor underflows: the length in
    units of the largest component, and this component."""
    largest = np.abs(vectors).max(axis=-1)
    scaled = np.linalg.norm(vectors / largest[..., None], axis=-1)
    return scaled, largest


def distances_to(t: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """The lengths of rays up to their t."""
    scaled, largest = lengths(directions)
    with np.errstate(over="ignore"):
        return np.asarray(t * largest * scaled)


def points_at(origins: np.ndarray, directions: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Points on rays, (n, 3); NaN for infinite t."""
    with np.errstate(over="ignore", invalid="ignore"):
        points = origins + t[:, None] * directions
    points[~np.isfinite(t)] = np.nan
    return np.asarray(points)
