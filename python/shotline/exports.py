"""Answers as tables of other packages and as files."""

from __future__ import annotations

import os
import tempfile
from typing import Any

import numpy as np

from .origin import NameSource, names_of

# The columns of numbers that stand for names.
NAMED = ("object", "material", "surface", "path")


def data_frame(columns: dict[str, np.ndarray], names: NameSource | None) -> Any:
    """A pandas.DataFrame of columns of rows; vectors become a column for each component, numbers become names."""
    try:
        import pandas
    except ImportError as error:
        raise ImportError("to_pandas needs pandas: pip install pandas", name=error.name) from error
    frame: dict[str, Any] = {}
    for name, column in columns.items():
        if name in NAMED and names is not None:
            frame[name] = pandas.Categorical(names_of(names, name, column))
        elif column.ndim == 1:
            frame[name] = column
        else:
            parts = zip(_components(column.shape[1:]), column.reshape(len(column), -1).T, strict=True)
            frame |= {f"{name}_{part}": values for part, values in parts}
    return pandas.DataFrame(frame)


def _components(shape: tuple[int, ...]) -> list[str]:
    """The names of the components of a vector, a matrix or a box."""
    ends = {2: ["min_", "max_"], 3: ["x", "y", "z"]}
    names = [""]
    for size in shape:
        names = [name + end for name in names for end in ends[size]]
    return names


def ragged_records(columns: dict[str, np.ndarray], splits: np.ndarray) -> Any:
    """An awkward.Array with a list of records for each ray."""
    try:
        import awkward
    except ImportError as error:
        raise ImportError("to_awkward needs awkward: pip install awkward", name=error.name) from error
    return awkward.unflatten(awkward.zip(columns, depth_limit=1), np.diff(splits))


def write_npz(path: str | os.PathLike[str], columns: dict[str, np.ndarray], names: NameSource | None) -> None:
    """Write columns as the command `shotline cast` does: with the names of objects and materials, and with paths as
    indices into the names of those that occur. The file appears complete or not at all."""
    path = os.fspath(path)
    if not path.lower().endswith(".npz"):
        raise ValueError(f"answers are saved as .npz, not as {path}")
    arrays = dict(columns)
    if names is not None:
        arrays |= {"object_names": _texts(names.object_names), "material_names": _texts(names.material_names)}
        if "path" in columns:
            paths = columns["path"]
            distinct = np.unique(paths[paths >= 0])
            arrays["path"] = np.where(paths >= 0, np.searchsorted(distinct, paths), -1).astype(np.int64)
            arrays["path_names"] = _texts(names_of(names, "path", distinct).tolist())
    descriptor, unfinished = tempfile.mkstemp(suffix=".npz", dir=os.path.dirname(path) or ".")
    try:
        with os.fdopen(descriptor, "wb") as file:
            np.savez(file, **arrays)  # type: ignore[arg-type]
        os.chmod(unfinished, 0o666 & ~_mask())
        os.replace(unfinished, path)
    except BaseException:
        os.unlink(unfinished)
        raise


def _mask() -> int:
    """The permissions that new files of this process do not get."""
    mask = os.umask(0o022)
    os.umask(mask)
    return mask


def _texts(names: list[str]) -> np.ndarray:
    return np.array(names, dtype=str)
