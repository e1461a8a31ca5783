"""Grids of cells, whose centres are found on rays along their rows."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .values import bounded_integer, floats

# Rays per query, which bounds the memory beside the grid.
_BLOCK = 1 << 18

MAX_CELLS = 2**31


class Grid:
    """Cells of equal size in a box. The rows run along the axis that has the most cells."""

    def __init__(self, bounds: ArrayLike, shape: Any) -> None:
        box = floats(bounds, "bounds")
        if box.shape != (2, 3) or not np.isfinite(box).all():
            raise ValueError(
                f"bounds are the least and the greatest corner, (2, 3) finite numbers, not {box.tolist()}"
            )
        if not (box[0] < box[1]).all():
            raise ValueError(f"bounds from {box[0].tolist()} to {box[1].tolist()} have no volume")
        try:
            sizes = tuple(shape)
        except TypeError:
            sizes = ()
        if len(sizes) != 3:
            raise TypeError(f"shape is the number of cells along x, y and z, as in (40, 30, 20), not {shape!r}")
        self.shape = tuple(bounded_integer(size, "a number of cells in shape", 1, MAX_CELLS) for size in sizes)
        if np.prod(self.shape, dtype=float) > MAX_CELLS:
            raise ValueError(f"shape has {np.prod(self.shape, dtype=float):.3g} cells, but at most {MAX_CELLS} fit")
        self.axis = int(np.argmax(self.shape))
        self._cell = (box[1] - box[0]) / self.shape
        self._first = box[0] + 0.5 * self._cell
        self.length = self.shape[self.axis]

    def rows(self) -> Iterator[tuple[slice, np.ndarray, np.ndarray]]:
        """Blocks of rows: which they are, the origins of their rays, (n, 3), and the direction, (3,). The centre of the
        first cell is at t = 1, that of the next at t = 2."""
        across = [axis for axis in range(3) if axis != self.axis]
        counts = [self.shape[axis] for axis in across]
        direction = np.zeros(3)
        direction[self.axis] = self._cell[self.axis]
        total = counts[0] * counts[1]
        for start in range(0, total, _BLOCK):
            rows = np.arange(start, min(start + _BLOCK, total))
            origins = np.tile(self._first - direction, (len(rows), 1))
            for axis, numbers in zip(across, np.divmod(rows, counts[1]), strict=True):
                origins[:, axis] += numbers * self._cell[axis]
            yield slice(start, start + len(rows)), origins, direction

    def array(self, rows: np.ndarray) -> np.ndarray:
        """An array [x, y, z] from one of rows, (rows, cells)."""
        counts = [size for axis, size in enumerate(self.shape) if axis != self.axis]
        return np.ascontiguousarray(np.moveaxis(rows.reshape(*counts, self.length), -1, self.axis))


def fill(rows: np.ndarray, ray_ids: np.ndarray, t_in: np.ndarray, t_out: np.ndarray, values: np.ndarray) -> None:
    """Writes the values of intervals of rows into the cells whose centres they hold."""
    cells = rows.shape[1]
    first = np.clip(np.ceil(t_in), 1, cells + 1).astype(np.int64) - 1
    last = np.clip(np.ceil(t_out), 1, cells + 1).astype(np.int64) - 1
    counts = np.maximum(last - first, 0)
    ends = np.cumsum(counts)
    within = np.arange(ends[-1] if len(ends) else 0) - np.repeat(ends - counts, counts)
    rows.reshape(-1)[np.repeat(ray_ids * cells + first, counts) + within] = np.repeat(values, counts)
