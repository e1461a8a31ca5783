"""The base of results in which any number of rows belong to each ray."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from .columns import Columns, chosen_rows, one_row
from .exports import ragged_records
from .rays import distances_to, points_at
from .values import floats

_Kind = TypeVar("_Kind", bound=Columns)

# What stands in a column for a ray that has no row, as in `closest` for a miss.
_ABSENT: dict[str, Any] = {"t": np.inf, "t_in": np.inf, "t_out": np.inf, "entering": False}
_ABSENT |= dict.fromkeys(("normal", "length", "t_err"), np.nan)
_ABSENT |= dict.fromkeys(("object", "material", "surface", "primitive", "path"), -1)


class Ragged(Columns):
    """Rows grouped by ray."""

    ray_splits: np.ndarray

    @property
    def ray_ids(self) -> np.ndarray:
        """The ray of each row, (rows,) int64."""
        splits = self.ray_splits
        return np.repeat(np.arange(len(splits) - 1), np.diff(splits))

    def __len__(self) -> int:
        return int(self.ray_splits[-1])

    def ray(self, number: int | tuple[int, ...]) -> Any:
        """The rows of one ray, as an answer of the same kind for one ray: by its number in C order, or by its indices along
        the axes of the rays. Raises IndexError for a ray that does not exist."""
        return self._chosen(one_row(number, self._shape(), "rays"))

    def sum(self, values: str | ArrayLike) -> np.ndarray:
        """The sum over the rows of each ray, float64 of the rays' shape (...); 0 for a ray without rows.

        Args:
            values: the name of a column, or an array with a number for each row, (rows,), or with several, (rows, k), for a
                result of shape (..., k). The rows are added in their order.

        Raises ValueError for another number of rows, KeyError for the name of no column.

        >>> scene = Scene(Sphere(radius=1).named("ball", material="lead"), materials={"lead": {"density": 11.3}})
        >>> segments = scene.segments([[-3, 0, 0], [-3, 5, 0]], [1, 0, 0])
        >>> segments.sum("length").tolist()
        [2.0, 0.0]
        >>> segments.sum(segments.length * np.array([11.3])[segments.material]).tolist()
        [22.6, 0.0]
        """
        return _sums(self._column(values) if isinstance(values, str) else values, self.ray_ids, self._shape())

    def _row_per_ray(self, kind: type[_Kind], rows: np.ndarray) -> _Kind:
        """These rows, one of each ray, as an answer of this kind."""
        given = self.to_dict()
        columns = (
            _picked(name, given[name], rows, self._shape()) if name in given else None for name in kind._fields
        )
        return kind._of(columns, self._origin)

    def to_awkward(self) -> Any:
        """An `awkward.Array` that has for each ray a list of records, with the columns as fields.

        Raises ImportError without awkward.
        """
        return ragged_records(self._row_columns(), self.ray_splits)

    def to_pandas(self) -> Any:
        """A `pandas.DataFrame` with a row for each row, and in the column `ray` its ray. Vectors become columns such as
        `normal_x`. Numbers of objects, materials, surfaces and paths become their names, as categories, and are missing
        where there is none.

        Raises ImportError without pandas.
        """
        frame = super().to_pandas()
        frame.insert(0, "ray", self.ray_ids)
        return frame

    def _shape(self) -> tuple[int, ...]:
        return (len(self.ray_splits) - 1,) if self._origin is None else self._origin.shape

    def _row_columns(self) -> dict[str, np.ndarray]:
        return {name: column for name, column in self.to_dict().items() if name != "ray_splits"}

    def _selected(self, key: Any) -> Any:
        return self._chosen(chosen_rows(key, self._shape(), "rays"))

    def _chosen(self, rays: np.ndarray) -> Any:
        flat, splits = rays.reshape(-1), self.ray_splits
        counts = np.diff(splits)[flat]
        chosen = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
        rows = np.repeat(splits[flat] - chosen[:-1], counts) + np.arange(chosen[-1])
        columns = (None if column is None else column[rows] for column in list(self)[1:])
        return type(self)._of((chosen, *columns), self._origin and self._origin.select(rays))

    def _along_rays(self, t: np.ndarray) -> np.ndarray:
        return points_at(*self._ray_vectors(self.ray_ids), t)

    def _distances(self, t: np.ndarray) -> np.ndarray:
        _, directions = self._ray_vectors(self.ray_ids)
        return distances_to(t, directions)

    def _texts(self) -> dict[str, Callable[[int], str]]:
        splits = self.ray_splits
        ray: dict[str, Callable[[int], str]] = {
            "ray": lambda row: str(int(np.searchsorted(splits, row, side="right")) - 1)
        }
        return ray | super()._texts()


def first_rows(splits: np.ndarray) -> np.ndarray:
    """The first row of each ray; -1 for a ray that has none."""
    return np.where(np.diff(splits) > 0, splits[:-1], -1)


def last_rows(splits: np.ndarray) -> np.ndarray:
    """The last row of each ray; -1 for a ray that has none."""
    return np.where(np.diff(splits) > 0, splits[1:] - 1, -1)


def _picked(name: str, column: np.ndarray, rows: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """These rows of the column of this name, as an array of the shape of the rays; -1 stands for a ray without a row."""
    found = np.full((len(rows), *column.shape[1:]), _ABSENT[name], column.dtype)
    present = rows >= 0
    found[present] = column[rows[present]]
    return found.reshape((*shape, *column.shape[1:]))


def _sums(values: Any, ray_ids: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """The sum of the values of each ray's rows, added in their order. Raises ValueError for another number of values."""
    array = floats(values, "values", "the name of a column, or a number for each row")
    if array.ndim == 0 or len(array) != len(ray_ids):
        raise ValueError(f"values has a number for each of the {len(ray_ids)} rows, not shape {array.shape}")
    total = np.zeros((int(np.prod(shape, dtype=np.int64)), *array.shape[1:]))
    np.add.at(total, ray_ids, array)
    return total.reshape((*shape, *array.shape[1:]))
