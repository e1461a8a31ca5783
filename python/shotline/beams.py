"""Beams: small objects that know how many rays they have and generate any range of them where they are needed.

A beam has `len(beam)` and `beam.rays(start, stop)`, which returns the origins and directions of the rays numbered from
`start` up to, but not including, `stop`: (stop - start, 3), or (3,) for one that all rays share. It may have
`beam.shape`, the shape of results. A ray has the same bits in whatever range it is generated. Any object with these is
a beam; it is sent to other machines by pickle.

>>> beam = Cone(source=(0, 0, -100), center=(0, 0, 100), u=(0.5, 0, 0), v=(0, 0.5, 0), shape=(2, 3))
>>> len(beam), beam.shape
(6, (2, 3))
>>> origins, directions = beam.rays(0, len(beam))
>>> directions[0].tolist()
[-0.5, -0.25, 200.0]
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .rays import points

__all__ = ["Cone", "Function", "Parallel", "Random"]


class _Panel:
    """Pixels in rows and columns, in one or several views."""

    def __init__(self, shape: tuple[int, int], **vectors: ArrayLike) -> None:
        self._rows, self._columns = (_count(size, "shape") for size in shape)
        arrays = {name: points(value, name) for name, value in vectors.items()}
        try:
            views = np.broadcast_shapes(*(array.shape[:-1] for array in arrays.values()))
        except ValueError:
            views = (0, 0)
        if len(views) > 1:
            shapes = ", ".join(f"{name} {array.shape}" for name, array in arrays.items())
            raise ValueError(f"vectors must have shape (3,), or (views, 3) with the same views: {shapes}")
        self._vectors = {
            name: np.broadcast_to(array, (*(views or (1,)), 3)).copy() for name, array in arrays.items()
        }
        self.shape = (*views, self._rows, self._columns)

    def __len__(self) -> int:
        return math.prod(self.shape)

    def _pixels(self, start: int, stop: int) -> tuple[np.ndarray, np.ndarray]:
        """The view of each pixel, and its centre."""
        view, pixel = np.divmod(np.arange(start, stop), self._rows * self._columns)
        row, column = np.divmod(pixel, self._columns)
        right = (column - (self._columns - 1) / 2)[:, None]
        down = (row - (self._rows - 1) / 2)[:, None]
        center, u, v = (self._vectors[name][view] for name in ("center", "u", "v"))
        return view, center + right * u + down * v


class Parallel(_Panel):
    """Parallel rays, which start at the centres of the pixels of a flat panel.

    Args:
        direction: of all rays; `t` counts lengths of it.
        center: the middle of the panel, in world coordinates.
        u: from the centre of a pixel to that of the next in its row.
        v: to that of the one below.
        shape: rows and columns.

    Each vector is (3,), or (views, 3) for a panel that moves; rays are numbered by view, row, column, and results have
    the shape ([views,] rows, columns). ValueError for other shapes.
    """

    def __init__(
        self, *, direction: ArrayLike, center: ArrayLike, u: ArrayLike, v: ArrayLike, shape: tuple[int, int]
    ) -> None:
        super().__init__(shape, direction=direction, center=center, u=u, v=v)

    def rays(self, start: int, stop: int) -> tuple[np.ndarray, np.ndarray]:
        """Origins and directions of the rays `start` to `stop - 1`: (stop - start, 3) float64 each."""
        view, pixels = self._pixels(start, stop)
        return pixels, self._vectors["direction"][view]


class Cone(_Panel):
    """Rays from a point to the centres of the pixels of a flat panel, as of an X-ray tube or a pinhole.

    The panel is at t = 1, so that `t_max=1` ends all rays there. `source` is the point, in world coordinates; the other
    arguments are those of `Parallel`.
    """

    def __init__(
        self, *, source: ArrayLike, center: ArrayLike, u: ArrayLike, v: ArrayLike, shape: tuple[int, int]
    ) -> None:
        super().__init__(shape, source=source, center=center, u=u, v=v)

    def rays(self, start: int, stop: int) -> tuple[np.ndarray, np.ndarray]:
        """Origins and directions of the rays `start` to `stop - 1`: (stop - start, 3) float64 each."""
        view, pixels = self._pixels(start, stop)
        source = self._vectors["source"][view]
        return source, pixels - source


class Random:
    """Rays with random origins in a box, or at a point, and random directions.

    Args:
        count: how many rays.
        seed: 0 to 2^128 - 1; the same seed gives the same bits, with any version of NumPy and on any machine.
        min, max: corners of the box in world coordinates, (3,); equal ones are a point.

    Directions are isotropic, of length 1 but for rounding. Numbers come from Philox (Salmon et al. 2011), whose counter
    is set for each chunk of a few thousand rays, so that a range costs only its own chunks.
    """

    # Rays per chunk. Another number would give other rays.
    _CHUNK = 8192

    def __init__(self, count: int, *, seed: int, min: ArrayLike = (0, 0, 0), max: ArrayLike = (0, 0, 0)) -> None:
        self._count, self._seed = _count(count, "count", least=0), operator.index(seed)
        if not 0 <= self._seed < 2**128:
            raise ValueError(f"seed is {seed}, but must be from 0 to 2^128 - 1")
        self._min, self._max = points(min, "min").reshape(3), points(max, "max").reshape(3)

    def __len__(self) -> int:
        return self._count

    def rays(self, start: int, stop: int) -> tuple[np.ndarray, np.ndarray]:
        """Origins and directions of the rays `start` to `stop - 1`: (stop - start, 3) float64 each."""
        first = start // self._CHUNK
        chunks = [self._chunk(number) for number in range(first, -(-stop // self._CHUNK))]
        rays = np.concatenate([np.empty((0, 2, 3)), *chunks])[start - first * self._CHUNK :][: stop - start]
        return rays[:, 0], rays[:, 1]

    def _chunk(self, number: int) -> np.ndarray:
        """Rays of shape (_CHUNK, origin and direction, 3). Uses only operations that IEEE 754 rounds in one way; no
        sine."""
        bits = np.random.Philox(key=self._seed, counter=[0, number, 0, 0])
        rays = np.empty((self._CHUNK, 2, 3))
        rays[:, 0] = self._min + (self._max - self._min) * _uniform(bits, self._CHUNK)
        made = 0
        while made < self._CHUNK:
            # Points of the unit ball; those near its centre would lose digits.
            x, y, z = (2 * _uniform(bits, 2 * self._CHUNK) - 1).T
            squared = x * x + y * y + z * z
            kept = np.flatnonzero((squared <= 1) & (squared > 2**-20))[: self._CHUNK - made]
            length = np.sqrt(squared[kept])
            for axis, values in enumerate((x, y, z)):
                rays[made : made + len(kept), 1, axis] = values[kept] / length
            made += len(kept)
        return rays


class Function:
    """Rays from a function of (start, stop), which returns origins and directions as `rays` of any beam does.

    It must give the same ray for a number in every range. It is sent by cloudpickle, so a lambda works.
    """

    def __init__(
        self, count: int, function: Callable[[int, int], tuple[Any, Any]], *, shape: tuple[int, ...] | None = None
    ) -> None:
        self._count, self.rays = _count(count, "count", least=0), function
        self.shape = (self._count,) if shape is None else tuple(shape)
        if math.prod(self.shape) != self._count:
            raise ValueError(f"{count} rays do not fill the shape {shape}")

    def __len__(self) -> int:
        return self._count


def _count(value: Any, what: str, least: int = 1) -> int:
    number = operator.index(value)
    if number < least:
        raise ValueError(f"{what} has {number}, but must have at least {least}")
    return number


def _uniform(bits: np.random.Philox, count: int) -> np.ndarray:
    """Uniform numbers in [0, 1), multiples of 2^-53: (count, 3)."""
    return ((bits.random_raw(3 * count) >> np.uint64(11)) * 2.0**-53).reshape(count, 3)
