"""What a compiled scene can be asked: many rays at once, arrays in and arrays out; and what its numbers stand for."""

from __future__ import annotations

import math
import warnings
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _native
from .progress import callback
from .rays import points, rays
from .results import Closest, Cost, Crossings, Segments
from .values import choice, integer, number, text, whole


class Queries:
    """The queries of a `Scene`."""

    __slots__ = ()
    _native: _native.Scene

    def closest(
        self,
        o: ArrayLike,
        d: ArrayLike | None = None,
        *,
        t_min: float = 0.0,
        t_max: float = math.inf,
        surfaces_only: bool = False,
        threads: int = 0,
        progress: Any = None,
    ) -> Closest:
        """The first crossing of each ray.

        Args:
            o: origins, (..., 3) in world coordinates; or, without `d`, rays of shape (..., 6): origin, direction.
            d: directions, (..., 3), of any length but zero; broadcast against `o`.
            t_min: only crossings from here on; a ray that is inside there has a crossing at `t_min` itself.
            t_max: only crossings up to here.
            surfaces_only: look for real surfaces only: not for the crossing at `t_min` of a ray that begins inside, nor
                for that at `t_max` of one that ends inside. As a ray of a lidar in a room, or of Embree.
            threads: 0 for one a core. The bits are the same for any number.
            progress: True, a callable of (done, total), or a bar with `update` such as tqdm's.

        Arrays of float64 in C order are read in place: do not change them meanwhile from another thread.

        Returns:
            `Closest`, its arrays of the broadcast shape (...).

        Raises:
            ValueError: for shapes that do not fit, and for a ray with NaN, infinite numbers or without direction: its
                row is named, numbered in C order, before any work is done. Also for a ray that takes more than 10^7 steps, or
                has more than 2^20 crossings where they are listed, as where parts lie in one another over and over. The
                error has the number of the row as `row`.
            TypeError: for what are no real numbers.
            MemoryError: for answers that do not fit into memory.
        """
        shape, ask = _ask(o, d, t_min, t_max, threads, progress, surfaces_only)
        t, normal, *rest = self._native.closest(ask)
        return Closest(t.reshape(shape), normal.reshape(*shape, 3), *(column.reshape(shape) for column in rest))

    def any(
        self,
        o: ArrayLike,
        d: ArrayLike | None = None,
        *,
        t_min: float = 0.0,
        t_max: float = math.inf,
        surfaces_only: bool = False,
        threads: int = 0,
        progress: Any = None,
    ) -> np.ndarray:
        """Whether each ray has any crossing: (...) bool. Takes and raises what `closest` does."""
        shape, ask = _ask(o, d, t_min, t_max, threads, progress, surfaces_only)
        return self._native.any(ask).reshape(shape)

    def count(
        self,
        o: ArrayLike,
        d: ArrayLike | None = None,
        *,
        t_min: float = 0.0,
        t_max: float = math.inf,
        surfaces_only: bool = False,
        threads: int = 0,
        progress: Any = None,
    ) -> np.ndarray:
        """The number of crossings of each ray: (...) int64. Takes and raises what `closest` does."""
        shape, ask = _ask(o, d, t_min, t_max, threads, progress, surfaces_only)
        return self._native.count(ask).reshape(shape)

    def crossings(
        self,
        o: ArrayLike,
        d: ArrayLike | None = None,
        *,
        t_min: float = 0.0,
        t_max: float = math.inf,
        surfaces_only: bool = False,
        threads: int = 0,
        progress: Any = None,
    ) -> Crossings:
        """Every crossing of each ray, in order: see `Crossings`. Takes and raises what `closest` does; also ValueError
        for more than 10^9 rows. With `surfaces_only` rows of kind start and end are left out, so that a ray that begins
        inside begins with an exit.

        >>> torus = Scene(Torus(R=2, r=0.5))
        >>> torus.crossings([-5, 0, 0], [1, 0, 0]).t.tolist()
        [2.5, 3.5, 6.5, 7.5]
        """
        _, ask = _ask(o, d, t_min, t_max, threads, progress, surfaces_only)
        return Crossings(*self._native.crossings(ask))

    def segments(
        self,
        o: ArrayLike,
        d: ArrayLike | None = None,
        *,
        overlaps: str = "error",
        t_min: float = 0.0,
        t_max: float = math.inf,
        surfaces_only: bool = False,
        threads: int = 0,
        progress: Any = None,
    ) -> Segments:
        """The stretches of each ray inside objects, with their materials and lengths: see `Segments`.

        Where objects overlap, the one of the higher priority owns the stretch. Of equal priority: with "error" that is a
        ValueError, which names both and the place; with "priority" the later one owns it, and an `OverlapWarning` tells
        how many there were; with "all" both keep it.
        The `path` of a segment is -1 where parts of several paths of the object join.
        Takes and raises what `closest` does; also ValueError where a mesh is not closed, and for `surfaces_only`, which is
        not for stretches inside.
        """
        _not_surfaces_only("segments", surfaces_only)
        _, ask = _ask(o, d, t_min, t_max, threads, progress)
        *columns, met = self._native.segments(ask, text(overlaps, "overlaps"))
        _warn(met, overlaps)
        return Segments(*columns)

    def thickness(
        self,
        o: ArrayLike,
        d: ArrayLike | None = None,
        *,
        by: str = "material",
        overlaps: str = "error",
        t_min: float = 0.0,
        t_max: float = math.inf,
        surfaces_only: bool = False,
        threads: int = 0,
        progress: Any = None,
    ) -> np.ndarray:
        """How far each ray goes through each material or object: (..., columns) float64, in world units.

        By "material" there is a column for each of `material_names`, and a last one for objects without a material; so
        the sum of a row is all that the ray passes inside objects. By "object" there is a column for each of
        `object_names`.

        It is the sum of `segments`, and takes and raises what that does; also ValueError for more than 10^9 numbers.

        >>> scene = Scene(Sphere(radius=1).named("ball", material="lead"), materials={"lead": {"mu": 1.2}})
        >>> scene.thickness([[-5, 0, 0], [-5, 0.6, 0]], [2, 0, 0]).round(12).tolist()
        [[2.0, 0.0], [1.6, 0.0]]
        >>> Scene(Sphere(radius=1)).thickness([-5, 0, 0], [2, 0, 0]).tolist()
        [2.0]
        """
        _not_surfaces_only("thickness", surfaces_only)
        shape, ask = _ask(o, d, t_min, t_max, threads, progress)
        lengths, met = self._native.thickness(
            ask, choice(by, "by", ("material", "object")), text(overlaps, "overlaps")
        )
        _warn(met, overlaps)
        return lengths.reshape(*shape, lengths.shape[1])

    def cost(
        self,
        o: ArrayLike,
        d: ArrayLike | None = None,
        *,
        t_min: float = 0.0,
        t_max: float = math.inf,
        surfaces_only: bool = False,
        threads: int = 0,
        progress: Any = None,
    ) -> Cost:
        """What finding the first crossing of each ray takes: see `Cost`. Takes and raises what `closest` does."""
        shape, ask = _ask(o, d, t_min, t_max, threads, progress, surfaces_only)
        return Cost(*(column.reshape(shape) for column in self._native.cost(ask).T))

    def contains(self, p: ArrayLike, *, threads: int = 0, progress: Any = None) -> np.ndarray:
        """Whether points of shape (..., 3) are inside of any object: (...) bool. No promise within rounding of a
        surface.

        Raises ValueError for a point with NaN or infinite numbers, by its row, and where a mesh is not closed.
        """
        where = points(p, "p")
        inside = self._native.contains(where.reshape(-1, 3), threads_of(threads), callback(progress))
        return inside.reshape(where.shape[:-1])

    def objects_at(self, p: ArrayLike, *, threads: int = 0, progress: Any = None) -> tuple[np.ndarray, np.ndarray]:
        """The objects that hold each of n points: `splits`, (n + 1,) int64, and `object`, (rows,) int32; those of point
        i are `object[splits[i] : splits[i + 1]]`, ascending. Takes and raises what `contains` does."""
        where = points(p, "p")
        return self._native.objects_containing(where.reshape(-1, 3), threads_of(threads), callback(progress))

    @property
    def units(self) -> str | None:
        """The unit of length: "nm", "um", "mm", "cm", "m", "km", "in" or "ft"; None for a scene without one."""
        return self._native.units()

    @property
    def object_names(self) -> list[str]:
        """The names of the objects, in the order of their numbers."""
        return self._native.object_names()

    @property
    def material_names(self) -> list[str]:
        """The names of the materials, in the order of their numbers."""
        return self._native.material_names()

    def surface_name(self, surface: int) -> str:
        """What a surface's number stands for, as in `cylinder#1.side`. IndexError for a number not in use."""
        return self._native.surface_name(number_of(surface, "surface", 2**32))

    def path_name(self, path: int) -> str:
        """What a path's number stands for, as in `world/arm[2]/bolt[0]`. IndexError for a number not in use."""
        return self._native.path_name(number_of(path, "path", 2**63))

    def path_transform(self, path: int) -> np.ndarray:
        """The matrix of a path, (3, 4) float64: world coordinates from those of what is placed there."""
        return np.array(self._native.path_transform(number_of(path, "path", 2**63))).reshape(3, 4)

    @property
    def path_count(self) -> int:
        """How many instance paths there are; they are numbered from 0."""
        return self._native.path_count()

    @property
    def bounds(self) -> np.ndarray:
        """The least and the greatest corner of a box around everything, (2, 3) float64; infinite where it has no end."""
        return np.array(self._native.bounds())

    @property
    def stats(self) -> dict[str, Any]:
        """Sizes: nodes, objects, leaves, virtual_leaves (every placement counted), memory_bytes, and the largest
        condition number of a matrix on the way to a solid."""
        return self._native.stats()


