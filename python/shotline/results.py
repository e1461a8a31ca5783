"""The results of queries: named tuples of arrays, which print as tables."""

from __future__ import annotations

from typing import Any, ClassVar, NamedTuple

import numpy as np

# The number of rows of a table that are shown at each end.
SHOWN = 5


class _Table(tuple[Any, ...]):
    """Columns of one length, some with aliases. A mixin for named tuples."""

    __slots__ = ()
    _aliases: ClassVar[dict[str, str]] = {}

    def _names(self) -> tuple[str, ...]:
        raise NotImplementedError

    def to_dict(self) -> dict[str, np.ndarray]:
        """The arrays by name; they are not copied. Columns that were not asked for are left out."""
        named = zip(self._names(), self, strict=True)
        return {name: column for name, column in named if column is not None}

    def __getitem__(self, key: Any) -> Any:
        """By position as in any tuple, or by name, including Open3D's names: `hits["t_hit"]`."""
        if not isinstance(key, str):
            return super().__getitem__(key)
        name = self._aliases.get(key, key)
        if name in self._names() or name in self._aliases:
            column = getattr(self, name)
            if column is None:
                raise KeyError(f"{key!r}; this column was not among the fields that were asked for")
            return column
        raise KeyError(f"{key!r}; the names are {', '.join([*self._names(), *self._aliases])}")

    def _rows(self) -> tuple[int, list[tuple[str, Any]]]:
        raise NotImplementedError

    def _heading(self) -> str:
        raise NotImplementedError

    def __repr__(self) -> str:
        count, columns = self._rows()
        rows = list(range(count)) if count <= 2 * SHOWN + 1 else [*range(SHOWN), *range(count - SHOWN, count)]
        table = [[name, *(_cell(column[row]) for row in rows)] for name, column in columns]
        table.insert(0, ["", *map(str, rows)])
        if len(rows) < count:
            for column in table:
                column.insert(1 + SHOWN, "...")
        widths = [max(map(len, column)) for column in table]
        lines = [
            "  ".join(cell.rjust(width) for cell, width in zip(line, widths, strict=True))
            for line in zip(*table, strict=True)
        ]
        return "\n".join([self._heading(), *lines])


def _counted(count: int, what: str) -> str:
    return f"{count} {what}{'' if count == 1 else 's'}"


