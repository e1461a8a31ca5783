"""The base of results with one row for each ray or object."""

from __future__ import annotations

from typing import Any

import numpy as np

from .columns import Columns, chosen_rows, one_row


class PerRow(Columns):
    """Columns with a row for each ray or object; the first has their shape."""

    _what = "rays"

    def _shape(self) -> tuple[int, ...]:
        return tuple(next(iter(self)).shape)

    def __len__(self) -> int:
        return int(next(iter(self)).size)

    def _row_columns(self) -> dict[str, np.ndarray]:
        lead, count = len(self._shape()), len(self)
        return {name: column.reshape(count, *column.shape[lead:]) for name, column in self.to_dict().items()}

    def _selected(self, key: Any) -> Any:
        return self._chosen(chosen_rows(key, self._shape(), self._what))

    def _chosen(self, rows: np.ndarray) -> Any:
        flat = self._row_columns()
        columns = (flat[name][rows] if name in flat else None for name in self._fields)
        # A row of a column may be a number; columns are arrays.
        arrays = (None if column is None else np.asarray(column) for column in columns)
        return type(self)._of(arrays, self._origin and self._origin.select(rows))


class PerRay(PerRow):
    """Columns with a row for each ray."""

    def ray(self, number: int | tuple[int, ...]) -> Any:
        """The row of one ray, as an answer of the same kind whose arrays have the shape (): by its number in C order, or
        by its indices along the axes of the rays. Raises IndexError for a ray that does not exist."""
        return self._chosen(one_row(number, self._shape(), self._what))
