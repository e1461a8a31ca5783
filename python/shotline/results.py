"""The results of queries: columns that are read by name, with the points, names and other forms of their rows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from .derivatives import Derivatives
from .on_triangles import OnTriangles
from .per_row import PerRay, PerRow
from .ragged import Ragged, first_rows, last_rows
from .rays import distances_to, lengths, points_at
from .tables import counted

_OPEN3D = {
    "t_hit": "t",
    "geometry_ids": "object",
    "primitive_ids": "primitive",
    "primitive_normals": "normal",
}


def _alias(name: str) -> property:
    return property(lambda self: getattr(self, name), doc=f"Another name of `{name}`.")


class _Hits(Derivatives, OnTriangles):
    """Columns about crossings with surfaces."""

    t_hit = _alias("t")
    geometry_ids = _alias("object")
    primitive_ids = _alias("primitive")
    primitive_normals = _alias("normal")

    @property
    def cosine(self) -> np.ndarray:
        """The cosine of the angle of incidence, float64 of the shape of `t`: 1 where the ray is perpendicular to the surface,
        0 where it is tangent, on either side of it. NaN where there is no normal. Needs the column normal.

        >>> float(Scene(Sphere(radius=1)).closest([-3, 0, 0.6], [2, 0, 0]).cosine.round(12))
        0.8
        """
        normals = self._column("normal")
        _, directions = self._ray_vectors(self._rows_of_rays())
        scaled, largest = lengths(directions)
        along = (normals.reshape(-1, 3) * (directions / largest[..., None])).sum(axis=-1) / scaled
        return np.asarray(np.minimum(np.abs(along), 1.0).reshape(normals.shape[:-1]))

    def object_names(self) -> np.ndarray:
        """The names of the objects, an array of str with the shape of `object`, with None where there is no object. Raises
        KeyError if the column was not asked for."""
        return self._named("object")

    def surface_names(self) -> np.ndarray:
        """The names of the surfaces, as in "cylinder#1.side": as `object_names`."""
        return self._named("surface")

    def path_names(self) -> np.ndarray:
        """The names of the instances, as in "world/arm[2]/bolt[0]": as `object_names`."""
        return self._named("path")


@dataclass(frozen=True, repr=False, eq=False)
class Closest(PerRay, _Hits):
    """The first crossing of each ray; all arrays have the rays' shape (...).

    t: (...) float64, in lengths of the direction; inf for a miss.
    normal: (..., 3) float64, of unit length, pointing out of the solid, in world coordinates; NaN for a miss and for a
        ray that begins inside, where there is no surface.
    object, surface: (...) int32, for `scene.object_names` and `scene.surface_name`; -1 for a miss.
    primitive: (...) int32, the triangle of a mesh; -1 for none.
    path: (...) int64, the instance, for `scene.path_name`; -1 for a miss.
    entering: (...) bool.
    t_err: (...) float64, a bound on the error of t; NaN for a miss.

    Columns that were not among the `fields` asked for are None.

    Open3D's names are aliases: `t_hit`, `geometry_ids`, `primitive_ids`, `primitive_normals`.

    Unpacking gives the columns, `len` is the number of rays. `hits[3]`, `hits[10:20]`, `hits[mask]` and `hits[[4, 2]]`
    are answers of the same kind, with the chosen rays; these are numbered in C order, and a mask may have their shape.
    `hits[2, 5]` is the ray of those indices. Pickles keep the columns, the rays and the names that occur, but not
    the scene.

    >>> hits = Scene(Sphere(radius=1).named("ball")).closest([[-3, 0, 0], [-3, 5, 0]], [2, 0, 0])
    >>> hits.points[0].tolist(), hits.distance.tolist(), hits.object_names().tolist()
    ([-1.0, 0.0, 0.0], [2.0, inf], ['ball', None])
    >>> hits[np.isfinite(hits.t)].normal.tolist()
    [[-1.0, 0.0, 0.0]]
    """

    t: np.ndarray
    normal: np.ndarray
    object: np.ndarray
    surface: np.ndarray
    primitive: np.ndarray
    path: np.ndarray
    entering: np.ndarray
    t_err: np.ndarray

    _aliases: ClassVar[dict[str, str]] = _OPEN3D
    _which = "closest"

    @property
    def points(self) -> np.ndarray:
        """The points that are hit, o + t d, (..., 3) float64 in world coordinates; NaN for a miss. Each use computes them
        from the arrays of rays that the query was given: do not change these."""
        origins, directions = self._ray_vectors(None)
        return points_at(origins, directions, self.t.reshape(-1)).reshape(*self.t.shape, 3)

    @property
    def distance(self) -> np.ndarray:
        """The distance from the origin of the ray, (...) float64 in the scene's units: t times the length of the
        direction; inf for a miss."""
        _, directions = self._ray_vectors(None)
        return distances_to(self.t.reshape(-1), directions).reshape(self.t.shape)

    def _texts(self) -> dict[str, Callable[[int], str]]:
        hit = np.isfinite(self.t).reshape(-1)

        def shown(name: str, text: Callable[[int], str]) -> Callable[[int], str]:
            miss = "miss" if name == "t" else ""
            return lambda row: text(row) if hit[row] else miss

        return {name: shown(name, text) for name, text in super()._texts().items()}

    def _heading(self) -> str:
        return f"{self._which} crossings of rays of shape {self.t.shape}: {int(np.isfinite(self.t).sum())} hit"


class _LastCrossings(Closest):
    """What `Crossings.last` returns."""

    _which = "last"


@dataclass(frozen=True, repr=False, eq=False)
class SegmentPerRay(PerRay):
    """One segment of each ray; all arrays have the rays' shape (...). It is what `Segments.first` and `last` return.

    t_in, t_out: (...) float64, in lengths of the direction; inf for a ray without a segment.
    length: (...) float64, in world units; NaN for a ray without a segment.
    material, object: (...) int32; -1 for a ray without a segment, and for an object without a material.
    path: (...) int64, the instance that owns the segment; -1 for a ray without one.

    Unpacking, `len` and the selection of rays are as in `Closest`.
    """

    t_in: np.ndarray
    t_out: np.ndarray
    length: np.ndarray
    material: np.ndarray
    object: np.ndarray
    path: np.ndarray

    def object_names(self) -> np.ndarray:
        """The names of the objects, (...) of str; None for a ray without a segment."""
        return self._named("object")

    def material_names(self) -> np.ndarray:
        """The names of the materials, (...) of str; None for an object without one."""
        return self._named("material")

    def path_names(self) -> np.ndarray:
        """The names of the instances, as in "world/arm[2]/bolt[0]": (...) of str."""
        return self._named("path")

    def _heading(self) -> str:
        return f"one segment of each ray, of shape {self.t_in.shape}: {int((self.path >= 0).sum())} have one"


@dataclass(frozen=True, repr=False, eq=False)
class Crossings(Ragged, _Hits):
    """Every crossing of n rays, a row each, grouped by ray, ascending in t. For each path entering and exiting
    alternate; with `surfaces_only`, crossings of kind start and end are left out.

    ray_splits: (n + 1,) int64; the rows of ray i are `ray_splits[i]` to `ray_splits[i + 1]`. Rays of several axes are
        numbered in C order.
    t, normal, entering, object, surface, primitive, path, t_err: as in `Closest`, (rows,) and (rows, 3).
    kind: (rows,) int8; 0 a surface, 1 start (the ray begins inside, at t_min), 2 end (it ends inside, at t_max).

    Columns that were not among the `fields` asked for are None.

    Open3D's names are aliases: `t_hit`, `ray_ids`, `geometry_ids`, `primitive_ids`, `primitive_normals`.

    Unpacking gives the columns, `len` is the number of rows. `hits[3]`, `hits[10:20]`, `hits[mask]` and `hits[[4, 2]]`
    are answers of the same kind, with all rows of the chosen rays, as in `Closest`.

    >>> hits = Scene(Sphere(radius=1).named("ball")).crossings([[-3, 0, 0], [-3, 5, 0]], [1, 0, 0])
    >>> hits.ray(0).points.tolist(), len(hits[1:])
    ([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]], 0)
    """

    ray_splits: np.ndarray
    t: np.ndarray
    normal: np.ndarray
    entering: np.ndarray
    object: np.ndarray
    surface: np.ndarray
    primitive: np.ndarray
    path: np.ndarray
    kind: np.ndarray
    t_err: np.ndarray

    _aliases: ClassVar[dict[str, str]] = _OPEN3D | {"ray_ids": "ray_ids"}

    @property
    def points(self) -> np.ndarray:
        """The points of the crossings, o + t d, (rows, 3) float64 in world coordinates; NaN where t is infinite. Each
        use computes them from the arrays of rays that the query was given: do not change these."""
        return self._along_rays(self.t)

    @property
    def distance(self) -> np.ndarray:
        """The distance from the origin of the ray, (rows,) float64 in the scene's units: t times the length of the
        direction."""
        return self._distances(self.t)

    def first(self) -> Closest:
        """The first crossing of each ray, what `closest` returns for the same rays: arrays of the rays' shape (...), with the
        values of a miss for a ray without crossings.

        >>> hits = Scene(Sphere(radius=1)).crossings([[-3, 0, 0], [-3, 5, 0]], [1, 0, 0])
        >>> hits.first().t.tolist(), hits.last().t.tolist()
        ([2.0, inf], [4.0, inf])
        """
        return self._row_per_ray(Closest, first_rows(self.ray_splits))

    def last(self) -> Closest:
        """The last crossing of each ray, in the form of `first`."""
        return self._row_per_ray(_LastCrossings, last_rows(self.ray_splits))

    def _rows_of_rays(self) -> np.ndarray:
        return self.ray_ids

    def _heading(self) -> str:
        return f"{counted(len(self), 'crossing')} of {counted(len(self.ray_splits) - 1, 'ray')}"


@dataclass(frozen=True, repr=False, eq=False)
class Segments(Ragged):
    """The intervals of n rays inside objects, a row each, grouped by ray.

    ray_splits: (n + 1,) int64; the rows of ray i are `ray_splits[i]` to `ray_splits[i + 1]`.
    t_in, t_out: (rows,) float64, in lengths of the direction.
    length: (rows,) float64, in world units.
    material: (rows,) int32, for `scene.material_names`; -1 for an object without one.
    object: (rows,) int32.
    path: (rows,) int64, the instance that owns the segment.

    `geometry_ids` is an alias of `object`. Unpacking, `len` and the selection of rays are as in `Crossings`.
    """

    ray_splits: np.ndarray
    t_in: np.ndarray
    t_out: np.ndarray
    length: np.ndarray
    material: np.ndarray
    object: np.ndarray
    path: np.ndarray

    _aliases: ClassVar[dict[str, str]] = {"ray_ids": "ray_ids", "geometry_ids": "object"}
    geometry_ids = _alias("object")

    @property
    def points(self) -> np.ndarray:
        """Where each segment begins and ends, (rows, 2, 3) float64 in world coordinates; NaN where t is infinite. Each
        use computes them from the arrays of rays that the query was given: do not change these."""
        return np.stack([self._along_rays(t) for t in (self.t_in, self.t_out)], axis=1)

    @property
    def distance(self) -> np.ndarray:
        """The distances of its beginning and end from the origin of the ray, (rows, 2) float64 in the scene's units."""
        return np.stack([self._distances(t) for t in (self.t_in, self.t_out)], axis=1)

    def first(self) -> SegmentPerRay:
        """The first segment of each ray: arrays of the rays' shape (...). Its `length` is the thickness of the first wall, from
        where the ray enters, or begins inside, to where it exits; NaN for a ray without a segment.

        >>> tube = Scene(Cylinder(radius=2, z0=0, z1=9) - Cylinder(radius=1.5, z0=0, z1=9))
        >>> tube.segments([[-5, 0, 1], [-5, 0, 99]], [1, 0, 0]).first().length.tolist()
        [0.5, nan]
        """
        return self._row_per_ray(SegmentPerRay, first_rows(self.ray_splits))

    def last(self) -> SegmentPerRay:
        """The last segment of each ray, in the form of `first`."""
        return self._row_per_ray(SegmentPerRay, last_rows(self.ray_splits))

    def object_names(self) -> np.ndarray:
        """The names of the objects, (rows,) of str."""
        return self._named("object")

    def material_names(self) -> np.ndarray:
        """The names of the materials, (rows,) of str; None for an object without one."""
        return self._named("material")

    def path_names(self) -> np.ndarray:
        """The names of the instances, as in "world/arm[2]/bolt[0]": (rows,) of str."""
        return self._named("path")

    def _heading(self) -> str:
        return f"{counted(len(self), 'segment')} of {counted(len(self.ray_splits) - 1, 'ray')}"