def _cell(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return "(" + ", ".join(_cell(x) for x in value) + ")"
    # Adding zero turns -0 into 0.
    return f"{value + 0.0:.6g}" if isinstance(value, (float, np.floating)) else str(value)


class _ClosestFields(NamedTuple):
    t: np.ndarray
    normal: np.ndarray
    object: np.ndarray
    surface: np.ndarray
    primitive: np.ndarray
    path: np.ndarray
    entering: np.ndarray
    t_err: np.ndarray


class Closest(_Table, _ClosestFields):
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
    """

    __slots__ = ()
    _aliases: ClassVar[dict[str, str]] = {
        "t_hit": "t",
        "geometry_ids": "object",
        "primitive_ids": "primitive",
        "primitive_normals": "normal",
    }

    t_hit = property(lambda self: self.t)
    geometry_ids = property(lambda self: self.object)
    primitive_ids = property(lambda self: self.primitive)
    primitive_normals = property(lambda self: self.normal)

    def _rows(self) -> tuple[int, list[tuple[str, Any]]]:
        columns = [(n, c.reshape(-1, 3) if n == "normal" else c.reshape(-1)) for n, c in self.to_dict().items()]
        return self.t.size, columns

    def _names(self) -> tuple[str, ...]:
        return self._fields

    def _heading(self) -> str:
        return f"closest crossings of rays of shape {self.t.shape}: {int(np.isfinite(self.t).sum())} hit"


class _Ragged(_Table):
    """Rows grouped by ray."""

    __slots__ = ()
    ray_splits: np.ndarray

    @property
    def ray_ids(self) -> np.ndarray:
        """The ray of each row, (rows,) int64."""
        splits = self.ray_splits
        return np.repeat(np.arange(len(splits) - 1), np.diff(splits))

    def _rows(self) -> tuple[int, list[tuple[str, Any]]]:
        splits = self.ray_splits
        columns = [(n, c) for n, c in self.to_dict().items() if isinstance(c, np.ndarray) and n != "ray_splits"]
        return int(splits[-1]), [("ray", _RayOfRow(splits)), *columns]


class _RayOfRow:
    """The column of `ray_ids`, computed only for the rows that are read."""

    def __init__(self, splits: np.ndarray) -> None:
        self.splits = splits

    def __getitem__(self, row: int) -> int:
        return int(np.searchsorted(self.splits, row, side="right")) - 1


class _CrossingsFields(NamedTuple):
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


class Crossings(_Ragged, _CrossingsFields):
    """Every crossing of n rays, a row each, grouped by ray, ascending in t. For each path entering and exiting
    alternate; with `surfaces_only`, crossings of kind start and end are left out.

    ray_splits: (n + 1,) int64; the rows of ray i are `ray_splits[i]` to `ray_splits[i + 1]`. Rays of several axes are
        numbered in C order.
    t, normal, entering, object, surface, primitive, path, t_err: as in `Closest`, (rows,) and (rows, 3).
    kind: (rows,) int8; 0 a surface, 1 start (the ray begins inside, at t_min), 2 end (it ends inside, at t_max).

    Columns that were not among the `fields` asked for are None.

    Open3D's names are aliases: `t_hit`, `ray_ids`, `geometry_ids`, `primitive_ids`, `primitive_normals`.
    """

    __slots__ = ()
    _aliases = Closest._aliases | {"ray_ids": "ray_ids"}

    t_hit = property(lambda self: self.t)
    geometry_ids = property(lambda self: self.object)
    primitive_ids = property(lambda self: self.primitive)
    primitive_normals = property(lambda self: self.normal)

    def _names(self) -> tuple[str, ...]:
        return self._fields

    def _heading(self) -> str:
        return f"{_counted(len(self.t), 'crossing')} of {_counted(len(self.ray_splits) - 1, 'ray')}"


class _MeasuresFields(NamedTuple):
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


class Measures(_Table, _MeasuresFields):
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

    __slots__ = ()

    def _rows(self) -> tuple[int, list[tuple[str, Any]]]:
        shown = ("object", "volume", "volume_err", "mass", "mass_err", "centroid", "exact", "rays")
        return len(self.object), [(name, column) for name, column in self.to_dict().items() if name in shown]

    def _names(self) -> tuple[str, ...]:
        return self._fields

    def _heading(self) -> str:
        return f"measures of {_counted(len(self.object), 'object')}"


class _CostFields(NamedTuple):
    boxes: np.ndarray
    cells: np.ndarray
    planes: np.ndarray
    solids: np.ndarray
    tags: np.ndarray
    heap: np.ndarray
    all: np.ndarray


class Cost(_Table, _CostFields):
    """The work of finding the first crossing of each ray; all arrays have the rays' shape (...), int64.

    boxes: boxes tested.
    cells: cells visited.
    planes: splitting planes visited.
    solids: solids and triangles intersected.
    tags: intersections saved by tags.
    heap: entries pushed on heaps.
    all: boxes, cells, planes and solids together.
    """

    __slots__ = ()

    def _rows(self) -> tuple[int, list[tuple[str, Any]]]:
        return self.all.size, [(name, column.reshape(-1)) for name, column in self.to_dict().items()]

    def _names(self) -> tuple[str, ...]:
        return self._fields

    def _heading(self) -> str:
        mean = float(self.all.mean()) if self.all.size else 0.0
        return f"costs of rays of shape {self.all.shape}: {mean:.4g} in the mean"


class _SegmentsFields(NamedTuple):
    ray_splits: np.ndarray
    t_in: np.ndarray
    t_out: np.ndarray
    length: np.ndarray
    material: np.ndarray
    object: np.ndarray
    path: np.ndarray


class Segments(_Ragged, _SegmentsFields):
    """The intervals of n rays inside objects, a row each, grouped by ray.

    ray_splits: (n + 1,) int64; the rows of ray i are `ray_splits[i]` to `ray_splits[i + 1]`.
    t_in, t_out: (rows,) float64, in lengths of the direction.
    length: (rows,) float64, in world units.
    material: (rows,) int32, for `scene.material_names`; -1 for an object without one.
    object: (rows,) int32.
    path: (rows,) int64, the instance that owns the segment.
    """

    __slots__ = ()
    _aliases: ClassVar[dict[str, str]] = {"ray_ids": "ray_ids", "geometry_ids": "object"}

    geometry_ids = property(lambda self: self.object)

    def _names(self) -> tuple[str, ...]:
        return self._fields

    def _heading(self) -> str:
        return f"{_counted(len(self.t_in), 'segment')} of {_counted(len(self.ray_splits) - 1, 'ray')}"
