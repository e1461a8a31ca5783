"""The base of the results of queries: columns of equal length that are read by name."""

from __future__ import annotations

import operator
import os
from collections.abc import Callable, Iterator
from typing import Any, ClassVar, TypeVar

import numpy as np

from .exports import NAMED, data_frame, write_npz
from .origin import NameSource, Origin, names_of
from .tables import as_html, as_text, cell, cells

_Self = TypeVar("_Self", bound="Columns")


class Columns:
    """Columns of one length, some with aliases; a base of frozen dataclasses whose fields are the columns.

    Iteration, and so unpacking, gives the columns; `len` is the number of rows.
    """

    _fields: ClassVar[tuple[str, ...]] = ()
    _aliases: ClassVar[dict[str, str]] = {}
    # What the answer comes from; None for columns that were put together by hand.
    _origin: ClassVar[Origin | None] = None

    def __init_subclass__(cls) -> None:
        # A class without columns of its own has those of its base.
        cls._fields = tuple(name for name in cls.__annotations__ if not name.startswith("_")) or cls._fields

    @classmethod
    def _of(cls: type[_Self], columns: Any, origin: Origin | None) -> _Self:
        """The answer that has these columns, in the order of its fields."""
        made = object.__new__(cls)
        # As `cls(*columns)`, which would set each field by a call of its own: too slow for calls with few rays.
        made.__dict__.update(zip(cls._fields, columns, strict=True), _origin=origin)
        return made

    def to_dict(self) -> dict[str, np.ndarray]:
        """The arrays by name; they are not copied. Columns that were not asked for are left out."""
        named = zip(self._fields, self, strict=True)
        return {name: column for name, column in named if column is not None}

    def __iter__(self) -> Iterator[Any]:
        return (getattr(self, name) for name in self._fields)

    # Else Python would count back from `len`, as in a sequence of rows.
    __reversed__ = None

    def __contains__(self, name: object) -> bool:
        """Whether there is a column of this name."""
        return name in self.to_dict() or name in self._aliases

    def __len__(self) -> int:
        raise NotImplementedError

    def __getitem__(self, key: Any) -> Any:
        """A column by name, including Open3D's names: `hits["t_hit"]`; or the rows of some rays, as an answer of the
        same kind: `hits[3]`, `hits[10:20]`, `hits[mask]`, `hits[[4, 2]]`."""
        return self._column(key) if isinstance(key, str) else self._selected(key)

    def _column(self, key: str) -> Any:
        name = self._aliases.get(key, key)
        if name not in self._fields and name not in self._aliases:
            raise KeyError(f"{key!r}; the names are {', '.join([*self._fields, *self._aliases])}")
        column = getattr(self, name)
        if column is None:
            raise KeyError(f"{key!r}; this column was not among the fields that were asked for")
        return column

    def _selected(self, key: Any) -> Any:
        raise NotImplementedError

    # --- names

    def _source(self) -> NameSource:
        if self._origin is None:
            raise ValueError("these columns were put together by hand, so their names and rays are not known")
        return self._origin.names

    def _named(self, kind: str) -> np.ndarray:
        return names_of(self._source(), kind, self._column(kind))

    def _ray_vectors(self, numbers: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
        """The origins and directions of rays; of all of the answer for None."""
        self._source()
        assert self._origin is not None
        return self._origin.vectors(numbers)

    # --- other forms

    def _row_columns(self) -> dict[str, np.ndarray]:
        """The columns with one axis of rows."""
        raise NotImplementedError

    def to_pandas(self) -> Any:
        """A `pandas.DataFrame` with a row for each row. Vectors become columns such as `normal_x`. Numbers of objects,
        materials, surfaces and paths become their names, as categories, and are missing where there is none.

        Raises ImportError without pandas.
        """
        return data_frame(self._row_columns(), None if self._origin is None else self._origin.names)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write an .npz file, as `shotline cast` does: the columns by name, `object_names` and `material_names`, and
        paths as indices into `path_names`, the names of those that occur. It appears complete or not at all.

        Raises ValueError for another extension, OSError if the file cannot be written.
        """
        write_npz(path, self.to_dict(), None if self._origin is None else self._origin.names)

    # --- as text

    def _heading(self) -> str:
        raise NotImplementedError

    def _texts(self) -> dict[str, Callable[[int], str]]:
        """The text of each row of each column."""
        return {name: self._text_of(name, column) for name, column in self._row_columns().items()}

    def _text_of(self, name: str, column: np.ndarray) -> Callable[[int], str]:
        if name in NAMED and self._origin is not None:
            source = self._origin.names
            return lambda row: cell(names_of(source, name, column[row : row + 1])[0] or "-")
        if column.dtype.kind == "i":
            return lambda row: "-" if column[row] < 0 else cell(column[row])
        return lambda row: cell(column[row])

    def __repr__(self) -> str:
        return as_text(self._heading(), cells(len(self), self._texts()))

    def _repr_html_(self) -> str:
        return as_html(self._heading(), cells(len(self), self._texts()))

    # --- pickling

    def __reduce__(self) -> Any:
        """Without the scene: names that occur are kept, and the rays."""
        origin = self._origin and self._origin.without_scene(self.to_dict())
        return _unpickled, (type(self), tuple(self), origin)


def _unpickled(kind: type[Columns], columns: tuple[Any, ...], origin: Origin | None) -> Columns:
    return kind._of(columns, origin)


def chosen_rows(key: Any, shape: tuple[int, ...], what: str) -> np.ndarray:
    """The numbers of rows that an index chooses: an integer, a slice, a mask or a list of numbers in C order, or a tuple
    of these along the axes of `shape`. An array of the shape of the selection; raises IndexError."""
    numbers = np.arange(int(np.prod(shape, dtype=np.int64)))
    if isinstance(key, tuple):
        return np.asarray(numbers.reshape(shape)[key])
    if not isinstance(key, slice):
        key = np.asarray(key)
        key = key.astype(np.intp) if key.size == 0 and key.dtype.kind == "f" else key
        if key.dtype.kind not in "iub":
            raise TypeError(f"{what} are chosen by numbers, slices and masks, columns by names; not by {key.dtype}")
        if key.dtype.kind == "b" and key.shape not in (shape, numbers.shape):
            raise IndexError(f"the mask has shape {key.shape}, but the {what} have shape {shape}")
        key = key.reshape(-1) if key.dtype.kind == "b" else key
    try:
        return np.asarray(numbers[key])
    except IndexError:
        raise IndexError(f"there are {len(numbers)} {what}, numbered from 0: there is no {key}") from None


def one_row(number: Any, shape: tuple[int, ...], what: str) -> np.ndarray:
    """The number of one row, as an array of shape ()."""
    if not isinstance(number, tuple):
        return chosen_rows(operator.index(number), shape, what)
    row = chosen_rows(number, shape, what)
    if row.ndim:
        raise TypeError(f"{number} is not one of the {what}")
    return row
