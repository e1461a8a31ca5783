"""The queries of a compiled scene: many rays at once, arrays in and arrays out; and the names of objects, surfaces and
paths."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _native
from .grid import Grid, fill
from .native_args import RayQuery
from .origin import Origin
from .progress import callback
from .rays import Rays, points, rays
from .results import Closest, Cost, Crossings, Segments
from .slices import Slice, slice_of
from .values import choice, integer, number, suggestion, text, threads_of


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
        fields: Iterable[str] | None = None,
        progress: Any = None,
    ) -> Closest:
        """The first crossing of each ray.

        Args:
            o: origins, (..., 3) in world coordinates; or, without `d`, rays of shape (..., 6): origin, direction.
            d: directions, (..., 3), of any length but zero; broadcast against `o`.
            t_min: only crossings from here on; a ray that is inside there has a crossing at `t_min` itself.
            t_max: only crossings up to here.
            surfaces_only: count only real surfaces: not the crossing at `t_min` of a ray that begins inside, nor that
                at `t_max` of a ray that ends inside. This is what a LiDAR in a room or a user of Embree means by a hit.
            threads: 0 for one per core. The bits are the same for any number.
            fields: the names of the columns that are needed, such as `["t", "normal"]`; None for all. The others are
                None in the result, and cost nothing. `t` is always there.
            progress: True, a callable of (done, total), or a bar with `update` such as tqdm's.

        Arrays of float64 in C order are read in place: other threads must not change them during the call.

        Returns:
            `Closest`, its arrays of the broadcast shape (...).

        Raises:
            ValueError: for shapes that do not match, and for a ray with NaN, infinite numbers or a zero direction: the
                error names its row, numbered in C order, before any work is done. Also for a ray that takes more than
                10^7 steps, or has more than 2^20 crossings where they are listed, as in groups nested many times. The
                attribute `row` of the error is the number of the row.
            TypeError: for values that are not real numbers.
            MemoryError: for results that do not fit into memory.
        """
        names = _fields_of(Closest, fields)
        given, query = _ray_query(o, d, t_min, t_max, threads, progress, surfaces_only, names)
        columns, shape = self._native.closest(query), given.shape
        if len(shape) != 1:
            vectors = (*shape, 3)
            columns = tuple(c if c is None else c.reshape(vectors if c.ndim == 2 else shape) for c in columns)
        return Closest._of(columns, Origin.of(self, given))

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
        """Whether each ray has any crossing: (...) bool. Arguments and errors are those of `closest`."""
        given, query = _ray_query(o, d, t_min, t_max, threads, progress, surfaces_only)
        return self._native.any(query).reshape(given.shape)

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
        """The number of crossings of each ray: (...) int64. Arguments and errors are those of `closest`."""
        given, query = _ray_query(o, d, t_min, t_max, threads, progress, surfaces_only)
        return self._native.count(query).reshape(given.shape)

    def crossings(
        self,
        o: ArrayLike,
        d: ArrayLike | None = None,
        *,
        t_min: float = 0.0,
        t_max: float = math.inf,
        surfaces_only: bool = False,
        threads: int = 0,
        fields: Iterable[str] | None = None,
        progress: Any = None,
    ) -> Crossings:
        """Every crossing of each ray, in order: see `Crossings`. Arguments and errors are those of `closest`; also
        ValueError for more than 10^9 rows. With `surfaces_only` rows of kind start and end are left out, so that the
        list of a ray that begins inside starts with an exit.

        >>> torus = Scene(Torus(R=2, r=0.5))
        >>> torus.crossings([-5, 0, 0], [1, 0, 0]).t.tolist()
        [2.5, 3.5, 6.5, 7.5]
        """
        names = _fields_of(Crossings, fields)
        given, query = _ray_query(o, d, t_min, t_max, threads, progress, surfaces_only, names)
        return Crossings._of(self._native.crossings(query), Origin.of(self, given))

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
        """The intervals of each ray inside objects, with their materials and lengths: see `Segments`.

        A segment ends where another body, or a copy of this one, begins to own the ray. The contents of an object own their
        part of it. Elsewhere, where objects overlap, the one of higher priority owns the segment. For equal priorities,
        "error" raises a ValueError that names both objects and the position; with "priority" the one that is placed later
        owns it, and an `OverlapWarning` reports the number of overlaps; with "all" every object keeps its whole segment,
        also around its contents; of contents of an object that clips that is what is inside it.
        Arguments and errors are those of `closest`; also ValueError for a mesh that is not closed, and for
        `surfaces_only`, which does not apply to segments.
        """
        _not_surfaces_only("segments", surfaces_only)
        given, query = _ray_query(o, d, t_min, t_max, threads, progress)
        *columns, overlap_count = self._native.segments(query, text(overlaps, "overlaps"))
        _warn(overlap_count, overlaps)
        return Segments._of(columns, Origin.of(self, given))

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
        """The length of each ray in each material or object: (..., columns) float64, in world units.

        By "material" there is a column for each of `material_names`, and a last one for objects without a material; so
        the sum of a row is the length of the ray inside objects. By "object" there is a column for each of
        `object_names`.

        It is the sum of `segments`, and has the arguments and errors of that; also ValueError for more than 10^9
        numbers. Mass per area is `scene.thickness(o, d)[..., :-1] @ density`, with the density of each material in the order of
        `material_names`; in g/cm^2 for lengths in cm and densities in g/cm^3.

        >>> scene = Scene(Sphere(radius=1).named("ball", material="lead"), materials={"lead": {"mu": 1.2}})
        >>> scene.thickness([[-5, 0, 0], [-5, 0.6, 0]], [2, 0, 0]).round(12).tolist()
        [[2.0, 0.0], [1.6, 0.0]]
        >>> Scene(Sphere(radius=1)).thickness([-5, 0, 0], [2, 0, 0]).tolist()
        [2.0]
        """
        _not_surfaces_only("thickness", surfaces_only)
        given, query = _ray_query(o, d, t_min, t_max, threads, progress)
        lengths, overlap_count = self._native.thickness(
            query, choice(by, "by", ("material", "object")), text(overlaps, "overlaps")
        )
        _warn(overlap_count, overlaps)
        return lengths.reshape(*given.shape, lengths.shape[1])

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
        """The work of finding the first crossing of each ray: see `Cost`. Arguments and errors are those of
        `closest`."""
        given, query = _ray_query(o, d, t_min, t_max, threads, progress, surfaces_only)
        columns = (column.reshape(given.shape) for column in self._native.cost(query).T)
        return Cost._of(columns, Origin.of(self, given))

    def contains(self, p: ArrayLike, *, threads: int = 0, progress: Any = None) -> np.ndarray:
        """Whether points of shape (..., 3) are inside any object: (...) bool. What is outside an object that contains it and
        clips does not count. The result is not defined within rounding
        error of a surface.

        Raises ValueError for a point with NaN or infinite numbers, which names its row, and for a mesh that is not
        closed.
        """
        positions = points(p, "p")
        inside = self._native.contains(positions.reshape(-1, 3), threads_of(threads), callback(progress))
        return inside.reshape(positions.shape[:-1])

    def objects_at(self, p: ArrayLike, *, threads: int = 0, progress: Any = None) -> tuple[np.ndarray, np.ndarray]:
        """The objects that contain each of n points: `splits`, (n + 1,) int64, and `object`, (rows,) int32; those of
        point i are `object[splits[i] : splits[i + 1]]`, ascending. Arguments and errors are those of `contains`."""
        positions = points(p, "p")
        return self._native.objects_containing(positions.reshape(-1, 3), threads_of(threads), callback(progress))

    def voxels(
        self,
        bounds: ArrayLike,
        shape: tuple[int, int, int],
        *,
        by: str = "object",
        overlaps: str = "error",
        threads: int = 0,
    ) -> np.ndarray:
        """What owns the centre of each cell of a grid: an int32 array of this shape, [x, y, z]; -1 outside of all objects.

        Rays along the rows of the grid find the boundaries exactly. The result is not defined within rounding error of a
        surface.

        Args:
            bounds: the least and the greatest corner of the grid, (2, 3), in world coordinates, such as `scene.bounds`.
            shape: the numbers of cells along x, y and z, 2^31 cells at most.
            by: "object" or "material"; -1 is also for objects without a material.
            overlaps: "error" or "priority", as in `segments`.
            threads: as in `closest`.

        Raises:
            ValueError: for bounds without a volume or not finite, and as in `segments`.

        >>> scene = Scene(Box(min=(0, 0, 0), max=(2, 1, 1)))
        >>> scene.voxels([[-1, 0, 0], [3, 1, 1]], (4, 1, 1))[:, 0, 0].tolist()
        [-1, 0, 0, -1]
        """
        grid = Grid(bounds, shape)
        column, policy = (
            choice(by, "by", ("object", "material")),
            choice(overlaps, "overlaps", ("error", "priority")),
        )
        owners = np.full((math.prod(grid.shape) // grid.length, grid.length), -1, np.int32)
        overlap_count = 0
        for rows, origins, direction in grid.rows():
            _, query = _ray_query(origins, direction, 0.5, grid.length + 0.5, threads, None)
            *columns, found = self._native.segments(query, policy)
            overlap_count += found
            segments = Segments(*columns)
            fill(owners[rows], segments.ray_ids, segments.t_in, segments.t_out, segments[column])
        _warn(overlap_count, policy)
        return grid.array(owners)

    def slice(
        self,
        plane: str | Sequence[float] = "z=0",
        *,
        size: tuple[int, int] | None = None,
        area: ArrayLike | None = None,
        by: str = "object",
        threads: int = 0,
        progress: Any = None,
    ) -> Slice:
        """What owns each pixel of a plane: see `Slice`. Nothing is hidden: what encloses everything is shown too.

        Rays along the rows of pixels find the boundaries exactly. They are beside the plane by rounding, on the side that
        the `clip` of `render` keeps, so that a face in the plane is no obstacle. The result is not defined within rounding
        error of a surface.

        Args:
            plane: "x=1", "y=-2", "z=0", or (nx, ny, nz, d) for the points with nx x + ny y + nz z = d. The axes are x and
                y for z=0, y and z for x=1, x and z for y=-2; in other planes the axis upwards is nearest to z, or to y
                if the normal is mostly along z.
            size: columns and rows; None for 800 on the longer side, and square pixels.
            area: the lower left and the upper right corner along the axes, (u0, v0, u1, v1); None for what is around the
                bounded objects in the plane.
            by: "object", "material" or "instance": what the `regions` of the slice are.
            threads, progress: as in `closest`; progress is in rows.

        Raises ValueError for text that is no plane, an area without extent, a size out of range, a mesh that is not
        closed, and a scene with nothing of finite size if there is no area.

        >>> scene = Scene(Box(min=(0, 0, 0), max=(2, 1, 1)))
        >>> scene.slice("z=0.5", size=(4, 1), area=(-1, 0, 3, 1)).object.tolist()
        [[-1, 0, 0, -1]]
        """
        return slice_of(self._native, plane, size, area, by, threads_of(threads), callback(progress))

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
        """The name of a surface, as in `cylinder#1.side`. IndexError for a number not in use."""
        return self._native.surface_name(number_of(surface, "surface", 2**32))

    def path_name(self, path: int) -> str:
        """The name of a path, as in `world/arm[2]/bolt[0]`. IndexError for a number not in use."""
        return self._native.path_name(number_of(path, "path", 2**63))

    def path_transform(self, path: int) -> np.ndarray:
        """The matrix of a path, (3, 4) float64: world coordinates from the local coordinates of the instance."""
        return np.array(self._native.path_transform(number_of(path, "path", 2**63))).reshape(3, 4)

    @property
    def path_count(self) -> int:
        """The number of instance paths; they are numbered from 0."""
        return self._native.path_count()

    @property
    def bounds(self) -> np.ndarray:
        """The least and the greatest corner of a box around everything, (2, 3) float64; infinite where the scene is
        unbounded."""
        return np.array(self._native.bounds())

    @property
    def stats(self) -> dict[str, Any]:
        """Sizes: nodes, objects, leaves, virtual_leaves (every instance counted), memory_bytes; and condition, the
        largest condition number of a matrix from the world to a solid."""
        return self._native.stats()


class OverlapWarning(UserWarning):
    """Objects of equal priority overlap; the later one was chosen to own the overlap."""


def _warn(count: int, overlaps: str) -> None:
    if count and overlaps == "priority":
        message = f"{count} overlap{'' if count == 1 else 's'} of objects of equal priority: the one placed later owns each"
        warnings.warn(message, OverlapWarning, stacklevel=3)


def _ray_query(
    o: Any,
    d: Any,
    t_min: float,
    t_max: float,
    threads: int,
    progress: Any,
    surfaces_only: bool = False,
    fields: list[str] | None = None,
) -> tuple[Rays, RayQuery]:
    """The rays, and the query in the form that the native half takes."""
    given = rays(o, d)
    span = number(t_min, "t_min"), number(t_max, "t_max"), bool(surfaces_only)
    return given, RayQuery(
        given.ray_count, given.origins, given.directions, *span, threads_of(threads), callback(progress), fields
    )


def _fields_of(result: type[Closest] | type[Crossings], fields: Iterable[str] | None) -> list[str] | None:
    """The names of the columns that are needed; None for all."""
    if fields is None:
        return None
    if isinstance(fields, str):
        raise TypeError(f"fields must be a list of names, such as [{fields!r}], not a string")
    names = list(fields)
    for name in names:
        if name not in result._fields:
            raise ValueError(f"{name!r} is not a field; {suggestion(str(name), result._fields, 'the fields are')}")
    return names


def _not_surfaces_only(query: str, surfaces_only: bool) -> None:
    if surfaces_only:
        raise ValueError(
            f"surfaces_only is not for {query}, which lists intervals inside objects, also where a ray begins or ends inside; "
            "it is for closest, any, count, crossings and cost"
        )


def number_of(value: int, what: str, limit: int) -> int:
    """A checked number of a surface, path or object, from 0 to below `limit`; the native half checks the exact
    range."""
    count = integer(value, what)
    if not 0 <= count < limit:
        raise IndexError(f"the scene has no such {what}: {count}")
    return count