class OverlapWarning(UserWarning):
    """Objects of equal priority overlap, and the later one was taken to own what both fill."""


def _warn(met: int, overlaps: str) -> None:
    if met and overlaps == "priority":
        message = f"{met} overlap{'' if met == 1 else 's'} of objects of equal priority: the later one owns each"
        warnings.warn(message, OverlapWarning, stacklevel=3)


def _ask(
    o: Any, d: Any, t_min: float, t_max: float, threads: int, progress: Any, surfaces_only: bool = False
) -> tuple[tuple[int, ...], tuple[Any, ...]]:
    """A query in the terms of the core, and the shape of its answer."""
    shape, count, origins, directions = rays(o, d)
    span = number(t_min, "t_min"), number(t_max, "t_max"), bool(surfaces_only)
    return shape, (count, origins, directions, *span, threads_of(threads), callback(progress))


def _not_surfaces_only(query: str, surfaces_only: bool) -> None:
    if surfaces_only:
        raise ValueError(
            f"surfaces_only is not for {query}, which is about stretches inside, also where a ray begins or ends inside; "
            "it is for closest, any, count, crossings and cost"
        )


def threads_of(threads: int) -> int:
    """How many threads: 0 is one a core."""
    return whole(threads, "threads", 0, 1024)


def number_of(value: int, what: str, limit: int) -> int:
    """The number of one of the things that a scene counts from 0, of which the core knows fewer than the limit."""
    count = integer(value, what)
    if not 0 <= count < limit:
        raise IndexError(f"the scene has no such {what}: {count}")
    return count