@dataclass(frozen=True, repr=False, eq=False)
class Measures(PerRow):
    """Volume, mass, centroid and inertia of objects, a row each. Each `_err` is one standard error, and 0 where the
    value is exact except for rounding.

    object: (n,) int32. volume: (n,) float64, all instances together; in cubed scene units. NaN, as all other values,
        for an unbounded object.
    mass: (n,) float64, NaN without a density. In grams, by the density of the material in g/cm^3; in a scene without
        units it is the volume times the density, in the units of these.
    centroid: (n, 3) float64, world coordinates; NaN where there is no volume.
    inertia: (n, 3, 3) float64, about the centroid along the world's axes, for density 1; multiply by the density for
        the inertia of the mass.
    exact: (n,) bool. bounds: (n, 2, 3) float64, the corners of a box around the object. rays: (n,) int64, the rays
        cast.
    """

    object: np.ndarray
    volume: np.ndarray
    volume_err: np.ndarray
    mass: np.ndarray
    mass_err: np.ndarray
    centroid: np.ndarray
    centroid_err: np.ndarray
    inertia: np.ndarray
    inertia_err: np.ndarray
    exact: np.ndarray
    bounds: np.ndarray
    rays: np.ndarray

    _what = "objects"

    def object_names(self) -> np.ndarray:
        """The names of the objects, (n,) of str."""
        return self._named("object")

    def _texts(self) -> dict[str, Callable[[int], str]]:
        shown = ("object", "volume", "volume_err", "mass", "mass_err", "centroid", "exact", "rays")
        return {name: text for name, text in super()._texts().items() if name in shown}

    def _heading(self) -> str:
        return f"measures of {counted(len(self), 'object')}"


@dataclass(frozen=True, repr=False, eq=False)
class Cost(PerRay):
    """The work of finding the first crossing of each ray; all arrays have the rays' shape (...), int64.

    boxes: boxes tested.
    cells: cells visited.
    planes: splitting planes visited.
    solids: solids and triangles intersected.
    tags: intersections saved by tags.
    heap: entries pushed on heaps.
    all: boxes, cells, planes and solids together.
    """

    boxes: np.ndarray
    cells: np.ndarray
    planes: np.ndarray
    solids: np.ndarray
    tags: np.ndarray
    heap: np.ndarray
    all: np.ndarray

    def _heading(self) -> str:
        mean = float(self.all.mean()) if self.all.size else 0.0
        return f"costs of rays of shape {self.all.shape}: {mean:.4g} in the mean"
