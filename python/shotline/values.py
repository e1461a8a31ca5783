"""Checks numbers, names and choices given by users. Errors name the argument that is wrong."""

from __future__ import annotations

import difflib
import operator
from collections.abc import Sequence
from decimal import Decimal
from math import inf, isfinite
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

# The largest number that the native half accepts; the core has lower limits, which its errors state.
MAX_NATIVE = 2**32 - 1

# Integers up to here are float64.
_EXACT = 2**53

# Numbers of Python itself, of which `float` makes the number that NumPy makes.
_PLAIN = {float, int}


def floats(values: ArrayLike, what: str, wanted: str = "an array of real numbers") -> np.ndarray:
    """Real numbers as float64 in C order; not copied if they are that already. `wanted` describes, for errors, what the
    argument must be.

    Raises TypeError for anything other than real numbers, ValueError for rows of several lengths and for masked
    entries, which have no value.
    """
    if type(values) is np.ndarray and values.dtype == np.float64:
        flags = values.flags
        if flags.c_contiguous and flags.aligned:
            # What follows would take longer than to cast a few rays.
            return values
    refuse_masked(values, what)
    try:
        array = np.asarray(values)
    except ValueError:
        raise ValueError(f"{what} has rows of several lengths, so it is not an array of numbers") from None
    if array.dtype.kind == "O":
        array = _from_objects(array, what, wanted)
    if array.dtype.kind not in "fiub":
        found = "strings" if array.dtype.kind in "US" else str(array.dtype)
        raise _not_numbers(what, wanted, found, values, array.ndim)
    return np.require(array, np.float64, ["C", "A"])


def refuse_masked(values: Any, what: str) -> None:
    """Raises ValueError for masked entries. NumPy drops masks when it creates arrays, so masked values would count."""
    arrays = values if isinstance(values, (list, tuple)) else (values,)
    masked = sum(int(np.ma.getmaskarray(array).sum()) for array in arrays if isinstance(array, np.ma.MaskedArray))
    if masked:
        entries = f"{masked} entr{'y' if masked == 1 else 'ies'}"
        raise ValueError(f"{what} has {entries} masked, so without a value: fill them, or leave their rows out")


def numbers(values: ArrayLike, count: int, what: str) -> tuple[float, ...]:
    """`count` finite numbers. Raises ValueError or TypeError that names the argument, `what`."""
    if isinstance(values, tuple) and len(values) == count and _PLAIN.issuperset(map(type, values)):
        # Scenes have many short tuples, for which an array would take ten times as long.
        try:
            found = tuple(map(float, values))
        except OverflowError:
            found = (inf,)
        # The sum is not finite either where one of them is not; where only the sum overflows, what follows tells.
        if isfinite(sum(found)):
            return found
    array = floats(values, what, "a real number" if count == 1 else f"{count} real numbers").reshape(-1)
    if array.size != count:
        raise ValueError(f"{what} takes {count} number{'' if count == 1 else 's'}, not {array.size}")
    if not np.isfinite(array).all():
        wrong = array.tolist()
        raise ValueError(f"{what} is {wrong[0] if count == 1 else wrong}, but must be finite")
    return tuple(array.tolist())


def rows(values: ArrayLike, count: int, what: str) -> tuple[tuple[float, ...], ...]:
    """Any number of rows of `count` finite numbers. Raises ValueError or TypeError that names the argument, `what`."""
    array = floats(values, what, f"rows of {count} real numbers")
    if array.ndim != 2 or array.shape[1] != count:
        raise ValueError(f"{what} takes rows of {count} numbers, an array of shape (n, {count}), not {array.shape}")
    finite = np.isfinite(array).all(axis=1)
    if not finite.all():
        row = int(finite.argmin())
        raise ValueError(f"{what} row {row + 1} of {len(array)} is {array[row].tolist()}, but must be finite")
    return tuple(map(tuple, array.tolist()))


def three(values: tuple[Any, ...], what: str) -> tuple[float, ...]:
    """Three numbers, given separately or as one vector."""
    if len(values) == 3:
        x, y, z = values
        # Scenes have many of these.
        if type(x) is float and type(y) is float and type(z) is float and isfinite(x + y + z):
            return values
    return numbers(values[0] if len(values) == 1 else values, 3, what)


def affine(matrix: ArrayLike) -> tuple[float, ...]:
    """The 12 numbers of an affine map in row-major order."""
    array = floats(matrix, "the matrix")
    if array.shape == (4, 4):
        if array[3].tolist() != [0.0, 0.0, 0.0, 1.0]:
            raise ValueError(f"the last row of a 4x4 matrix must be [0, 0, 0, 1], not {array[3].tolist()}")
        array = array[:3]
    if array.shape not in [(3, 4), (12,)]:
        raise ValueError(f"a matrix has shape (3, 4), (4, 4) or (12,), not {array.shape}")
    return numbers(array, 12, "the matrix")


def number(value: Any, what: str) -> float:
    """One real number, which may be infinite. Raises TypeError for anything else."""
    if type(value) is float:
        return value
    if type(value) is int and -_EXACT <= value <= _EXACT:
        return float(value)
    array = floats(value, what, "a real number")
    if array.ndim:
        raise TypeError(f"{what} must be one number, not an array of shape {array.shape}")
    return float(array)


def bounded_integer(value: Any, what: str, least: int, most: int) -> int:
    """An integer from `least` to `most`. Raises TypeError for anything else, ValueError out of range."""
    count = integer(value, what)
    if not least <= count <= most:
        raise ValueError(f"{what} is {count}, but must be from {least} to {most}")
    return count


def integer(value: Any, what: str) -> int:
    """An integer of any size; a float with an integral value is accepted."""
    if isinstance(value, (float, np.floating)) and float(value).is_integer():
        return int(value)
    try:
        return operator.index(value)
    except TypeError:
        raise TypeError(f"{what} must be a whole number, not {value!r}") from None


def picture_size(size: Any) -> tuple[int, int]:
    """Width and height in pixels. Raises TypeError for anything but two whole numbers, ValueError out of range."""
    try:
        width, height = size
    except (TypeError, ValueError):
        raise TypeError(f"size is width and height in pixels, as in (800, 600), not {size!r}") from None
    return bounded_integer(width, "the width in size", 0, MAX_NATIVE), bounded_integer(
        height, "the height in size", 0, MAX_NATIVE
    )


def text(value: Any, what: str) -> str:
    """A string that can be encoded. Raises TypeError for anything else, ValueError for a lone surrogate."""
    if type(value) is str and value.isascii():
        return value
    if not isinstance(value, str):
        raise TypeError(f"{what} must be a string, not {type(value).__name__}")
    try:
        value.encode()
    except UnicodeEncodeError:
        raise ValueError(f"{what} is {value!r}, which holds half of a character (a lone surrogate)") from None
    return str(value)


def material_name(material: Any) -> str:
    """The checked name of a material."""
    if not isinstance(material, str):
        hint = 'as in material="steel", and the scene has materials={"steel": ...}'
        raise TypeError(f"material (the name of one) is a string, {hint}; not {type(material).__name__}")
    return text(material, "material (the name of one)")


def choice(value: Any, what: str, known: Sequence[str]) -> str:
    """One of a few known names. Raises ValueError, with all of them."""
    if value in known:
        return str(value)
    near = difflib.get_close_matches(str(value).lower(), known, n=1)
    meant = f"did you mean {near[0]!r}? " if near else ""
    raise ValueError(f"{what} is {value!r}: {meant}it must be one of {', '.join(known)}")


def suggestion(name: str, known: Sequence[str], listed: str) -> str:
    """What might have been meant by a name that is not known: the nearest that is, or else the first ones, after the words
    `listed`."""
    near = difflib.get_close_matches(name.lower(), known, n=1) or difflib.get_close_matches(name, known, n=1)
    if near:
        return f"did you mean {near[0]!r}?"
    return f"{listed} {', '.join(known[:12])}{', ...' if len(known) > 12 else ''}"


# What users ask of a node, but only a scene answers.
_OF_SCENES = frozenset(
    "any bounds closest contains cost count crossings measure objects_at render save segments thickness voxels".split()
)


def no_attribute(kind: str, name: str) -> str:
    """The message for an attribute that a node of this kind does not have."""
    hint = f": a scene has it, as in Scene(node).{name}" if name in _OF_SCENES else ""
    return f"{kind} has no attribute {name!r}{hint}"


def _from_objects(array: np.ndarray, what: str, wanted: str) -> np.ndarray:
    """Fractions, decimals and long integers as float64."""
    for value in array.flat:
        if not isinstance(value, (Real, Decimal)):
            raise _not_numbers(what, wanted, type(value).__name__, value, array.ndim)
    try:
        return array.astype(np.float64)
    except OverflowError:
        raise ValueError(f"{what} has a number beyond what float64 holds") from None


def _not_numbers(what: str, wanted: str, found: str, value: Any, axes: int) -> TypeError:
    if axes == 0:
        return TypeError(f"{what} must be {wanted}, not {value!r}")
    return TypeError(f"{what} must be real numbers, not {found}")


def threads_of(threads: int) -> int:
    """A checked number of threads; 0 is one per core."""
    return bounded_integer(threads, "threads", 0, 1024)
